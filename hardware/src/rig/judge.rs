//! Judges the samples of a rig by the device's own clock: that clock, frozen positions, leaps,
//! bundles, noise, and the confirmation of forces. Arrival times depend on this computer, so a late
//! host is never taken for a fault of the device.

use rt_core::fault::{Fault, FaultSet};
use rt_core::math::Vec3;
use rt_core::port::Findings;
use rt_core::time::TimeNs;

use super::bundles::Bundles;
use super::trail::Trail;
use super::wire::{State, Status};
use crate::noise::Noise;

/// Consecutive samples that must agree before a leap, or a clock that was wrong, is believed.
/// Damage on the line does not move so many samples to one place.
const AGREEING: u32 = 8;
/// Samples in a row that repeat one clock reading before the clock counts as standing still. Two
/// samples may fall into one microsecond; twenty never do.
const STUCK: u32 = 20;
/// Distance that a sample may add to the way at [`FASTEST_M_S`] from the one before, m: noise.
const NOISE_M: f32 = 0.003;
/// Speed above which a hand leaps, m/s. Thrown handles reach 3 m/s.
const FASTEST_M_S: f32 = 10.0;
/// Way that a measured velocity must promise before a standing position is frozen, m. Encoders
/// resolve a tenth of it.
const PROMISED_M: f32 = 0.0005;
/// Slowest measured velocity that promises a way, m/s: slower ones are noise of a resting hand.
const MOVING_M_S: f32 = 0.005;
/// Pause of the host after which samples may have waited, ns.
const HOST_PAUSE_NS: u64 = 20_000_000;
/// Polls without a backlog after which it counts as drained: the reading thread, which stood still
/// as well, has had its turn.
const CALM_POLLS: u32 = 3;
/// Most bytes of a poll without a backlog: ten frames.
const CALM_BYTES: usize = 512;
/// Length of a window in which the device's clock is compared with this computer's, ns.
const UNIT_WINDOW_NS: u64 = 400_000_000;
/// Bad windows in a row after which the clock's unit is wrong. One may begin with a sample that
/// waited while this computer stood still.
const UNIT_WINDOWS: u32 = 2;
/// Silence that ends such a window, ns.
const UNIT_GAP_NS: u64 = 100_000_000;
/// Device time without a confirmed force after which the device is deaf, µs.
const DEAF_US: u32 = 250_000;
/// Forces that the device must have been sent in that time.
const DEAF_SENDS: u32 = 100;
/// Refused forces in a row after which the device counts as deaf: as many as leave in the time that
/// the force of a stale sample takes to fade.
const REFUSALS: u32 = 20;
/// Age of the last force sent at which the host no longer expects an answer, ns.
const SENT_LATELY_NS: u64 = 20_000_000;

/// A sample as it is judged.
#[derive(Debug, Clone, Copy)]
struct Seen {
    us: u32,
    at_m: Vec3,
}

/// Judgement of one device.
#[derive(Debug, Default)]
pub(super) struct Judge {
    polled_ns: TimeNs,
    /// Polls that must still be calm.
    unsettled: u32,
    seen: Option<Seen>,
    admitted: Option<Seen>,
    agreeing: u32,
    forward: u32,
    stuck: u32,
    clock_is_bad: bool,
    /// Windows in a row in which the clock's unit was wrong.
    bad_units: u32,
    unit_from: Option<(TimeNs, u32)>,
    arrived_ns: TimeNs,
    promised_m: Vec3,
    trail: Trail,
    noise: Noise,
    bundles: Bundles,
    confirmed: Option<(u16, u32)>,
    sends: u32,
    sent_ns: TimeNs,
    /// Forces that the line refused since it last took one.
    refusals: u32,
    is_deaf: bool,
    /// True if a fault other than a leap dropped a sample since the last admitted one.
    broke_off: bool,
    /// True if the last sample was dropped for a fault.
    dropped: bool,
    /// True while this poll has brought no sample. The findings are then those of earlier polls.
    quiet: bool,
    /// True if no sample has come for [`UNIT_GAP_NS`].
    is_silent: bool,
    findings: Findings,
    /// Status of the last sample.
    status: Status,
}

impl Judge {
    /// Begins a poll.
    pub(super) fn begin(&mut self, now_ns: TimeNs) {
        let paused_ns = now_ns.saturating_sub(self.polled_ns);
        if self.polled_ns > 0 && paused_ns > HOST_PAUSE_NS {
            self.unsettled = CALM_POLLS;
            self.unit_from = None;
        }
        // What waited for the host is no bundle of the device.
        self.bundles.begin(if self.unsettled > 0 {
            u64::MAX
        } else {
            paused_ns
        });
        self.polled_ns = now_ns;
        self.quiet = true;
        self.findings.leapt = false;
        // Silence has a name of its own.
        self.is_silent = now_ns.saturating_sub(self.arrived_ns) > UNIT_GAP_NS;
        if self.is_silent {
            self.findings.faults = FaultSet::NONE;
        }
        self.findings.bundle_ms = self.bundles.length_ms().unwrap_or(0);
    }

    /// Judges a sample. Returns its velocity, m/s, if it is good.
    pub(super) fn take(
        &mut self,
        state: &State,
        measures_velocity: bool,
        at_ns: TimeNs,
    ) -> Option<Vec3> {
        let now = Seen {
            us: state.device_time_us,
            at_m: state.position_m.into(),
        };
        let measured_m_s = measures_velocity.then(|| Vec3::from(state.velocity_m_s));
        self.status = state.status;
        self.bundles.take(now.us, at_ns);
        let mut faults = FaultSet::NONE;
        let before = self.seen.replace(now);
        self.judge_clock(before, now, at_ns, &mut faults);
        // The velocity counts here even if the device says that it does not measure one.
        self.judge_rest(before, now, &state.velocity_m_s.into(), &mut faults);
        self.judge_answer(state, &mut faults);
        let continues = self.judge_leap(before, now, &mut faults);
        let earlier = if self.quiet {
            FaultSet::NONE
        } else {
            self.findings.faults
        };
        self.quiet = false;
        self.findings.faults = earlier.with(faults);
        self.dropped = !faults.is_empty();
        if self.dropped {
            let mut leap = FaultSet::NONE;
            leap.raise(Fault::DeviceLeap);
            self.broke_off |= !faults.without(leap).is_empty();
            return None;
        }
        // The sample belongs to the time in which nobody listened.
        if self.unsettled > 0 {
            self.admitted = Some(now);
            self.trail.clear();
            self.noise.part();
            return None;
        }
        if !continues || self.broke_off {
            self.findings.leapt = true;
            self.broke_off = false;
            self.trail.clear();
            self.noise.part();
        }
        self.admitted = Some(now);
        self.noise.take(now.us, &now.at_m);
        let moved_m_s = self.trail.add(now.us, &now.at_m);
        // The faster one: the device may leave its velocity empty, or use another unit.
        Some(match measured_m_s {
            Some(said_m_s) if moved_m_s.norm() <= said_m_s.norm() => said_m_s,
            _ => moved_m_s,
        })
    }

    /// True if the last sample was dropped for a fault.
    pub(super) const fn dropped(&self) -> bool {
        self.dropped
    }

    /// Ends a poll that read so many bytes.
    pub(super) fn end(&mut self, bytes: usize) {
        if bytes <= CALM_BYTES {
            self.unsettled = self.unsettled.saturating_sub(1);
        } else if self.unsettled > 0 {
            self.unsettled = CALM_POLLS;
        }
        if self.quiet && self.findings.faults.contains(Fault::DeviceLeap) {
            let mut leap = FaultSet::NONE;
            leap.raise(Fault::DeviceLeap);
            self.findings.faults = self.findings.faults.without(leap);
        }
    }

    /// Notes that a force left.
    pub(super) fn sent(&mut self, now_ns: TimeNs) {
        self.refusals = 0;
        self.sends = self.sends.saturating_add(1);
        self.sent_ns = now_ns;
    }

    /// Notes that the line refused a force.
    pub(super) const fn refused(&mut self) {
        self.refusals = self.refusals.saturating_add(1);
    }

    /// Faults of the last poll that brought a sample, with those of the device's status. A leap
    /// lasts for its own poll only.
    pub(super) fn findings(&self) -> Findings {
        let mut findings = self.findings;
        findings.noise_um = self.noise.rms_m().map(|rms_m| (rms_m * 1.0e6) as u32);
        let faults = &mut findings.faults;
        let mut raise_if = |it: bool, fault| faults.raise_if(it && !self.is_silent, fault);
        raise_if(self.bundles.are_found(), Fault::DeviceBundles);
        raise_if(self.noise.is_found(), Fault::NoisyDevice);
        raise_if(self.status.contains(Status::FAULT), Fault::DeviceFault);
        let is_tripped = self.status.contains(Status::WATCHDOG);
        raise_if(is_tripped, Fault::DeviceWatchdog);
        raise_if(self.status.contains(Status::LIMITED), Fault::DeviceLimited);
        findings
    }

    fn judge_clock(
        &mut self,
        before: Option<Seen>,
        now: Seen,
        at_ns: TimeNs,
        faults: &mut FaultSet,
    ) {
        let Some(before) = before else { return };
        match now.us.wrapping_sub(before.us).cast_signed() {
            ..0 => {
                self.clock_is_bad = true;
                self.forward = 0;
                self.stuck = 0;
                self.unit_from = None;
            }
            0 => {
                self.stuck = self.stuck.saturating_add(1);
                self.forward = 0;
            }
            1.. => {
                self.stuck = 0;
                self.forward = self.forward.saturating_add(1);
                self.clock_is_bad &= self.forward < AGREEING;
            }
        }
        let is_still = self.stuck >= STUCK && now.at_m == before.at_m;
        faults.raise_if(is_still, Fault::FrozenDevice);
        self.judge_unit(now, at_ns);
        let unit_is_bad = self.bad_units >= UNIT_WINDOWS;
        let is_bad = self.clock_is_bad || unit_is_bad || self.stuck >= STUCK;
        faults.raise_if(is_bad && !is_still, Fault::DeviceClock);
    }

    /// Compares the device's clock with this computer's. A factor of ten allows for any delay.
    fn judge_unit(&mut self, now: Seen, at_ns: TimeNs) {
        if at_ns.saturating_sub(self.arrived_ns) > UNIT_GAP_NS || self.unsettled > 0 {
            self.unit_from = None;
        }
        self.arrived_ns = at_ns;
        let (from_ns, from_us) = *self.unit_from.get_or_insert((at_ns, now.us));
        let passed_ns = at_ns.saturating_sub(from_ns);
        if passed_ns >= UNIT_WINDOW_NS {
            let device_ns = u64::from(now.us.wrapping_sub(from_us)) * 1000;
            let is_good = (passed_ns / 10..=passed_ns * 10).contains(&device_ns);
            self.bad_units = if is_good { 0 } else { self.bad_units + 1 };
            self.unit_from = Some((at_ns, now.us));
        }
    }

    fn judge_rest(
        &mut self,
        before: Option<Seen>,
        now: Seen,
        said_m_s: &Vec3,
        faults: &mut FaultSet,
    ) {
        let Some(before) = before else { return };
        if now.at_m != before.at_m || said_m_s.norm() < MOVING_M_S {
            self.promised_m = Vec3::zeros();
            return;
        }
        let passed_us = now
            .us
            .wrapping_sub(before.us)
            .min(UNIT_GAP_NS as u32 / 1000);
        self.promised_m += said_m_s * (passed_us as f32 * 1.0e-6);
        faults.raise_if(self.promised_m.norm() > PROMISED_M, Fault::FrozenDevice);
    }

    fn judge_answer(&mut self, state: &State, faults: &mut FaultSet) {
        let (applied, us) = (state.applied_force, state.device_time_us);
        let since_us = match self.confirmed {
            Some((last, since_us)) if last == applied => since_us,
            _ => {
                self.confirmed = Some((applied, us));
                self.sends = 0;
                us
            }
        };
        // A deaf device stays deaf until it confirms a force, or, if its line refused forces, until
        // the line takes one.
        let waits = self.is_deaf || self.polled_ns.saturating_sub(self.sent_ns) <= SENT_LATELY_NS;
        let confirms_none = self.sends >= DEAF_SENDS && us.wrapping_sub(since_us) >= DEAF_US;
        // A device at fault renders no force, and says so itself.
        let is_at_fault = state.status.contains(Status::FAULT);
        self.is_deaf = !is_at_fault && ((waits && confirms_none) || self.refusals >= REFUSALS);
        faults.raise_if(self.is_deaf, Fault::DeafDevice);
    }

    /// Returns true if the sample continues the last good one. A leap is a fault until enough
    /// samples agree.
    fn judge_leap(&mut self, before: Option<Seen>, now: Seen, faults: &mut FaultSet) -> bool {
        let passed_us = |then: Seen| now.us.wrapping_sub(then.us).cast_signed().max(0);
        let is_near = |then: Seen, passed_us: i32| {
            let reach_m = NOISE_M + FASTEST_M_S * (passed_us as f32 * 1.0e-6);
            (now.at_m - then.at_m).norm() <= reach_m
        };
        let step_us = before.map_or(0, passed_us);
        // During a leap, the reach around the last good place does not grow with time.
        let since = |then: Seen| {
            if self.agreeing > 0 {
                step_us
            } else {
                passed_us(then)
            }
        };
        if self.admitted.is_none_or(|then| is_near(then, since(then))) {
            self.agreeing = 0;
            return true;
        }
        let agrees = self.agreeing > 0 && before.is_some_and(|then| is_near(then, step_us));
        self.agreeing = if agrees { self.agreeing + 1 } else { 1 };
        faults.raise_if(self.agreeing < AGREEING, Fault::DeviceLeap);
        false
    }
}

#[cfg(test)]
mod tests;
