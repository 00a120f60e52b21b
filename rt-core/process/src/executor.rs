//! embassy's raw executor on the calling thread. This file adds the pender (embassy's wake-up
//! function) and an idle loop that sleeps to absolute deadlines.
//!
//! Tasks must not use `yield_now` or other futures that wake themselves: the loop polls again
//! instead of sleeping while a task is ready. Tasks that are ready at the same time run in reverse
//! order of waking, so work that needs an order belongs in one task.
#![expect(
    unsafe_code,
    reason = "the pender is a symbol that gets a raw pointer; polling is unsafe by contract"
)]

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::raw;

use crate::time_driver;

/// embassy's executor. The executor and its tasks are leaked, because embassy needs them to be
/// `'static`. Create one per thread.
pub struct Executor {
    raw: &'static raw::Executor,
    pending: &'static AtomicBool,
}

/// embassy calls this from any thread when a task of the executor with this context becomes ready.
#[unsafe(export_name = "__pender")]
fn pender(context: *mut ()) {
    // SAFETY: `Executor::new` makes every executor of this program. Its context points to a leaked
    // `AtomicBool`.
    let pending = unsafe { &*context.cast::<AtomicBool>() };
    pending.store(true, Ordering::Release);
}

impl Default for Executor {
    fn default() -> Self {
        Self::new()
    }
}

impl Executor {
    /// Makes an executor for the calling thread.
    #[must_use]
    pub fn new() -> Self {
        let pending: &'static AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
        let context = core::ptr::from_ref(pending).cast_mut().cast();
        Self {
            raw: Box::leak(Box::new(raw::Executor::new(context))),
            pending,
        }
    }

    /// Adds a task. Call it only before [`Self::run`], because it allocates.
    pub fn spawn<F: Future<Output = ()> + 'static>(&self, task: F) {
        let storage: &'static raw::TaskStorage<F> = Box::leak(Box::new(raw::TaskStorage::new()));
        // It fails only if the storage already holds a task, and this storage is new.
        if let Ok(token) = storage.spawn(|| task) {
            self.raw.spawner().spawn(token);
        }
    }

    /// Runs until no task is ready and no timer is set. Wakes `spin_ns` before each timer and spins
    /// for the rest.
    pub fn run(&self, spin_ns: u64) {
        loop {
            // SAFETY: the executor was made on this thread, because it is not `Send`. This is the
            // only call of `poll`. No task has access to the executor, so no task re-enters it.
            unsafe { self.raw.poll() };
            let next = time_driver::wake_expired();
            if self.pending.swap(false, Ordering::Acquire) {
                continue;
            }
            if next == u64::MAX {
                return;
            }
            time_driver::sleep_until(next, spin_ns);
        }
    }
}
