//! Which period a tick belongs to: absolute deadlines, no burst after a stall.

/// The 1 kHz grid. Deadlines stand at `start + k × period`; a period that is over before its
/// tick could start is missed, counted, and never made up for.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    next_ns: u64,
    period_ns: u64,
    missed: u64,
}

/// A tick that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Due {
    /// When it should have started: the first deadline that no tick has served. The lateness
    /// against it is the whole truth, lost periods included.
    pub scheduled_ns: u64,
    /// When it must have ended: the start of the next period.
    pub deadline_ns: u64,
    /// Whole periods that passed between its scheduled and its actual start: skipped.
    pub missed: u32,
}

impl Schedule {
    /// A grid whose first tick is due at `start_ns`.
    #[must_use]
    pub fn new(start_ns: u64, period_ns: u64) -> Self {
        Self {
            next_ns: start_ns,
            period_ns: period_ns.max(1),
            missed: 0,
        }
    }

    /// When to wake up.
    #[must_use]
    pub fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Periods missed so far.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Gives up the period that runs at `now_ns`, if its tick has not begun: the next one is due at
    /// the grid's first point after it. For a loop that has not slept for too long.
    pub fn rest(&mut self, now_ns: u64) {
        if now_ns >= self.next_ns {
            let _ = self.begin(now_ns);
            self.missed += 1;
        }
    }

    /// The tick that starts at `now_ns`, and moves on: the next one is due on the grid, after
    /// `now_ns`. Whole periods that passed meanwhile are skipped.
    pub fn begin(&mut self, now_ns: u64) -> Due {
        let late_ns = now_ns.saturating_sub(self.next_ns);
        let missed = late_ns / self.period_ns;
        let scheduled_ns = self.next_ns;
        self.missed += missed;
        self.next_ns += (missed + 1) * self.period_ns;
        Due {
            scheduled_ns,
            deadline_ns: self.next_ns,
            missed: u32::try_from(missed).unwrap_or(u32::MAX),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_late_tick_keeps_its_place_and_a_stalled_one_skips() {
        let mut schedule = Schedule::new(1_000, 100);
        assert_eq!(schedule.begin(1_003).scheduled_ns, 1_000);
        let late = schedule.begin(1_199);
        assert_eq!((late.scheduled_ns, late.missed), (1_100, 0));
        let stalled = schedule.begin(1_750);
        assert_eq!((stalled.scheduled_ns, stalled.missed), (1_200, 5));
        assert_eq!(schedule.next_ns(), 1_800);
        assert_eq!(schedule.missed(), 5);
    }

    proptest! {
        #[test]
        fn deadlines_stay_on_the_grid_rise_and_account_for_every_period(
            period in 1u64..5_000_000,
            stalls in proptest::collection::vec(0u64..30_000_000, 1..60),
        ) {
            let start = 7_000_000_000;
            let mut schedule = Schedule::new(start, period);
            let (mut now, mut last) = (start, None);
            let mut ticks = 0;
            for stall in stalls {
                now = now.max(schedule.next_ns()) + stall;
                let due = schedule.begin(now);
                ticks += 1;
                prop_assert_eq!((due.scheduled_ns - start) % period, 0);
                prop_assert!(due.scheduled_ns <= now && now < due.deadline_ns);
                prop_assert!(due.deadline_ns - now <= period);
                prop_assert!(last.is_none_or(|last| due.scheduled_ns > last));
                last = Some(due.scheduled_ns);
                let periods = (due.deadline_ns - start) / period;
                prop_assert_eq!(periods, ticks + schedule.missed());
            }
        }
    }
}
