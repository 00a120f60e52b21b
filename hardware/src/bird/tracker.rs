//! Driver of the endoscope's tracker: a single bird or one of a group.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Vec3};
use rt_core::port::{LineCounters, Polled, Tracker, TrackerSample};
use rt_core::time::TimeNs;

use super::bulk::{Bulk, BulkPipe};
use super::filter::{self, Filter};
use super::transport::Transport;
use super::usb::UsbPipe;
use super::wire::{Hemisphere, Record, RecordReader, Scale, command, parameter, status};
use crate::HardwareError;
use crate::line::{Line, Read, Written};

/// Fastest bit rate of a serial bird, baud. A record then takes 1.2 ms on the wire.
pub(crate) const BAUD: u32 = 115_200;
/// Longest wait for an answer. A bird answers within milliseconds, but later while it wakes up or
/// resets.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);
/// Attempts per question. The first attempts may fail because bytes of an old stream precede the
/// answer.
const TRIES: u32 = 4;
/// Silence on the line after which a stopped stream counts as ended.
const SILENCE: Duration = Duration::from_millis(30);
/// Factor by which each failed attempt prolongs that silence. On a busy computer an emulated bird
/// answers late, and an old answer may arrive before the new one.
const SILENCE_FACTOR: u32 = 4;
/// Largest number of bytes that one poll reads: 36 records.
const BYTES_PER_POLL: usize = 512;
/// Fastest plausible movement of an endoscope, m/s.
const SPEED_LIMIT_M_S: f32 = 2.0;
/// Noise of a position, m, allowed on top of that movement.
const NOISE_M: f32 = 0.003;
/// Time after an admitted record, ns, beyond which any position is plausible.
const FORGET_NS: u64 = 500_000_000;
/// Error codes after which the manual forbids the use of the bird.
const FATAL: [u8; 12] = [1, 2, 15, 16, 20, 21, 22, 23, 24, 25, 26, 27];

/// Pause that the birds need before and after the command that configures a group.
const CONFIGURE_PAUSE: Duration = Duration::from_millis(600);
/// Largest number of birds of a group.
const BIRDS_MAX: u8 = 14;

/// Settings of the tracker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BirdSetup {
    /// Hemisphere of the endoscope, seen from the transmitter.
    pub hemisphere: Hemisphere,
    /// Range of the positions.
    pub scale: Scale,
    /// Number of units on the bus, 1 to 14. An extended-range controller is refused, because its
    /// positions have another scale.
    pub birds: u8,
    /// Address of the endoscope's bird, 1 to `birds`.
    pub bird: u8,
    /// Corner frequency of the filter while the endoscope is held still, Hz; 0: no filter.
    pub filter_rest_hz: f32,
}

impl Default for BirdSetup {
    /// One bird, within 0.9 m, on the −z side of the transmitter.
    fn default() -> Self {
        Self {
            hemisphere: Hemisphere::Upper,
            scale: Scale::default(),
            birds: 1,
            bird: 1,
            filter_rest_hz: filter::REST_HZ,
        }
    }
}

/// A tracker that returns about 100 mildly filtered poses per second.
#[derive(Debug)]
pub struct BirdTracker {
    line: Box<dyn Transport>,
    setup: BirdSetup,
    reader: RecordReader,
    counters: LineCounters,
    gate: Gate,
    filter: Filter,
}

impl BirdTracker {
    /// Opens a serial line, identifies the bird and starts the stream. This takes about 1 s, and 2
    /// s more for a group, so the tick must not call it.
    pub fn open(path: &Path, setup: BirdSetup) -> Result<Self, HardwareError> {
        Self::start(Box::new(Line::open(path, BAUD)?), setup)
    }

    /// Opens a trakSTAR on the USB: the first one (`usb`) or the one with this serial number.
    pub fn open_usb(name: &Path, setup: BirdSetup) -> Result<Self, HardwareError> {
        Self::open_bulk(name, Box::new(UsbPipe::open(name)?), setup)
    }

    /// Opens any device that takes the commands in packets. `name` appears in messages only.
    pub fn open_bulk(
        name: &Path,
        pipe: Box<dyn BulkPipe>,
        setup: BirdSetup,
    ) -> Result<Self, HardwareError> {
        Self::start(Box::new(Bulk::start(name, pipe)?), setup)
    }

    fn start(line: Box<dyn Transport>, setup: BirdSetup) -> Result<Self, HardwareError> {
        let birds = setup.birds.clamp(1, BIRDS_MAX);
        let setup = BirdSetup {
            birds,
            bird: setup.bird.clamp(1, birds),
            ..setup
        };
        let mut bird = Self {
            line,
            setup,
            reader: RecordReader::default(),
            counters: LineCounters::default(),
            gate: Gate::default(),
            filter: Filter::new(setup.filter_rest_hz),
        };
        bird.identify()?;
        bird.check_errors()?;
        if bird.is_group() || bird.line.is_addressed() {
            thread::sleep(CONFIGURE_PAUSE);
            bird.send(&[command::CHANGE, parameter::AUTO_CONFIGURE, birds])?;
            thread::sleep(CONFIGURE_PAUSE);
        }
        let [low, high] = setup.scale.bytes();
        bird.send(&[command::CHANGE, parameter::SCALING, low, high])?;
        let [low_now, high_now] = bird.ask(parameter::SCALING)?;
        if [low_now, high_now] != [low, high] {
            return Err(bird.wrong_device(format!(
                "scale code {low_now}, which cannot be changed to {low}"
            )));
        }
        let [axis, sign] = setup.hemisphere.bytes();
        bird.send_to(setup.bird, &[command::HEMISPHERE, axis, sign])?;
        if bird.is_group() {
            // All birds must send records of equal length.
            for address in 1..=birds {
                bird.send_to(address, &[command::POSITION_QUATERNION])?;
            }
            bird.send(&[command::CHANGE, parameter::GROUP_MODE, 1])?;
            bird.reader = RecordReader::of_group();
        } else {
            // An earlier host may have left the bird in group mode, in which each record ends with
            // an address.
            bird.send(&[command::CHANGE, parameter::GROUP_MODE, 0])?;
            bird.send_to(setup.bird, &[command::POSITION_QUATERNION])?;
        }
        bird.drain(SILENCE)?;
        let point = [command::TO_BIRD | setup.bird, command::POINT];
        let begun = if bird.is_group() {
            bird.line.begin(&[command::POINT])
        } else {
            bird.line.begin(&point)
        };
        bird.check_written(begun)?;
        Ok(bird)
    }

    /// Path of the line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.line.path()
    }

    /// Settings of the tracker.
    #[must_use]
    pub const fn setup(&self) -> BirdSetup {
        self.setup
    }

    /// True if the line is lost; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.line.is_lost()
    }

    fn is_group(&self) -> bool {
        self.setup.birds > 1
    }

    fn identify(&mut self) -> Result<(), HardwareError> {
        // `POINT` ends a stream that an earlier host left on. A bird that does not stream answers
        // `POINT` with one record.
        self.send(&[command::RUN])?;
        self.send(&[command::POINT])?;
        let model: [u8; 10] = self.ask(parameter::MODEL)?;
        if model.starts_with(EXTENDED_RANGE) {
            return Err(self.wrong_device(
                "an extended-range controller, whose positions have another scale (144 in): connect a \
                 standard transmitter"
                    .into(),
            ));
        }
        if model.iter().all(|byte| (0x20..0x7F).contains(byte)) {
            Ok(())
        } else {
            Err(self.wrong_device(format!("something that calls itself {model:02X?}")))
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

    fn wrong_device(&self, found: String) -> HardwareError {
        HardwareError::WrongDevice {
            path: self.path().to_path_buf(),
            expected: NAME,
            found,
        }
    }

    /// Sends a command to one bird, with the bird's address in a group and on the USB.
    fn send_to(&mut self, address: u8, bytes: &[u8]) -> Result<(), HardwareError> {
        if !self.is_group() && !self.line.is_addressed() {
            return self.send(bytes);
        }
        let mut addressed = [0; 4];
        let address = [command::TO_BIRD | address];
        for (slot, &byte) in addressed.iter_mut().zip(address.iter().chain(bytes)) {
            *slot = byte;
        }
        self.send(addressed.get(..=bytes.len()).unwrap_or(&addressed))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), HardwareError> {
        let written = self.line.write(bytes);
        self.check_written(written)
    }

    fn check_written(&self, written: Written) -> Result<(), HardwareError> {
        match written {
            Written::All => Ok(()),
            Written::Part(_) | Written::Nothing => Err(HardwareError::Line {
                path: self.path().to_path_buf(),
                doing: "sending a command",
                what: "the line takes no bytes".into(),
            }),
        }
    }

    /// Asks for a parameter, at most [`TRIES`] times, until an answer of exactly `N` bytes has
    /// come.
    fn ask<const N: usize>(&mut self, parameter: u8) -> Result<[u8; N], HardwareError> {
        let began = Instant::now();
        let (mut heard, mut silence) = (0, SILENCE);
        for _ in 0..TRIES {
            heard += self.drain(silence)?;
            self.send(&[command::EXAMINE, parameter])?;
            let mut answer = [0; N];
            let mut have = 0;
            let asked = Instant::now();
            while have < N && asked.elapsed() < ANSWER_TIMEOUT {
                match self.line.read(answer.get_mut(have..).unwrap_or(&mut [])) {
                    Read::Bytes(count, _) => have += count,
                    Read::Empty => thread::sleep(Duration::from_millis(1)),
                    Read::Lost => return Err(self.missing()),
                }
            }
            heard += have as u64;
            let rest = self.drain(silence)?;
            heard += rest;
            if have == N && rest == 0 {
                return Ok(answer);
            }
            if rest > 0 {
                // Bytes after the answer mean that a stream is still on.
                self.send(&[command::POINT])?;
            }
            silence = ANSWER_TIMEOUT.min(silence * SILENCE_FACTOR);
        }
        Err(HardwareError::Silent {
            path: self.path().to_path_buf(),
            expected: NAME,
            waited_ms: began.elapsed().as_millis() as u64,
            heard,
        })
    }

    /// Discards input until the line has been silent for `silence`. Gives up after `silence` plus
    /// half a second. Returns the number of bytes discarded.
    fn drain(&mut self, silence: Duration) -> Result<u64, HardwareError> {
        let start = Instant::now();
        let mut last = start;
        let mut dropped = 0;
        let mut bytes = [0; BYTES_PER_POLL];
        while last.elapsed() < silence && start.elapsed() < ANSWER_TIMEOUT + silence {
            match self.line.read(&mut bytes) {
                Read::Bytes(count, _) => {
                    dropped += count as u64;
                    last = Instant::now();
                }
                Read::Empty => thread::sleep(Duration::from_millis(1)),
                Read::Lost => return Err(self.missing()),
            }
        }
        Ok(dropped)
    }

    fn missing(&self) -> HardwareError {
        HardwareError::Missing {
            path: self.path().to_path_buf(),
        }
    }
}

/// Model name of the controller of an extended-range transmitter.
const EXTENDED_RANGE: &[u8] = b"6DERC";
const NAME: &str = "Flock-of-Birds tracker";

impl Drop for BirdTracker {
    fn drop(&mut self) {
        // Two writes, because a USB packet holds only one command.
        self.line.write(&[command::POINT]);
        self.line.write(&[command::SLEEP]);
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
                Some(Ok((_, address))) if address != 0 && address != self.setup.bird => continue,
                Some(read) => read
                    .ok()
                    .and_then(|(record, _)| Record::parse(record, self.setup.scale)),
            };
            match record.filter(|record| self.gate.admit(record, at_ns)) {
                Some(record) => {
                    self.counters.frames += 1;
                    newest = Some(self.filter.update(&record, at_ns));
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

/// Holds back a record that is implausibly far from the last admitted one, until a second record
/// agrees with it. Records have no checksum, so a damaged record may look valid.
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
    use std::collections::VecDeque;

    use super::*;
    use crate::bird::device::Bird;
    use nalgebra::UnitQuaternion;

    fn at(x: f32) -> Record {
        Record {
            position_m: [x, 0.0, 0.0],
            rotation: UnitQuaternion::identity(),
        }
    }

    /// An emulated bird with delayed answers.
    #[derive(Debug)]
    struct DelayedBird {
        bird: Bird,
        by: Duration,
        answers: VecDeque<(Instant, Vec<u8>)>,
    }

    impl Transport for DelayedBird {
        fn path(&self) -> &Path {
            Path::new("late")
        }

        fn is_lost(&self) -> bool {
            false
        }

        fn read(&mut self, buffer: &mut [u8]) -> Read {
            let Some((due, bytes)) = self.answers.front_mut() else {
                return Read::Empty;
            };
            if *due > Instant::now() {
                return Read::Empty;
            }
            let count = bytes.len().min(buffer.len());
            buffer[..count].copy_from_slice(&bytes[..count]);
            bytes.drain(..count);
            if bytes.is_empty() {
                self.answers.pop_front();
            }
            Read::Bytes(count, 0)
        }

        fn write(&mut self, bytes: &[u8]) -> Written {
            let due = Instant::now() + self.by;
            let answers = &mut self.answers;
            self.bird
                .receive(bytes, |answer| answers.push_back((due, answer.to_vec())));
            Written::All
        }

        fn begin(&mut self, _: &[u8]) -> Written {
            self.write(&[command::STREAM])
        }

        fn is_addressed(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_bird_that_answers_late_is_found_and_a_silent_one_is_not() {
        let start = |by_ms: u64| {
            let late = DelayedBird {
                bird: Bird::new(at(0.3)),
                by: Duration::from_millis(by_ms),
                answers: VecDeque::new(),
            };
            BirdTracker::start(Box::new(late), BirdSetup::default())
        };
        for by_ms in [0, 60, 150, 300] {
            let begun = start(by_ms);
            assert!(begun.is_ok(), "{by_ms} ms late: {begun:?}");
        }
        let outcome = start(10_000);
        assert!(
            matches!(&outcome, Err(HardwareError::Silent { heard: 0, .. })),
            "{outcome:?}"
        );
    }

    #[test]
    fn a_bird_that_reports_a_broken_part_is_refused_with_its_code() {
        let mut bird = Bird::new(at(0.3));
        bird.fail(FATAL[0]);
        let broken = DelayedBird {
            bird,
            by: Duration::ZERO,
            answers: VecDeque::new(),
        };
        let said = BirdTracker::start(Box::new(broken), BirdSetup::default());
        let said = said.unwrap_err().to_string();
        let words = "the device reports error 1. Look it up in the manual";
        assert!(said.contains(words), "{said}");
    }

    #[test]
    fn one_implausible_record_is_dropped_and_a_real_movement_is_followed() {
        let mut gate = Gate::default();
        let ms = |ms: u64| ms * 1_000_000;
        assert!(gate.admit(&at(0.1), ms(0)));
        assert!(!gate.admit(&at(0.7), ms(10)), "a jump of 0.6 m in 10 ms");
        assert!(gate.admit(&at(0.101), ms(20)), "back where it was");
        assert!(!gate.admit(&at(0.5), ms(30)));
        assert!(gate.admit(&at(0.501), ms(40)), "the second record agrees");
        assert!(gate.admit(&at(-0.4), ms(600)), "after a long silence");
    }
}
