//! The main thread's look at the tick: does it still beat, and is it still realtime?

use core::sync::atomic::Ordering::Relaxed;

use core::time::Duration;

use crate::realtime::Standing;
use crate::shared::Shared;
use crate::time_driver::monotonic_ns;

/// From any end of the tick (panic, signal, `SIGSTOP`, a kill, a lock on memory or a device that is
/// lost) to the end of the force. A tick that still runs zeroes it itself; else the device's
/// watchdog does, whose limit (`hardware::rig::device::WATCHDOG_LIMIT_MS`) is this, too.
pub const FORCE_ZERO_WITHIN: Duration = Duration::from_millis(100);
const _: () = assert!(
    FORCE_ZERO_WITHIN.as_millis() >= hardware::rig::device::WATCHDOG_LIMIT_MS as u128
        && FORCE_ZERO_WITHIN.as_nanos() >= 2 * STANDING_EVERY_NS as u128
);
/// A tick that stands still for longer is reported.
const STALL_NS: u64 = 50_000_000;
/// How often the thread's standing is asked for: it reads a file.
const STANDING_EVERY_NS: u64 = 50_000_000;

/// Reports each standstill once, and how long it was.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    silent_since_ns: Option<u64>,
    stalls_seen: u64,
    standing_at_ns: u64,
}

/// What a look found.
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

    /// Looks at the heartbeat, and says what it finds on standard error.
    pub(crate) fn look(&mut self, shared: &Shared) {
        match self.find(shared.heartbeat_ns.load(Relaxed), monotonic_ns()) {
            Finding::Nothing => {}
            Finding::Stopped { silent_ms } => {
                crate::say!("calot rt: the tick has stood still for {silent_ms} ms");
            }
            Finding::WentOn { stood_ms } => {
                crate::say!("calot rt: the tick goes on after {stood_ms} ms");
            }
        }
    }

    /// Looks, now and then, whether somebody took from the tick what makes it realtime. Takes it
    /// from `standing` and from every report too, says so, and cuts the force.
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

    /// Standstills so far.
    pub(crate) fn stalls_seen(&self) -> u64 {
        self.stalls_seen
    }

    fn find(&mut self, heartbeat_ns: u64, now_ns: u64) -> Finding {
        // No heartbeat before the first tick.
        let silent_ns = match heartbeat_ns {
            0 => 0,
            beat => now_ns.saturating_sub(beat),
        };
        match self.silent_since_ns {
            None if silent_ns > STALL_NS => {
                self.silent_since_ns = Some(heartbeat_ns);
                self.stalls_seen += 1;
                let silent_ms = silent_ns / 1_000_000;
                Finding::Stopped { silent_ms }
            }
            Some(since_ns) if heartbeat_ns != since_ns => {
                self.silent_since_ns = None;
                let stood_ms = heartbeat_ns.saturating_sub(since_ns) / 1_000_000;
                Finding::WentOn { stood_ms }
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
            watch.find(0, 900 * MS),
            Finding::Nothing,
            "before the start"
        );
        assert_eq!(watch.find(1000 * MS, 1040 * MS), Finding::Nothing);
        let stopped = Finding::Stopped { silent_ms: 60 };
        assert_eq!(watch.find(1000 * MS, 1060 * MS), stopped);
        assert_eq!(watch.find(1000 * MS, 1070 * MS), Finding::Nothing);
        let went_on = Finding::WentOn { stood_ms: 100 };
        assert_eq!(watch.find(1100 * MS, 1101 * MS), went_on);
        assert_eq!(watch.find(1101 * MS, 1102 * MS), Finding::Nothing);
        assert_eq!(watch.stalls_seen(), 1);
    }
}
