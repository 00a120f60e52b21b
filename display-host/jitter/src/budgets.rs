//! Attributes each late tick to the part that exceeded its admitted time most: the wake-up or a
//! stage.

use serde::{Deserialize, Serialize};
use shared_mem::message::{STAGE_NAMES, STAGES};

use crate::blackbox::Tick;

/// Name of the part before the stages.
pub const WAKE_UP: &str = "wake-up";

/// Part of a tick, as `jitter.json` holds it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// `wake-up`, or a stage.
    pub stage: String,
    /// Time that the stage took in the worst tick of the controller's own trial before the run.
    /// `None` for the wake-up, and if the controller did not measure its scene.
    pub admitted_ns: Option<u64>,
    /// Longest time that the part took in the run, ns.
    pub worst_ns: u64,
    /// Late ticks that this part caused.
    pub late_ticks: u64,
    /// Share that this part has in all late ticks.
    pub late_share: f64,
}

/// Counts of the late ticks by part.
#[derive(Debug, Clone, Copy, Default)]
pub struct Budgets {
    /// Admitted time of each stage, ns.
    pub admitted_ns: Option<[u64; STAGES]>,
    /// Wake-up, then the stages.
    worst_ns: [u64; STAGES + 1],
    late_ticks: [u64; STAGES + 1],
}

impl Budgets {
    /// Takes a tick. `last_overran` is true if the tick before ended after its deadline.
    pub fn take(&mut self, tick: &Tick, last_overran: bool) {
        for (worst, ns) in self.worst_ns.iter_mut().zip(parts(tick)) {
            *worst = (*worst).max(ns);
        }
        // Periods that were missed while the tick before was at work were counted with that tick.
        let is_late = tick.overran() || (tick.missed > 0 && !last_overran);
        let blamed = self.blamed(tick);
        if is_late && let Some(count) = self.late_ticks.get_mut(blamed) {
            *count += 1;
        }
    }

    /// Part that exceeded its admitted time most. The wake-up has no admitted time. Without a trial
    /// the stages have none either.
    fn blamed(&self, tick: &Tick) -> usize {
        let admitted = self.admitted_ns.unwrap_or_default();
        let due = [0].into_iter().chain(admitted);
        let excess = parts(tick).into_iter().zip(due);
        let excess = excess.map(|(ns, due)| ns.saturating_sub(due)).enumerate();
        excess.max_by_key(|part| part.1).map_or(0, |part| part.0)
    }

    /// The table, in the order of a tick.
    pub fn table(&self) -> Vec<Budget> {
        let names = [WAKE_UP].into_iter().chain(STAGE_NAMES);
        let admitted = [None].into_iter().chain(match self.admitted_ns {
            Some(ns) => ns.map(Some),
            None => [None; STAGES],
        });
        let counts = self.worst_ns.iter().zip(&self.late_ticks);
        let rows = names.zip(admitted).zip(counts);
        let rows = rows.map(|((stage, admitted_ns), (&worst_ns, &late_ticks))| Budget {
            stage: stage.to_owned(),
            admitted_ns,
            worst_ns,
            late_ticks,
            late_share: 0.0,
        });
        shared(rows.collect())
    }
}

/// Wake-up and stages of a tick, ns.
fn parts(tick: &Tick) -> [u64; STAGES + 1] {
    let mut parts = [u64::from(tick.wake_latency_ns); STAGES + 1];
    for (part, &ns) in parts.iter_mut().skip(1).zip(&tick.stage_ns) {
        *part = ns.into();
    }
    parts
}

/// Adds up the tables of two runs.
pub fn sum(mut all: Vec<Budget>, more: Vec<Budget>) -> Vec<Budget> {
    for budget in more {
        match all.iter_mut().find(|it| it.stage == budget.stage) {
            Some(it) => {
                it.admitted_ns = it.admitted_ns.max(budget.admitted_ns);
                it.worst_ns = it.worst_ns.max(budget.worst_ns);
                it.late_ticks += budget.late_ticks;
            }
            None => all.push(budget),
        }
    }
    shared(all)
}

fn shared(mut all: Vec<Budget>) -> Vec<Budget> {
    let late: u64 = all.iter().map(|it| it.late_ticks).sum();
    for it in &mut all {
        it.late_share = it.late_ticks as f64 / late.max(1) as f64;
    }
    all
}

#[cfg(test)]
mod tests {
    use shared_mem::message::TickRecord;

    use super::*;

    fn tick(wake_us: u32, solve_us: u32, late: bool) -> Tick {
        let mut stage_ns = [10_000; STAGES];
        stage_ns[3] = solve_us * 1000;
        Tick {
            tick: 1,
            scheduled_ns: 0,
            wake_latency_ns: wake_us * 1000,
            tick_ns: stage_ns.iter().sum(),
            missed: 0,
            stage_ns,
            bits: if late { TickRecord::OVERRAN } else { 0 },
        }
    }

    fn late_of(table: &[Budget], stage: &str) -> (u64, f64) {
        let found = table.iter().find(|it| it.stage == stage);
        found.map(|it| (it.late_ticks, it.late_share)).unwrap()
    }

    #[test]
    fn a_late_tick_is_laid_to_the_part_that_exceeded_its_due_most() {
        let mut budgets = Budgets {
            admitted_ns: Some([20_000, 20_000, 20_000, 300_000, 20_000, 20_000, 20_000]),
            ..Budgets::default()
        };
        budgets.take(&tick(5000, 300, false), false);
        // The solver exceeds its admitted time by 10 µs, and the wake-up exceeds its own by 800 µs.
        budgets.take(&tick(800, 310, true), false);
        budgets.take(&tick(400, 900, true), false);
        budgets.take(&tick(500, 900, true), false);
        let mut missed = tick(3000, 300, false);
        missed.missed = 3;
        budgets.take(&missed, false);
        budgets.take(&missed, true);
        let table = budgets.table();
        assert_eq!(table.len(), STAGES + 1);
        assert_eq!(late_of(&table, WAKE_UP).0, 2);
        assert_eq!(late_of(&table, "solve").0, 2);
        assert!((late_of(&table, "solve").1 - 0.5).abs() < 1e-9);
        assert_eq!((table[0].worst_ns, table[0].admitted_ns), (5_000_000, None));
        assert_eq!(
            (table[4].worst_ns, table[4].admitted_ns),
            (900_000, Some(300_000))
        );
        let twice = sum(table.clone(), table);
        assert_eq!(late_of(&twice, "solve").0, 4);
        assert!((late_of(&twice, "solve").1 - 0.5).abs() < 1e-9);
    }

    #[test]
    fn without_a_trial_the_longest_part_is_it_and_nothing_is_said_of_no_late_ticks() {
        let mut budgets = Budgets::default();
        assert!(budgets.table().iter().all(|it| it.late_share.abs() < 1e-9));
        budgets.take(&tick(800, 900, true), false);
        assert_eq!(late_of(&budgets.table(), "solve").0, 1);
    }
}
