//! State that the threads of the process share. It consists of atomics, so that no access blocks.

use core::sync::atomic::{
    AtomicBool, AtomicI32, AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed,
};

use std::sync::OnceLock;

use shared_mem::inputs::RunSetup;
use shared_mem::limits::{FAULTS, STAGES};

use crate::summary::Ended;

/// Counters and flags. The tick's thread writes them unless stated otherwise.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// Request to the tick to end: 0 for none, otherwise an [`Ended`] + 1. Any thread writes it.
    stop: AtomicU8,
    /// The tick's thread is past its last tick and sends nothing more.
    pub(crate) tick_ended: AtomicBool,
    /// Kernel's id of the tick's thread.
    pub(crate) tick_thread: AtomicI32,
    /// Bits of `TimingBatch::realtime`. The watch clears the bits of lost privileges.
    pub(crate) realtime: AtomicU32,
    pub(crate) ticks: AtomicU64,
    /// Scheduled start of the newest tick, which the publishing thread follows.
    pub(crate) scheduled_ns: AtomicU64,
    /// End of the newest tick, which the watch checks.
    pub(crate) heartbeat_ns: AtomicU64,
    /// Longest time between the ends of two ticks since the watch last looked.
    pub(crate) stood_ns: AtomicU64,
    pub(crate) missed_periods: AtomicU64,
    pub(crate) late_ticks: AtomicU64,
    /// Allocations of the tick's thread; `u64::MAX`: not counted.
    pub(crate) allocations: AtomicU64,
    pub(crate) page_faults: AtomicU64,
    pub(crate) involuntary_switches: AtomicU64,
    pub(crate) blocks: AtomicU64,
    /// Ticks in which a device came, went stale or was lost.
    pub(crate) device_changes: AtomicU64,
    /// Request of the watch to cut the force; a host's command enables it again.
    pub(crate) cut_force: AtomicBool,
    /// Ticks in which each stage took longer than its budget.
    pub(crate) stages_over: [AtomicU64; STAGES],
    pub(crate) faults: [AtomicU64; FAULTS],
    /// Ticks in which contact asked for a force.
    pub(crate) contact_ticks: AtomicU64,
    /// Ticks of contact in which less of the asked force or none was rendered, for each fault that
    /// held it back.
    pub(crate) held_ticks: [AtomicU64; FAULTS],
    /// Number of times that each fault began to hold the force back during contact.
    pub(crate) held_times: [AtomicU64; FAULTS],
    /// Length of the bundles in which the haptic device's samples came, ms; 0: they came one by
    /// one.
    pub(crate) bundle_ms: AtomicU32,
    /// Largest force sent, N, as bits of f32.
    pub(crate) force_max_n: AtomicU32,
    pub(crate) frames_skipped: AtomicU64,
    pub(crate) self_collisions_dropped: AtomicU64,
    pub(crate) far_organs_dropped: AtomicU64,
    pub(crate) frames_dropped: AtomicU64,
    pub(crate) events_lost: AtomicU64,
    pub(crate) records_lost: AtomicU64,
    /// Ticks whose inputs did not fit their queue; a recording has a gap there.
    pub(crate) inputs_lost: AtomicU64,
    /// Start conditions of the run, set before its first tick.
    pub(crate) setup: OnceLock<RunSetup>,
}

impl Shared {
    /// Asks the tick to end. The first reason is kept.
    pub(crate) fn ask_to_end(&self, why: Ended) {
        let _ = self
            .stop
            .compare_exchange(0, why as u8 + 1, Relaxed, Relaxed);
    }

    /// Reason for which the tick must end, if any.
    pub(crate) fn asked_to_end(&self) -> Option<Ended> {
        match self.stop.load(Relaxed) {
            0 => None,
            1 => Some(Ended::Asked),
            2 => Some(Ended::Commanded),
            3 => Some(Ended::Finished),
            _ => Some(Ended::Runaway),
        }
    }

    /// Adds one to a counter.
    pub(crate) fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_reason_to_end_stays() {
        let shared = Shared::default();
        assert_eq!(shared.asked_to_end(), None);
        shared.ask_to_end(Ended::Commanded);
        shared.ask_to_end(Ended::Asked);
        assert_eq!(shared.asked_to_end(), Some(Ended::Commanded));
        for why in [Ended::Asked, Ended::Finished, Ended::Runaway] {
            let shared = Shared::default();
            shared.ask_to_end(why);
            assert_eq!(shared.asked_to_end(), Some(why));
        }
    }
}
