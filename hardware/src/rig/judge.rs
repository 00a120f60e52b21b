//! Judges the samples of a rig: the device's clock, frozen positions, leaps (jumps), bundles
//! (bursts of samples), noise, and the confirmation of forces.
//!
//! Times are those of the device's own clock as far as possible. Arrival times also depend on this
//! computer (the host). They serve only for bundles, silence and the unit of the device's clock.
//! After a pause of the host, bundles and the unit are not judged until the backlog is drained.

use rt_core::fault::{Fault, FaultSet};
use rt_core::math::Vec3;
use rt_core::port::Findings;
use rt_core::time::TimeNs;

use super::bundles::Bundles;
use super::wire::{State, Status};
use crate::noise::Noise;
use crate::trail::Trail;

/// Consecutive samples that must agree with each other before a leap is accepted. Damage on the
/// line does not move so many samples to one place. After a backward step of the clock, this many
/// forward steps must follow before the clock is trusted again.
const AGREEING: u32 = 8;
/// Number of repetitions of a clock reading in a row after which the clock counts as stopped. Two
/// samples may fall into one microsecond; twenty never do.
const CLOCK_REPEATS_MAX: u32 = 20;
/// Noise of a position, m. A position may lie this much beyond the reach of a handle at
/// [`FASTEST_M_S`].
const NOISE_M: f32 = 0.003;
/// Speed above which a change of position is a leap, m/s. Thrown handles reach 3 m/s.
const FASTEST_M_S: f32 = 10.0;
/// Distance above which an unchanged position counts as frozen, m. The distance is the integral of
/// the reported velocity over the time in which the position does not change. Encoders resolve a
/// tenth of this distance.
const FROZEN_TRAVEL_M: f32 = 0.0005;
/// Longest time between two samples in that integral, µs. A device that pauses for longer, such as
/// an emulated one on a busy computer, does not move in the pause, although its clock goes on. The
/// limit does not delay the check at 1 kHz, because samples are then 1 ms apart.
const FROZEN_STEP_MAX_US: u32 = 2000;
/// Slowest reported velocity in that integral, m/s. A slower one is the noise of a resting hand.
const MOVING_M_S: f32 = 0.005;
/// Time between two polls above which samples may have waited in this computer, ns.
const HOST_PAUSE_NS: u64 = 20_000_000;
/// Number of consecutive polls with at most [`CALM_BYTES`] after which the backlog counts as
/// drained. The reading thread, which may have stood still as well, has run by then.
const CALM_POLLS: u32 = 3;
/// Largest number of bytes of a poll without a backlog: about ten frames.
const CALM_BYTES: usize = 512;
/// Length of a window in which the device's clock is compared with this computer's, ns.
const UNIT_WINDOW_NS: u64 = 400_000_000;
/// Bad windows in a row after which the clock's unit counts as wrong. One bad window is no proof:
/// it may begin with a sample that waited while this computer stood still.
const UNIT_WINDOWS: u32 = 2;
/// Time without a sample after which the device is silent, ns. Such a gap also ends a unit window.
const SILENT_NS: u64 = 100_000_000;
/// Device time without a newly confirmed force after which the device may count as deaf, µs.
const DEAF_US: u32 = 250_000;
/// Forces that the host must have sent in that time before the device counts as deaf.
const DEAF_SENDS: u32 = 100;
/// Forces in a row that the line refused, after which the device counts as deaf. At one force per
/// tick, this is the time in which the force fades after the samples become stale.
const REFUSALS: u32 = 20;
/// Time after the last sent force for which the host expects a confirmation, ns.
const CONFIRMATION_WINDOW_NS: u64 = 20_000_000;

/// The parts of a sample with which later samples are compared.
#[derive(Debug, Clone, Copy)]
struct ClockedPosition {
    us: u32,
    at_m: Vec3,
}

/// Judgement of one device.
#[derive(Debug, Default)]
pub(super) struct Judge {
    polled_ns: TimeNs,
    /// Polls of at most [`CALM_BYTES`] that are still needed until the backlog counts as drained.
    calm_polls_needed: u32,
    last: Option<ClockedPosition>,
    admitted: Option<ClockedPosition>,
    /// Number of consecutive samples of the present leap that agree with each other; 0: no leap.
    agreeing: u32,
    /// Number of consecutive forward steps of the device's clock.
    forward_steps: u32,
    /// Number of consecutive repetitions of a clock reading.
    clock_repeats: u32,
    clock_is_bad: bool,
    /// Windows in a row in which the clock's unit was wrong.
    bad_units: u32,
    unit_window_start: Option<(TimeNs, u32)>,
    arrived_ns: TimeNs,
    reported_travel_m: Vec3,
    trail: Trail,
    noise: Noise,
    bundles: Bundles,
    /// Number of the newest confirmed force, and the device's time at its first confirmation, µs.
    confirmed: Option<(u16, u32)>,
    /// Forces sent since that confirmation.
    sends: u32,
    sent_ns: TimeNs,
    /// Forces that the line refused since it last accepted one.
    refusals: u32,
    is_deaf: bool,
    /// True if a fault other than a leap dropped a sample since [`Self::take`] last returned a
    /// velocity.
    was_interrupted: bool,
    /// True if the last sample was dropped for a fault.
    dropped: bool,
    /// True while this poll has brought no sample. The findings are then those of earlier polls.
    is_poll_empty: bool,
    /// True if no sample has come for [`SILENT_NS`].
    is_silent: bool,
    findings: Findings,
    /// Status bits of the last sample.
    status: Status,
}

impl Judge {
    /// Begins a poll.
    pub(super) fn begin(&mut self, now_ns: TimeNs) {
        let paused_ns = now_ns.saturating_sub(self.polled_ns);
        if self.polled_ns > 0 && paused_ns > HOST_PAUSE_NS {
            self.calm_polls_needed = CALM_POLLS;
            self.unit_window_start = None;
        }
        // Samples that waited for the host are not a bundle that the device made.
        self.bundles.begin(if self.calm_polls_needed > 0 {
            u64::MAX
        } else {
            paused_ns
        });
        self.polled_ns = now_ns;
        self.is_poll_empty = true;
        self.findings.leapt = false;
        // Silence is a fault of its own, so earlier faults end here.
        self.is_silent = now_ns.saturating_sub(self.arrived_ns) > SILENT_NS;
        if self.is_silent {
            self.findings.faults = FaultSet::NONE;
        }
        self.findings.bundle_ms = self.bundles.length_ms().unwrap_or(0);
    }

    /// Judges a sample. Returns its velocity, m/s; `None` if the sample has a fault or may have
    /// waited while the host paused.
    pub(super) fn take(
        &mut self,
        state: &State,
        measures_velocity: bool,
        at_ns: TimeNs,
    ) -> Option<Vec3> {
        let now = ClockedPosition {
            us: state.device_time_us,
            at_m: state.position_m.into(),
        };
        let measured_m_s = measures_velocity.then(|| Vec3::from(state.velocity_m_s));
        self.status = state.status;
        self.bundles.take(now.us, at_ns);
        let mut faults = FaultSet::NONE;
        let before = self.last.replace(now);
        self.judge_clock(before, now, at_ns, &mut faults);
        // The check for a frozen position uses the velocity even if the device declares that it
        // measures none.
        self.judge_frozen(before, now, &state.velocity_m_s.into(), &mut faults);
        self.judge_confirmation(state, &mut faults);
        let continues = self.judge_leap(before, now, &mut faults);
        let earlier = if self.is_poll_empty {
            FaultSet::NONE
        } else {
            self.findings.faults
        };
        self.is_poll_empty = false;
        self.findings.faults = earlier.with(faults);
        self.dropped = !faults.is_empty();
        if self.dropped {
            let mut leap = FaultSet::NONE;
            leap.raise(Fault::DeviceLeap);
            self.was_interrupted |= !faults.without(leap).is_empty();
            return None;
        }
        // The sample may have waited while the host paused, so it is too old.
        if self.calm_polls_needed > 0 {
            self.admitted = Some(now);
            self.trail.clear();
            self.noise.interrupt();
            return None;
        }
        if !continues || self.was_interrupted {
            self.findings.leapt = true;
            self.was_interrupted = false;
            self.trail.clear();
            self.noise.interrupt();
        }
        self.admitted = Some(now);
        self.noise.take(now.us, &now.at_m);
        let derived_m_s = self.trail.add(now.us, &now.at_m);
        // The faster of the two counts: the device may send zero, or use another unit.
        Some(match measured_m_s {
            Some(reported_m_s) if derived_m_s.norm() <= reported_m_s.norm() => reported_m_s,
            _ => derived_m_s,
        })
    }

    /// True if the last sample was dropped for a fault.
    pub(super) const fn dropped(&self) -> bool {
        self.dropped
    }

    /// Ends a poll that read `bytes` bytes.
    pub(super) fn end(&mut self, bytes: usize) {
        if bytes <= CALM_BYTES {
            self.calm_polls_needed = self.calm_polls_needed.saturating_sub(1);
        } else if self.calm_polls_needed > 0 {
            self.calm_polls_needed = CALM_POLLS;
        }
        if self.is_poll_empty && self.findings.faults.contains(Fault::DeviceLeap) {
            let mut leap = FaultSet::NONE;
            leap.raise(Fault::DeviceLeap);
            self.findings.faults = self.findings.faults.without(leap);
        }
    }

    /// Notes that the line accepted a force.
    pub(super) fn sent(&mut self, now_ns: TimeNs) {
        self.refusals = 0;
        self.sends = self.sends.saturating_add(1);
        self.sent_ns = now_ns;
    }

    /// Notes that the line refused a force.
    pub(super) const fn refused(&mut self) {
        self.refusals = self.refusals.saturating_add(1);
    }

    /// Faults of the last poll that brought a sample, faults of the device's status, and the
    /// findings about noise and bundles. A leap lasts for its own poll only. While the device is
    /// silent, there are no faults.
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
        before: Option<ClockedPosition>,
        now: ClockedPosition,
        at_ns: TimeNs,
        faults: &mut FaultSet,
    ) {
        let Some(before) = before else { return };
        match now.us.wrapping_sub(before.us).cast_signed() {
            ..0 => {
                self.clock_is_bad = true;
                self.forward_steps = 0;
                self.clock_repeats = 0;
                self.unit_window_start = None;
            }
            0 => {
                self.clock_repeats = self.clock_repeats.saturating_add(1);
                self.forward_steps = 0;
            }
            1.. => {
                self.clock_repeats = 0;
                self.forward_steps = self.forward_steps.saturating_add(1);
                self.clock_is_bad &= self.forward_steps < AGREEING;
            }
        }
        let is_still = self.clock_repeats >= CLOCK_REPEATS_MAX && now.at_m == before.at_m;
        faults.raise_if(is_still, Fault::FrozenDevice);
        self.judge_unit(now, at_ns);
        let unit_is_bad = self.bad_units >= UNIT_WINDOWS;
        let is_bad = self.clock_is_bad || unit_is_bad || self.clock_repeats >= CLOCK_REPEATS_MAX;
        faults.raise_if(is_bad && !is_still, Fault::DeviceClock);
    }

    /// Compares the device's clock with this computer's. They may differ by a factor of ten, so
    /// that delays do not matter but a wrong unit is found.
    fn judge_unit(&mut self, now: ClockedPosition, at_ns: TimeNs) {
        if at_ns.saturating_sub(self.arrived_ns) > SILENT_NS || self.calm_polls_needed > 0 {
            self.unit_window_start = None;
        }
        self.arrived_ns = at_ns;
        let (from_ns, from_us) = *self.unit_window_start.get_or_insert((at_ns, now.us));
        let passed_ns = at_ns.saturating_sub(from_ns);
        if passed_ns >= UNIT_WINDOW_NS {
            let device_ns = u64::from(now.us.wrapping_sub(from_us)) * 1000;
            let is_good = (passed_ns / 10..=passed_ns * 10).contains(&device_ns);
            self.bad_units = if is_good { 0 } else { self.bad_units + 1 };
            self.unit_window_start = Some((at_ns, now.us));
        }
    }

    fn judge_frozen(
        &mut self,
        before: Option<ClockedPosition>,
        now: ClockedPosition,
        reported_m_s: &Vec3,
        faults: &mut FaultSet,
    ) {
        let Some(before) = before else { return };
        if now.at_m != before.at_m || reported_m_s.norm() < MOVING_M_S {
            self.reported_travel_m = Vec3::zeros();
            return;
        }
        let passed_us = now.us.wrapping_sub(before.us).min(FROZEN_STEP_MAX_US);
        self.reported_travel_m += reported_m_s * (passed_us as f32 * 1.0e-6);
        faults.raise_if(
            self.reported_travel_m.norm() > FROZEN_TRAVEL_M,
            Fault::FrozenDevice,
        );
    }

    fn judge_confirmation(&mut self, state: &State, faults: &mut FaultSet) {
        let (applied, us) = (state.applied_force, state.device_time_us);
        let since_us = match self.confirmed {
            Some((last, since_us)) if last == applied => since_us,
            _ => {
                self.confirmed = Some((applied, us));
                self.sends = 0;
                us
            }
        };
        // A deaf device stays deaf until it confirms a new force. If it is deaf only because the
        // line refused forces, it stays deaf until the line accepts one.
        let expects_confirmation =
            self.is_deaf || self.polled_ns.saturating_sub(self.sent_ns) <= CONFIRMATION_WINDOW_NS;
        let confirms_none = self.sends >= DEAF_SENDS && us.wrapping_sub(since_us) >= DEAF_US;
        // A device at fault renders no force. Its status already reports that.
        let is_at_fault = state.status.contains(Status::FAULT);
        self.is_deaf =
            !is_at_fault && ((expects_confirmation && confirms_none) || self.refusals >= REFUSALS);
        faults.raise_if(self.is_deaf, Fault::DeafDevice);
    }

    /// Returns true if a handle can have moved here from the last admitted sample. If not, the
    /// sample is a leap. A leap is a fault until [`AGREEING`] samples in a row agree with each
    /// other.
    fn judge_leap(
        &mut self,
        before: Option<ClockedPosition>,
        now: ClockedPosition,
        faults: &mut FaultSet,
    ) -> bool {
        let passed_us = |then: ClockedPosition| now.us.wrapping_sub(then.us).cast_signed().max(0);
        let is_near = |then: ClockedPosition, passed_us: i32| {
            let reach_m = NOISE_M + FASTEST_M_S * (passed_us as f32 * 1.0e-6);
            (now.at_m - then.at_m).norm() <= reach_m
        };
        let step_us = before.map_or(0, passed_us);
        // During a leap, the reach around the last admitted place stays the reach of one step,
        // however long the leap lasts.
        let since = |then: ClockedPosition| {
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
