//! Leads a program that has a force sensor through `feel`. Both write one JSON object per line.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use hardware::feel::{Answer, Direction, Guide, Left, Squeezed, Step};
use rt_core::math::Vec3;
use serde_json::{Value, json};

use super::pace::Pace;
use crate::problem::Problem;

/// Longest time that the program may take for an answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running program.
pub(super) struct Script {
    program: Child,
    asks: ChildStdin,
    answers: Receiver<Value>,
    pace: Pace,
}

impl Script {
    pub(super) fn start(path: &Path, stop: Arc<AtomicBool>) -> Result<Self, Problem> {
        let mut program = Command::new(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("--script {}: {error}", path.display()))?;
        let (Some(asks), Some(says)) = (program.stdin.take(), program.stdout.take()) else {
            return Err("--script: no pipe to the program".into());
        };
        let (sender, answers) = sync_channel(16);
        std::thread::spawn(move || {
            for line in BufReader::new(says).lines().map_while(Result::ok) {
                // A line that is no JSON is a message for people.
                let Ok(value) = serde_json::from_str(&line) else {
                    crate::say::note(line);
                    continue;
                };
                if sender.send(value).is_err() {
                    return;
                }
            }
        });
        Ok(Self {
            program,
            asks,
            answers,
            pace: Pace::new(stop),
        })
    }

    fn write(&mut self, ask: &Value) {
        let line = format!("{ask}\n");
        let written = self.asks.write_all(line.as_bytes());
        if written.and_then(|()| self.asks.flush()).is_err() {
            self.pace.end();
        }
    }

    /// Asks, and waits for an answer that `read` understands. `None`: none came in time.
    fn ask<T>(&mut self, ask: &Value, read: impl Fn(&Value) -> Option<T>) -> Option<T> {
        self.write(ask);
        let start = Instant::now();
        while !self.pace.is_stopped() && start.elapsed() < PATIENCE {
            match self.answers.recv_timeout(Duration::from_millis(100)) {
                Ok(answer) => {
                    if let Some(answer) = read(&answer) {
                        return Some(answer);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.pace.end(),
            }
        }
        None
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

impl Guide for Script {
    fn tell(&mut self, step: &Step) {
        while self.answers.try_recv().is_ok() {}
        let ask = match step {
            Step::Move { direction, way_m } => {
                json!({ "step": "move", "direction": direction.name(), "way_m": way_m })
            }
            Step::Hold | Step::HoldForSilence => json!({ "step": "hold" }),
            Step::HoldFirmly => json!({ "step": "hold", "firmly": true }),
            Step::PushAndFallSilent { force_n } => {
                json!({ "step": "push", "force_n": force_n, "then_silent": true })
            }
            Step::Push { force_n } => json!({ "step": "push", "force_n": force_n }),
            Step::Shut => json!({ "step": "shut" }),
            Step::Open => json!({ "step": "open" }),
            Step::HoldFingers => json!({ "step": "hold_fingers" }),
            Step::PushFingers { force_n } => json!({ "step": "push_fingers", "force_n": force_n }),
            Step::Scale => json!({ "step": "scale" }),
            Step::Press { force_n } => json!({ "step": "press", "force_n": force_n }),
            Step::Response => json!({ "step": "response" }),
        };
        self.write(&ask);
    }

    fn is_done(&mut self) -> bool {
        match self.answers.try_recv() {
            Ok(answer) => answer["done"] == true,
            Err(TryRecvError::Empty) => false,
            Err(TryRecvError::Disconnected) => {
                self.pace.end();
                false
            }
        }
    }

    fn pushed(&mut self) -> Answer {
        self.ask(&json!({ "ask": "pushed" }), answer)
            .unwrap_or(Answer::Nothing)
    }

    fn squeezed(&mut self) -> Squeezed {
        self.ask(&json!({ "ask": "pushed_fingers" }), squeezed)
            .unwrap_or(Squeezed::Nothing)
    }

    fn has_scale(&mut self) -> bool {
        let has = self.ask(&json!({ "ask": "scale" }), |answer| {
            answer["scale"].as_bool()
        });
        has.unwrap_or(false)
    }

    fn pressed_n(&mut self) -> Option<f32> {
        self.ask(&json!({ "ask": "pressed" }), |answer| {
            let pressed = answer.get("pressed_n")?;
            Some(pressed.as_f64().map(|newton| newton as f32))
        })?
    }

    fn left(&mut self) -> Option<Left> {
        self.ask(&json!({ "ask": "left" }), left)
    }

    fn wait(&mut self) -> u64 {
        self.pace.wait()
    }

    fn is_stopped(&self) -> bool {
        self.pace.is_stopped()
    }
}

/// Answer to a push: `{"force_n": [x, y, z]}` or `{"felt": "right"}`.
fn answer(said: &Value) -> Option<Answer> {
    if let Some(felt) = said["felt"].as_str() {
        let of = |it: &Direction| it.name() == felt;
        return match felt {
            "nothing" => Some(Answer::Nothing),
            _ => Direction::ALL.into_iter().find(of).map(Answer::Felt),
        };
    }
    let parts: Vec<f32> = said["force_n"]
        .as_array()?
        .iter()
        .filter_map(Value::as_f64)
        .map(|part| part as f32)
        .collect();
    match *parts.as_slice() {
        [x, y, z] => Some(Answer::Measured(Vec3::new(x, y, z))),
        _ => None,
    }
}

/// Answer to the question whether a force is left: `{"force_n": [0.0, 0.0, 0.0]}`, the force that
/// the sensor measures now, or `{"felt": "nothing"}`.
fn left(said: &Value) -> Option<Left> {
    Some(match answer(said)? {
        Answer::Felt(_) => Left::Pushes,
        Answer::Measured(force_n) => Left::Measured(force_n),
        Answer::Nothing => Left::Nothing,
    })
}

/// Answer to a push of the fingers: `{"opening_n": 0.9}` or `{"felt": "open"}`.
fn squeezed(said: &Value) -> Option<Squeezed> {
    match said["felt"].as_str() {
        Some("open") => Some(Squeezed::Open),
        Some("shut") => Some(Squeezed::Shut),
        Some("nothing") => Some(Squeezed::Nothing),
        Some(_) => None,
        None => {
            let opening_n = said["opening_n"].as_f64()?;
            Some(Squeezed::Measured(opening_n as f32))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_forces_or_directions() {
        let felt = answer(&json!({ "felt": "towards" }));
        assert_eq!(felt, Some(Answer::Felt(Direction::Towards)));
        assert_eq!(answer(&json!({ "felt": "nothing" })), Some(Answer::Nothing));
        let measured = answer(&json!({ "force_n": [0.0, 0.25, 0] }));
        assert_eq!(measured, Some(Answer::Measured(Vec3::new(0.0, 0.25, 0.0))));
        assert_eq!(answer(&json!({ "force_n": [0.0] })), None);
        assert_eq!(answer(&json!({ "felt": "sideways" })), None);
    }

    #[test]
    fn a_force_that_is_left_is_measured_or_felt() {
        let measured = left(&json!({ "force_n": [0.0, 0.5, 0.0] }));
        assert_eq!(measured, Some(Left::Measured(Vec3::new(0.0, 0.5, 0.0))));
        assert_eq!(left(&json!({ "felt": "nothing" })), Some(Left::Nothing));
        assert_eq!(left(&json!({ "felt": "up" })), Some(Left::Pushes));
        assert_eq!(left(&json!({ "done": true })), None);
    }

    #[test]
    fn fingers_answer_by_a_force_or_a_word() {
        for (said, wanted) in [
            (json!({ "felt": "open" }), Some(Squeezed::Open)),
            (json!({ "felt": "shut" }), Some(Squeezed::Shut)),
            (json!({ "felt": "nothing" }), Some(Squeezed::Nothing)),
            (json!({ "opening_n": -0.5 }), Some(Squeezed::Measured(-0.5))),
            (json!({ "felt": "up" }), None),
            (json!({ "done": true }), None),
        ] {
            assert_eq!(squeezed(&said), wanted, "{said}");
        }
    }
}
