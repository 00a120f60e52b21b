//! Signs that the window gives the bench, without waiting.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

/// Signs of a window. None is taken back.
#[derive(Debug, Default)]
pub(super) struct Signs {
    seen: AtomicBool,
    halt: AtomicBool,
}

impl Signs {
    /// The person sees the window.
    pub(super) fn see(&self) {
        self.seen.store(true, SeqCst);
    }

    /// True once the person has seen the window.
    pub(super) fn is_seen(&self) -> bool {
        self.seen.load(SeqCst)
    }

    /// The test must end now, with every force.
    pub(super) fn halt(&self) {
        self.halt.store(true, SeqCst);
    }

    /// True once the test must end.
    pub(super) fn is_halted(&self) -> bool {
        self.halt.load(SeqCst)
    }
}
