//! Clock of a test: waits for each millisecond, and knows when the test must end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use rt_process::time_driver::now_ns;

/// Paces a test. The test ends on Ctrl-C, or when nobody can answer any more.
pub(super) struct Pace {
    stop: Arc<AtomicBool>,
    is_over: bool,
    due: Instant,
}

impl Pace {
    /// Starts the clock of a test that `stop` ends.
    pub(super) fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            stop,
            is_over: false,
            due: Instant::now(),
        }
    }

    /// Waits for the next millisecond and returns the time, ns. A late call returns at once, and
    /// the next millisecond begins at that moment.
    pub(super) fn wait(&mut self) -> u64 {
        self.due += Duration::from_millis(1);
        match self.due.checked_duration_since(Instant::now()) {
            Some(early) => std::thread::sleep(early),
            None => self.due = Instant::now(),
        }
        now_ns()
    }

    /// Ends the test, because nobody can answer.
    pub(super) const fn end(&mut self) {
        self.is_over = true;
    }

    /// True if the test must end.
    pub(super) fn is_stopped(&self) -> bool {
        self.is_over || self.stop.load(Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_ends_on_ctrl_c_or_when_nobody_answers() {
        let stop = Arc::new(AtomicBool::new(false));
        let mut pace = Pace::new(Arc::clone(&stop));
        let before_ns = pace.wait();
        assert!(pace.wait() >= before_ns && !pace.is_stopped());
        stop.store(true, Relaxed);
        assert!(pace.is_stopped());
        stop.store(false, Relaxed);
        pace.end();
        assert!(pace.is_stopped());
    }

    #[test]
    fn each_wait_takes_a_millisecond_and_missed_ones_are_not_made_up_for() {
        let mut pace = Pace::new(Arc::default());
        let start = Instant::now();
        std::thread::sleep(Duration::from_millis(20));
        for _ in 0..10 {
            pace.wait();
        }
        // The first wait is late and returns at once. The other nine take 1 ms each.
        assert!(start.elapsed() >= Duration::from_millis(29));
    }
}
