//! Finds samples that come in bundles, as a USB adapter's latency timer sends them.

use rt_core::time::TimeNs;

/// Shortest time between the first and the last sample of a bundle by the device's clock, µs:
/// longer than the 5 ms after which a sample at 1 kHz is stale.
const BUNDLE_US: u32 = 6_000;
/// Longest pause of the host between two polls for which samples are judged, ns. A longer pause
/// would itself make samples come in bundles.
const ON_TIME_NS: u64 = 4_000_000;
/// Length of a window of samples that are judged together, by the device's clock, µs.
const WINDOW_US: u32 = 300_000;
/// Share of a window's time, in percent, that bundles must fill.
const BUNDLED_PERCENT: u32 = 80;
/// Largest spread of the bundles' lengths in a window, µs. A timer is regular; a busy computer is
/// not.
const SPREAD_US: u32 = 3_000;
/// Windows in a row that must show bundles.
const WINDOWS: u32 = 2;

/// Pause between two arrivals that ends a bundle, ns. Samples of a bundle come within a millisecond
/// or two, however many polls that takes.
const PAUSE_NS: u64 = 3_000_000;
/// Time by the device's clock after which a group of arrivals without a pause is ended and judged,
/// µs.
const STREAM_US: u32 = 100_000;

/// Samples that came without a pause between them.
#[derive(Debug, Clone, Copy)]
struct Group {
    first_us: u32,
    last_us: u32,
    first_ns: TimeNs,
    last_ns: TimeNs,
}

/// The present group of samples, and the sums over the earlier groups of the window.
#[derive(Debug, Default)]
pub(super) struct Bundles {
    group: Option<Group>,
    /// Arrival of the newest sample.
    arrived_ns: TimeNs,
    /// True after the host was late. Samples are then ignored up to the next pause between
    /// arrivals.
    is_ignoring: bool,
    judged_us: u32,
    bundled_us: u32,
    shortest_us: u32,
    longest_us: u32,
    count: u32,
    windows: u32,
    length_us: u32,
}

impl Bundles {
    /// Begins a poll, `paused_ns` after the previous one.
    pub(super) const fn begin(&mut self, paused_ns: u64) {
        if paused_ns > ON_TIME_NS {
            self.group = None;
            self.is_ignoring = true;
        }
    }

    /// Takes a sample: the device's time and its arrival.
    pub(super) fn take(&mut self, us: u32, at_ns: TimeNs) {
        let paused = at_ns.saturating_sub(self.arrived_ns) >= PAUSE_NS;
        self.arrived_ns = at_ns;
        if self.is_ignoring && !paused {
            return;
        }
        self.is_ignoring = false;
        let fresh = Group {
            first_us: us,
            last_us: us,
            first_ns: at_ns,
            last_ns: at_ns,
        };
        match &mut self.group {
            Some(group) if !paused && us.wrapping_sub(group.first_us) < STREAM_US => {
                group.last_us = us;
                group.last_ns = at_ns;
            }
            Some(group) => {
                let ended = *group;
                self.finish(ended, us);
                self.group = Some(fresh);
            }
            None => self.group = Some(fresh),
        }
    }

    /// Judges a group that has ended. The next group begins with a sample of the time `next_us`.
    fn finish(&mut self, group: Group, next_us: u32) {
        let passed_us = next_us.wrapping_sub(group.first_us);
        if passed_us > WINDOW_US {
            return;
        }
        self.judged_us += passed_us;
        let length_us = group.last_us.wrapping_sub(group.first_us);
        // The samples of a bundle come much faster than they were taken.
        let came_us = group.last_ns.saturating_sub(group.first_ns) / 1000;
        let is_quick = 2 * came_us <= u64::from(length_us);
        if length_us >= BUNDLE_US && is_quick {
            self.bundled_us += passed_us;
            self.shortest_us = if self.count == 0 {
                length_us
            } else {
                self.shortest_us.min(length_us)
            };
            self.longest_us = self.longest_us.max(length_us);
            self.count += 1;
        }
        if self.judged_us >= WINDOW_US {
            self.close();
        }
    }

    fn close(&mut self) {
        let has_bundles = self.bundled_us * 100 >= self.judged_us * BUNDLED_PERCENT
            && self.longest_us - self.shortest_us <= SPREAD_US;
        self.windows = if has_bundles { self.windows + 1 } else { 0 };
        if has_bundles {
            // The length of a bundle runs from its first sample to the first sample of the next
            // bundle.
            self.length_us = self.bundled_us / self.count.max(1);
        }
        self.judged_us = 0;
        self.bundled_us = 0;
        self.longest_us = 0;
        self.shortest_us = 0;
        self.count = 0;
    }

    /// True while samples come in bundles.
    pub(super) const fn are_found(&self) -> bool {
        self.windows >= WINDOWS
    }

    /// Length of the bundles, ms, while they are found.
    pub(super) fn length_ms(&self) -> Option<u32> {
        self.are_found().then_some((self.length_us + 500) / 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two seconds of samples at 1 kHz. They arrive in the milliseconds for which `comes` is true.
    fn bundles_of(comes: impl Fn(u32) -> bool, paused_ns: u64) -> Bundles {
        let mut bundles = Bundles::default();
        let mut waiting = Vec::new();
        for ms in 0..2000u32 {
            waiting.push(ms * 1000);
            bundles.begin(paused_ns);
            if comes(ms) {
                let at_ns = u64::from(ms) * 1_000_000;
                // A slow line hands a bundle over in parts.
                let parts = waiting.drain(..).enumerate();
                parts.for_each(|(i, us)| bundles.take(us, at_ns + i as u64 * 50_000));
            }
        }
        bundles
    }

    #[test]
    fn a_latency_timer_is_found_with_its_length() {
        assert_eq!(
            bundles_of(|ms| ms % 16 == 0, 1_000_000).length_ms(),
            Some(16)
        );
        assert_eq!(bundles_of(|_| true, 1_000_000).length_ms(), None);
        assert_eq!(bundles_of(|ms| ms % 4 == 0, 1_000_000).length_ms(), None);
    }

    #[test]
    fn a_late_host_or_an_irregular_device_is_not_reported_as_bundles() {
        assert_eq!(bundles_of(|ms| ms % 16 == 0, 16_000_000).length_ms(), None);
        let irregular = |ms: u32| ms.is_multiple_of(41) || ms.is_multiple_of(29);
        assert_eq!(bundles_of(irregular, 1_000_000).length_ms(), None);
    }
}
