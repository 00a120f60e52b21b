//! Keeps the device under test within limits: every force of every experiment passes
//! [`Bench::tick`].

use std::collections::VecDeque;

use rt_core::fault::{Fault, FaultSet};
use rt_core::port::{ForceCommand, HapticDevice, Polled};
use rt_core::time::TimeNs;

use super::guard::{Guard, of_handle};
pub(super) use super::guard::{HandleState, OPENING, Vector};
use super::halt::Halt;
use super::limits::{Limits, slewed_n};

/// Time of the experiments: real or simulated.
pub trait Clock {
    /// Waits for the next millisecond and returns its time, ns. `None` if a person asks to stop.
    fn next(&mut self) -> Option<TimeNs>;
}

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
pub(super) struct TickRecord {
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
    limits: Limits,
    guard: Guard,
    start_ns: TimeNs,
    now_ns: TimeNs,
    now: HandleState,
    is_fresh: bool,
    sampled_s: f64,
    /// Polls since the last sample.
    empty_polls: u32,
    last_n: Vector,
    past: VecDeque<(f64, Vector)>,
    record: Vec<TickRecord>,
}

impl<'a> Bench<'a> {
    /// Waits for the device's first sample. `force_n` is the largest force that a person allows.
    pub(super) fn new(
        device: &'a mut dyn HapticDevice,
        clock: &'a mut dyn Clock,
        force_n: Option<f64>,
    ) -> Result<Self, Halt> {
        let can = device.capabilities();
        let mut bench = Self {
            limits: Limits::new(&can, force_n)?,
            device,
            clock,
            guard: Guard::new(&can),
            start_ns: 0,
            now_ns: 0,
            now: HandleState::start(),
            is_fresh: false,
            sampled_s: 0.0,
            empty_polls: 0,
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

    /// Begins to measure the opening of a handle as well.
    pub(super) fn begin_opening(&mut self) -> Result<(), Halt> {
        let travel_m = self.device.capabilities().opening.travel_m;
        self.guard.opening_m = Some(0.5 * f64::from(travel_m));
        // The newest sample may be older than this call, so the next one is awaited.
        self.past.clear();
        while self.past.is_empty() {
            self.send(self.last_n);
            self.wait(FIRST_S)?;
        }
        Ok(())
    }

    /// Largest forces.
    pub(super) const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Largest distance from the middle along an axis, m.
    pub(super) fn reach_m(&self, axis: usize) -> f64 {
        self.guard.reach_m(axis)
    }

    /// State of the handle now.
    pub(super) const fn now(&self) -> HandleState {
        self.now
    }

    /// Sets an excursion limit: the measurement ends if the handle goes farther than `reach_m` from
    /// `at_m`.
    pub(super) const fn limit_excursion(&mut self, at_m: Vector, reach_m: f64) {
        self.guard.excursion_limit = Some((at_m, reach_m));
    }

    /// Removes the excursion limit.
    pub(super) const fn clear_excursion_limit(&mut self) {
        self.guard.excursion_limit = None;
    }

    /// Starts a new record.
    pub(super) fn start_record(&mut self) {
        self.record.clear();
    }

    /// The record since it was started.
    pub(super) fn take_record(&mut self) -> Vec<TickRecord> {
        std::mem::take(&mut self.record)
    }

    /// Sends a force, reduced to the limits, and waits for the next millisecond and its sample.
    pub(super) fn tick(&mut self, force_n: Vector) -> Result<HandleState, Halt> {
        let is_stale = self.now.at_s - self.sampled_s > STALE_S;
        let wanted_n = if is_stale || !force_n.norm().is_finite() {
            Vector::zeros()
        } else {
            self.limits.bounded_n(&force_n)
        };
        let sent_n = slewed_n(&self.last_n, &wanted_n);
        self.send(sent_n);
        self.record.push(TickRecord {
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
            force_n: of_handle(&force_n).cast(),
            opening_n: force_n[OPENING] as f32,
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
                self.empty_polls = 0;
                let at_m = sample.device_from_handle.translation.vector;
                let half_m = self.guard.opening_m.unwrap_or(0.0);
                let opening = f64::from(sample.opening.unwrap_or(0.5));
                self.now.at_m = at_m.cast().push((2.0 * opening - 1.0) * half_m);
                self.measure_speed();
            }
            Polled::Nothing => self.empty_polls += 1,
        }
        let silent_s = self.now.at_s - self.sampled_s;
        if silent_s > patience_s && self.empty_polls > QUIET_POLLS {
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
        let HandleState { at_s, at_m, .. } = self.now;
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
