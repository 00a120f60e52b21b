//! Flags that the window sets and the test reads, so that neither waits for the other.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// Flags of a window. A flag that is set stays set.
#[derive(Debug, Default)]
pub(super) struct Signs {
    seen: AtomicBool,
    halt: AtomicBool,
}

impl Signs {
    /// Notes that the person sees the window.
    pub(super) fn see(&self) {
        self.seen.store(true, SeqCst);
    }

    /// True once the person has seen the window.
    pub(super) fn is_seen(&self) -> bool {
        self.seen.load(SeqCst)
    }

    /// Asks the test to end itself and every force now.
    pub(super) fn halt(&self) {
        self.halt.store(true, SeqCst);
    }

    /// True once the test must end.
    pub(super) fn is_halted(&self) -> bool {
        self.halt.load(SeqCst)
    }
}
