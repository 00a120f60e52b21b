//! Stage `sample`: checks the samples of the devices, and their age.

use crate::fault::{Fault, FaultSet};
use crate::math::{self, Pose, Vec3};
use crate::port::{Buttons, DeviceCapabilities, DeviceSample, PedalSample, Polled, TrackerSample};
use crate::sim::Samples;
use crate::time::TimeNs;
use crate::words::{Health, Status};

/// Lower bound of the age above which a device sample is stale, ns. The force falls while the
/// sample is stale. A larger value tolerates longer gaps, in which an old force acts.
const DEVICE_STALE_NS: u64 = 5_000_000;
/// Age above which a device sample is stale, in periods of the device's own rate. With fewer
/// periods, the samples of a slow device could always be stale, because a sample may be in transit
/// for a period.
const STALE_PERIODS: f32 = 3.0;
/// Upper bound of the age above which a device sample is stale, ns: the longest time for which a
/// device's own watchdog may hold a force.
const DEVICE_STALE_MAX_NS: u64 = 100_000_000;
/// Time between two ticks above which the force starts from zero again, ns: the time in which the
/// force falls after a sample became stale.
const STANDSTILL_NS: u64 = 20_000_000;
/// Time after a standstill, ns, in which no speed is computed from positions and the force does not
/// rise. Samples that the device sent during the standstill arrive all at once, so their distances
/// are not travel within a tick. A serial line delivers its buffer of 4 kB in a few milliseconds,
/// or in tens of milliseconds on a busy machine.
const SETTLE_NS: u64 = 50_000_000;
/// Age above which a tracker sample is stale, ns.
const TRACKER_STALE_NS: u64 = 100_000_000;
/// Age above which the pedal's state is stale, ns. A stale state raises [`Fault::LostPedal`].
const PEDAL_STALE_NS: u64 = 500_000_000;
/// Largest coordinate of a pose in its device's frame, m.
const COORDINATE_MAX_M: f32 = 10.0;
/// Lower bound of the time between two samples in the computation of a speed, s. Each tick takes
/// one sample, so two samples are a tick apart even if the first arrived late.
const SAMPLE_PERIOD_MIN_S: f32 = 0.001;

/// State of one device's line, and its newest sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<T> {
    newest: Option<T>,
    at_ns: TimeNs,
    is_fresh: bool,
    is_lost: bool,
}

impl<T> Default for Line<T> {
    fn default() -> Self {
        Self {
            newest: None,
            at_ns: 0,
            is_fresh: false,
            is_lost: false,
        }
    }
}

impl<T: Copy> Line<T> {
    fn take(&mut self, polled: Polled<T>, at_ns: impl Fn(&T) -> TimeNs) {
        self.is_fresh = false;
        match polled {
            Polled::Fresh(sample) => {
                self.at_ns = at_ns(&sample);
                self.newest = Some(sample);
                self.is_fresh = true;
                self.is_lost = false;
            }
            Polled::Nothing => {}
            Polled::Lost => self.is_lost = true,
        }
    }

    pub(crate) const fn newest(&self) -> Option<&T> {
        self.newest.as_ref()
    }

    /// Time at which the newest sample was read; 0 if there is none.
    pub(crate) const fn at_ns(&self) -> TimeNs {
        self.at_ns
    }

    /// True if this tick brought the newest sample.
    pub(crate) const fn is_fresh(&self) -> bool {
        self.is_fresh
    }

    fn health(&self, now_ns: TimeNs, stale_ns: u64) -> Health {
        if self.newest.is_none() {
            let status = if self.is_lost {
                Status::Lost
            } else {
                Status::Absent
            };
            return Health { status, age_ns: 0 };
        }
        let age_ns = now_ns.saturating_sub(self.at_ns);
        let status = match (self.is_lost, age_ns > stale_ns) {
            (true, _) => Status::Lost,
            (false, true) => Status::Stale,
            (false, false) => Status::Live,
        };
        Health { status, age_ns }
    }
}

/// All devices.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Inputs {
    pub(crate) device: Line<DeviceSample>,
    pub(crate) tracker: Line<TrackerSample>,
    pedal: Line<PedalSample>,
    /// Velocity of the handle in the device's frame, m/s: measured by the device, or else from the
    /// last two samples.
    pub(crate) velocity_m_s: Vec3,
    newly_pressed: Buttons,
    /// True if this tick's sample is the first, or the first after a gap.
    is_first_after_gap: bool,
    /// Age at which a device sample is stale, ns.
    stale_ns: u64,
    had_standstill: bool,
    has_returned: bool,
    /// Time until which the lines may still deliver samples that they buffered in a standstill, ns.
    settles_until_ns: TimeNs,
    now_ns: TimeNs,
}

impl Inputs {
    /// Inputs of a station with this haptic device.
    pub(crate) fn of(device: &DeviceCapabilities) -> Self {
        // A rate that is NaN or below 1 Hz gives the largest age.
        let period_ns = (1.0e9 * STALE_PERIODS / device.rate_hz.max(1.0)) as u64;
        Self {
            stale_ns: period_ns.clamp(DEVICE_STALE_NS, DEVICE_STALE_MAX_NS),
            ..Self::default()
        }
    }

    /// Takes the samples of the ports. Invalid samples are dropped; without valid ones, the line
    /// becomes stale.
    pub(crate) fn take(&mut self, samples: &Samples, faults: &mut FaultSet) {
        faults.raise_if(
            self.now_ns > 0 && samples.now_ns <= self.now_ns,
            Fault::BadClock,
        );
        self.had_standstill =
            self.now_ns > 0 && samples.now_ns.saturating_sub(self.now_ns) > STANDSTILL_NS;
        faults.raise_if(self.had_standstill, Fault::StaleDevice);
        if self.had_standstill {
            self.settles_until_ns = samples.now_ns.saturating_add(SETTLE_NS);
        }
        self.now_ns = self.now_ns.max(samples.now_ns);

        let before = self
            .device
            .newest()
            .copied()
            .filter(|_| !self.device.is_lost);
        let device = checked(samples.device, is_device_sample, faults);
        self.has_returned = self.device.is_lost && matches!(device, Polled::Fresh(_));
        self.device.take(device, |sample| sample.at_ns);
        self.newly_pressed = Buttons::default();
        self.is_first_after_gap = false;
        if let Polled::Fresh(sample) = device {
            let before_gap = self.is_settling();
            self.velocity_m_s = sample
                .velocity_m_s
                .unwrap_or_else(|| velocity(before.filter(|_| !before_gap).as_ref(), &sample));
            self.is_first_after_gap = before.is_none() || self.may_have_jumped();
            // A button that is pressed at the start acts only after it was released.
            let held = before.map_or(sample.buttons, |before| before.buttons);
            self.newly_pressed = Buttons(sample.buttons.0 & !held.0);
        }
        let is_tracker_sample = |sample: &TrackerSample| is_pose(&sample.tracker_from_sensor);
        let tracker = checked(samples.tracker, is_tracker_sample, faults);
        self.tracker.take(tracker, |sample| sample.at_ns);
        self.pedal.take(samples.pedal, |sample| sample.at_ns);
        let is_silent = self.pedal_health().status == Status::Stale && !self.is_settling();
        let is_lost = samples.pedal == Polled::Lost || is_silent;
        faults.raise_if(is_lost, Fault::LostPedal);
    }

    /// State of the pedal. A lost pedal reads as released; a stale one keeps its last state.
    pub(crate) fn pedal(&self) -> PedalSample {
        self.pedal
            .newest()
            .copied()
            .filter(|_| !self.pedal.is_lost)
            .unwrap_or_default()
    }

    /// Position of the handle in the device's frame, m, if this tick brought it.
    pub(crate) fn fresh_handle_m(&self) -> Option<Vec3> {
        let sample = self.device.newest().filter(|_| self.device.is_fresh())?;
        Some(sample.device_from_handle.translation.vector)
    }

    /// Buttons that were pressed with this tick's sample.
    pub(crate) const fn newly_pressed(&self) -> Buttons {
        self.newly_pressed
    }

    /// True if this tick's sample is the first, or the first after a gap: the handle may have
    /// opened or shut since the last sample.
    pub(crate) const fn is_first_after_gap(&self) -> bool {
        self.is_first_after_gap
    }

    /// True if the hand may have moved anywhere: no tick ran for a long time (a stopped process, a
    /// stalled machine), or the device has returned after a loss.
    pub(crate) const fn may_have_jumped(&self) -> bool {
        self.had_standstill || self.has_returned
    }

    /// True for a short time after a standstill, in which the force must not rise.
    pub(crate) const fn is_settling(&self) -> bool {
        self.now_ns < self.settles_until_ns
    }

    pub(crate) fn device_health(&self) -> Health {
        self.device.health(self.now_ns, self.stale_ns)
    }

    pub(crate) fn tracker_health(&self) -> Health {
        self.tracker.health(self.now_ns, TRACKER_STALE_NS)
    }

    pub(crate) fn pedal_health(&self) -> Health {
        self.pedal.health(self.now_ns, PEDAL_STALE_NS)
    }
}

/// Velocity between two samples, m/s; zero without an earlier sample.
fn velocity(before: Option<&DeviceSample>, now: &DeviceSample) -> Vec3 {
    let Some(before) = before else {
        return Vec3::zeros();
    };
    let elapsed_s = now.at_ns.saturating_sub(before.at_ns) as f32 * 1.0e-9;
    let travel_m =
        now.device_from_handle.translation.vector - before.device_from_handle.translation.vector;
    travel_m / elapsed_s.max(SAMPLE_PERIOD_MIN_S)
}

/// `polled`, or nothing and a fault if its sample is invalid.
fn checked<T: Copy>(
    polled: Polled<T>,
    is_good: impl Fn(&T) -> bool,
    faults: &mut FaultSet,
) -> Polled<T> {
    match polled {
        Polled::Fresh(sample) if !is_good(&sample) => {
            faults.raise(Fault::BadSample);
            Polled::Nothing
        }
        polled => polled,
    }
}

fn is_pose(pose: &Pose) -> bool {
    math::is_rigid(pose) && pose.translation.vector.amax() <= COORDINATE_MAX_M
}

fn is_device_sample(sample: &DeviceSample) -> bool {
    is_pose(&sample.device_from_handle)
        && sample
            .velocity_m_s
            .is_none_or(|velocity| math::is_finite(&velocity))
        && sample
            .opening
            .is_none_or(|opening| (0.0..=1.0).contains(&opening))
}
