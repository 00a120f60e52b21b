//! The clock of the experiments.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use hardware::characterise::Clock;
use rt_process::time_driver::now_ns;

use crate::devices::typed::typed_lines;
use crate::say;

/// If a step is later than this, the milliseconds restart at the present time, ns.
const LATE_NS: u64 = 20_000_000;
const MILLISECOND_NS: u64 = 1_000_000;
/// Interval at which the wait for Enter checks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(20);

/// A clock of real milliseconds, which ends when a person presses Enter or Ctrl-C.
pub(super) struct RealClock {
    stop: Arc<AtomicBool>,
    keys: Receiver<String>,
    due_ns: u64,
}

impl RealClock {
    /// Makes a clock that ends on Enter, and on Ctrl-C, which sets `stop`.
    pub(super) fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            stop,
            keys: typed_lines(),
            due_ns: 0,
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Relaxed) || self.keys.try_recv().is_ok()
    }

    /// Waits for Enter. Returns false on Ctrl-C, and if nobody can press Enter.
    pub(super) fn wait_for_enter(&self) -> bool {
        while !self.stop.load(Relaxed) {
            match self.keys.recv_timeout(LOOK) {
                Ok(_) => return true,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    say::note("Standard input is closed, so nobody can press Enter. Add --yes.");
                    return false;
                }
            }
        }
        false
    }
}

impl Clock for RealClock {
    fn next(&mut self) -> Option<u64> {
        self.due_ns += MILLISECOND_NS;
        let now = now_ns();
        if now > self.due_ns + LATE_NS || self.due_ns > now + LATE_NS {
            self.due_ns = now;
        }
        if let Some(early_ns) = self.due_ns.checked_sub(now) {
            std::thread::sleep(Duration::from_nanos(early_ns));
        }
        (!self.is_stopped()).then(now_ns)
    }
}
