//! Stretches of time in which something ran on the tick's core.

use serde::{Deserialize, Serialize};

/// Kind of what ran.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// A device's or a timer's interrupt.
    Interrupt,
    /// Deferred work of interrupts.
    Softirq,
    /// Another thread.
    Thread,
    /// Nothing: the core slept although a tick was due.
    Idle,
    /// The hypervisor ran something else.
    Steal,
    /// The tick's own thread. The tick before was still at work, or this tick's thread ran and had
    /// not yet read the clock.
    Tick,
    /// Nothing that the source of the causes can see.
    Unseen,
}

impl What {
    /// Name in JSON and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interrupt => "interrupt",
            Self::Softirq => "softirq",
            Self::Thread => "thread",
            Self::Idle => "idle",
            Self::Steal => "steal",
            Self::Tick => "tick",
            Self::Unseen => "unseen",
        }
    }
}

/// A stretch of time in which something ran on the tick's core.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slice {
    /// Kind.
    pub what: What,
    /// Name of interrupt, softirq or thread.
    pub name: String,
    /// Beginning, `CLOCK_MONOTONIC`.
    pub from_ns: u64,
    /// Length.
    pub for_ns: u64,
}
