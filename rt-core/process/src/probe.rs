//! Bare loops that measure the cost of waking up on this machine, without a simulation.
//!
//! The executor's loop is the one that the tick runs on; the plain loop is the minimum of any
//! program. Compare both with `cyclictest` in the same minutes: only figures of interleaved runs
//! can be compared.

use core::cell::RefCell;
use core::ops::ControlFlow;
use std::rc::Rc;
use std::sync::Arc;

use rt_core::math::{Pose, Vec3};
use rt_core::scene::{Room, Scene, Trocar};
use rt_core::sim::Sim;
use rt_core::state::State;
use shared_mem::message::TimingBatch;

use crate::config::RtConfig;
use crate::control::control;
use crate::devices::{Devices, FALLBACK_CAPABILITIES};
use crate::error::RtError;
use crate::executor::Executor;
use crate::realtime::{self, NoDeepIdle, Standing, ThreadUsage};
use crate::run::queues;
use crate::schedule::Schedule;
use crate::settings::Settings;
use crate::shared::Shared;
use crate::tick::{Tick, World};
use crate::time_driver::{monotonic_ns, now_ns, simulate_from, sleep_until};

/// Loop under test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loop {
    /// embassy's executor with our time driver, which spins for the last `spin_ns`.
    Executor {
        /// Time for which the loop spins before each tick, ns; see `RtConfig`.
        spin_ns: u64,
    },
    /// `clock_nanosleep` to the next absolute deadline, nothing else.
    Plain,
}

/// Settings of a measurement.
#[derive(Debug, Clone)]
pub struct Probe {
    /// Loop under test.
    pub kind: Loop,
    /// Number of periods of 1 ms, run or missed.
    pub periods: u64,
    /// Core of the thread.
    pub core: usize,
    /// `SCHED_FIFO` priority.
    pub priority: u8,
    /// Undisturbed duration of each tick's work, ns, used in order and repeated. Empty: no work.
    pub work_ns: Vec<u32>,
}

/// Missed periods by cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Misses {
    /// Periods missed by a sleeping loop whose last tick was on time: the machine woke it too late.
    pub woken_late: u64,
    /// Periods missed by a loop whose last tick was still at work.
    pub at_work: u64,
    /// Number of interruptions of the loop, each of one missed period or more.
    pub occasions: u64,
    /// Ticks that ended after their deadline. Most of them did not cause a missed period.
    pub late_ticks: u64,
}

impl Misses {
    /// Notes the start of a tick. `missed` is the number of periods missed before it. `overran` is
    /// true if the tick before it ended after its deadline.
    pub fn note_begin(&mut self, missed: u32, overran: bool) {
        self.occasions += u64::from(missed > 0);
        match overran {
            true => self.at_work += u64::from(missed),
            false => self.woken_late += u64::from(missed),
        }
    }

    /// Total of missed periods.
    #[must_use]
    pub fn periods(&self) -> u64 {
        self.woken_late + self.at_work
    }
}

/// Results of a measurement.
#[derive(Debug, Clone, Default)]
pub struct Latencies {
    /// Actual minus scheduled wake-up of every tick, ns, in order.
    pub wake_latency_ns: Vec<u32>,
    /// Duration of each tick's work with its disturbances, ns; empty without work.
    pub burnt_ns: Vec<u32>,
    /// Skipped periods and late ticks.
    pub misses: Misses,
    /// Realtime privileges that the thread got.
    pub standing: Standing,
    /// Page faults and involuntary switches during the run.
    pub usage: ThreadUsage,
}

const PERIOD_NS: u64 = 1_000_000;

impl Probe {
    /// Measures in a thread of its own.
    ///
    /// # Errors
    /// When the thread does not start.
    pub fn run(self) -> Result<Latencies, RtError> {
        let mut standing = Standing::default();
        let _awake = NoDeepIdle::ask();
        standing.note(TimingBatch::LOCKED, realtime::lock_memory());
        let thread = "probe";
        std::thread::Builder::new()
            .spawn(move || self.measure(standing))
            .map_err(|source| RtError::Thread { thread, source })?
            .join()
            .map_err(|_| RtError::Panicked {
                thread,
                message: "while measuring".to_owned(),
            })
    }

    fn measure(self, mut standing: Standing) -> Latencies {
        realtime::leave_signals_to_main();
        standing.note(TimingBatch::PINNED, realtime::pin_to(&[self.core]));
        standing.note(TimingBatch::FIFO, realtime::take_fifo(self.priority));
        let touched = |each: usize| {
            let mut room = vec![1u32; each * usize::try_from(self.periods).unwrap_or(0)];
            // Touch the memory now, not in the loop.
            room.clear();
            room
        };
        let found = Rc::new(RefCell::new(Latencies {
            wake_latency_ns: touched(1),
            burnt_ns: touched(usize::from(!self.work_ns.is_empty())),
            ..Latencies::default()
        }));
        let rounds_per_ns = rounds_per_ns();
        let periods = self.periods;
        let (work_ns, mut next) = (self.work_ns, 0);
        let work_ns_count = work_ns.len();
        let schedule = Schedule::new(monotonic_ns() + 5 * PERIOD_NS, PERIOD_NS);
        realtime::prefault_stack();
        let before = ThreadUsage::now();
        let keep = Rc::clone(&found);
        let mut overran = false;
        let mut tick = move |due: crate::schedule::Due| {
            let now = now_ns();
            let saturate = |ns: u64| u32::try_from(ns).unwrap_or(u32::MAX);
            let mut found = keep.borrow_mut();
            let latency_ns = now.saturating_sub(due.scheduled_ns);
            found.wake_latency_ns.push(saturate(latency_ns));
            found.misses.note_begin(due.missed, overran);
            overran = false;
            if let Some(&work_ns) = work_ns.get(next) {
                next = (next + 1) % work_ns_count;
                work((f64::from(work_ns) * rounds_per_ns) as u64);
                let end = now_ns();
                found.burnt_ns.push(saturate(end - now));
                overran = end > due.deadline_ns;
                found.misses.late_ticks += u64::from(overran);
            }
            if found.wake_latency_ns.len() as u64 + found.misses.periods() >= periods {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        };
        match self.kind {
            Loop::Executor { spin_ns } => {
                let executor = Executor::new();
                executor.spawn(control(schedule, tick));
                executor.run(spin_ns);
            }
            Loop::Plain => {
                let mut schedule = schedule;
                loop {
                    sleep_until(schedule.next_ns(), 0);
                    if tick(schedule.begin(now_ns())).is_break() {
                        break;
                    }
                }
            }
        }
        let usage = ThreadUsage::now().since(before);
        let found = found.replace(Latencies::default());
        Latencies {
            standing,
            usage,
            ..found
        }
    }
}

/// Work of a fixed number of instructions. Interruptions do not shorten it.
fn work(rounds: u64) {
    let mut x = 1u64;
    for _ in 0..rounds {
        // Each step depends on the one before.
        x = core::hint::black_box(x.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1));
    }
}

/// Undisturbed speed of [`work`], rounds per ns: the best of many tries.
fn rounds_per_ns() -> f64 {
    const ROUNDS: u64 = 20_000;
    let try_once = |_| {
        let start = now_ns();
        work(ROUNDS);
        now_ns().saturating_sub(start).max(1)
    };
    let best_ns = (0..100).map(try_once).min().unwrap_or(1);
    ROUNDS as f64 / best_ns as f64
}

/// Mean cost of executor, timer queue and schedule per tick, ns, over `ticks` empty ticks in
/// simulated time.
#[must_use]
pub fn executor_cost_ns(ticks: u64) -> f64 {
    let measure = move || {
        simulate_from(PERIOD_NS);
        let executor = Executor::new();
        let mut left = ticks;
        executor.spawn(control(Schedule::new(PERIOD_NS, PERIOD_NS), move |_| {
            left = left.saturating_sub(1);
            if left == 0 {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        }));
        let start = monotonic_ns();
        executor.run(0);
        (monotonic_ns() - start) as f64 / ticks.max(1) as f64
    };
    // Simulated time is a property of the thread.
    std::thread::spawn(measure).join().unwrap_or(f64::NAN)
}

/// Mean time of a whole tick over an empty room without devices, ns, on this machine's clock. This
/// is the tick without its work: stamps, budgets, counters, record, and the passage through the
/// stages.
///
/// # Errors
/// When the thread does not start.
pub fn empty_tick_cost_ns(ticks: u64) -> Result<f64, RtError> {
    let room = Room {
        gravity_m_s2: Vec3::zeros(),
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: Vec3::zeros(),
        instrument_length_m: 0.3,
        endoscope_port_m: Vec3::zeros(),
        world_from_camera: Pose::identity(),
        breath_s: 0.0,
        trocar: Trocar::NONE,
    };
    let measure = move || {
        let Ok(scene) = Scene::new(&[], &[], &[], room) else {
            return f64::NAN; // does not happen: an empty scene is valid
        };
        let config = RtConfig::new("probe", "none");
        let settings = Settings::new(&config, None);
        let (ends, mut other_ends) = queues();
        let shared = Arc::<Shared>::default();
        let world = World::new(Devices::default(), ends, shared, [0; 16], &settings);
        let state: &'static mut State = Box::leak(Box::new(State::new()));
        let sim = Sim::new(scene, state, FALLBACK_CAPABILITIES, config.parameters);
        let mut tick = Tick::new(sim, world, None);
        let mut in_ticks_ns = 0;
        for _ in 0..ticks {
            let start_ns = monotonic_ns();
            let due = Schedule::new(start_ns, PERIOD_NS).begin(start_ns);
            let _ = tick.run(due);
            in_ticks_ns += monotonic_ns() - start_ns;
            // Empties the queues, as the publishing thread does: with a full queue the tick would
            // run other code.
            while other_ends.records.dequeue().is_some() {}
            while other_ends.inputs.dequeue().is_some() {}
            while other_ends.events.dequeue().is_some() {}
        }
        in_ticks_ns as f64 / ticks.max(1) as f64
    };
    let thread = "probe";
    std::thread::Builder::new()
        .stack_size(crate::thread::TICK_STACK_BYTES)
        .spawn(measure)
        .map_err(|source| RtError::Thread { thread, source })?
        .join()
        .map_err(|_| RtError::Panicked {
            thread,
            message: "while measuring".to_owned(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_period_is_measured_or_missed() {
        for kind in [Loop::Plain, Loop::Executor { spin_ns: 100_000 }] {
            let probe = Probe {
                kind,
                periods: 50,
                core: realtime::allowed_cores()[0],
                priority: 50,
                work_ns: vec![10_000, 200_000],
            };
            let found = probe.run().unwrap();
            let ticks = found.wake_latency_ns.len();
            let missed = found.misses.periods();
            assert!(ticks > 0 && ticks as u64 + missed >= 50, "{kind:?}");
            let late = found.wake_latency_ns.iter().filter(|&&ns| ns > 1_000_000);
            assert!(
                late.count() as u64 <= missed,
                "a wake-up later than a period counts as a miss"
            );
            assert_eq!(found.burnt_ns.len(), ticks);
        }
    }

    #[test]
    fn work_is_in_proportion() {
        let best = |rounds| {
            let once = |_| {
                let start = monotonic_ns();
                work(rounds);
                monotonic_ns() - start
            };
            (0..50).map(once).min().unwrap_or(0) as f64
        };
        let ratio = best(80_000) / best(20_000);
        assert!((3.0..5.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_period_is_missed_asleep_or_at_work() {
        let mut misses = Misses::default();
        misses.note_begin(0, true);
        misses.note_begin(3, false);
        misses.note_begin(2, true);
        assert_eq!((misses.woken_late, misses.at_work), (3, 2));
        assert_eq!((misses.occasions, misses.periods()), (2, 5));
    }

    #[test]
    fn an_empty_tick_costs_something_but_far_less_than_a_period() {
        let cost_ns = executor_cost_ns(100_000);
        assert!(cost_ns > 1.0 && cost_ns < 100_000.0, "{cost_ns}");
        let cost_ns = empty_tick_cost_ns(20_000).unwrap();
        assert!(cost_ns > 10.0 && cost_ns < 100_000.0, "{cost_ns}");
    }
}
