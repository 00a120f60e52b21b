//! Keeps the device under test within limits: every force of every experiment passes
//! [`Bench::tick`].

use std::collections::VecDeque;

use rt_core::fault::{Fault, FaultSet};
use rt_core::port::{DeviceCapabilities, ForceCommand, HapticDevice, Polled};
use rt_core::time::TimeNs;

use super::guard::Guard;
pub(super) use super::guard::{Now, Vector};
use super::halt::Halt;

/// Time of the experiments: real or simulated.
pub trait Clock {
    /// Waits for the next millisecond and returns its time, ns. `None` if a person asks to stop.
    fn next(&mut self) -> Option<TimeNs>;
}

/// Largest force unless a person allows more, N: the weight of 100 g. A hand that this force
/// surprises gives way or stops it without effort. The force is several times the dry friction of
/// desktop devices (0.1 to 0.3 N), so it moves their handles.
pub const FORCE_N: f64 = 1.0;
/// Share of the declared peak force that no experiment exceeds. A device that declares half of its
/// true peak may give twice the force that was sent, and then still stays within the declared peak.
const PEAK_SHARE: f64 = 0.5;
/// Least force with which anything can be measured, N.
const FORCE_MIN_N: f64 = 0.05;
/// Largest change of force per tick, N. A chirp of 50 Hz and 0.88 N changes by up to 0.28 N per
/// tick.
const SLEW_N: f64 = 0.3;
/// Age of a sample above which no force is sent, s.
const STALE_S: f64 = 0.02;
/// Time without a sample after which the measurement ends, s, if `QUIET_POLLS` was exceeded as
/// well. The force has been zero for most of this time.
const SILENT_S: f64 = 0.3;
/// Number of polls without a sample that must also have passed. So a pause of this computer does
/// not count as silence of the device.
const QUIET_POLLS: u32 = 30;
/// Time in which the first sample must come, s.
const FIRST_S: f64 = 1.0;
/// Time over which speed is measured, s. Over this time an encoder step of 0.055 mm looks like 7
/// mm/s.
const SPEED_S: f64 = 0.008;

/// Record of a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Time at which the force was sent, and the new sample, if any, was taken, s.
    pub(super) at_s: f64,
    /// Force sent, N.
    pub(super) force_n: Vector,
    /// Position, m, if a new sample had come.
    pub(super) at_m: Option<Vector>,
}

/// The device within its limits. Dropping a `Bench` sets the force to zero, whatever ended the
/// measurement.
pub(super) struct Bench<'a> {
    device: &'a mut dyn HapticDevice,
    clock: &'a mut dyn Clock,
    /// Largest force, N.
    limit_n: f64,
    guard: Guard,
    start_ns: TimeNs,
    now_ns: TimeNs,
    now: Now,
    is_fresh: bool,
    sampled_s: f64,
    /// Polls since the last sample.
    quiet: u32,
    last_n: Vector,
    past: VecDeque<(f64, Vector)>,
    record: Vec<Step>,
}

/// Largest force that may be asked of a device, N.
fn allowed_n(device: &DeviceCapabilities) -> f64 {
    (PEAK_SHARE * f64::from(device.force_max_n)).min(f64::from(device.force_continuous_n))
}

impl<'a> Bench<'a> {
    /// Waits for the device's first sample. `force_n` is the largest force that a person allows.
    pub(super) fn new(
        device: &'a mut dyn HapticDevice,
        clock: &'a mut dyn Clock,
        force_n: Option<f64>,
    ) -> Result<Self, Halt> {
        let can = device.capabilities();
        let allowed_n = allowed_n(&can);
        let limit_n = force_n.unwrap_or(FORCE_N.min(allowed_n));
        if !(FORCE_MIN_N..=allowed_n).contains(&limit_n) {
            let force_n = limit_n;
            return Err(Halt::Force { force_n, allowed_n });
        }
        let mut bench = Self {
            device,
            clock,
            limit_n,
            guard: Guard::new(&can),
            start_ns: 0,
            now_ns: 0,
            now: Now::start(),
            is_fresh: false,
            sampled_s: 0.0,
            quiet: 0,
            last_n: Vector::zeros(),
            past: VecDeque::new(),
            record: Vec::new(),
        };
        bench.begin()?;
        Ok(bench)
    }

    fn begin(&mut self) -> Result<(), Halt> {
        self.start_ns = self.clock.next().ok_or(Halt::Asked)?;
        self.now_ns = self.start_ns;
        while self.past.is_empty() {
            self.send(Vector::zeros());
            self.wait(FIRST_S)?;
        }
        Ok(())
    }

    /// Largest force, N.
    pub(super) const fn limit_n(&self) -> f64 {
        self.limit_n
    }

    /// Largest distance from the middle of the workspace, m.
    pub(super) const fn region_m(&self) -> f64 {
        self.guard.region_m
    }

    /// State of the handle now.
    pub(super) const fn now(&self) -> Now {
        self.now
    }

    /// Sets the leash: the measurement ends if the handle goes farther than `reach_m` from `at_m`.
    pub(super) const fn leash(&mut self, at_m: Vector, reach_m: f64) {
        self.guard.leash = Some((at_m, reach_m));
    }

    /// Removes the leash.
    pub(super) const fn unleash(&mut self) {
        self.guard.leash = None;
    }

    /// Starts a new record.
    pub(super) fn start_record(&mut self) {
        self.record.clear();
    }

    /// The record since it was started.
    pub(super) fn take_record(&mut self) -> Vec<Step> {
        std::mem::take(&mut self.record)
    }

    /// Sends a force, reduced to the limits, and waits for the next millisecond and its sample.
    pub(super) fn tick(&mut self, force_n: Vector) -> Result<Now, Halt> {
        let is_stale = self.now.at_s - self.sampled_s > STALE_S;
        let wanted_n = if is_stale || !force_n.norm().is_finite() {
            Vector::zeros()
        } else {
            shortened(force_n, self.limit_n)
        };
        let sent_n = self.last_n + shortened(wanted_n - self.last_n, SLEW_N);
        self.send(sent_n);
        self.record.push(Step {
            at_s: self.now.at_s,
            force_n: sent_n,
            at_m: self.is_fresh.then_some(self.now.at_m),
        });
        let waited = self.wait(SILENT_S);
        if waited.is_err() {
            self.cut();
        }
        waited?;
        Ok(self.now)
    }

    fn send(&mut self, force_n: Vector) {
        let command = ForceCommand {
            force_n: force_n.cast(),
            ..ForceCommand::default()
        };
        self.device.send(command, self.now_ns);
        self.last_n = force_n;
    }

    /// Sends zero force, and tries again if the line refuses. If every attempt fails, the device's
    /// watchdog ends the force.
    pub(super) fn cut(&mut self) {
        const TRIES: u32 = 3;
        for _ in 0..TRIES {
            let refused = self.device.counters().dropped_writes;
            self.send(Vector::zeros());
            if self.device.counters().dropped_writes == refused {
                break;
            }
        }
    }

    /// Waits for the next millisecond, takes the new sample and checks it against all limits.
    fn wait(&mut self, patience_s: f64) -> Result<(), Halt> {
        self.now_ns = self.clock.next().ok_or(Halt::Asked)?;
        self.now.at_s = self.now_ns.saturating_sub(self.start_ns) as f64 * 1e-9;
        self.is_fresh = false;
        match self.device.poll(self.now_ns) {
            Polled::Lost => return Err(Halt::Lost),
            Polled::Fresh(sample) => {
                self.is_fresh = true;
                self.sampled_s = self.now.at_s;
                self.quiet = 0;
                self.now.at_m = sample.device_from_handle.translation.vector.cast();
                self.measure_speed();
            }
            Polled::Nothing => self.quiet += 1,
        }
        let silent_s = self.now.at_s - self.sampled_s;
        if silent_s > patience_s && self.quiet > QUIET_POLLS {
            return Err(Halt::Silent {
                waited_ms: silent_s * 1e3,
                allowed_ms: patience_s * 1e3,
            });
        }
        let faults = self.device.findings().faults;
        if !faults.is_empty() && !self.past.is_empty() {
            let names = names(faults);
            return Err(Halt::Fault { names });
        }
        if self.past.is_empty() {
            return Ok(());
        }
        self.guard.judge(&self.now)
    }

    fn measure_speed(&mut self) {
        let Now { at_s, at_m, .. } = self.now;
        self.past.push_back((at_s, at_m));
        let is_old = |then: Option<&(f64, Vector)>| then.is_some_and(|it| at_s - it.0 >= SPEED_S);
        while is_old(self.past.get(1)) {
            self.past.pop_front();
        }
        // A shorter time is not enough: one encoder step within a millisecond looks fast.
        let then = self.past.front().filter(|it| at_s - it.0 >= 0.5 * SPEED_S);
        self.now.v_m_s = then.map_or(Vector::zeros(), |it| (at_m - it.1) / (at_s - it.0));
    }
}

impl Drop for Bench<'_> {
    fn drop(&mut self) {
        self.cut();
    }
}

fn names(faults: FaultSet) -> String {
    let found = Fault::ALL.iter().filter(|it| faults.contains(**it));
    let names: Vec<_> = found.map(|it| it.name()).collect();
    names.join(", ")
}

/// `wanted`, shortened to `limit`.
fn shortened(wanted: Vector, limit: f64) -> Vector {
    let norm = wanted.norm();
    if norm <= limit {
        wanted
    } else {
        wanted * (limit / norm)
    }
}
