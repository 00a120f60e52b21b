//! Driver of a flat two-armed device on a hAPI board.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Quat, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Freedom, HapticDevice, LineCounters,
    Polled, TimeNs,
};

use super::pantograph::{Pantograph, swapped};
use super::wire::{ARMS, AnswerReader, ID, SET_UP_BYTES, set_up, torques};
use crate::HardwareError;
use crate::gate::Gate;
use crate::line::{Line, Read, Written, now_ns};

/// The board's USB ignores it.
pub(crate) const BAUD: u32 = 115_200;
const NAME: &str = "Haply hAPI board";
/// The firmware waits up to 1 s for what a broken command lacks.
const HANDSHAKE: Duration = Duration::from_secs(3);
/// A board that is well answers within a millisecond; a busy host may take longer to notice.
const ANSWER: Duration = Duration::from_millis(150);
/// The board has then read what was sent, and expects a command.
const SETTLED: Duration = Duration::from_millis(5);
/// Asked so often without a whole answer, a board is not going to give one as it is.
const ROUNDS: u32 = 8;
/// What a board is told when nobody knows where its arms are: no arm is ever turned so far, so
/// neither this nor what is turned since passes for a place.
const UNKNOWN_DEG: [f32; ARMS] = [560.0; ARMS];
/// No arm of any generation is turned further than this from the line of the motors, degrees.
const TURN_MAX_DEG: f32 = 390.0;
/// Completes any command that was broken off, with floats near zero; the rest are resets.
const ZEROS: [u8; SET_UP_BYTES] = [0; SET_UP_BYTES];
/// Most bytes that one poll reads: 56 answers.
const BYTES_PER_POLL: usize = 512;
/// A sample further out than so many workspace radii is no sample.
const REACH: f32 = 3.0;
/// No arm is turned faster than this, degrees per second…
const SPEED_LIMIT_DEG_S: f32 = 2000.0;
/// …beside this much noise.
const NOISE_DEG: f32 = 0.3;
/// What is left of an answer after so long is not going to be finished.
const LEFT_OVER_NS: u64 = 500_000;
/// Asked for so long without an answer, the board has lost its place or its power: it has to be
/// opened anew. Until then it may hold a torque.
const LOST_NS: u64 = 100_000_000;

/// A board with a flat two-armed device. It answers commands: without [`HapticDevice::send`]
/// there are no samples.
#[derive(Debug)]
pub struct HapiHaptic {
    line: Line,
    generation: Pantograph,
    reader: AnswerReader,
    gate: Gate<ARMS>,
    counters: LineCounters,
    sequence: u16,
    /// Bytes of a command that the line did not take: they come first, as zeros.
    owed: usize,
    /// When the oldest command without an answer was sent.
    asked_ns: Option<TimeNs>,
    is_silent: bool,
}

/// What a board says to a command for torques.
enum Answer {
    /// It is set up: the angles of arms 1 and 2, degrees.
    Angles([f32; ARMS]),
    /// It is not: its name alone.
    Name,
    /// Nothing, or what is no answer.
    Nothing,
}

impl HapiHaptic {
    /// Opens the line, takes away any torque, and sets the board up.
    ///
    /// A board that Calot has set up since it was powered knows its angles. For any other the
    /// handle must be **at home** now: that is where its encoders begin to count. Not for the tick:
    /// waits up to 4 s.
    pub fn open(path: &Path, generation: Pantograph) -> Result<Self, HardwareError> {
        Self::on(Line::open(path, BAUD)?, generation, generation.home_deg)
    }

    /// The same after a loss, with nobody there who holds the handle at home: a board that does not
    /// know its angles any more is refused, without torque.
    pub fn reopen(path: &Path, generation: Pantograph) -> Result<Self, HardwareError> {
        Self::on(Line::open(path, BAUD)?, generation, UNKNOWN_DEG)
    }

    /// The same on a line that is open; a board that does not know its angles is told these.
    pub(crate) fn on(
        line: Line,
        generation: Pantograph,
        else_deg: [f32; ARMS],
    ) -> Result<Self, HardwareError> {
        let path = line.path().to_path_buf();
        let mut board = Self {
            line,
            generation,
            reader: AnswerReader::default(),
            gate: Gate::new(SPEED_LIMIT_DEG_S, NOISE_DEG),
            counters: LineCounters::default(),
            sequence: 0,
            owed: 0,
            asked_ns: None,
            is_silent: false,
        };
        // Where this fails, `drop` sends no more than a zero: it must not give the board a place.
        let angles_deg = board.greet(else_deg)?;
        if board.place(angles_deg).is_none() {
            return Err(HardwareError::Calibration {
                path,
                remedy: "The board does not know where its arms are. End Calot, switch the board off and on, hold the handle \
                         at home (near the motors)",
            });
        }
        board.gate.begin(angles_deg, now_ns());
        board.asked_ns = None;
        board.counters = LineCounters::default();
        Ok(board)
    }

    /// The line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.line.path()
    }

    /// Whether the line is gone or the board has lost its place; see
    /// [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.is_silent || self.line.is_lost()
    }

    /// Where the handle was last, base frame, m.
    #[must_use]
    pub fn position_m(&self) -> Vec3 {
        let angles_deg = self.gate.last().unwrap_or(self.generation.home_deg);
        self.generation.position_m(angles_deg).unwrap_or_default()
    }

    /// Takes any torque away, and gives the angles of a board that knows them or takes these.
    fn greet(&mut self, else_deg: [f32; ARMS]) -> Result<[f32; ARMS], HardwareError> {
        let start = Instant::now();
        let mut heard = 0;
        // If it is set up already, this takes its torque away within a millisecond.
        self.write([0.0; ARMS], now_ns());
        loop {
            if let Some(angles_deg) = self.settle(&mut heard)? {
                return Ok(angles_deg);
            }
            if start.elapsed() >= HANDSHAKE {
                return Err(HardwareError::Silent {
                    path: self.path().to_path_buf(),
                    expected: NAME,
                    waited_ms: HANDSHAKE.as_millis() as u64,
                    heard,
                });
            }
            self.begin(else_deg);
        }
    }

    /// Waits until the board, which was sent a zero, has heard one for sure; sets nothing up. None
    /// where it is not set up, or silent for long: a board that is merely slow keeps its angles.
    fn settle(&mut self, heard: &mut u64) -> Result<Option<[f32; ARMS]>, HardwareError> {
        // The first answer may be to what another host's broken command made of it, and its rest
        // then resets the board with the motors on: only one that answers twice has heard a zero.
        let mut is_sure = false;
        for _ in 0..ROUNDS {
            match self.answer(heard)? {
                Answer::Angles(angles_deg) if is_sure => return Ok(Some(angles_deg)),
                Answer::Angles(_) => is_sure = true,
                Answer::Name => return Ok(None),
                Answer::Nothing => is_sure = false,
            }
            self.write([0.0; ARMS], now_ns());
        }
        Ok(None)
    }

    /// From whatever the board is doing to no torque and a question: only a board that is set up
    /// takes a torque, and resetting it leaves the motors on.
    fn begin(&mut self, angles_deg: [f32; ARMS]) {
        self.line.write(&ZEROS);
        self.owed = 0;
        thread::sleep(SETTLED);
        self.line.write(&set_up(&self.generation.ports(angles_deg)));
        self.line.write(&torques([0.0; ARMS]));
    }

    /// Waits a little for an answer.
    fn answer(&mut self, heard: &mut u64) -> Result<Answer, HardwareError> {
        let asked = Instant::now();
        let (mut count_now, mut last) = (0, 0);
        let mut found = None;
        self.reader.clear();
        while found.is_none() && asked.elapsed() < ANSWER {
            let mut bytes = [0; BYTES_PER_POLL];
            match self.line.read(&mut bytes) {
                Read::Bytes(count, _) => {
                    count_now += count as u64;
                    for &byte in bytes.iter().take(count) {
                        last = byte;
                        if let Some(Ok(ports)) = self.reader.push(byte) {
                            found = Some(swapped(ports));
                        }
                    }
                }
                Read::Empty => thread::sleep(Duration::from_millis(1)),
                Read::Lost => {
                    return Err(HardwareError::Missing {
                        path: self.path().to_path_buf(),
                    });
                }
            }
        }
        *heard += count_now;
        Ok(match found {
            Some(angles_deg) => Answer::Angles(angles_deg),
            None if count_now == 1 && last == ID => Answer::Name,
            None => Answer::Nothing,
        })
    }

    /// Where the handle is, if it can be there.
    fn place(&self, angles_deg: [f32; ARMS]) -> Option<Vec3> {
        let reach_m = self.generation.radius_m as f32 * REACH;
        if angles_deg.iter().any(|deg| deg.abs() > TURN_MAX_DEG) {
            return None;
        }
        self.generation
            .position_m(angles_deg)
            .filter(|position_m| position_m.norm() <= reach_m)
    }

    fn write(&mut self, torque_n_m: [f32; ARMS], now_ns: TimeNs) {
        if self.owed > 0 {
            let rest = ZEROS.get(..self.owed).unwrap_or(&ZEROS);
            match self.line.write(rest) {
                Written::All => self.owed = 0,
                Written::Part(count) => self.owed = self.owed.saturating_sub(count),
                Written::Nothing => {}
            }
        }
        let command = torques(torque_n_m);
        let written = if self.owed > 0 {
            Written::Nothing
        } else {
            self.line.write(&command)
        };
        match written {
            Written::All => {
                self.asked_ns.get_or_insert(now_ns);
            }
            Written::Part(count) => {
                self.owed = command.len() - count;
                self.counters.dropped_writes += 1;
            }
            Written::Nothing => self.counters.dropped_writes += 1,
        }
    }
}

impl Drop for HapiHaptic {
    /// The board would hold its torque for ever. One that has lost its place is set up as one
    /// that does not know where it is: only a board that is set up takes a zero.
    fn drop(&mut self) {
        self.write([0.0; ARMS], 0);
        if self.is_silent && matches!(self.settle(&mut 0), Ok(None)) {
            self.begin(UNKNOWN_DEG);
        }
    }
}

impl HapticDevice for HapiHaptic {
    fn capabilities(&self) -> DeviceCapabilities {
        DeviceCapabilities {
            force_max_n: self.generation.force_max_n as f32,
            force_continuous_n: self.generation.force_continuous_n as f32,
            torque_max_n_m: 0.0,
            stiffness_max_n_m: self.generation.stiffness_max_n_m as f32,
            damping_max_n_s_m: self.generation.damping_max_n_s_m as f32,
            damping_n_s_m: self.generation.damping_n_s_m as f32,
            delay_s: self.generation.delay_s as f32,
            workspace_radius_m: self.generation.radius_m as f32,
            // As often as it is asked.
            rate_hz: 1000.0,
        }
    }

    /// In the plane: of the force's three directions it drops one.
    fn freedom(&self) -> Freedom {
        Freedom {
            measured: 2,
            rendered: 2,
        }
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        let mut bytes = [0; BYTES_PER_POLL];
        let (count, at_ns) = match self.line.read(&mut bytes) {
            Read::Bytes(count, at_ns) => (count, at_ns),
            Read::Lost => return Polled::Lost,
            Read::Empty => (0, now_ns),
        };
        let mut newest = None;
        for &byte in bytes.iter().take(count) {
            let Some(read) = self.reader.push(byte) else {
                continue;
            };
            let good = read.ok().map(swapped).and_then(|angles_deg| {
                let position_m = self.place(angles_deg);
                if position_m.is_none() || !self.gate.admit(angles_deg, at_ns) {
                    self.reader.refuse();
                    return None;
                }
                position_m
            });
            match good {
                Some(position_m) => {
                    self.counters.frames += 1;
                    self.sequence = self.sequence.wrapping_add(1);
                    self.asked_ns = None;
                    newest = Some(position_m);
                }
                None => self.counters.bad_frames += 1,
            }
        }
        // Answers come whole, or not at all: what is left must not be taken for the next one's
        // head.
        if count > 0 && self.reader.waiting() > 0 && now_ns.saturating_sub(at_ns) > LEFT_OVER_NS {
            self.counters.bad_frames += 1;
            self.reader.clear();
        }
        // Whatever it says: it may be set up no more, and answer with its name alone.
        let is_overdue = |asked_ns| now_ns.saturating_sub(asked_ns) > LOST_NS;
        if !self.is_silent && self.asked_ns.is_some_and(is_overdue) {
            self.is_silent = true;
            self.write([0.0; ARMS], now_ns);
        }
        if self.is_silent {
            return Polled::Lost;
        }
        newest.map_or(Polled::Nothing, |position_m| {
            Polled::Fresh(DeviceSample {
                device_from_handle: Pose::from_parts(position_m.into(), Quat::identity()),
                velocity_m_s: None,
                buttons: Buttons::default(),
                sequence: self.sequence,
                at_ns,
            })
        })
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        let mut force_n = command.force_n;
        let norm = force_n.norm();
        let max_n = self.generation.force_max_n as f32;
        if norm > max_n {
            force_n *= max_n / norm;
        }
        let torque_n_m = match self.gate.last() {
            Some(angles_deg) if norm.is_finite() && !self.is_silent => {
                self.generation.torques_n_m(angles_deg, force_n)
            }
            _ => None,
        };
        self.write(swapped(torque_n_m.unwrap_or_default()), now_ns);
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}
