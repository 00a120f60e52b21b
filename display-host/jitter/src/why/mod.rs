//! Finds out what ran on the tick's core while a tick was late.
//!
//! ```text
//! kernel's events ─► tracer ─► parse ─► course   what ran when, for the last seconds
//! perf_event_open  ─► switches ─────────► course   threads alone, if tracefs may not be read
//! kernel's counters ─► coarse                    what rose when, if neither may be read
//!                          course ─► losses ─► causes   summed over the late ticks
//!                                        └──► slices    of each incident
//! ```
//!
//! The source is the kernel's events of context switches, interrupts and softirqs, read through an
//! instance of its own in tracefs. Every kernel with tracefs has them. The tracers osnoise and
//! timerlat tell the same, but many kernels lack them. Their settings also belong to the whole
//! machine, so this run would disturb a tester's own `rtla`.

pub mod coarse;
pub mod course;
pub mod parse;
pub mod switches;
pub mod tracer;
mod watch;

use crate::blackbox::Tick;
use crate::cause::sorted;

pub use crate::cause::{Cause, Source, sum};
pub use crate::slice::{Slice, What};
pub use watch::Watch;

/// Least lost time at which a tick counts as late, ns: a tenth of the period. A smaller loss leaves
/// a tick nearly all of its period, and is below the frame of high-speed USB (125 µs).
pub const LATE_NS: u64 = 100_000;
/// Largest number of causes kept by name. Later ones count together as one, so memory is constant.
const CAUSES_MAX: usize = 200;
/// Name under which the later causes count.
const OTHERS: &str = "others";

/// Time that one tick lost to one thing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss {
    /// Kind.
    pub what: What,
    /// Name.
    pub name: String,
    /// Time, ns.
    pub ns: u64,
}

/// Time that a tick lost, by cause. All time from its due time until it began is lost. After that,
/// only the time in which something else ran is lost. `slices` are those that overlap the tick.
pub fn losses(tick: &Tick, slices: &[Slice], virtual_machine: bool) -> Vec<Loss> {
    let due = tick.scheduled_ns;
    let begun = due + u64::from(tick.wake_latency_ns);
    let end = begun + u64::from(tick.tick_ns);
    let mut lost: Vec<Loss> = Vec::new();
    let mut covered = 0;
    for slice in slices {
        let to = slice.from_ns.saturating_add(slice.for_ns);
        let within = |from: u64, until: u64| to.min(until).saturating_sub(slice.from_ns.max(from));
        let before = within(due, begun);
        covered += before;
        let during = match slice.what {
            What::Tick => 0,
            _ => within(begun, end),
        };
        let cause = match slice.what {
            // The tick's thread ran, and had not yet read the clock.
            What::Tick if slice.from_ns > due => (What::Tick, "its own start"),
            _ => named(slice, virtual_machine),
        };
        add(&mut lost, cause, before + during);
    }
    // An NMI is listed on top of what it interrupted, so the sum can exceed the latency.
    let unseen = u64::from(tick.wake_latency_ns).saturating_sub(covered);
    add(&mut lost, (What::Unseen, "no event"), unseen);
    lost.sort_by_key(|loss| core::cmp::Reverse(loss.ns));
    lost
}

/// Cause that a slice stands for, if a tick lost time to the slice.
fn named(slice: &Slice, virtual_machine: bool) -> (What, &str) {
    match (slice.what, virtual_machine) {
        (What::Idle, true) => (What::Steal, "the host woke the sleeping core late"),
        (What::Idle, false) => (What::Idle, "the timer woke the sleeping core late"),
        (What::Tick, _) => (What::Tick, "the tick before was still at work"),
        (what, _) => (what, &slice.name),
    }
}

fn add(lost: &mut Vec<Loss>, (what, name): (What, &str), ns: u64) {
    if ns == 0 {
        return;
    }
    let same = |loss: &&mut Loss| loss.what == what && loss.name == name;
    match lost.iter_mut().find(same) {
        Some(loss) => loss.ns += ns,
        None => lost.push(Loss {
            what,
            name: name.to_owned(),
            ns,
        }),
    }
}

/// Sums of the losses. They are kept in ns, and the table states them in µs.
#[derive(Debug, Clone, Default)]
pub struct Causes {
    sums: Vec<(Loss, u64)>,
    /// Late ticks so far.
    pub late_ticks: u64,
}

impl Causes {
    /// Takes the losses of a tick. Only a late tick counts.
    pub fn take(&mut self, losses: &[Loss]) {
        let all: u64 = losses.iter().map(|loss| loss.ns).sum();
        if all < LATE_NS {
            return;
        }
        self.late_ticks += 1;
        for loss in losses {
            self.add(loss);
        }
    }

    fn add(&mut self, loss: &Loss) {
        let is_full = self.sums.len() >= CAUSES_MAX;
        let same = |sum: &&mut (Loss, u64)| sum.0.what == loss.what && sum.0.name == loss.name;
        if let Some((sum, ticks)) = self.sums.iter_mut().find(same) {
            sum.ns += loss.ns;
            *ticks += 1;
            return;
        }
        let rest = |sum: &&mut (Loss, u64)| sum.0.name == OTHERS;
        match self.sums.iter_mut().find(rest) {
            Some((sum, ticks)) if is_full => {
                sum.ns += loss.ns;
                *ticks += 1;
            }
            _ => {
                let mut first = loss.clone();
                if is_full {
                    OTHERS.clone_into(&mut first.name);
                    first.what = What::Unseen;
                }
                self.sums.push((first, 1));
            }
        }
    }

    /// The causes by lost time, greatest first.
    pub fn table(&self) -> Vec<Cause> {
        let each = self.sums.iter().map(|(sum, ticks)| Cause {
            what: sum.what,
            name: sum.name.clone(),
            lost_us: (sum.ns + 500) / 1000,
            ticks: *ticks,
        });
        sorted(each.collect())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn slice(what: What, name: &str, from_ns: u64, for_ns: u64) -> Slice {
        Slice {
            what,
            name: name.to_owned(),
            from_ns,
            for_ns,
        }
    }

    pub(crate) fn tick(scheduled_ns: u64, wake_latency_ns: u32, tick_ns: u32) -> Tick {
        Tick {
            tick: 1,
            scheduled_ns,
            wake_latency_ns,
            tick_ns,
            missed: 0,
            stage_ns: [0; 7],
            bits: 0,
        }
    }

    fn told(losses: &[Loss]) -> Vec<(What, &str, u64)> {
        let each = losses.iter();
        each.map(|loss| (loss.what, loss.name.as_str(), loss.ns))
            .collect()
    }

    #[test]
    fn time_before_the_begin_is_lost_whole_and_later_only_to_others() {
        // Due at 1000 µs, begun at 1150 µs, ended at 1350 µs.
        let late = tick(1_000_000, 150_000, 200_000);
        let slices = [
            slice(What::Idle, "swapper/1", 900_000, 140_000),
            slice(What::Interrupt, "local_timer", 1_040_000, 10_000),
            slice(What::Thread, "kworker/1:0", 1_050_000, 90_000),
            slice(What::Tick, "calot-tick", 1_140_000, 60_000),
            slice(What::Softirq, "NET_RX", 1_200_000, 30_000),
            slice(What::Tick, "calot-tick", 1_230_000, 120_000),
            slice(What::Idle, "swapper/1", 1_350_000, 500_000),
        ];
        let expected = [
            (What::Thread, "kworker/1:0", 90_000),
            (What::Idle, "the timer woke the sleeping core late", 40_000),
            (What::Softirq, "NET_RX", 30_000),
            (What::Interrupt, "local_timer", 10_000),
            (What::Tick, "its own start", 10_000),
        ];
        assert_eq!(told(&losses(&late, &slices, false)), expected);
        let in_guest = losses(&late, &slices, true);
        assert!(
            in_guest
                .iter()
                .any(|loss| loss.what == What::Steal && loss.ns == 40_000)
        );
        let busy = [slice(What::Tick, "calot-tick", 900_000, 250_000)];
        let expected = [(What::Tick, "the tick before was still at work", 150_000)];
        assert_eq!(told(&losses(&late, &busy, false)), expected);
        let without = losses(&late, &[], false);
        assert_eq!(told(&without), [(What::Unseen, "no event", 150_000)]);
    }

    #[test]
    fn only_late_ticks_count_and_the_greatest_cause_comes_first() {
        let mut causes = Causes::default();
        let loss = |name: &str, ns| Loss {
            what: What::Thread,
            name: name.to_owned(),
            ns,
        };
        causes.take(&[loss("a", LATE_NS - 1)]);
        assert!(causes.table().is_empty());
        causes.take(&[loss("a", 70_000), loss("b", 30_000)]);
        causes.take(&[loss("b", 130_400)]);
        let cause = |name: &str, lost_us, ticks| Cause {
            what: What::Thread,
            name: name.to_owned(),
            lost_us,
            ticks,
        };
        assert_eq!(causes.table(), [cause("b", 160, 2), cause("a", 70, 1)]);
        assert_eq!(causes.late_ticks, 2);
        let twice = sum(causes.table(), causes.table());
        assert_eq!(twice, [cause("b", 320, 4), cause("a", 140, 2)]);
    }

    #[test]
    fn a_thousand_names_take_no_more_room_than_two_hundred() {
        let mut causes = Causes::default();
        for i in 0..1000 {
            causes.take(&[Loss {
                what: What::Thread,
                name: format!("worker-{i}"),
                ns: LATE_NS,
            }]);
        }
        let table = causes.table();
        assert_eq!(table.len(), CAUSES_MAX + 1);
        let first = &table[0];
        assert_eq!((first.name.as_str(), first.ticks), (OTHERS, 800));
        let all: u64 = table.iter().map(|cause| cause.lost_us).sum();
        assert_eq!(all, 100 * 1000);
    }
}
