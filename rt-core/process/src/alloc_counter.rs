//! Allocator that counts the allocations of a thread after the thread has called [`arm`].
//!
//! A binary declares it: `#[global_allocator] static ALLOCATOR: CountingAllocator =
//! CountingAllocator::new();`. [`arm`] checks that the binary declared it, because without it the
//! count would be zero as well.
#![expect(unsafe_code, reason = "GlobalAlloc is an unsafe trait")]

use core::cell::Cell;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

/// Consequence of breaking a rule of the realtime thread (no allocation, no page fault, no block).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnViolation {
    /// The violation is counted.
    Count,
    /// The violation ends the process with a backtrace, for debugging.
    Abort,
}

impl OnViolation {
    /// Debug builds abort on the first violation; release builds count.
    pub const BUILD_DEFAULT: Self = if cfg!(debug_assertions) {
        Self::Abort
    } else {
        Self::Count
    };
}

/// The system's allocator, with a count of the allocations of each armed thread.
#[derive(Debug, Default)]
pub struct CountingAllocator(());

impl CountingAllocator {
    /// Makes the allocator.
    #[must_use]
    pub const fn new() -> Self {
        Self(())
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Arming {
    Off,
    Counting,
    Aborting,
}

thread_local! {
    // These cells have constant initial values and no destructors, so reading them never allocates.
    static ARMING: Cell<Arming> = const { Cell::new(Arming::Off) };
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// Starts counting the calling thread's allocations at 0. Returns false, and does not count, when
/// [`CountingAllocator`] is not the program's allocator.
pub fn arm(on_violation: OnViolation) -> bool {
    COUNT.set(0);
    ARMING.set(Arming::Counting);
    drop(core::hint::black_box(Box::new(0u8)));
    let installed = COUNT.get() > 0;
    COUNT.set(0);
    ARMING.set(match (installed, on_violation) {
        (false, _) => Arming::Off,
        (true, OnViolation::Count) => Arming::Counting,
        (true, OnViolation::Abort) => Arming::Aborting,
    });
    installed
}

/// Stops counting; the count stays.
pub fn disarm() {
    ARMING.set(Arming::Off);
}

/// Allocations, frees and reallocations of the calling thread while it was armed.
#[must_use]
pub fn count() -> u64 {
    COUNT.get()
}

fn note() {
    match ARMING.get() {
        Arming::Off => {}
        Arming::Counting => COUNT.set(COUNT.get() + 1),
        // A panic allocates its message, and the message must still be printed.
        Arming::Aborting if std::thread::panicking() => {}
        Arming::Aborting => {
            disarm();
            let trace = std::backtrace::Backtrace::force_capture();
            // `eprintln` is avoided, because a test harness would capture the message.
            let message = "the realtime thread allocated after its start";
            let _ = writeln!(std::io::stderr(), "{message}:\n{trace}");
            std::process::abort();
        }
    }
}

// SAFETY: every call is passed on to the system's allocator unchanged; counting touches only
// constant-initialised thread-local cells.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        note();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(block, layout, new_size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        note();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(block, layout) }
    }
}
