//! Leads a person through `feel` in a terminal.

use std::io::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::Duration;

use hardware::feel::{Answer, Direction, Guide, Left, Squeezed, Step};

use super::pace::Pace;
use super::weight::weight_n;
use crate::devices::typed::typed_lines;
use crate::say;

/// Interval at which a waiting question checks whether the test must end.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// A person at a terminal.
pub(super) struct Terminal {
    typed: Receiver<String>,
    pace: Pace,
}

impl Terminal {
    pub(super) fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            typed: typed_lines(),
            pace: Pace::new(stop),
        }
    }

    /// Asks until `read` understands the answer. Returns `None` if the test must end.
    fn ask<T>(&mut self, question: &str, read: impl Fn(&str) -> Option<T>) -> Option<T> {
        while !self.pace.is_stopped() {
            let mut to = std::io::stderr();
            let _ = write!(to, "{question} ").and_then(|()| to.flush());
            let line = loop {
                if self.pace.is_stopped() {
                    return None;
                }
                match self.typed.recv_timeout(LOOK_EVERY) {
                    Ok(line) => break line,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => self.pace.end(),
                }
            };
            if let Some(answer) = read(line.trim()) {
                return Some(answer);
            }
        }
        None
    }
}

/// Sentence for a rig whose handle belongs to an instrument in a port.
const fn port_note(step: &Step) -> Option<&'static str> {
    match step {
        Step::Move {
            direction: Direction::Right | Direction::Left,
            ..
        } => Some(
            "An instrument in a port: begin with it half drawn out. It swings about the port while its \
             handle moves; only the motion of the handle counts.",
        ),
        Step::Move { .. } => Some(
            "An instrument in a port: draw the instrument out along its shaft, as far as that leads in this \
             direction, and tilt it for the rest. Only the motion of the handle counts.",
        ),
        Step::Hold | Step::HoldFirmly | Step::HoldForSilence => Some(
            "An instrument in a port: hold it half drawn out, so that it can slide both ways. A push that \
             draws it out goes up or towards you, one that pushes it in goes down or away.",
        ),
        Step::Scale => Some(
            "An instrument in a port: draw it out so far that the scale fits under its handle, and set the handle down on it.",
        ),
        _ => None,
    }
}

impl Guide for Terminal {
    fn tell(&mut self, step: &Step) {
        while self.typed.try_recv().is_ok() {}
        match step {
            Step::Move { direction, way_m } => say::note(format_args!(
                "\nHold the handle still. Then move it {:.0} mm {}, hold it still there, and press Enter.",
                way_m * 1e3,
                direction.words()
            )),
            Step::Hold => say::note(
                "\nHold the handle loosely in the middle of its workspace, and press Enter. It will push \
                 gently for a second.",
            ),
            Step::Push { force_n } => say::note(format_args!("It pushes with {force_n:.1} N …")),
            Step::Shut => say::note("\nShut the handle fully, and press Enter."),
            Step::Open => say::note("\nOpen the handle fully, and press Enter."),
            Step::HoldFingers => say::note(
                "\nHold the handle half open with loose fingers, and press Enter. It will push them \
                 gently for a second.",
            ),
            Step::PushFingers { force_n } => {
                say::note(format_args!("It pushes your fingers with {force_n:.1} N …"));
            }
            Step::Scale => say::note(
                "\nStand the handle's tip on the scale and set the scale to zero. Then press Enter.",
            ),
            Step::Press { .. } => {
                say::note("It presses down now. Read the scale, and press Enter.");
            }
            Step::HoldFirmly => say::note(
                "\nHold the handle firmly in the middle of its workspace, and press Enter. It will push \
                 harder, for a second.",
            ),
            Step::HoldForSilence => say::note(
                "\nHold the handle loosely in the middle of its workspace, and press Enter. It will push \
                 up for a second; then Calot sends nothing more, and the push must end by itself.",
            ),
            Step::PushAndFallSilent { force_n } => {
                say::note(format_args!("It pushes up with {force_n:.1} N …"));
            }
            Step::Response => say::note("It pushes to and fro for 9 s. Hold it loosely …"),
        }
        if let Some(note) = port_note(step) {
            say::note(note);
        }
    }

    fn is_done(&mut self) -> bool {
        match self.typed.try_recv() {
            Ok(_) => true,
            Err(TryRecvError::Empty) => false,
            Err(TryRecvError::Disconnected) => {
                self.pace.end();
                false
            }
        }
    }

    fn pushed(&mut self) -> Answer {
        let question =
            "Which way did it push? [r]ight [l]eft [u]p [d]own [t]owards you [a]way [n]othing:";
        self.ask(question, |line| {
            let letter = line.chars().next()?.to_ascii_lowercase();
            let of = |it: &Direction| it.name().starts_with(letter);
            match letter {
                'n' => Some(Answer::Nothing),
                _ => Direction::ALL.into_iter().find(of).map(Answer::Felt),
            }
        })
        .unwrap_or(Answer::Nothing)
    }

    fn squeezed(&mut self) -> Squeezed {
        let question = "Which way did it push your fingers? [o]pen [s]hut [n]othing:";
        self.ask(question, |line| {
            match line.chars().next()?.to_ascii_lowercase() {
                'o' => Some(Squeezed::Open),
                's' => Some(Squeezed::Shut),
                'n' => Some(Squeezed::Nothing),
                _ => None,
            }
        })
        .unwrap_or(Squeezed::Nothing)
    }

    fn has_scale(&mut self) -> bool {
        say::note("");
        let question = "Is there a kitchen scale at hand? [y]es [n]o:";
        let read = |line: &str| match line.chars().next()?.to_ascii_lowercase() {
            'y' => Some(true),
            'n' => Some(false),
            _ => None,
        };
        self.ask(question, read).unwrap_or(false)
    }

    fn pressed_n(&mut self) -> Option<f32> {
        let read = |line: &str| match line {
            "" => Some(None),
            grams => weight_n(grams).map(Some),
        };
        self.ask("Grams on the scale (Enter: not read):", read)?
    }

    fn left(&mut self) -> Option<Left> {
        let question = "Calot sends nothing now. Does it still push? [y]es [n]o:";
        self.ask(question, |line| {
            match line.chars().next()?.to_ascii_lowercase() {
                'y' => Some(Left::Pushes),
                'n' => Some(Left::Nothing),
                _ => None,
            }
        })
    }

    fn wait(&mut self) -> u64 {
        self.pace.wait()
    }

    fn is_stopped(&self) -> bool {
        self.pace.is_stopped()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notes_for_an_instrument_in_a_port_say_to_draw_it_out() {
        for direction in [Direction::Up, Direction::Towards] {
            let note = port_note(&Step::Move {
                direction,
                way_m: 0.05,
            });
            assert!(note.is_some_and(|it| it.contains("draw the instrument out")));
        }
        assert!(port_note(&Step::Hold).is_some_and(|it| it.contains("half drawn out")));
        assert!(port_note(&Step::Scale).is_some_and(|it| it.contains("draw it out")));
        assert_eq!(port_note(&Step::Shut), None);
    }
}
