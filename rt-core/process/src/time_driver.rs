//! Time for embassy: `CLOCK_MONOTONIC` in ns, or simulated time that jumps to the next expiry.
//!
//! embassy allows one time driver per program. This one keeps clock and timer queue per thread, so
//! that executors in several threads (tests) do not affect each other: a task's timers are polled
//! only on the thread of its executor.

use core::cell::{Cell, RefCell};
use core::task::Waker;

use embassy_time_queue_utils::Queue;
use rustix::thread::ClockId;
use rustix::time::Timespec;

thread_local! {
    static SIMULATED_NS: Cell<Option<u64>> = const { Cell::new(None) };
    static SLEEPS: Cell<u64> = const { Cell::new(0) };
    static TIMERS: RefCell<Queue> = const { RefCell::new(Queue::new()) };
}

/// Nanoseconds of `CLOCK_MONOTONIC`, or this thread's simulated time.
#[must_use]
pub fn now_ns() -> u64 {
    SIMULATED_NS.get().unwrap_or_else(monotonic_ns)
}

/// Nanoseconds of `CLOCK_MONOTONIC`, even in simulated time.
#[must_use]
pub fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(ClockId::Monotonic);
    // Neither field is negative on a monotonic clock.
    now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()
}

/// Switches this thread to simulated time, in which sleeping takes no time.
pub fn simulate_from(start_ns: u64) {
    SIMULATED_NS.set(Some(start_ns));
}

/// Advances simulated time, as work or a stall would. Does nothing in real time.
pub fn advance_simulated(by_ns: u64) {
    if let Some(now) = SIMULATED_NS.get() {
        SIMULATED_NS.set(Some(now.saturating_add(by_ns)));
    }
}

/// Number of times that this thread slept for a deadline.
pub(crate) fn sleeps() -> u64 {
    SLEEPS.get()
}

/// Sleeps until `at_ns`, waking `spin_ns` early to spin for the rest. Returns at once when the time
/// has passed. A signal does not end the sleep early, because the loop sleeps to the absolute
/// deadline again.
pub(crate) fn sleep_until(at_ns: u64, spin_ns: u64) {
    if let Some(now) = SIMULATED_NS.get() {
        SIMULATED_NS.set(Some(now.max(at_ns)));
        return;
    }
    let wake_ns = at_ns.saturating_sub(spin_ns);
    let wake = Timespec {
        tv_sec: (wake_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (wake_ns % 1_000_000_000).cast_signed(),
    };
    while monotonic_ns() < wake_ns {
        SLEEPS.set(SLEEPS.get() + 1);
        // The error is EINTR; in any case the loop reads the clock again.
        let _ = rustix::thread::clock_nanosleep_absolute(ClockId::Monotonic, &wake);
    }
    while monotonic_ns() < at_ns {
        core::hint::spin_loop();
    }
}

/// Wakes this thread's tasks whose time has come; returns the next expiry, `u64::MAX` for none.
pub(crate) fn wake_expired() -> u64 {
    TIMERS.with_borrow_mut(|timers| timers.next_expiration(now_ns()))
}

struct ThreadTime;

impl embassy_time_driver::Driver for ThreadTime {
    fn now(&self) -> u64 {
        now_ns()
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        TIMERS.with_borrow_mut(|timers| timers.schedule_wake(at, waker));
    }
}

// One tick of embassy is one nanosecond here.
const _: () = assert!(embassy_time::TICK_HZ == 1_000_000_000);

embassy_time_driver::time_driver_impl!(static DRIVER: ThreadTime = ThreadTime);
