//! Sound: electrode, clips, alarms, heart monitor. It is synthesised ([`synth`]) and piped to a
//! player program of the system, so that Calot builds without sound libraries. Without a sound card
//! or a player there is one warning, then silence.

pub mod synth;

use std::io::Write as _;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use self::synth::{Current, Heard, Synth};

const RATE_HZ: u32 = 48_000;
/// Number of samples computed at once: 10 ms.
const BLOCK: usize = 480;
/// Number of blocks that are written before the player needs them.
const AHEAD: u32 = 4;
/// A player that ends within this time counts as one that never played.
const STARTS: Duration = Duration::from_millis(1500);

/// Players that read raw samples from standard input, with their arguments.
const PLAYERS: [(&str, &[&str]); 3] = [
    (
        "pw-cat",
        &[
            "--playback",
            "--raw",
            "--rate",
            "48000",
            "--channels",
            "1",
            "--format",
            "s16",
            "--latency",
            "40ms",
            "-",
        ],
    ),
    (
        "paplay",
        &[
            "--raw",
            "--format=s16le",
            "--rate=48000",
            "--channels=1",
            "--latency-msec=60",
        ],
    ),
    (
        "aplay",
        &[
            "-q",
            "-t",
            "raw",
            "-f",
            "S16_LE",
            "-r",
            "48000",
            "-c",
            "1",
            "--buffer-time=80000",
        ],
    ),
];

/// The playing sound; silent once dropped.
#[derive(Debug)]
pub struct Sound {
    heard: Arc<AtomicU32>,
    stop: Arc<AtomicBool>,
    problem: Receiver<String>,
}

impl Sound {
    /// Starts a player on a thread of its own, off the core of the realtime tick, and does not wait
    /// for it.
    #[must_use]
    pub fn start(tick_cpu: Option<usize>) -> Self {
        Self::with(&PLAYERS, tick_cpu)
    }

    fn with(players: &'static [(&str, &[&str])], tick_cpu: Option<usize>) -> Self {
        let heard = Arc::new(AtomicU32::new(0));
        let stop = Arc::new(AtomicBool::new(false));
        let (tell, problem) = channel();
        let (its_heard, its_stop) = (heard.clone(), stop.clone());
        let failed = tell.clone();
        let thread = std::thread::Builder::new()
            .name("calot-sound".into())
            .spawn(move || {
                // The player's process inherits priority and cores from this thread.
                crate::priority::step_aside(tick_cpu);
                if let Err(error) = play_by_any(players, &its_heard, &its_stop) {
                    // The owner may be gone.
                    let _ = tell.send(error);
                }
            });
        if let Err(error) = thread {
            let _ = failed.send(format!("no sound: {error}"));
        }
        Self {
            heard,
            stop,
            problem,
        }
    }

    /// Sets the sounds to hear from now on.
    pub fn hear(&self, heard: Heard) {
        self.heard.store(packed(heard), Ordering::Relaxed);
    }

    /// Takes the reason for which no sound plays, if there is one. A second call returns `None`.
    pub fn take_problem(&self) -> Option<String> {
        self.problem.try_recv().ok()
    }
}

impl Drop for Sound {
    fn drop(&mut self) {
        // The thread ends its player. Nothing waits for the thread, because a player may hang.
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The sounds packed into one word, which needs no lock.
fn packed(heard: Heard) -> u32 {
    let current = match heard.current {
        Current::Off => 0,
        Current::Cut => 1,
        Current::Coagulate => 2,
    };
    current
        | u32::from(heard.alarm) << 2
        | u32::from(heard.heart) << 3
        | u32::from(heard.clips) << 8
}

fn unpacked(word: u32) -> Heard {
    Heard {
        current: match word & 3 {
            1 => Current::Cut,
            2 => Current::Coagulate,
            _ => Current::Off,
        },
        alarm: word & 4 != 0,
        heart: word & 8 != 0,
        clips: (word >> 8 & 0xff) as u8,
    }
}

/// Plays with the first player that works, until `stop` is set.
fn play_by_any(
    players: &[(&str, &[&str])],
    heard: &AtomicU32,
    stop: &AtomicBool,
) -> Result<(), String> {
    for (program, words) in players {
        let child = Command::new(program)
            .args(*words)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut child) = child else { continue };
        let played = match child.stdin.take() {
            Some(into) => play(into, &mut child, heard, stop),
            None => Played::Never,
        };
        // Ends a player that still runs, and reaps one that has ended.
        let _ = child.kill();
        let _ = child.wait();
        match played {
            Played::ToTheEnd => return Ok(()),
            Played::Never => {}
            Played::UntilLost => return Err(format!("{program} has ended: no sound")),
        }
    }
    let names: Vec<&str> = players.iter().map(|(program, _)| *program).collect();
    Err(format!(
        "no sound: there is no sound card, or none of {} to play with (apt-get install alsa-utils); \
         --mute suppresses this warning",
        names.join(", ")
    ))
}

enum Played {
    ToTheEnd,
    UntilLost,
    Never,
}

fn play(mut into: ChildStdin, child: &mut Child, heard: &AtomicU32, stop: &AtomicBool) -> Played {
    let mut synth = Synth::new(RATE_HZ as f32);
    let block_time = Duration::from_secs_f64(BLOCK as f64 / f64::from(RATE_HZ));
    let began = Instant::now();
    let mut due = began;
    let mut bytes = Vec::with_capacity(2 * BLOCK);
    while !stop.load(Ordering::Relaxed) {
        synth.hear(unpacked(heard.load(Ordering::Relaxed)));
        bytes.clear();
        for _ in 0..BLOCK {
            bytes.extend(((synth.sample() * 32_767.0) as i16).to_le_bytes());
        }
        let ended = matches!(child.try_wait(), Ok(Some(_)) | Err(_));
        if ended || into.write_all(&bytes).is_err() {
            return if began.elapsed() < STARTS {
                Played::Never
            } else {
                Played::UntilLost
            };
        }
        due += block_time;
        let now = Instant::now();
        // After a delay the sound continues from now and does not catch up.
        if due + block_time * AHEAD < now {
            due = now;
        }
        std::thread::sleep(due.saturating_duration_since(now + block_time * AHEAD));
    }
    Played::ToTheEnd
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sounds_pass_in_one_word() {
        for current in [Current::Off, Current::Cut, Current::Coagulate] {
            for (alarm, heart, clips) in [(false, true, 0), (true, false, 255), (true, true, 7)] {
                let heard = Heard {
                    current,
                    alarm,
                    heart,
                    clips,
                };
                assert_eq!(unpacked(packed(heard)), heard);
            }
        }
    }

    fn problem_of(players: &'static [(&str, &[&str])]) -> String {
        let sound = Sound::with(players, None);
        sound.hear(Heard {
            alarm: true,
            ..Heard::default()
        });
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            if let Some(problem) = sound.take_problem() {
                assert_eq!(sound.take_problem(), None);
                return problem;
            }
            assert!(Instant::now() < end, "no reason was given");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn missing_player_or_card_gives_one_reason() {
        const NONE: [(&str, &[&str]); 1] = [("no-such-player", &[])];
        // A player that finds no card ends at once.
        const MUTE: [(&str, &[&str]); 1] = [("false", &[])];
        for players in [&NONE, &MUTE] {
            let problem = problem_of(players);
            assert!(problem.contains("no sound"), "{problem}");
            assert!(problem.contains(players[0].0), "{problem}");
        }
    }

    #[test]
    fn a_player_gets_samples_until_it_is_told_to_stop() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("samples");
        let script = format!("cat > {}", file.display());
        let mut child = Command::new("sh")
            .args(["-c", &script])
            .stdin(Stdio::piped())
            .spawn()
            .expect("a shell");
        let into = child.stdin.take().expect("its input");
        let heard = AtomicU32::new(packed(Heard {
            current: Current::Cut,
            ..Heard::default()
        }));
        let stop = AtomicBool::new(false);
        let size = || std::fs::metadata(&file).map_or(0, |m| m.len());
        let end = Instant::now() + Duration::from_secs(60);
        std::thread::scope(|scope| {
            let playing = scope.spawn(|| play(into, &mut child, &heard, &stop));
            while size() < 20_000 && Instant::now() < end {
                std::thread::sleep(Duration::from_millis(5));
            }
            stop.store(true, Ordering::Relaxed);
            assert!(matches!(playing.join(), Ok(Played::ToTheEnd)));
        });
        let _ = child.wait();
        let bytes = std::fs::read(&file).expect("samples");
        assert!(
            bytes.len() >= 20_000 && bytes.len().is_multiple_of(2 * BLOCK),
            "{}",
            bytes.len()
        );
        let samples = bytes
            .chunks_exact(2)
            .map(|b| i16::from_le_bytes([b[0], b[1]]));
        assert!(samples.map(i16::unsigned_abs).max() > Some(2000));
    }
}
