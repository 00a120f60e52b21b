//! Time stamps that follow the ticks and never run backwards.

use std::time::{SystemTime, UNIX_EPOCH};

use rt_process::time_driver::monotonic_ns;

/// A wall clock that is read once at the start and then advances with the monotonic clock. The
/// stamps do not jump if somebody sets the wall clock later. Receivers refuse stamps that run
/// backwards.
#[derive(Debug, Clone)]
pub(super) struct Stamps {
    unix_from_monotonic_ns: i128,
    last_ns: u64,
}

impl Stamps {
    pub(super) fn now() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let unix_ns = now.unwrap_or_default().as_nanos() as i128;
        Self {
            unix_from_monotonic_ns: unix_ns - i128::from(monotonic_ns()),
            last_ns: 0,
        }
    }

    /// Stamp of a moment on the monotonic clock: Unix time, ns. It is never before the last stamp.
    /// A moment in the future counts as now; only a faulty station sends one.
    pub(super) fn of(&mut self, at_ns: u64) -> u64 {
        let unix_ns = i128::from(at_ns.min(monotonic_ns())) + self.unix_from_monotonic_ns;
        self.last_ns = self.last_ns.max(u64::try_from(unix_ns).unwrap_or_default());
        self.last_ns
    }

    /// Stamp of this moment, for messages that no tick wrote. The stamps of ticks ignore it.
    pub(super) fn present(&self) -> u64 {
        let unix_ns = i128::from(monotonic_ns()) + self.unix_from_monotonic_ns;
        u64::try_from(unix_ns).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_follow_the_ticks_and_never_go_back() {
        // The wall clock is read once, so only the ticks move the stamps.
        let mut stamps = Stamps {
            unix_from_monotonic_ns: 1_700_000_000_000_000_000,
            last_ns: 0,
        };
        for at_ns in [5, 1_000_005, 2_000_005] {
            assert_eq!(stamps.of(at_ns), 1_700_000_000_000_000_000 + at_ns);
        }
        assert_eq!(stamps.of(7), 1_700_000_000_002_000_005);
        assert!(stamps.of(u64::MAX) <= stamps.present(), "not in the future");
    }

    #[test]
    fn stamps_begin_at_the_time_of_day() {
        let mut stamps = Stamps::now();
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let apart_ns = i128::from(stamps.of(monotonic_ns())) - now.as_nanos() as i128;
        assert!(apart_ns.abs() < 60_000_000_000, "{apart_ns} ns");
    }
}
