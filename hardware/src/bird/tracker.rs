//! Driver of one serial bird: the endoscope's tracker.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Vec3};
use rt_core::port::{LineCounters, Polled, TimeNs, Tracker, TrackerSample};

use super::wire::{Hemisphere, Record, RecordReader, command, parameter, status};
use crate::HardwareError;
use crate::line::{Line, Read, Written};

/// The fastest of the bird's rates: a record takes 1.2 ms on the wire.
pub(crate) const BAUD: u32 = 115_200;
/// A bird answers a question within milliseconds; one that sleeps or resets takes longer.
const ANSWER: Duration = Duration::from_millis(500);
/// Tries per question: bytes of an old stream may stand before the first answer.
const TRIES: u32 = 4;
/// A stream that was told to stop is over when the line has been quiet for so long.
const QUIET: Duration = Duration::from_millis(30);
/// Most bytes that one poll reads: 36 records.
const BYTES_PER_POLL: usize = 512;
/// An endoscope is never moved faster than this, m/s…
const SPEED_LIMIT_M_S: f32 = 2.0;
/// …beside this much noise, m.
const NOISE_M: f32 = 0.003;
/// Without a record for so long, any place is plausible.
const FORGET_NS: u64 = 500_000_000;
/// Errors after which the manual says that the bird must not be used.
const FATAL: [u8; 12] = [1, 2, 15, 16, 20, 21, 22, 23, 24, 25, 26, 27];

/// A tracker that streams position and rotation, about 100 times a second.
#[derive(Debug)]
pub struct BirdTracker {
    line: Line,
    reader: RecordReader,
    counters: LineCounters,
    gate: Gate,
}

impl BirdTracker {
    /// Opens the line, asks who answers, and starts the stream, for a transmitter whose −z
    /// points to where the endoscope is. Not for the tick: takes a second or so.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        Self::open_in(path, Hemisphere::Upper)
    }

    /// The same, for an endoscope in another half of the room around the transmitter.
    pub fn open_in(path: &Path, hemisphere: Hemisphere) -> Result<Self, HardwareError> {
        let mut bird = Self {
            line: Line::open(path, BAUD)?,
            reader: RecordReader::default(),
            counters: LineCounters::default(),
            gate: Gate::default(),
        };
        bird.identify()?;
        bird.check_errors()?;
        let [axis, sign] = hemisphere.bytes();
        bird.tell(&[command::CHANGE, parameter::SCALING, 0, 0])?;
        bird.tell(&[command::HEMISPHERE, axis, sign])?;
        let [low, high] = bird.ask(parameter::SCALING)?;
        if [low, high] != [0, 0] {
            return Err(bird.wrong(format!("a scale of code {low} that cannot be set to 36 in")));
        }
        bird.tell(&[command::POSITION_QUATERNION])?;
        bird.tell(&[command::STREAM])?;
        Ok(bird)
    }

    /// The line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.line.path()
    }

    /// Whether the line is gone; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.line.is_lost()
    }

    fn identify(&mut self) -> Result<(), HardwareError> {
        // Ends a stream that an earlier host left; a bird at rest answers with one record.
        self.tell(&[command::RUN, command::POINT])?;
        let model: [u8; 10] = self.ask(parameter::MODEL)?;
        if model.iter().all(|byte| (0x20..0x7F).contains(byte)) {
            Ok(())
        } else {
            Err(self.wrong(format!("something that calls itself {model:02X?}")))
        }
    }

    fn check_errors(&mut self) -> Result<(), HardwareError> {
        let word = u16::from_le_bytes(self.ask(parameter::STATUS)?);
        if word & status::ERROR == 0 {
            return Ok(());
        }
        let [code] = self.ask(parameter::ERROR)?;
        if FATAL.contains(&code) {
            return Err(HardwareError::Fault {
                path: self.path().to_path_buf(),
                code: code.into(),
            });
        }
        Ok(())
    }

    fn wrong(&self, found: String) -> HardwareError {
        HardwareError::WrongDevice {
            path: self.path().to_path_buf(),
            expected: NAME,
            found,
        }
    }

    fn tell(&mut self, bytes: &[u8]) -> Result<(), HardwareError> {
        match self.line.write(bytes) {
            Written::All => Ok(()),
            Written::Part | Written::Nothing => Err(HardwareError::Line {
                path: self.path().to_path_buf(),
                doing: "sending a command",
                what: "the line takes no bytes".into(),
            }),
        }
    }

    /// Asks for a parameter until an answer of exactly `N` bytes stands alone on the line.
    fn ask<const N: usize>(&mut self, parameter: u8) -> Result<[u8; N], HardwareError> {
        let mut heard = 0;
        for _ in 0..TRIES {
            heard += self.drain()?;
            self.tell(&[command::EXAMINE, parameter])?;
            let mut answer = [0; N];
            let mut have = 0;
            let asked = Instant::now();
            while have < N && asked.elapsed() < ANSWER {
                match self.line.read(answer.get_mut(have..).unwrap_or(&mut [])) {
                    Read::Bytes(count, _) => have += count,
                    Read::Empty => thread::sleep(Duration::from_millis(1)),
                    Read::Lost => return Err(self.vanished()),
                }
            }
            heard += have as u64;
            let rest = self.drain()?;
            heard += rest;
            if have == N && rest == 0 {
                return Ok(answer);
            }
            // More than the answer: a stream that is still on.
            self.tell(&[command::POINT])?;
        }
        Err(HardwareError::Silent {
            path: self.path().to_path_buf(),
            expected: NAME,
            waited_ms: (ANSWER * TRIES).as_millis() as u64,
            heard,
        })
    }

    /// Throws away what comes until the line is quiet, or for half a second; says how much.
    fn drain(&mut self) -> Result<u64, HardwareError> {
        let start = Instant::now();
        let mut last = start;
        let mut dropped = 0;
        let mut bytes = [0; BYTES_PER_POLL];
        while last.elapsed() < QUIET && start.elapsed() < ANSWER {
            match self.line.read(&mut bytes) {
                Read::Bytes(count, _) => {
                    dropped += count as u64;
                    last = Instant::now();
                }
                Read::Empty => thread::sleep(Duration::from_millis(1)),
                Read::Lost => return Err(self.vanished()),
            }
        }
        Ok(dropped)
    }

    fn vanished(&self) -> HardwareError {
        HardwareError::Missing {
            path: self.path().to_path_buf(),
        }
    }
}

const NAME: &str = "Flock-of-Birds tracker";

impl Drop for BirdTracker {
    fn drop(&mut self) {
        self.line.write(&[command::POINT, command::SLEEP]);
    }
}

impl Tracker for BirdTracker {
    fn poll(&mut self, _now_ns: TimeNs) -> Polled<TrackerSample> {
        let mut bytes = [0; BYTES_PER_POLL];
        let (count, at_ns) = match self.line.read(&mut bytes) {
            Read::Bytes(count, at_ns) => (count, at_ns),
            Read::Empty => return Polled::Nothing,
            Read::Lost => return Polled::Lost,
        };
        let mut newest = None;
        for &byte in bytes.iter().take(count) {
            let record = match self.reader.push(byte) {
                None => continue,
                Some(read) => read.ok().and_then(Record::parse),
            };
            match record.filter(|record| self.gate.admit(record, at_ns)) {
                Some(record) => {
                    self.counters.frames += 1;
                    newest = Some(record);
                }
                None => self.counters.bad_frames += 1,
            }
        }
        newest.map_or(Polled::Nothing, |record| {
            Polled::Fresh(TrackerSample {
                tracker_from_sensor: Pose::from_parts(
                    Vec3::from(record.position_m).into(),
                    record.rotation,
                ),
                at_ns,
            })
        })
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}

/// Holds back a record that lies implausibly far from the last one until a second one agrees
/// with it: records have no checksum.
#[derive(Debug, Default)]
struct Gate {
    admitted: Option<(Vec3, TimeNs)>,
    held_back: Option<(Vec3, TimeNs)>,
}

impl Gate {
    fn admit(&mut self, record: &Record, now_ns: TimeNs) -> bool {
        let position = Vec3::from(record.position_m);
        let near = |(last, at_ns): (Vec3, TimeNs)| {
            let age_ns = now_ns.saturating_sub(at_ns);
            let reach_m = NOISE_M + SPEED_LIMIT_M_S * age_ns as f32 * 1e-9;
            age_ns > FORGET_NS || (position - last).norm() <= reach_m
        };
        if self.admitted.is_none_or(near) || self.held_back.is_some_and(near) {
            self.admitted = Some((position, now_ns));
            self.held_back = None;
            true
        } else {
            self.held_back = Some((position, now_ns));
            false
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn at(x: f32) -> Record {
        Record {
            position_m: [x, 0.0, 0.0],
            rotation: UnitQuaternion::identity(),
        }
    }

    #[test]
    fn one_wild_record_is_held_back_and_a_real_move_is_followed() {
        let mut gate = Gate::default();
        let ms = |ms: u64| ms * 1_000_000;
        assert!(gate.admit(&at(0.1), ms(0)));
        assert!(!gate.admit(&at(0.7), ms(10)), "a jump of 0.6 m in 10 ms");
        assert!(gate.admit(&at(0.101), ms(20)), "back where it was");
        assert!(!gate.admit(&at(0.5), ms(30)));
        assert!(gate.admit(&at(0.501), ms(40)), "it really is there");
        assert!(gate.admit(&at(-0.4), ms(600)), "after a long silence");
    }
}
