//! Table of the time that late ticks lost, by cause.

use serde::{Deserialize, Serialize};

use crate::slice::What;

/// Time that late ticks lost to one thing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cause {
    /// Kind.
    pub what: What,
    /// Name of interrupt, softirq or thread.
    pub name: String,
    /// Time lost, µs.
    pub lost_us: u64,
    /// Late ticks that lost time to it.
    pub ticks: u64,
}

/// Source of the causes, as `jitter.json` and the page state it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// `events`, `switches` (threads alone) or `counters`.
    pub name: String,
    /// True if causes are guessed from counters that rose meanwhile.
    pub is_coarse: bool,
    /// Permission or option that a better source needs; empty for events.
    pub missing: String,
    /// Events read.
    pub events: u64,
    /// Events that the kernel dropped because they were not read in time.
    pub lost_events: u64,
    /// Late ticks.
    pub late_ticks: u64,
}

impl Source {
    /// Source of two turns together.
    pub fn and(mut self, other: Self) -> Self {
        self.is_coarse |= other.is_coarse;
        if other.is_coarse {
            self.name = other.name;
            self.missing = other.missing;
        }
        self.events += other.events;
        self.lost_events += other.lost_events;
        self.late_ticks += other.late_ticks;
        self
    }
}

/// Adds up tables of causes.
pub fn sum(mut all: Vec<Cause>, more: Vec<Cause>) -> Vec<Cause> {
    for cause in more {
        let same = |it: &&mut Cause| it.what == cause.what && it.name == cause.name;
        match all.iter_mut().find(same) {
            Some(sum) => {
                sum.lost_us += cause.lost_us;
                sum.ticks += cause.ticks;
            }
            None => all.push(cause),
        }
    }
    sorted(all)
}

/// Sorts causes by lost time, greatest first.
pub(crate) fn sorted(mut causes: Vec<Cause>) -> Vec<Cause> {
    causes.sort_by(|a, b| b.lost_us.cmp(&a.lost_us).then_with(|| a.name.cmp(&b.name)));
    causes
}
