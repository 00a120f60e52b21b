//! Finds light in sound: a photodiode at a sound card's input.
//!
//! Most cards pass no direct current. So light makes a pulse that decays, and its end makes a pulse
//! of the opposite sign. Each pulse begins with a step: the mean of half a millisecond differs from
//! the mean of the half millisecond before. A step counts if it is at least a third as high as the
//! highest step of the last seconds.

use rt_core::time::TimeNs;

use super::edge::Edge;

/// Length of each of the two means, s.
const MEAN_S: f64 = 0.5e-3;
/// Smallest step that counts; full scale is 32768. Smaller steps are the noise of an open input.
const STEP_MIN: f64 = 300.0;
/// Smallest step that counts, as a share of the highest step.
const STEP_SHARE: f64 = 1.0 / 3.0;
/// Half-life of the highest step, s.
const HALF_LIFE_S: f64 = 5.0;
/// Time after a step in which further steps are ignored, s.
const DEAD_TIME_S: f64 = 0.01;

/// A stream of samples.
#[derive(Debug)]
pub struct Sound {
    rate_hz: f64,
    /// The newest samples, as many as both means need.
    latest: std::collections::VecDeque<f64>,
    half: usize,
    /// Number of samples so far.
    count: u64,
    /// Highest step of the last seconds.
    highest: f64,
    /// The present step: its height so far, and the number of the sample at its middle.
    step: Option<(f64, u64)>,
    ignored_until: u64,
    /// Time of sample 0, ns, computed from the block that came with the least delay.
    began_ns: Option<i128>,
}

impl Sound {
    /// A stream of this rate.
    #[must_use]
    pub fn new(rate_hz: u32) -> Self {
        let rate_hz = f64::from(rate_hz.max(1));
        let half = ((rate_hz * MEAN_S) as usize).max(2);
        Self {
            rate_hz,
            latest: std::collections::VecDeque::with_capacity(2 * half + 1),
            half,
            count: 0,
            highest: 0.0,
            step: None,
            ignored_until: 0,
            began_ns: None,
        }
    }

    /// Takes samples, the last of which arrived at `at_ns`. Returns the edges that are complete
    /// now.
    pub fn take(&mut self, samples: impl Iterator<Item = i16>, at_ns: TimeNs) -> Vec<Edge> {
        let mut found = Vec::new();
        for sample in samples {
            found.extend(self.sample(f64::from(sample)));
        }
        // A block may come late, never early, so the earliest block gives the time. The clocks of
        // sound cards deviate by up to 100 ppm, so an old block counts less and less.
        let long_ns = (self.count as f64 / self.rate_hz * 1e9) as i128;
        let began_ns = i128::from(at_ns) - long_ns;
        let known_ns = self.began_ns.map_or(began_ns, |known| {
            let forgotten = known + (known - began_ns).abs() / 4096;
            began_ns.min(forgotten)
        });
        self.began_ns = Some(known_ns);
        let edge = |(bright, number): (bool, u64)| Edge {
            at_ns: TimeNs::try_from(known_ns + (number as f64 / self.rate_hz * 1e9) as i128)
                .unwrap_or(0),
            bright,
            within_ns: (0.5e9 / self.rate_hz) as u64,
        };
        found.into_iter().map(edge).collect()
    }

    /// Takes a sample. Returns a step that has ended: its sign, and the sample at its middle.
    fn sample(&mut self, value: f64) -> Option<(bool, u64)> {
        self.latest.push_back(value);
        self.count += 1;
        if self.latest.len() > 2 * self.half {
            self.latest.pop_front();
        }
        if self.latest.len() < 2 * self.half {
            return None;
        }
        let sum = |from: usize| self.latest.iter().skip(from).take(self.half).sum::<f64>();
        let height = (sum(self.half) - sum(0)) / self.half as f64;
        self.highest *= 0.5f64.powf(1.0 / (HALF_LIFE_S * self.rate_hz));
        self.highest = self.highest.max(height.abs());
        let counts = height.abs() >= STEP_MIN.max(STEP_SHARE * self.highest);
        let middle = self.count - self.half as u64;
        match self.step {
            _ if self.count < self.ignored_until => None,
            Some((top, _)) if counts && height.abs() > top.abs() => {
                self.step = Some((height, middle));
                None
            }
            None if counts => {
                self.step = Some((height, middle));
                None
            }
            // Both means now lie behind the step, so its height no longer grows.
            Some((top, at)) if middle > at + self.half as u64 => {
                self.step = None;
                self.ignored_until = self.count + (DEAD_TIME_S * self.rate_hz) as u64;
                Some((top > 0.0, at))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: u32 = 48_000;

    /// Edges of a signal of `seconds`, in blocks of 256 samples that come late by up to 3 ms.
    fn edges(seconds: f64, signal: impl Fn(f64) -> f64) -> Vec<(i64, bool)> {
        let mut sound = Sound::new(RATE);
        let began_ns = 7_000_000_000u64;
        let mut found = Vec::new();
        let count = (seconds * f64::from(RATE)) as u64;
        let all: Vec<u64> = (0..count).collect();
        for (block, numbers) in all.chunks(256).enumerate() {
            let values = numbers.iter().map(|&n| {
                let noise = f64::from((n.wrapping_mul(2_654_435_761) >> 7) as u8) - 127.0;
                (signal(n as f64 / f64::from(RATE)) + noise) as i16
            });
            let there = numbers.last().map_or(0, |n| n + 1) * 1_000_000_000 / u64::from(RATE);
            let late_ns = (block as u64 * 7919) % 3000 * 1000;
            for edge in sound.take(values, began_ns + there + late_ns) {
                let at_us = (edge.at_ns as i64 - began_ns as i64) / 1000;
                found.push((at_us, edge.bright));
            }
        }
        found
    }

    /// Asserts edges near these times, ms.
    fn assert_at(found: &[(i64, bool)], expected: &[(i64, bool)]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (it, (at_ms, bright)) in found.iter().zip(expected) {
            // The first block may be late by 3 ms. Later blocks give better times.
            assert!((it.0 - 1000 * at_ms).abs() < 3200, "{found:?}");
            assert_eq!(it.1, *bright, "{found:?}");
        }
    }

    #[test]
    fn light_is_found_through_a_sound_card_that_blocks_direct_current() {
        // Pulses that decay in 8 ms, at 300 ms up, at 700 ms down, at 1100 ms up.
        let pulse = |t: f64, from: f64| {
            if t < from {
                0.0
            } else {
                9000.0 * (-(t - from) / 0.008).exp()
            }
        };
        let found = edges(1.5, |t| pulse(t, 0.3) - pulse(t, 0.7) + pulse(t, 1.1));
        assert_at(&found, &[(300, true), (700, false), (1100, true)]);
    }

    #[test]
    fn plain_levels_are_found_and_noise_is_not() {
        let level = |t: f64| {
            if (t / 0.4) as i32 % 2 == 1 {
                12_000.0
            } else {
                0.0
            }
        };
        let found = edges(1.5, level);
        assert_at(&found, &[(400, true), (800, false), (1200, true)]);
        // Later edges are as exact as the samples, because late blocks no longer count.
        let off_us = found.last().map(|it| (it.0 - 1_200_000).abs());
        assert!(off_us.is_some_and(|us| us < 300), "{found:?}");
        assert_eq!(edges(1.0, |_| 0.0), []);
    }

    #[test]
    fn slow_changes_of_the_room_light_are_ignored() {
        let found = edges(2.0, |t| 10_000.0 * (core::f64::consts::TAU * t).sin());
        assert_eq!(found, []);
    }
}
