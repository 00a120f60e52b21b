//! Driver of a haptic device that speaks the rig protocol.

use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, Echo, Findings, ForceCommand, HapticDevice,
    Identity, LineCounters, Opening, Polled, Reading,
};
use rt_core::time::TimeNs;

use super::echo::Echoes;
use super::host::{BadReason, Host};
use super::judge::Judge;
use super::watchdog::{Watchdog, WatchdogDrops};
use super::wire::{Capabilities, DeviceKind, Field, Force, State, Status, WireError};
use crate::HardwareError;
use crate::line::Line;

/// A haptic device that has answered the greeting.
#[derive(Debug)]
pub struct RigHaptic {
    host: Host,
    declared: Capabilities,
    status: RigStatus,
    judge: Judge,
    echoes: Echoes,
    watchdog: Watchdog,
    /// Velocity that the device reported with its newest sample; `None` if it measures none.
    reported_m_s: Option<Vec3>,
}

/// Status that the device last reported, without its pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RigStatus {
    /// Status bits.
    pub status: Status,
    /// Sequence number of the force that the device renders.
    pub applied_force: u16,
    /// The device's clock, µs; wraps.
    pub device_time_us: u32,
    /// Time at which it arrived.
    pub at_ns: TimeNs,
}

impl RigHaptic {
    /// Opens the line, greets the device and checks its capabilities. Waits up to 5 s for the
    /// answer, so the tick must not call it.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        Ok(Self::of(Host::open(path, DeviceKind::Haptic)?))
    }

    /// Opens the device on an open line.
    pub(crate) fn on(line: Line) -> Result<Self, HardwareError> {
        Ok(Self::of(Host::on(line, DeviceKind::Haptic)?))
    }

    fn of((host, declared): (Host, Capabilities)) -> Self {
        Self {
            host,
            declared,
            status: RigStatus::default(),
            judge: Judge::default(),
            echoes: Echoes::default(),
            watchdog: Watchdog::default(),
            reported_m_s: None,
        }
    }

    /// Capabilities that the device reported when it was opened.
    #[must_use]
    pub const fn declared(&self) -> &Capabilities {
        &self.declared
    }

    /// Status of the last sample within the allowed ranges, even if the sample was then judged
    /// wrong.
    #[must_use]
    pub const fn status(&self) -> RigStatus {
        self.status
    }

    /// Sequence number of the last force, sent or refused. [`RigStatus::applied_force`] reports it
    /// once that force is in effect.
    #[must_use]
    pub fn sent_sequence(&self) -> u16 {
        self.host.sent_sequence()
    }

    /// Drops of the force by the device's watchdog so far.
    #[must_use]
    pub const fn drops(&self) -> WatchdogDrops {
        self.watchdog.drops()
    }

    /// Number of samples so far that came whole and were refused.
    #[must_use]
    pub fn refused_samples(&self) -> u64 {
        let bad = self.host.bad();
        let of = |why: BadReason| bad.get(why as usize).copied().unwrap_or(0);
        BadReason::OF_SAMPLES.into_iter().map(of).sum()
    }

    /// Number of bad frames so far by reason.
    pub fn bad_frames(&self) -> impl Iterator<Item = (&'static str, u64)> + use<> {
        BadReason::NAMES.into_iter().zip(self.host.bad())
    }

    /// Path of the line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.host.path()
    }

    /// True if the line is lost. Then open the path anew on a thread that may wait, exchange the
    /// drivers in the tick, and drop this one outside the tick.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.host.is_lost()
    }
}

impl RigHaptic {
    /// Reads the received bytes, and returns the newest sample. `each` gets every good sample.
    fn read(&mut self, now_ns: TimeNs, mut each: impl FnMut(&Reading)) -> Polled<DeviceSample> {
        let reach_m = self.declared.workspace_radius_m * REACH;
        let measures_velocity = self.declared.measures_velocity;
        let mut newest = None;
        let judge = &mut self.judge;
        judge.begin(now_ns);
        let echoes = &mut self.echoes;
        echoes.begin();
        let watchdog = &mut self.watchdog;
        let mut status = self.status;
        let mut reported_m_s = self.reported_m_s;
        let opens = self.declared.opening.is_some();
        let mut rejected = [0; BadReason::COUNT];
        let mut reject = |why: BadReason| {
            if let Some(count) = rejected.get_mut(why as usize) {
                *count += 1;
            }
        };
        let read = self
            .host
            .receive(|message, at_ns| match State::parse(message) {
                Err(WireError::Range(field)) => reject(field.into()),
                Err(_) => reject(BadReason::Message),
                Ok(state) if state.opening.is_some() != opens => reject(BadReason::Message),
                Ok(state) if Vec3::from(state.position_m).norm() > reach_m => {
                    reject(BadReason::Reach);
                }
                Ok(state) => {
                    let raw_m_s = Vec3::from(state.velocity_m_s);
                    reported_m_s = Some(raw_m_s);
                    echoes.take(&state);
                    watchdog.take(&state);
                    status = RigStatus {
                        status: state.status,
                        applied_force: state.applied_force,
                        device_time_us: state.device_time_us,
                        at_ns,
                    };
                    let velocity_m_s = judge.take(&state, measures_velocity, at_ns);
                    if velocity_m_s.is_none() && judge.dropped() {
                        reject(BadReason::Judged);
                        return;
                    }
                    let sample = sample(&state, message.sequence(), velocity_m_s, at_ns);
                    each(&Reading {
                        sample,
                        reported_m_s: measures_velocity.then_some(raw_m_s),
                        device_time_us: Some(state.device_time_us),
                        status: Some(state.status.0),
                    });
                    // A sample without velocity waited for this computer, so it is too old.
                    if velocity_m_s.is_some() {
                        newest = Some(sample);
                        echoes.use_sample(&state, at_ns);
                    }
                }
            });
        self.host.reject(&rejected);
        self.reported_m_s = reported_m_s.filter(|_| measures_velocity);
        self.judge.end(read.unwrap_or(0));
        self.status = status;
        match (newest, read) {
            (Some(sample), _) => Polled::Fresh(sample),
            (None, Some(_)) => Polled::Nothing,
            (None, None) => Polled::Lost,
        }
    }
}

impl From<Field> for BadReason {
    fn from(field: Field) -> Self {
        match field {
            Field::Position => Self::Position,
            Field::Velocity => Self::Velocity,
            Field::Rotation => Self::Rotation,
            Field::Other => Self::Range,
        }
    }
}

impl From<&Capabilities> for DeviceCapabilities {
    fn from(said: &Capabilities) -> Self {
        Self {
            force_max_n: said.force_max_n,
            force_continuous_n: said.force_continuous_n,
            stiffness_max_n_m: said.stiffness_max_n_m,
            damping_max_n_s_m: said.damping_max_n_s_m,
            workspace_radius_m: said.workspace_radius_m,
            torque_max_nm: said.torque_max_nm,
            opening: said.opening.map_or(Opening::NONE, |it| Opening {
                travel_m: it.travel_m,
                force_max_n: it.force_max_n,
                stiffness_max_n_m: it.stiffness_max_n_m,
            }),
            damping_n_s_m: said.damping_n_s_m,
            delay_s: said.delay_s,
            rate_hz: said.rate_hz.into(),
        }
    }
}

impl HapticDevice for RigHaptic {
    fn capabilities(&self) -> DeviceCapabilities {
        (&self.declared).into()
    }

    fn identity(&self) -> Identity {
        Identity::new(&self.declared.name, self.declared.serial)
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        self.read(now_ns, |_| {})
    }

    fn poll_each(
        &mut self,
        now_ns: TimeNs,
        each: &mut dyn FnMut(&Reading),
    ) -> Polled<DeviceSample> {
        self.read(now_ns, each)
    }

    fn watchdog_ms(&self) -> Option<u16> {
        Some(self.declared.watchdog_ms.into())
    }

    fn reported_velocity_m_s(&self) -> Option<Vec3> {
        self.reported_m_s
    }

    fn findings(&self) -> Findings {
        self.judge.findings()
    }

    fn echo(&self) -> Option<Echo> {
        self.echoes.found()
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        // The core has already limited force and torque. These limits are the last guard of the
        // device's peak.
        let force_n = within(command.force_n, self.declared.force_max_n);
        let torque_nm = within(command.torque_nm, self.declared.torque_max_nm);
        let sequence = self.host.next_sequence();
        let force = Force {
            force_n: force_n.into(),
            torque_nm: torque_nm.into(),
            opening_n: self.declared.opening.map(|it| {
                let most_n = it.force_max_n;
                within(Vec3::new(command.opening_n, 0.0, 0.0), most_n).x
            }),
        };
        let dropped = self.host.counters().dropped_writes;
        self.host.send(&force.frame(sequence));
        self.echoes.sent(sequence);
        if self.host.counters().dropped_writes == dropped {
            self.judge.sent(now_ns);
        } else {
            self.judge.refused();
        }
    }

    fn counters(&self) -> LineCounters {
        self.host.counters()
    }
}

/// `wanted`, shortened to at most `limit`; zero if it is not finite.
fn within(wanted: Vec3, limit: f32) -> Vec3 {
    let norm = wanted.norm();
    if norm <= limit {
        wanted
    } else if norm.is_finite() {
        wanted * (limit / norm)
    } else {
        Vec3::zeros()
    }
}

/// Farthest plausible position from the middle, in workspace radii. It lies beyond the mechanical
/// stops.
const REACH: f32 = 2.0;

fn sample(state: &State, sequence: u16, velocity_m_s: Option<Vec3>, at_ns: TimeNs) -> DeviceSample {
    let [x, y, z, w] = state.rotation_xyzw;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    DeviceSample {
        device_from_handle: Pose::from_parts(Vec3::from(state.position_m).into(), rotation),
        velocity_m_s,
        buttons: Buttons(state.buttons),
        opening: state.opening,
        sequence,
        at_ns,
    }
}
