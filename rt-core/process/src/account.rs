//! The accounting task: what only the kernel and the allocator know of the tick's thread.

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

/// Wakes the accounting; true with the last batch.
pub(crate) type BatchDone = Signal<NoopRawMutex, bool>;

/// The task: once a batch, in the gap after a tick. Its first run arms the counters, just before
/// the first tick.
///
/// With [`OnViolation::Abort`] a page fault in locked memory ends the process, as an allocation
/// does, and so does a block: a wait for anything but the next tick (a lock, a file). Not in a
/// batch that missed periods: whoever stops the process (`SIGSTOP`, a debugger) makes it wait, too.
/// And not in one in which a device came or went: the kernel holds a line while it hangs it up.
/// Page faults end it at the first where the kernel leaves locked pages in their places, else when
/// there are more than it causes by moving some.
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
        let excuses = shared.deadline_misses.load(Relaxed) + shared.device_changes.load(Relaxed);
        let blocked_on_time = blocks.note(usage.waits, sleeps(), excuses);
        shared.allocations.store(allocations, Relaxed);
        if is_strict && (usage.page_faults > faults_max || blocked_on_time) {
            alloc_counter::disarm();
            // Not `eprintln`: a test harness would swallow the last words.
            let did = match blocked_on_time {
                true => "waited for something else than its next tick",
                false => "took a page fault after its start",
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
            // What follows frees the tasks.
            alloc_counter::disarm();
            return;
        }
        last = batch_done.wait().await;
    }
}

/// Pages of the tick's that the kernel may have moved in a run: it works through memory for
/// minutes.
const MOVED_MAX: u64 = 16;

/// Whether the kernel, to get larger blocks of free memory, moves locked pages too: each is a page
/// fault.
fn moves_locked_pages() -> bool {
    std::fs::read_to_string("/proc/sys/vm/compact_unevictable_allowed")
        .is_ok_and(|allowed| allowed.trim() != "0")
}

/// Waits that were no sleep for a tick, counted batch by batch: a sleep whose time comes before it
/// begins is none for the kernel, and must not hide a block elsewhere.
#[derive(Debug, Default)]
struct Blocks {
    waits: u64,
    sleeps: Option<u64>,
    excuses: u64,
    count: u64,
}

impl Blocks {
    /// The next batch, by the counts so far. Gives whether it blocked without an excuse in it.
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
        assert!(blocks.note(192, 1192, 0), "which hides no later block");
        assert!(!blocks.note(258, 1256, 9), "stopped from outside");
        assert_eq!(blocks.count, 3);
    }
}
