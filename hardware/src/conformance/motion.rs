//! Compares reported velocities with positions, and the device's clock with this computer's.

use std::collections::VecDeque;

use rt_core::math::Vec3;
use rt_core::time::TimeNs;

/// Number of samples over which the distance moved is compared with the reported velocities.
/// Encoders resolve the distance moved over so many samples.
const STRIDE: usize = 20;
/// Distance from the first position that the handle must reach before velocity can be judged, m:
/// far above noise.
const DISTANCE_MIN_M: f32 = 0.005;

/// Time between two samples above which the velocity of the second says little about the distance
/// between them, s.
const GAP_S: f32 = 0.01;
/// Length of a window in which only the least delayed sample counts, ns. Samples come late, never
/// early. So the least delayed samples follow the device's clock even while this computer is late.
const BUCKET_NS: u64 = 100_000_000;
/// Number of windows between two windows whose clocks are compared.
const BUCKETS: u64 = 5;

/// Sums that compare reported velocities with positions.
#[derive(Debug, Default)]
pub(crate) struct Motion {
    window: VecDeque<(Vec3, Vec3, f32)>,
    first_m: Option<Vec3>,
    farthest_m: f32,
    reported_dot_moved_m2: f32,
    moved_squared_m2: f32,
    reported_squared_m2: f32,
}

impl Motion {
    /// Takes a sample: position, reported velocity, and the time since the previous sample, s. A
    /// sample after a gap begins anew, because its velocity says little about the gap.
    pub(crate) fn take(&mut self, at_m: Vec3, reported_m_s: Vec3, passed_s: f32) {
        if passed_s > GAP_S {
            self.pause();
        }
        self.window.push_back((at_m, reported_m_s, passed_s));
        let first_m = *self.first_m.get_or_insert(at_m);
        self.farthest_m = self.farthest_m.max((at_m - first_m).norm());
        if self.window.len() <= STRIDE {
            return;
        }
        let Some((from_m, ..)) = self.window.pop_front() else {
            return;
        };
        let moved_m = at_m - from_m;
        let reported_m: Vec3 = self.window.iter().map(|(_, said, s)| said * *s).sum();
        self.reported_dot_moved_m2 += reported_m.dot(&moved_m);
        self.moved_squared_m2 += moved_m.norm_squared();
        self.reported_squared_m2 += reported_m.norm_squared();
    }

    /// Notes that the next sample does not continue the last one.
    pub(crate) fn pause(&mut self) {
        self.window.clear();
    }

    /// Distance that the reported velocities add up to, as a share of the distance that the
    /// positions show. `None` if the handle hardly moved.
    pub(crate) fn gain(&self) -> Option<f32> {
        (self.farthest_m >= DISTANCE_MIN_M)
            .then(|| self.reported_dot_moved_m2 / self.moved_squared_m2)
    }

    /// True if velocity and positions agree, with a sentence. `None` if the handle hardly moved.
    pub(crate) fn judged(&self) -> Option<(bool, String)> {
        let gain = self.gain()?;
        let correlation =
            self.reported_dot_moved_m2 / (self.reported_squared_m2 * self.moved_squared_m2).sqrt();
        let words = if self.reported_squared_m2 <= 0.0 {
            "it declares a velocity and leaves it zero. Send it, or clear bit 1 of the flags".into()
        } else if gain < 0.0 {
            format!("the velocity has the wrong sign: {gain:.2} of what the positions say")
        } else {
            format!(
                "the velocity is {gain:.2} of what the positions say, allowed is 0.7 to 1.4, at a \
                 correlation of {correlation:.2}, allowed from 0.8"
            )
        };
        Some(((0.7..=1.4).contains(&gain) && correlation >= 0.8, words))
    }
}

/// Comparison of the device's clock with this computer's.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    first: Option<(TimeNs, u32)>,
    last: Option<(TimeNs, u32)>,
    /// Number of each window, and the least time by which this computer's clock was ahead in it,
    /// µs.
    ahead: Vec<(u64, i64)>,
}

impl Clock {
    /// Takes a sample: its arrival time, and the time of the device's clock, µs.
    pub(crate) fn take(&mut self, at_ns: TimeNs, device_us: u32) {
        let (from_ns, from_us) = *self.first.get_or_insert((at_ns, device_us));
        self.last = Some((at_ns, device_us));
        let passed_ns = at_ns.saturating_sub(from_ns);
        let passed_us = i64::try_from(passed_ns / 1000).unwrap_or(i64::MAX);
        let ahead_us = passed_us - i64::from(device_us.wrapping_sub(from_us));
        let bucket = passed_ns / BUCKET_NS;
        match self.ahead.last_mut() {
            Some((last, least_us)) if *last == bucket => *least_us = ahead_us.min(*least_us),
            _ => self.ahead.push((bucket, ahead_us)),
        }
    }

    /// Rate as in [`Self::rate`], in the half second in which it is farthest from 1. `None` before
    /// half a second.
    pub(crate) fn worst_rate(&self) -> Option<f64> {
        let span_us = (BUCKETS * BUCKET_NS / 1000) as f64;
        let rates = self.ahead.iter().filter_map(|(from, from_us)| {
            let (_, to_us) = self.ahead.iter().find(|(to, _)| *to == from + BUCKETS)?;
            Some(1.0 - (to_us - from_us) as f64 / span_us)
        });
        rates.max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
    }

    /// Seconds of the device per second of this computer; `None` before two samples.
    pub(crate) fn rate(&self) -> Option<f64> {
        let (from_ns, from_us) = self.first?;
        let (to_ns, to_us) = self.last?;
        let passed_us = to_ns.saturating_sub(from_ns) as f64 * 1.0e-3;
        (passed_us > 0.0).then(|| f64::from(to_us.wrapping_sub(from_us)) / passed_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A handle that swings along x by 30 mm, and reports its velocity times `by`.
    fn swung(by: f32) -> Motion {
        let mut motion = Motion::default();
        for ms in 0..2000 {
            let turn = ms as f32 * 1.0e-3 * std::f32::consts::TAU;
            let at_m = Vec3::x() * (0.03 * turn.sin());
            let reported_m_s = Vec3::x() * (0.03 * std::f32::consts::TAU * turn.cos() * by);
            motion.take(at_m, reported_m_s, 1.0e-3);
        }
        motion
    }

    #[test]
    fn wrong_signs_units_and_empty_fields_are_distinguished() {
        assert!(swung(1.0).judged().unwrap().0);
        for (by, words) in [(-1.0, "wrong sign"), (0.001, "0.00 of what"), (0.0, "zero")] {
            let (good, said) = swung(by).judged().unwrap();
            assert!(!good && said.contains(words), "{said}");
        }
        assert!(Motion::default().judged().is_none());
    }

    #[test]
    fn a_gap_does_not_count_as_a_wrong_velocity() {
        let mut motion = Motion::default();
        for ms in 0..3000 {
            let turn = ms as f32 * 1.0e-3 * std::f32::consts::TAU;
            let at_m = Vec3::x() * (0.03 * turn.sin());
            let reported_m_s = Vec3::x() * (0.03 * std::f32::consts::TAU * turn.cos());
            // A computer that reads nothing for 60 of 200 ms, and then two samples at once.
            match ms % 200 {
                0..60 => {}
                60 => motion.take(at_m, reported_m_s, 0.061),
                61 => motion.take(at_m, reported_m_s, 0.0),
                _ => motion.take(at_m, reported_m_s, 1.0e-3),
            }
        }
        let (good, said) = motion.judged().unwrap();
        assert!(
            good && (motion.gain().unwrap() - 1.0).abs() < 0.05,
            "{said}"
        );
    }

    /// Worst rate over 3 s of a clock that is `ahead_us` ahead, with arrivals late by `late_us`.
    fn worst(ahead_us: impl Fn(f64) -> f64, late_us: impl Fn(u64) -> u64) -> f64 {
        let mut clock = Clock::default();
        for ms in 0..3000 {
            let device_us = ms as f64 * 1e3 + ahead_us(ms as f64 * 1e-3);
            clock.take((ms * 1000 + late_us(ms)) * 1000, device_us as u32);
        }
        clock.worst_rate().unwrap()
    }

    #[test]
    fn a_drifting_clock_is_found_and_a_late_computer_is_not_reported_as_one() {
        let tau = std::f64::consts::TAU;
        let wanders = |s: f64| 0.02 * 5.0 / tau * (1.0 - (tau * s / 5.0).cos()) * 1e6;
        assert!((worst(wanders, |_| 0) - 1.0).abs() > 0.015);
        let stalls = |ms: u64| {
            if ms % 250 < 70 {
                (70 - ms % 250) * 1000
            } else {
                0
            }
        };
        assert!((worst(|_| 0.0, stalls) - 1.0).abs() < 0.002);
        assert_eq!(Clock::default().worst_rate(), None);
    }

    #[test]
    fn clocks_are_compared_over_a_wrap() {
        let mut clock = Clock::default();
        assert_eq!(clock.rate(), None);
        clock.take(1_000_000, u32::MAX - 499);
        clock.take(2_000_000, 510);
        assert!((clock.rate().unwrap() - 1.01).abs() < 1e-9);
    }
}
