//! Service `timing`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::limits::{FAULTS, STAGES, TIMING_BATCH};

/// One tick's timing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
pub struct TickRecord {
    /// Tick's number.
    pub tick: u64,
    /// Its scheduled start (`CLOCK_MONOTONIC`): the first deadline that no earlier tick served.
    pub scheduled_ns: u64,
    /// Actual start − scheduled start, saturating.
    pub wake_latency_ns: u32,
    /// Start to end of the tick.
    pub tick_ns: u32,
    /// From the arrival of the device sample at the host to the written force. 0: no fresh sample.
    pub motion_to_force_ns: u32,
    /// Whole periods between scheduled and actual start. They were skipped (deadline misses).
    pub missed: u32,
    /// Time of each stage.
    pub stage_ns: [u32; STAGES],
    /// Bit set of [`TickRecord::OVERRAN`], `NOT_PUBLISHED`, `STALE`, `CONTACT`, `DROPPED_…`.
    pub bits: u32,
}

impl TickRecord {
    /// It ended after its deadline.
    pub const OVERRAN: u32 = 1;
    /// A frame was due and no slot was free.
    pub const NOT_PUBLISHED: u32 = 2;
    /// The device sample was older than its limit, or the device lost.
    pub const STALE: u32 = 4;
    /// The instrument touched something.
    pub const CONTACT: u32 = 8;
    /// There was no time for self-collision.
    pub const DROPPED_SELF_COLLISION: u32 = 32;
    /// There was no time for organs far from the instrument.
    pub const DROPPED_FAR_ORGANS: u32 = 64;
    /// A frame was due and there was no time for it.
    pub const DROPPED_PUBLISH: u32 = 16;
}

/// Service `timing`: batches of records, with the thread's counters since its start.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.TimingBatch.v6")]
pub struct TimingBatch {
    /// Batch number; a gap is a loss.
    pub sequence: u64,
    /// Heap allocations of the realtime thread since it was armed; `u64::MAX`: not counted.
    pub allocations: u64,
    /// Page faults (minor and major) of the realtime thread since it was armed.
    pub page_faults: u64,
    /// Involuntary context switches since it was armed.
    pub involuntary_switches: u64,
    /// Waits since it was armed, except those until its next tick.
    pub blocks: u64,
    /// Ticks so far.
    pub ticks: u64,
    /// Periods skipped so far.
    pub deadline_misses: u64,
    /// Ticks so far that ended after their deadline.
    pub overruns: u64,
    /// Faults of each kind so far ([`crate::words::Fault`]).
    pub faults: [u64; FAULTS],
    /// Ticks so far in which contact asked for a force.
    pub contact_ticks: u64,
    /// Those in which less or none of it was rendered, by the fault that is the reason.
    pub held_ticks: [u64; FAULTS],
    /// Number of times that force was held back, by reason.
    pub held_times: [u64; FAULTS],
    /// Bits of [`TimingBatch::FIFO`], `LOCKED`, `PINNED`. The thread is realtime with all three.
    pub realtime: u32,
    /// Number of `records` in use.
    pub count: u32,
    /// The records, oldest first.
    pub records: [TickRecord; TIMING_BATCH],
}

impl TimingBatch {
    /// The records in use. `None` if the batch is malformed.
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

// The layout is the contract: a change of size is a change of version.
const _: () = {
    assert!(size_of::<TimingBatch>() == 848 + 64 * TIMING_BATCH);
    assert!(size_of::<TickRecord>() == 64);
};
