//! The control task: one tick per period, on absolute deadlines.

use core::ops::ControlFlow;

use embassy_time::{Instant, Timer};

use crate::schedule::{Due, Schedule};
use crate::time_driver::now_ns;

/// Largest number of ticks in a row without a sleep. A tick that always exceeds its period must
/// still leave its core to others now and then; otherwise Linux stops it (realtime throttling) or
/// ends it ([`crate::runaway`]).
const TICKS_WITHOUT_SLEEP_MAX: u32 = 10;

/// Runs `tick` on the schedule until it returns `Break`. After a stall, the periods that passed are
/// skipped and counted; there is no burst to catch up.
pub async fn control(schedule: Schedule, tick: impl FnMut(Due) -> ControlFlow<()>) {
    following(schedule, tick, || 0).await;
}

/// Runs `tick` as [`control`] does. After each tick, `step_ns` gives the time by which the next
/// ticks start later, ns; a negative time makes them start earlier.
pub async fn following(
    mut schedule: Schedule,
    mut tick: impl FnMut(Due) -> ControlFlow<()>,
    mut step_ns: impl FnMut() -> i64,
) {
    let mut ticks_without_sleep = 0;
    loop {
        Timer::at(Instant::from_ticks(schedule.next_ns())).await;
        if tick(schedule.begin(now_ns())).is_break() {
            return;
        }
        schedule.step(step_ns());
        let now = now_ns();
        ticks_without_sleep = if now < schedule.next_ns() {
            0
        } else {
            ticks_without_sleep + 1
        };
        if ticks_without_sleep >= TICKS_WITHOUT_SLEEP_MAX {
            schedule.rest(now);
            ticks_without_sleep = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::Executor;
    use crate::time_driver::{advance_simulated, simulate_from};
    use std::cell::RefCell;
    use std::rc::Rc;

    const MS: u64 = 1_000_000;

    /// Runs `ticks` of the control task in simulated time. `cost_ns` gives the cost of each.
    fn simulate(
        ticks: u64,
        mut cost_ns: impl FnMut(u64) -> u64 + Send + 'static,
    ) -> Vec<(u64, Due)> {
        std::thread::scope(|scope| {
            let run = move || {
                simulate_from(MS);
                let log = Rc::new(RefCell::new(Vec::new()));
                let seen = Rc::clone(&log);
                let executor = Executor::new();
                let mut count = 0;
                executor.spawn(control(Schedule::new(2 * MS, MS), move |due| {
                    seen.borrow_mut().push((now_ns(), due));
                    advance_simulated(cost_ns(count));
                    count += 1;
                    if count == ticks {
                        return ControlFlow::Break(());
                    }
                    ControlFlow::Continue(())
                }));
                executor.run(0);
                log.take()
            };
            // Simulated time is a property of the thread.
            scope.spawn(run).join().unwrap()
        })
    }

    #[test]
    fn an_hour_runs_in_seconds_on_the_grid() {
        let ticks = 3_600_000;
        let log = simulate(ticks, |_| 300_000);
        assert_eq!(log.len() as u64, ticks);
        for (i, (now, due)) in log.iter().enumerate() {
            let expected = 2 * MS + i as u64 * MS;
            assert_eq!(
                (*now, due.scheduled_ns, due.missed),
                (expected, expected, 0)
            );
        }
    }

    #[test]
    fn a_stall_of_ten_periods_brings_no_burst() {
        // The third tick takes 10.4 ms.
        let log = simulate(6, |i| if i == 2 { 10_400_000 } else { 100_000 });
        let starts: Vec<u64> = log.iter().map(|(now, _)| (now - 2 * MS) / 1000).collect();
        // It began at 2 ms and ended at 12.4 ms. The fourth tick starts at 12.4 ms, late in its own
        // period. The fifth tick is on time again.
        assert_eq!(starts, [0, 1000, 2000, 12400, 13000, 14000]);
        let missed: Vec<u32> = log.iter().map(|(_, due)| due.missed).collect();
        assert_eq!(missed, [0, 0, 0, 9, 0, 0]);
    }

    #[test]
    fn a_tick_that_is_always_too_long_still_sleeps_now_and_then() {
        let cost_ns = 1_100_000;
        let log = simulate(1000, move |_| cost_ns);
        let mut without_sleep = 0;
        for pair in log.windows(2) {
            let slept_ns = pair[1].0 - pair[0].0 - cost_ns;
            without_sleep = if slept_ns == 0 { without_sleep + 1 } else { 0 };
            assert!(without_sleep < TICKS_WITHOUT_SLEEP_MAX);
        }
        // Every period is run or reported as missed.
        let missed: u64 = log.iter().map(|(_, due)| u64::from(due.missed)).sum();
        let deadline_ns = log[log.len() - 1].1.deadline_ns;
        assert_eq!((deadline_ns - 2 * MS) / MS, 1000 + missed);
        let (first, last) = (log[0].0, log[log.len() - 1].0);
        let busy = 999.0 * cost_ns as f64 / (last - first) as f64;
        assert!(busy < 0.95, "Linux's throttle strikes at 95 %: {busy}");
    }

    #[test]
    fn the_same_costs_give_the_same_ticks() {
        let costs = |i: u64| (i.wrapping_mul(2_654_435_761) % 3_000) * 1000;
        assert_eq!(simulate(10_000, costs), simulate(10_000, costs));
    }
}
