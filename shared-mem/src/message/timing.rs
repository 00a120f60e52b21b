//! Service `timing`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::limits::{FAULTS, STAGES, TIMING_BATCH};

/// Names of the stages of a tick, in the order in which they run.
pub const STAGE_NAMES: [&str; STAGES] = [
    "sample",
    "tool",
    "contact",
    "solve",
    "force",
    "procedure",
    "publish",
];

/// One tick's timing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
pub struct TickRecord {
    /// Number of the tick.
    pub tick: u64,
    /// Scheduled start of the tick (`CLOCK_MONOTONIC`): the start of the first period without a
    /// tick.
    pub scheduled_ns: u64,
    /// Actual start − scheduled start, saturating.
    pub wake_latency_ns: u32,
    /// Duration of the tick.
    pub tick_ns: u32,
    /// Time from the arrival of the haptic device's sample at this computer until the force was
    /// written to the device. 0: no fresh sample.
    pub motion_to_force_ns: u32,
    /// Missed periods: number of whole periods between the scheduled and the actual start.
    pub missed: u32,
    /// Duration of each stage.
    pub stage_ns: [u32; STAGES],
    /// Time from hand to force of an earlier tick, by the device's clock: from that tick's sample
    /// to the first sample that confirms that tick's force (its echo). 0: this tick received no
    /// echo.
    pub hand_to_force_ns: u32,
    /// `motion_to_force_ns` of that earlier tick.
    pub echoed_ns: u32,
    /// Bits of the `TickRecord` constants.
    pub bits: u32,
}

impl TickRecord {
    /// The tick ended after its deadline.
    pub const OVERRAN: u32 = 1;
    /// A frame was due, but all buffers for the state or the tools were in use.
    pub const NOT_PUBLISHED: u32 = 2;
    /// The haptic device's newest sample was older than its limit, or the device was lost.
    pub const STALE: u32 = 4;
    /// The instrument touched tissue or the endoscope.
    pub const CONTACT: u32 = 8;
    /// The tick skipped self-collision, because too little time was left.
    pub const DROPPED_SELF_COLLISION: u32 = 32;
    /// The tick skipped far organs, because too little time was left. A far organ is near no tool
    /// and not in the jaws.
    pub const DROPPED_FAR_ORGANS: u32 = 64;
    /// A frame was due, but too little time was left for it.
    pub const DROPPED_PUBLISH: u32 = 16;
    /// The ticks are set to follow the device's samples, but did not: too few samples had arrived,
    /// or they came too irregularly.
    pub const NOT_FOLLOWING: u32 = 128;
}

/// Service `timing`: one batch of records, with counters of the realtime thread. Counting begins
/// just before the first tick, when the thread is "armed".
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.TimingBatch.v7")]
pub struct TimingBatch {
    /// Number of the batch. A gap in the numbers means that batches were lost.
    pub sequence: u64,
    /// Heap allocations of the realtime thread since it was armed; `u64::MAX`: not counted.
    pub allocations: u64,
    /// Page faults (minor and major) of the realtime thread since it was armed.
    pub page_faults: u64,
    /// Involuntary context switches of the realtime thread since it was armed.
    pub involuntary_switches: u64,
    /// Waits of the realtime thread since it was armed, except its sleeps until the next tick.
    pub blocks: u64,
    /// Number of ticks so far.
    pub ticks: u64,
    /// Number of missed periods so far.
    pub missed_periods: u64,
    /// Number of ticks so far that ended after their deadline.
    pub late_ticks: u64,
    /// Number of ticks so far with each kind of fault ([`crate::words::Fault`]).
    pub faults: [u64; FAULTS],
    /// Number of ticks so far in which contact asked for a force. 0 without a haptic device.
    pub contact_ticks: u64,
    /// Number of contact ticks in which each fault held the force back, or in which the force still
    /// rose after that fault.
    pub held_ticks: [u64; FAULTS],
    /// Number of times that each fault began during contact.
    pub held_times: [u64; FAULTS],
    /// Bits [`TimingBatch::FIFO`], `LOCKED` and `PINNED`. The thread counts as a realtime thread if
    /// all three are set.
    pub realtime: u32,
    /// Number of `records` in use.
    pub count: u32,
    /// The records, oldest first.
    pub records: [TickRecord; TIMING_BATCH],
}

impl TimingBatch {
    /// The records in use. `None` if `count` is too large.
    #[must_use]
    pub fn records(&self) -> Option<&[TickRecord]> {
        self.records.get(..self.count as usize)
    }
}

impl TimingBatch {
    /// `realtime` bit: the thread runs under SCHED_FIFO or SCHED_DEADLINE.
    pub const FIFO: u32 = 1;
    /// `realtime` bit: all memory is locked.
    pub const LOCKED: u32 = 2;
    /// `realtime` bit: the thread is pinned to one core (or SCHED_DEADLINE guarantees its time).
    pub const PINNED: u32 = 4;
}

// Both processes rely on these sizes. A change of one needs a new version.
const _: () = {
    assert!(size_of::<TimingBatch>() == 848 + 72 * TIMING_BATCH);
    assert!(size_of::<TickRecord>() == 72);
};
