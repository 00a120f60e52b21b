//! Typical mistakes in the first firmware of a rig. The conformance suite or `feel` must find each
//! of them.

use rt_core::math::Vec3;

use super::random::Random;
use crate::rig::device::{Device, Motion};
use crate::rig::frame::{Frame, FrameReader};
use crate::rig::wire::{Capabilities, Force, Message, State, Status};

/// A mistake in the firmware of the emulated rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// Positions and velocities a thousand times too small.
    PositionsInMillimetres,
    /// Positions and velocities ten times too small.
    PositionsTenfold,
    /// Positions and velocities with y and z exchanged.
    AxesExchanged,
    /// Positions and velocities with left and right exchanged.
    Mirrored,
    /// Velocity declared as measured and left zero.
    VelocityZero,
    /// Velocity a thousand times too small.
    VelocityInMillimetres,
    /// Velocity with the wrong sign.
    VelocityNegated,
    /// Force with the wrong sign.
    ForceNegated,
    /// Force with y and z exchanged.
    ForceExchanged,
    /// Half of the force.
    ForceWeak,
    /// No force at all.
    ForceMissing,
    /// Forces above 0.6 N with the wrong sign, as after an integer overflow.
    ForceOverflows,
    /// Opening 1 shut and 0 wide open.
    OpeningReversed,
    /// Force along the opening with the wrong sign.
    OpeningForceNegated,
    /// Clock in milliseconds.
    ClockInMilliseconds,
    /// Clock that stands at zero.
    ClockZero,
    /// Clock that runs 3 % too fast.
    ClockFast,
    /// No watchdog.
    WatchdogMissing,
    /// Watchdog that acts in time in one of three cases, and after 2.5 s in the other two.
    WatchdogFlaky,
    /// Watchdog of 95 ms, declared as 50 ms.
    WatchdogSlow,
    /// Watchdog that only sets its status bit: the motors keep the force.
    WatchdogInStatusOnly,
    /// Status that reports a force as in effect only if the force is not zero.
    StatusNonzero,
    /// Status that reports a fault all the time.
    Fault,
    /// Half of the declared sample rate.
    RateHalf,
    /// Positions that never change, although the velocity does.
    Frozen,
    /// Positions that leap by 50 mm for three samples, five times a second.
    Leaps,
    /// Positions with noise of 0.5 mm rms.
    Noisy,
    /// Declared damping far beyond any device.
    DampingAbsurd,
    /// Declared delay of 0, although commands are confirmed 6 ms late.
    DelayUndeclared,
    /// Checksum with its bytes in the wrong order.
    ChecksumReversed,
    /// Frames without a closing zero.
    NoClosingZero,
    /// CAPABILITIES one byte short.
    AnswerShort,
    /// Samples, but no answer to HELLO.
    NoAnswer,
}

impl Mistake {
    /// All mistakes.
    pub const ALL: [Self; 33] = [
        Self::PositionsInMillimetres,
        Self::PositionsTenfold,
        Self::AxesExchanged,
        Self::Mirrored,
        Self::VelocityZero,
        Self::VelocityInMillimetres,
        Self::VelocityNegated,
        Self::ForceNegated,
        Self::ForceExchanged,
        Self::ForceWeak,
        Self::ForceMissing,
        Self::ForceOverflows,
        Self::OpeningReversed,
        Self::OpeningForceNegated,
        Self::ClockInMilliseconds,
        Self::ClockZero,
        Self::ClockFast,
        Self::WatchdogMissing,
        Self::WatchdogFlaky,
        Self::WatchdogSlow,
        Self::WatchdogInStatusOnly,
        Self::StatusNonzero,
        Self::Fault,
        Self::RateHalf,
        Self::Frozen,
        Self::Leaps,
        Self::Noisy,
        Self::DampingAbsurd,
        Self::DelayUndeclared,
        Self::ChecksumReversed,
        Self::NoClosingZero,
        Self::AnswerShort,
        Self::NoAnswer,
    ];

    /// Name for a command line, e.g. `force-negated`.
    #[must_use]
    pub fn name(self) -> String {
        let mut name = String::new();
        for letter in format!("{self:?}").chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('-');
            }
            name.push(letter.to_ascii_lowercase());
        }
        name
    }
}

/// True watchdog time of a device that declares 50 ms, ms.
const SLOW_MS: u8 = 95;
/// Force above which the number of a force overflows, N.
const OVERFLOW_N: f32 = 0.6;
/// Time for which a flaky watchdog fails, µs.
const FLAKY_US: u32 = 2_500_000;
/// Rms length of the noise of a noisy device, m.
const NOISE_M: f32 = 0.0005;
/// Number of samples by which a device with an undeclared delay confirms commands late.
const LATE_SAMPLES: usize = 6;

/// Firmware of the emulated rig, with at most one mistake.
#[derive(Debug)]
pub(super) struct RigFirmware {
    device: Device,
    mistake: Option<Mistake>,
    /// Time of the newest bytes from the host, µs.
    last_bytes_us: u32,
    trips: u32,
    samples: u32,
    frozen_at_m: Option<[f32; 3]>,
    confirmed: [u16; LATE_SAMPLES],
    random: Random,
    /// The last commanded force, N.
    commanded_n: Vec3,
}

impl RigFirmware {
    pub(super) fn new(capabilities: Capabilities, mistake: Option<Mistake>) -> Self {
        let mut inner = capabilities;
        if mistake == Some(Mistake::WatchdogSlow) {
            inner.watchdog_ms = SLOW_MS;
        }
        if mistake == Some(Mistake::DampingAbsurd) {
            inner.damping_n_s_m = 65.0;
        }
        if mistake == Some(Mistake::DelayUndeclared) {
            inner.delay_s = 0.0;
        }
        Self {
            device: Device::new(inner),
            mistake,
            last_bytes_us: 0,
            trips: 0,
            samples: 0,
            frozen_at_m: None,
            confirmed: [0; LATE_SAMPLES],
            random: Random::new(0, 0),
            commanded_n: Vec3::zeros(),
        }
    }

    fn has(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    pub(super) fn is_commanded(&self) -> bool {
        self.device.is_commanded()
    }

    pub(super) fn set_limited(&mut self, limited: bool) {
        self.device.set_limited(limited);
    }

    /// Takes the host's bytes, and returns the answer to a greeting.
    pub(super) fn receive(&mut self, bytes: &[u8], now_us: u32) -> Option<Vec<u8>> {
        if !bytes.is_empty() {
            self.last_bytes_us = now_us;
        }
        self.device.receive(bytes, now_us);
        let answer = self.device.answer()?;
        match self.mistake {
            Some(Mistake::NoAnswer) => None,
            Some(Mistake::WatchdogSlow) => {
                let mut declared = parsed(&answer, Capabilities::parse)?;
                declared.watchdog_ms = 50;
                Some(declared.frame(1).as_bytes().to_vec())
            }
            Some(Mistake::AnswerShort) => {
                let payload = payload(&answer)?;
                let short = payload.get(..payload.len() - 1)?;
                Some(Frame::new(short)?.as_bytes().to_vec())
            }
            _ => Some(self.sent(&answer)),
        }
    }

    /// Time that the watchdog is given, µs.
    fn watchdog_time_us(&self, now_us: u32) -> u32 {
        let silent_us = now_us.wrapping_sub(self.last_bytes_us);
        match self.mistake {
            // This watchdog's time stands still, so it never acts.
            Some(Mistake::WatchdogMissing) => self.last_bytes_us,
            Some(Mistake::WatchdogFlaky)
                if !self.trips.is_multiple_of(3) && silent_us < FLAKY_US =>
            {
                self.last_bytes_us
            }
            _ => now_us,
        }
    }

    /// Force of the motors now, N.
    pub(super) fn force_n(&mut self, now_us: u32) -> Vec3 {
        let seen_us = self.watchdog_time_us(now_us);
        let had = self.device.is_commanded();
        let Force { force_n, .. } = self.device.force(seen_us);
        if had && !self.device.is_commanded() {
            self.trips += 1;
        }
        let [x, y, z] = force_n;
        if self.device.is_commanded() {
            self.commanded_n = Vec3::new(x, y, z);
        }
        match self.mistake {
            Some(Mistake::WatchdogInStatusOnly) => self.commanded_n,
            Some(Mistake::ForceOverflows) if Vec3::new(x, y, z).norm() > OVERFLOW_N => {
                -Vec3::new(x, y, z)
            }
            Some(Mistake::ForceNegated) => -Vec3::new(x, y, z),
            Some(Mistake::ForceExchanged) => Vec3::new(x, z, y),
            Some(Mistake::ForceWeak) => Vec3::new(x, y, z) * 0.5,
            Some(Mistake::ForceMissing) => Vec3::zeros(),
            _ => Vec3::new(x, y, z),
        }
    }

    /// Force of the motor that opens the handle, N.
    pub(super) fn opening_n(&mut self, now_us: u32) -> f32 {
        let seen_us = self.watchdog_time_us(now_us);
        let opening_n = self.device.force(seen_us).opening_n.unwrap_or_default();
        if self.has(Mistake::OpeningForceNegated) {
            return -opening_n;
        }
        opening_n
    }

    /// The next sample as bytes, if one is due.
    pub(super) fn state(&mut self, motion: &Motion, now_us: u32) -> Option<Vec<u8>> {
        self.samples = self.samples.wrapping_add(1);
        if self.has(Mistake::RateHalf) && self.samples.is_multiple_of(2) {
            return None;
        }
        self.device.set_fault(self.has(Mistake::Fault));
        let motion = self.with_mistake(*motion);
        let seen_us = self.watchdog_time_us(now_us);
        let sample = self.device.state(&motion, seen_us)?;
        let mut state = parsed(&sample, State::parse)?;
        state.device_time_us = match self.mistake {
            Some(Mistake::ClockInMilliseconds) => now_us / 1000,
            Some(Mistake::ClockZero) => 0,
            Some(Mistake::ClockFast) => (f64::from(now_us) * 1.03) as u32,
            _ => now_us,
        };
        if self.has(Mistake::StatusNonzero) {
            let force_n = Vec3::from(self.device.force(seen_us).force_n);
            if force_n.norm() <= 0.0 {
                state.status.0 &= !Status::FORCE_ON.0;
            }
        }
        if self.has(Mistake::DelayUndeclared) {
            let late = self.confirmed.first().copied().unwrap_or(0);
            self.confirmed.rotate_left(1);
            if let Some(last) = self.confirmed.last_mut() {
                *last = state.applied_force;
            }
            state.applied_force = late;
        }
        Some(self.sent(&state.frame(sequence(&sample)?)))
    }

    fn with_mistake(&mut self, mut motion: Motion) -> Motion {
        let scale = |vector: [f32; 3], by: f32| vector.map(|part| part * by);
        let [x, y, z] = motion.position_m;
        let [u, v, w] = motion.velocity_m_s;
        match self.mistake {
            Some(Mistake::PositionsInMillimetres) => {
                motion.position_m = scale(motion.position_m, 1.0e-3);
                motion.velocity_m_s = scale(motion.velocity_m_s, 1.0e-3);
            }
            Some(Mistake::PositionsTenfold) => {
                motion.position_m = scale(motion.position_m, 0.1);
                motion.velocity_m_s = scale(motion.velocity_m_s, 0.1);
            }
            Some(Mistake::AxesExchanged) => {
                motion.position_m = [x, z, y];
                motion.velocity_m_s = [u, w, v];
            }
            Some(Mistake::Mirrored) => {
                motion.position_m = [-x, y, z];
                motion.velocity_m_s = [-u, v, w];
            }
            Some(Mistake::VelocityZero) => motion.velocity_m_s = [0.0; 3],
            Some(Mistake::VelocityInMillimetres) => {
                motion.velocity_m_s = scale(motion.velocity_m_s, 1.0e-3);
            }
            Some(Mistake::VelocityNegated) => {
                motion.velocity_m_s = scale(motion.velocity_m_s, -1.0);
            }
            Some(Mistake::OpeningReversed) => motion.opening = 1.0 - motion.opening,
            Some(Mistake::Frozen) => {
                motion.position_m = *self.frozen_at_m.get_or_insert(motion.position_m);
            }
            Some(Mistake::Leaps) if self.samples % 200 < 3 => {
                motion.position_m = [x + 0.05, y, z];
            }
            // A uniform distribution over ±1 has a mean square of 1/3, so three axes together have
            // 1.
            Some(Mistake::Noisy) => {
                motion.position_m = motion
                    .position_m
                    .map(|part| part + self.random.between(-NOISE_M, NOISE_M));
            }
            _ => {}
        }
        motion
    }

    /// Bytes of a frame as this firmware sends them.
    fn sent(&self, frame: &Frame) -> Vec<u8> {
        let mut bytes = frame.as_bytes().to_vec();
        match self.mistake {
            Some(Mistake::NoClosingZero) => {
                bytes.pop();
            }
            Some(Mistake::ChecksumReversed) => {
                bytes.pop();
                if let Ok(plain) = cobs::decode_in_place(&mut bytes)
                    && let Some(checksum) = bytes.get_mut(plain - 4..plain)
                {
                    checksum.reverse();
                    let mut stuffed = vec![0; cobs::max_encoding_length(plain)];
                    let length = cobs::encode(bytes.get(..plain).unwrap_or(&[]), &mut stuffed);
                    stuffed.truncate(length);
                    bytes = stuffed;
                }
                bytes.push(0);
            }
            _ => {}
        }
        bytes
    }
}

/// Payload of a frame.
fn payload(frame: &Frame) -> Option<Vec<u8>> {
    let mut reader = FrameReader::new();
    frame.as_bytes().iter().find_map(|&byte| {
        let read = reader.push(byte)?;
        read.ok().map(<[u8]>::to_vec)
    })
}

fn parsed<T, E>(frame: &Frame, parse: impl Fn(&Message<'_>) -> Result<T, E>) -> Option<T> {
    let payload = payload(frame)?;
    parse(&Message::new(&payload).ok()?).ok()
}

fn sequence(frame: &Frame) -> Option<u16> {
    let payload = payload(frame)?;
    Some(Message::new(&payload).ok()?.sequence())
}
