//! Driver of a flat two-armed device on a hAPI board.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Quat, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Freedom, HapticDevice, LineCounters,
    Opening, Polled,
};
use rt_core::time::TimeNs;

use super::pantograph::{Pantograph, swapped};
use super::wire::{ARMS, AnswerReader, ID, SET_UP_BYTES, set_up, torques};
use crate::HardwareError;
use crate::gate::Gate;
use crate::line::{Line, Read, Written, now_ns};

/// Bit rate of the line. The board's USB ignores it.
pub(crate) const BAUD: u32 = 115_200;
const NAME: &str = "Haply hAPI board";
/// Longest handshake. The firmware waits up to 1 s for the rest of a broken command.
const HANDSHAKE: Duration = Duration::from_secs(3);
/// Longest wait for an answer. A board answers within a millisecond; a busy host may read it later.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(150);
/// Time after which the board has read everything and expects a command.
const SETTLE_TIME: Duration = Duration::from_millis(5);
/// Number of requests without a complete answer after which the board is set up anew.
const REQUESTS_MAX: u32 = 8;
/// Angles for a board that does not know its own. No arm can turn this far, so neither these angles
/// nor later ones relative to them are mistaken for real ones.
const UNKNOWN_DEG: [f32; ARMS] = [560.0; ARMS];
/// Largest angle between an arm and the line of the motors, in any generation, degrees.
const TURN_MAX_DEG: f32 = 390.0;
/// Zeros that complete any incomplete command with floats near zero. The board reads the remaining
/// zeros as resets.
const ZEROS: [u8; SET_UP_BYTES] = [0; SET_UP_BYTES];
/// Largest number of bytes that one poll reads: 56 answers.
const BYTES_PER_POLL: usize = 512;
/// Farthest plausible position from the middle, in workspace radii.
const REACH: f32 = 3.0;
/// Fastest plausible turn of an arm, degrees per second.
const SPEED_LIMIT_DEG_S: f32 = 2000.0;
/// Noise of an angle, degrees, allowed on top of that turn.
const NOISE_DEG: f32 = 0.3;
/// Age above which an incomplete answer is dropped, ns.
const INCOMPLETE_NS: u64 = 500_000;
/// Time without an answer after which the board counts as lost, ns. It has then lost its angles or
/// its power and must be opened anew. Until then it may hold a torque.
const LOST_NS: u64 = 100_000_000;

/// A board with a flat two-armed device. It only answers commands: without [`HapticDevice::send`]
/// there are no samples.
#[derive(Debug)]
pub struct HapiHaptic {
    line: Line,
    generation: Pantograph,
    reader: AnswerReader,
    gate: Gate<ARMS>,
    counters: LineCounters,
    sequence: u16,
    /// Number of bytes of the last command that the line did not take. They are sent before the
    /// next command, as zeros.
    unsent_bytes: usize,
    /// Time of the oldest unanswered command.
    asked_ns: Option<TimeNs>,
    is_silent: bool,
}

/// Answer of a board to a torque command.
enum Answer {
    /// The board is set up: angles of arms 1 and 2, degrees.
    Angles([f32; ARMS]),
    /// The board is not set up and answers with our id only.
    Name,
    /// No answer, or an invalid one.
    Nothing,
}

impl HapiHaptic {
    /// Opens the line, removes any torque, and sets the board up.
    ///
    /// A board that Calot has set up since power-up knows its angles. For any other board the
    /// handle must be **at home** now, because its encoders count from there. Waits up to 4 s, so
    /// the tick must not call it.
    pub fn open(path: &Path, generation: Pantograph) -> Result<Self, HardwareError> {
        Self::on(Line::open(path, BAUD)?, generation, generation.home_deg)
    }

    /// Opens the device after a loss, when nobody holds the handle at home. A board that no longer
    /// knows its angles is refused, without torque.
    pub fn reopen(path: &Path, generation: Pantograph) -> Result<Self, HardwareError> {
        Self::on(Line::open(path, BAUD)?, generation, UNKNOWN_DEG)
    }

    /// Opens the device on an open line. `default_deg` are the angles for a board that does not
    /// know its own.
    pub(crate) fn on(
        line: Line,
        generation: Pantograph,
        default_deg: [f32; ARMS],
    ) -> Result<Self, HardwareError> {
        let path = line.path().to_path_buf();
        let mut board = Self {
            line,
            generation,
            reader: AnswerReader::default(),
            gate: Gate::new(SPEED_LIMIT_DEG_S, NOISE_DEG),
            counters: LineCounters::default(),
            sequence: 0,
            unsent_bytes: 0,
            asked_ns: None,
            is_silent: false,
        };
        // If the greeting fails, `drop` may send a zero but must not give the board angles.
        let angles_deg = board.greet(default_deg)?;
        if board.plausible_position_m(angles_deg).is_none() {
            return Err(HardwareError::Calibration {
                path,
                remedy: "The board does not know the angles of its arms. End Calot, switch the board off and on, hold the handle \
                         at home (near the motors)",
            });
        }
        board.gate.begin(angles_deg, now_ns());
        board.asked_ns = None;
        board.counters = LineCounters::default();
        Ok(board)
    }

    /// Path of the line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.line.path()
    }

    /// True if the line is lost or the board has lost its angles; see
    /// [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.is_silent || self.line.is_lost()
    }

    /// Last position of the handle, base frame, m; the home position before the first sample.
    #[must_use]
    pub fn position_m(&self) -> Vec3 {
        let angles_deg = self.gate.last().unwrap_or(self.generation.home_deg);
        self.generation.position_m(angles_deg).unwrap_or_default()
    }

    /// Removes any torque. Returns the angles of a board that knows them; any other board is given
    /// `default_deg`.
    fn greet(&mut self, default_deg: [f32; ARMS]) -> Result<[f32; ARMS], HardwareError> {
        let start = Instant::now();
        let mut heard = 0;
        // On a board that is set up, this removes the torque within a millisecond.
        self.write([0.0; ARMS], now_ns());
        loop {
            if let Some(angles_deg) = self.confirm_zero_torque(&mut heard)? {
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
            self.set_up_board(default_deg);
        }
    }

    /// Waits until the board has certainly received a zero torque. It does not set the board up, so
    /// a slow board keeps its angles. Returns `None` if the board is not set up, or does not answer
    /// for long.
    fn confirm_zero_torque(
        &mut self,
        heard: &mut u64,
    ) -> Result<Option<[f32; ARMS]>, HardwareError> {
        // The first answer may belong to an incomplete command of another host. Our zeros then
        // complete that command, and their rest resets the board with the motors on. Only a second
        // answer proves that the zero torque arrived.
        let mut is_sure = false;
        for _ in 0..REQUESTS_MAX {
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

    /// Brings the board from any state to zero torque, and requests an answer. A reset would leave
    /// the motors on, and only a board that is set up takes a torque. So the board is set up first.
    fn set_up_board(&mut self, angles_deg: [f32; ARMS]) {
        self.line.write(&ZEROS);
        self.unsent_bytes = 0;
        thread::sleep(SETTLE_TIME);
        self.line.write(&set_up(&self.generation.ports(angles_deg)));
        self.line.write(&torques([0.0; ARMS]));
    }

    /// Waits up to [`ANSWER_TIMEOUT`] for an answer.
    fn answer(&mut self, heard: &mut u64) -> Result<Answer, HardwareError> {
        let asked = Instant::now();
        let (mut count_now, mut last) = (0, 0);
        let mut found = None;
        self.reader.clear();
        while found.is_none() && asked.elapsed() < ANSWER_TIMEOUT {
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

    /// Position of the handle, if it is plausible.
    fn plausible_position_m(&self, angles_deg: [f32; ARMS]) -> Option<Vec3> {
        let reach_m = self.generation.radius_m as f32 * REACH;
        if angles_deg.iter().any(|deg| deg.abs() > TURN_MAX_DEG) {
            return None;
        }
        self.generation
            .position_m(angles_deg)
            .filter(|position_m| position_m.norm() <= reach_m)
    }

    fn write(&mut self, torque_nm: [f32; ARMS], now_ns: TimeNs) {
        if self.unsent_bytes > 0 {
            let rest = ZEROS.get(..self.unsent_bytes).unwrap_or(&ZEROS);
            match self.line.write(rest) {
                Written::All => self.unsent_bytes = 0,
                Written::Part(count) => self.unsent_bytes = self.unsent_bytes.saturating_sub(count),
                Written::Nothing => {}
            }
        }
        let command = torques(torque_nm);
        let written = if self.unsent_bytes > 0 {
            Written::Nothing
        } else {
            self.line.write(&command)
        };
        match written {
            Written::All => {
                self.asked_ns.get_or_insert(now_ns);
            }
            Written::Part(count) => {
                self.unsent_bytes = command.len() - count;
                self.counters.dropped_writes += 1;
            }
            Written::Nothing => self.counters.dropped_writes += 1,
        }
    }
}

impl Drop for HapiHaptic {
    /// Sends zero torque, because the board would hold its last torque for ever. Only a board that
    /// is set up takes a torque. So a board that lost its angles is first set up with impossible
    /// ones.
    fn drop(&mut self) {
        self.write([0.0; ARMS], 0);
        if self.is_silent && matches!(self.confirm_zero_torque(&mut 0), Ok(None)) {
            self.set_up_board(UNKNOWN_DEG);
        }
    }
}

impl HapticDevice for HapiHaptic {
    fn capabilities(&self) -> DeviceCapabilities {
        DeviceCapabilities {
            opening: Opening::NONE,
            force_max_n: self.generation.force_max_n as f32,
            force_continuous_n: self.generation.force_continuous_n as f32,
            torque_max_nm: 0.0,
            stiffness_max_n_m: self.generation.stiffness_max_n_m as f32,
            damping_max_n_s_m: self.generation.damping_max_n_s_m as f32,
            damping_n_s_m: self.generation.damping_n_s_m as f32,
            delay_s: self.generation.delay_s as f32,
            workspace_radius_m: self.generation.radius_m as f32,
            // The board answers as often as it is asked.
            rate_hz: 1000.0,
        }
    }

    /// Planar: one of the force's three directions is dropped.
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
                let position_m = self.plausible_position_m(angles_deg);
                if position_m.is_none() || !self.gate.admit(angles_deg, at_ns) {
                    self.reader.reject();
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
        // Answers arrive whole or not at all. A leftover part must not be read as the beginning of
        // the next answer.
        if count > 0 && self.reader.waiting() > 0 && now_ns.saturating_sub(at_ns) > INCOMPLETE_NS {
            self.counters.bad_frames += 1;
            self.reader.clear();
        }
        // Bytes alone do not show that the board still works: a board that is no longer set up
        // answers with our id only.
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
                opening: None,
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
        let torque_nm = match self.gate.last() {
            Some(angles_deg) if norm.is_finite() && !self.is_silent => {
                self.generation.torques_nm(angles_deg, force_n)
            }
            _ => None,
        };
        self.write(swapped(torque_nm.unwrap_or_default()), now_ns);
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}
