//! A sensor that a thread reads: its edges and their times.

use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::JoinHandle;
use std::time::Duration;

use rt_core::time::TimeNs;

use super::edge::Edge;
use super::sound::Sound;
use crate::line::now_ns;

/// Pause between two reads of an input.
const READ_INTERVAL: Duration = Duration::from_micros(100);
/// Largest number of bytes of sound that are read at once. They are few, so that the arrival of a
/// block gives the time of its samples.
const CHUNK: usize = 512;

/// Result of reading a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// Nothing new.
    Nothing,
    /// The sensor's state at this time.
    Level {
        /// True if it sees light.
        bright: bool,
        /// Time of the state, ns.
        at_ns: TimeNs,
    },
    /// The sensor is gone.
    Lost,
}

/// A sensor with two states, dark and bright. It is a trait because ptys have no modem pins and
/// test machines no photodiode: tests implement it.
pub trait LightInput: Send {
    /// Reads the sensor without waiting.
    fn look(&mut self, now_ns: TimeNs) -> Seen;
}

/// A sensor with its thread. Dropping it ends a thread of [`Self::watch`].
#[derive(Debug)]
pub struct Sensor {
    edges: Receiver<Edge>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Sensor {
    /// Starts a thread that reads an input up to ten times per millisecond.
    ///
    /// # Errors
    ///
    /// The system's error, if it can start no more threads.
    pub fn watch(mut input: impl LightInput + 'static) -> std::io::Result<Self> {
        let (sender, edges) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let look = move || {
            let mut levels = Levels::default();
            while !asked.load(Ordering::Relaxed) {
                match input.look(now_ns()) {
                    Seen::Lost => return,
                    Seen::Nothing => {}
                    Seen::Level { bright, at_ns } => {
                        if let Some(edge) = levels.take(bright, at_ns)
                            && sender.send(edge).is_err()
                        {
                            return;
                        }
                    }
                }
                std::thread::sleep(READ_INTERVAL);
            }
        };
        Ok(Self {
            edges,
            stop,
            thread: Some(thread(look)?),
        })
    }

    /// Starts a thread that reads sound: 16-bit samples, little-endian, one channel, as `arecord -f
    /// S16_LE` writes them.
    ///
    /// # Errors
    ///
    /// The system's error, if it can start no more threads.
    pub fn listen(from: impl Read + Send + 'static, rate_hz: u32) -> std::io::Result<Self> {
        let (sender, edges) = mpsc::channel();
        // The thread may wait in a read for ever, so `drop` must not wait for it.
        drop(thread(move || listen(from, rate_hz, &sender))?);
        Ok(Self {
            edges,
            stop: Arc::default(),
            thread: None,
        })
    }

    /// Appends the edges since the last call. Returns false once the sensor is gone.
    pub fn take(&self, into: &mut Vec<Edge>) -> bool {
        loop {
            match self.edges.try_recv() {
                Ok(edge) => into.push(edge),
                Err(TryRecvError::Empty) => return true,
                Err(TryRecvError::Disconnected) => return false,
            }
        }
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn thread(body: impl FnOnce() + Send + 'static) -> std::io::Result<JoinHandle<()>> {
    let named = std::thread::Builder::new().name("calot-light".to_owned());
    named.spawn(body)
}

fn listen(mut from: impl Read, rate_hz: u32, sender: &Sender<Edge>) {
    let mut sound = Sound::new(rate_hz);
    let mut chunk = [0; CHUNK];
    // A read may end in the middle of a sample.
    let mut held = 0;
    while let Ok(count @ 1..) = from.read(chunk.get_mut(held..).unwrap_or_default()) {
        let whole = (held + count) / 2 * 2;
        let samples = chunk.get(..whole).unwrap_or_default().chunks_exact(2);
        let samples = samples.map(|pair| match *pair {
            [low, high] => i16::from_le_bytes([low, high]),
            _ => 0,
        });
        for edge in sound.take(samples, now_ns()) {
            if sender.send(edge).is_err() {
                return;
            }
        }
        let rest = (held + count) % 2;
        if rest == 1 {
            let last = chunk.get(whole).copied().unwrap_or(0);
            chunk[0] = last;
        }
        held = rest;
    }
}

/// Turns states into edges.
#[derive(Debug, Default)]
struct Levels {
    last: Option<(bool, TimeNs)>,
}

impl Levels {
    fn take(&mut self, bright: bool, at_ns: TimeNs) -> Option<Edge> {
        let (was, before_ns) = self.last.replace((bright, at_ns))?;
        let half_ns = at_ns.saturating_sub(before_ns) / 2;
        (was != bright).then_some(Edge {
            at_ns: at_ns - half_ns,
            bright,
            within_ns: half_ns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_lies_in_the_middle_between_the_two_readings_around_it() {
        let mut levels = Levels::default();
        assert_eq!(levels.take(true, 100), None, "nothing was known before");
        assert_eq!(levels.take(true, 200), None);
        let edge = levels.take(false, 300);
        let expected = Edge {
            at_ns: 250,
            bright: false,
            within_ns: 50,
        };
        assert_eq!(edge, Some(expected));
    }

    /// A light that changes with every tenth read. The sensor is lost after 100 reads.
    struct Blinks(u32);

    impl LightInput for Blinks {
        fn look(&mut self, now_ns: TimeNs) -> Seen {
            self.0 += 1;
            match self.0 {
                101.. => Seen::Lost,
                n if n % 2 == 0 => Seen::Nothing,
                n => Seen::Level {
                    bright: (n / 10) % 2 == 1,
                    at_ns: now_ns,
                },
            }
        }
    }

    fn all(sensor: &Sensor) -> Vec<Edge> {
        let mut edges = Vec::new();
        while sensor.take(&mut edges) {
            std::thread::sleep(Duration::from_millis(1));
        }
        edges
    }

    #[test]
    fn each_change_is_reported_once_until_the_sensor_is_unplugged() {
        let edges = all(&Sensor::watch(Blinks(0)).unwrap());
        assert_eq!(edges.len(), 9, "{edges:?}");
        assert!(edges.iter().is_sorted_by_key(|edge| edge.at_ns));
        let alternate = |pair: &[Edge]| pair[0].bright != pair[1].bright;
        assert!(edges.windows(2).all(alternate), "{edges:?}");
    }

    #[test]
    fn a_stream_of_sound_ends_with_its_edges() {
        // Half a second of darkness, and half a second of light, whose reads end within a sample.
        let level = |n: usize| if n < 24_000 { -8000i16 } else { 8000 };
        let bytes: Vec<u8> = (0..48_000).flat_map(|n| level(n).to_le_bytes()).collect();
        struct SplitReads(std::io::Cursor<Vec<u8>>);
        impl Read for SplitReads {
            fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
                let most = into.len().min(33);
                self.0.read(&mut into[..most])
            }
        }
        let edges = all(&Sensor::listen(SplitReads(std::io::Cursor::new(bytes)), 48_000).unwrap());
        let brights: Vec<bool> = edges.iter().map(|edge| edge.bright).collect();
        assert_eq!(brights, [true], "{edges:?}");
    }
}
