//! Finds samples that come in bundles, as a USB adapter's latency timer sends them.

/// Device time that the shortest bundle spans, µs: more than the age that a sample may have.
const BUNDLE_US: u32 = 6_000;
/// Longest pause of the host before a poll that counts, ns. A longer pause makes bundles itself.
const ON_TIME_NS: u64 = 4_000_000;
/// Device time of the samples that are judged together, µs.
const WINDOW_US: u32 = 300_000;
/// Share of a window's samples, in percent, that must have come in bundles.
const SHARE: u32 = 80;
/// Largest spread of the bundles' lengths in a window, µs. A timer is regular; a busy computer is
/// not.
const SPREAD_US: u32 = 3_000;
/// Windows in a row that must show bundles.
const WINDOWS: u32 = 2;

/// The samples of a poll, and the sums over the polls before it.
#[derive(Debug, Default)]
pub(super) struct Bundles {
    on_time: bool,
    /// Device time of the poll's first and last sample.
    poll: Option<(u32, u32)>,
    /// Newest sample of earlier polls.
    before_us: Option<u32>,
    judged_us: u32,
    bundled_us: u32,
    shortest_us: u32,
    longest_us: u32,
    count: u32,
    windows: u32,
    length_us: u32,
}

impl Bundles {
    /// Begins a poll, this long after the one before.
    pub(super) const fn begin(&mut self, paused_ns: u64) {
        self.on_time = paused_ns <= ON_TIME_NS;
        self.poll = None;
    }

    /// Takes the device's time of a sample.
    pub(super) fn take(&mut self, us: u32) {
        let (first_us, _) = self.poll.unwrap_or((us, us));
        self.poll = Some((first_us, us));
    }

    /// Ends the poll.
    pub(super) fn end(&mut self) {
        let Some((first_us, last_us)) = self.poll else {
            return;
        };
        let passed_us = self.before_us.replace(last_us);
        let passed_us = passed_us.map_or(0, |before_us| last_us.wrapping_sub(before_us));
        if !self.on_time || passed_us > WINDOW_US {
            return;
        }
        self.judged_us += passed_us;
        let length_us = last_us.wrapping_sub(first_us);
        if length_us >= BUNDLE_US {
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
        let shows = self.bundled_us * 100 >= self.judged_us * SHARE
            && self.longest_us - self.shortest_us <= SPREAD_US;
        self.windows = if shows { self.windows + 1 } else { 0 };
        if shows {
            // The length runs from a bundle's first sample to the next one's.
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

    /// Two seconds of samples at 1 kHz that come when `comes` says so.
    fn heard(comes: impl Fn(u32) -> bool, paused_ns: u64) -> Bundles {
        let mut bundles = Bundles::default();
        let mut waiting = Vec::new();
        for ms in 0..2000u32 {
            waiting.push(ms * 1000);
            bundles.begin(paused_ns);
            if comes(ms) {
                waiting.drain(..).for_each(|us| bundles.take(us));
            }
            bundles.end();
        }
        bundles
    }

    #[test]
    fn a_latency_timer_is_found_with_its_length() {
        assert_eq!(heard(|ms| ms % 16 == 0, 1_000_000).length_ms(), Some(16));
        assert_eq!(heard(|_| true, 1_000_000).length_ms(), None);
        assert_eq!(heard(|ms| ms % 4 == 0, 1_000_000).length_ms(), None);
    }

    #[test]
    fn a_late_host_and_an_irregular_device_are_no_bundles() {
        assert_eq!(heard(|ms| ms % 16 == 0, 16_000_000).length_ms(), None);
        let irregular = |ms: u32| ms.is_multiple_of(41) || ms.is_multiple_of(29);
        assert_eq!(heard(irregular, 1_000_000).length_ms(), None);
    }
}
