//! The accounting task: reads what the kernel and the allocator counted for the tick's thread.

use core::sync::atomic::Ordering::Relaxed;
use std::io::Write;
use std::rc::Rc;
use std::sync::Arc;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use shared_mem::message::TimingBatch;

use crate::alloc_counter::{self, OnViolation};
use crate::realtime::ThreadUsage;
use crate::shared::Shared;
use crate::time_driver::sleeps;

/// Signal that wakes the accounting task. Its value is true for the last batch.
pub(crate) type BatchDone = Signal<NoopRawMutex, bool>;

/// Runs once per batch of timing records, in the gap after a tick. Its first run arms the counters
/// just before the first tick. The counters begin to count then.
///
/// With [`OnViolation::Abort`] and locked memory, the process ends at the end of a batch if:
///
/// - the thread took a page fault. A kernel that moves locked pages may cause [`MOVED_MAX`] of
///   these faults in a run.
/// - the thread blocked: it waited for anything other than its next tick (a lock, a file).
///
/// A block is excused in two kinds of batches. In a batch with missed periods the process may have
/// been stopped (`SIGSTOP`, a debugger). In a batch in which a device came or went, the kernel may
/// hold the device's line, and with it the thread, while the line hangs up.
pub(crate) async fn account(
    batch_done: Rc<BatchDone>,
    shared: Arc<Shared>,
    on_violation: OnViolation,
) {
    let is_locked = shared.realtime.load(Relaxed) & TimingBatch::LOCKED != 0;
    let is_strict = is_locked && on_violation == OnViolation::Abort;
    let faults_max = if moves_locked_pages() { MOVED_MAX } else { 0 };
    let counts = alloc_counter::arm(on_violation);
    let start = ThreadUsage::now();
    let mut blocks = Blocks::default();
    let mut last = false;
    loop {
        let allocations = if counts {
            alloc_counter::count()
        } else {
            u64::MAX
        };
        let usage = ThreadUsage::now().since(start);
        let excuses = shared.missed_periods.load(Relaxed) + shared.device_changes.load(Relaxed);
        let blocked_on_time = blocks.note(usage.waits, sleeps(), excuses);
        shared.allocations.store(allocations, Relaxed);
        if is_strict && (usage.page_faults > faults_max || blocked_on_time) {
            alloc_counter::disarm();
            // `eprintln` is avoided, because a test harness would capture the message.
            let did = match blocked_on_time {
                true => "waited for something other than its next tick",
                false => "took too many page faults after its start",
            };
            let _ = writeln!(
                std::io::stderr(),
                "the realtime thread {did} ({usage:?}, {blocks:?})"
            );
            std::process::abort();
        }
        shared.page_faults.store(usage.page_faults, Relaxed);
        shared
            .involuntary_switches
            .store(usage.involuntary_switches, Relaxed);
        shared.blocks.store(blocks.count, Relaxed);
        if last {
            // The executor's tasks are freed next, and these calls of the allocator must not count.
            alloc_counter::disarm();
            return;
        }
        last = batch_done.wait().await;
    }
}

/// Largest number of page faults in a run that is excused, because the kernel may have moved the
/// pages. The kernel may continue to move memory for minutes.
const MOVED_MAX: u64 = 16;

/// True if the kernel moves locked pages to form larger free blocks. Each move is a page fault.
fn moves_locked_pages() -> bool {
    std::fs::read_to_string("/proc/sys/vm/compact_unevictable_allowed")
        .is_ok_and(|allowed| allowed.trim() != "0")
}

/// Counter of blocks: waits of the thread other than its sleeps for a tick. It counts the waits of
/// each batch less the sleeps of that batch. A sleep whose time has already come is no wait for the
/// kernel. In a count over the whole run, each such sleep would hide a block in another batch.
#[derive(Debug, Default)]
struct Blocks {
    waits: u64,
    sleeps: Option<u64>,
    excuses: u64,
    count: u64,
}

impl Blocks {
    /// Takes the counts since the start, at the end of a batch. Returns true if the thread blocked
    /// in the batch without an excuse: a missed period, or a device that came or went.
    fn note(&mut self, waits: u64, sleeps: u64, excuses: u64) -> bool {
        let slept = sleeps - self.sleeps.unwrap_or(sleeps);
        let blocked = (waits - self.waits).saturating_sub(slept);
        let excused = excuses != self.excuses;
        self.count += blocked;
        (self.waits, self.sleeps, self.excuses) = (waits, Some(sleeps), excuses);
        blocked > 0 && !excused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_that_is_no_sleep_for_a_tick_is_a_block() {
        let mut blocks = Blocks::default();
        assert!(!blocks.note(0, 1000, 0), "before the first tick");
        assert!(!blocks.note(64, 1064, 0));
        assert!(!blocks.note(127, 1128, 0), "a sleep that was over at once");
        assert!(blocks.note(192, 1192, 0), "that sleep hides no later block");
        assert!(!blocks.note(258, 1256, 9), "stopped from outside");
        assert_eq!(blocks.count, 3);
    }
}
