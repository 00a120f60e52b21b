//! The main thread's checks of the tick: it must go on ticking and stay realtime.

use core::sync::atomic::Ordering::{Acquire, Relaxed};

use core::time::Duration;

use crate::realtime::Standing;
use crate::shared::Shared;
use crate::time_driver::monotonic_ns;

/// Longest time from any end of the tick (panic, signal, `SIGSTOP`, a kill, a lost memory lock or
/// device) to zero force. A tick that still runs zeroes the force itself. Otherwise the device's
/// watchdog does, whose limit (`hardware::rig::device::WATCHDOG_LIMIT_MS`) is equal.
pub const FORCE_ZERO_WITHIN: Duration = Duration::from_millis(100);
const _: () = assert!(
    FORCE_ZERO_WITHIN.as_millis() >= hardware::rig::device::WATCHDOG_LIMIT_MS as u128
        && FORCE_ZERO_WITHIN.as_nanos() >= 2 * STANDING_EVERY_NS as u128
);
/// Shortest standstill of the tick that is reported, ns.
const STALL_NS: u64 = 50_000_000;
/// Interval at which the privileges of the tick's thread are checked, ns. Each check reads a file.
const STANDING_EVERY_NS: u64 = 50_000_000;

/// Reports each standstill once, and its length.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    is_silent: bool,
    stalls_seen: u64,
    standing_at_ns: u64,
}

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Finding {
    Nothing,
    Stopped { silent_ms: u64 },
    WentOn { stood_ms: u64 },
}

impl Watch {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Checks the heartbeat and reports findings on standard error.
    pub(crate) fn look(&mut self, shared: &Shared) {
        let heartbeat_ns = shared.heartbeat_ns.load(Acquire);
        let stood_ns = shared.stood_ns.swap(0, Relaxed);
        match self.find(heartbeat_ns, stood_ns, monotonic_ns()) {
            Finding::Nothing => {}
            Finding::Stopped { silent_ms } => {
                crate::say!("calot rt: the tick has stood still for {silent_ms} ms");
            }
            Finding::WentOn { stood_ms } => {
                crate::say!("calot rt: the tick goes on after {stood_ms} ms");
            }
        }
    }

    /// Checks, at intervals, that the tick still has its realtime privileges. Prints the lost ones,
    /// removes them from `standing` and from every report, and cuts the force.
    pub(crate) fn look_at_standing(&mut self, shared: &Shared, standing: &mut Standing) {
        let now_ns = monotonic_ns();
        if now_ns < self.standing_at_ns {
            return;
        }
        self.standing_at_ns = now_ns + STANDING_EVERY_NS;
        for why in standing.lose(shared.tick_thread.load(Relaxed)) {
            crate::say!("calot rt: NOT REALTIME any more, force is cut: {why}");
            shared.cut_force.store(true, Relaxed);
        }
        shared.realtime.store(standing.bits, Relaxed);
    }

    /// Number of standstills so far.
    pub(crate) fn stalls_seen(&self) -> u64 {
        self.stalls_seen
    }

    /// Judges a standstill. `stood_ns` is the longest time between two ticks since the last check.
    /// If the whole process was stopped, it may tick again before the watch wakes. Then only
    /// `stood_ns` shows the standstill.
    fn find(&mut self, heartbeat_ns: u64, stood_ns: u64, now_ns: u64) -> Finding {
        // There is no heartbeat before the first tick.
        let silent_ns = match heartbeat_ns {
            0 => 0,
            beat => now_ns.saturating_sub(beat),
        };
        if stood_ns > STALL_NS {
            self.stalls_seen += u64::from(!self.is_silent);
            self.is_silent = false;
            return Finding::WentOn {
                stood_ms: stood_ns / 1_000_000,
            };
        }
        match self.is_silent {
            false if silent_ns > STALL_NS => {
                self.is_silent = true;
                self.stalls_seen += 1;
                let silent_ms = silent_ns / 1_000_000;
                Finding::Stopped { silent_ms }
            }
            _ => Finding::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_standstill_is_reported_once_and_its_end_too() {
        let mut watch = Watch::new();
        assert_eq!(
            watch.find(0, 0, 900 * MS),
            Finding::Nothing,
            "before the start"
        );
        assert_eq!(watch.find(1000 * MS, MS, 1040 * MS), Finding::Nothing);
        let stopped = Finding::Stopped { silent_ms: 60 };
        assert_eq!(watch.find(1000 * MS, 0, 1060 * MS), stopped);
        assert_eq!(watch.find(1000 * MS, 0, 1070 * MS), Finding::Nothing);
        let went_on = Finding::WentOn { stood_ms: 100 };
        assert_eq!(watch.find(1100 * MS, 100 * MS, 1101 * MS), went_on);
        assert_eq!(watch.find(1101 * MS, MS, 1102 * MS), Finding::Nothing);
        assert_eq!(watch.stalls_seen(), 1);
        // The whole process was stopped, and the tick woke first.
        let went_on = Finding::WentOn { stood_ms: 5000 };
        assert_eq!(watch.find(6101 * MS, 5000 * MS, 6102 * MS), went_on);
        assert_eq!(watch.stalls_seen(), 2);
    }
}
