//! The periods of the ticks: absolute times, and no burst after a stall.

/// The grid of periods. Period `k` begins at `start + k × period`, and its tick must end before the
/// next period begins. A period that ends before its tick could start is missed. Missed periods are
/// counted, and their ticks never run.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    /// Start of the first period that has had no tick.
    next_ns: u64,
    /// Earliest start of a tick after a rest.
    rest_until_ns: u64,
    period_ns: u64,
}

/// A tick that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Due {
    /// Scheduled start: the start of the first period that has had no tick. The tick's lateness
    /// against this time includes missed periods.
    pub scheduled_ns: u64,
    /// Deadline for the tick's end: the start of the next period.
    pub deadline_ns: u64,
    /// Whole periods skipped between the scheduled and the actual start.
    pub missed: u32,
}

impl Schedule {
    /// A grid whose first tick is due at `start_ns`.
    #[must_use]
    pub fn new(start_ns: u64, period_ns: u64) -> Self {
        Self {
            next_ns: start_ns,
            rest_until_ns: start_ns,
            period_ns: period_ns.max(1),
        }
    }

    /// Time of the next wake-up.
    #[must_use]
    pub fn next_ns(&self) -> u64 {
        self.next_ns.max(self.rest_until_ns)
    }

    /// Gives up the period in which `now_ns` lies, if its tick has not begun, so that the loop
    /// sleeps until the next period. The loop calls this when it has not slept for too long. The
    /// next tick reports the period as missed.
    pub fn rest(&mut self, now_ns: u64) {
        if now_ns >= self.next_ns {
            let over = (now_ns - self.next_ns) / self.period_ns;
            self.rest_until_ns = self.next_ns + (over + 1) * self.period_ns;
        }
    }

    /// Moves the following ticks. The step is at most a hundredth of a period either way.
    pub fn step(&mut self, by_ns: i64) {
        let most = i64::try_from(self.period_ns / 100).unwrap_or(i64::MAX);
        let by_ns = by_ns.clamp(-most, most);
        self.next_ns = self.next_ns.saturating_add_signed(by_ns);
        self.rest_until_ns = self.rest_until_ns.saturating_add_signed(by_ns);
    }

    /// Returns the tick that starts at `now_ns` and advances: the next one is due at the first grid
    /// point after `now_ns`. Whole periods in between are skipped.
    pub fn begin(&mut self, now_ns: u64) -> Due {
        let late_ns = now_ns.saturating_sub(self.next_ns);
        let missed = late_ns / self.period_ns;
        let scheduled_ns = self.next_ns;
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
    fn late_tick_keeps_its_period_and_stalled_tick_skips_periods() {
        let mut schedule = Schedule::new(1_000, 100);
        assert_eq!(schedule.begin(1_003).scheduled_ns, 1_000);
        let late = schedule.begin(1_199);
        assert_eq!((late.scheduled_ns, late.missed), (1_100, 0));
        let stalled = schedule.begin(1_750);
        assert_eq!((stalled.scheduled_ns, stalled.missed), (1_200, 5));
        assert_eq!(schedule.next_ns(), 1_800);
    }

    #[test]
    fn period_of_a_rest_is_reported_as_missed() {
        let mut schedule = Schedule::new(1_000, 100);
        let _ = schedule.begin(1_000);
        schedule.rest(1_050);
        assert_eq!(schedule.next_ns(), 1_100, "nothing to give up");
        schedule.rest(1_230);
        assert_eq!(schedule.next_ns(), 1_300);
        let due = schedule.begin(1_301);
        assert_eq!(
            (due.scheduled_ns, due.missed, due.deadline_ns),
            (1_100, 2, 1_400)
        );
        assert_eq!(schedule.next_ns(), 1_400);
    }

    #[test]
    fn a_step_moves_all_following_ticks_by_at_most_a_hundredth() {
        let mut schedule = Schedule::new(1_000_000, 100_000);
        schedule.step(300);
        assert_eq!(schedule.next_ns(), 1_000_300);
        let due = schedule.begin(1_000_300);
        assert_eq!((due.deadline_ns, due.missed), (1_100_300, 0));
        schedule.step(-90_000);
        assert_eq!(schedule.next_ns(), 1_099_300);
        schedule.rest(1_150_000);
        schedule.step(-300);
        assert_eq!(schedule.next_ns(), 1_199_000, "a rest moves along");
    }

    proptest! {
        #[test]
        fn deadlines_stay_on_the_grid_rise_and_account_for_every_period(
            period in 1u64..5_000_000,
            stalls in proptest::collection::vec((0u64..30_000_000, any::<bool>()), 1..60),
        ) {
            let start = 7_000_000_000;
            let mut schedule = Schedule::new(start, period);
            let (mut now, mut last) = (start, None);
            let (mut ticks, mut missed) = (0, 0);
            for (stall, rests) in stalls {
                now = now.max(schedule.next_ns()) + stall;
                if rests {
                    schedule.rest(now);
                    now = now.max(schedule.next_ns());
                }
                let due = schedule.begin(now);
                ticks += 1;
                missed += u64::from(due.missed);
                prop_assert_eq!((due.scheduled_ns - start) % period, 0);
                prop_assert!(due.scheduled_ns <= now && now < due.deadline_ns);
                prop_assert!(due.deadline_ns - now <= period);
                prop_assert!(last.is_none_or(|last| due.scheduled_ns > last));
                last = Some(due.scheduled_ns);
                let periods = (due.deadline_ns - start) / period;
                prop_assert_eq!(periods, ticks + missed);
            }
        }
    }
}
