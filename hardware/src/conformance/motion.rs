//! Compares reported velocities with positions, and the device's clock with this computer's.

use std::collections::VecDeque;

use rt_core::math::Vec3;
use rt_core::time::TimeNs;

/// Number of samples over which the distance moved is compared with the reported velocities.
/// Encoders resolve the distance moved over so many samples.
const STRIDE: usize = 20;
/// Distance from the first position that the handle must reach before velocity can be judged, m:
/// far above noise.
const WAY_MIN_M: f32 = 0.005;

/// Sums that compare reported velocities with positions.
#[derive(Debug, Default)]
pub(crate) struct Motion {
    window: VecDeque<(Vec3, Vec3, f32)>,
    first_m: Option<Vec3>,
    farthest_m: f32,
    said_by_moved: f32,
    moved_by_moved: f32,
    said_by_said: f32,
}

impl Motion {
    /// Takes a sample: position, reported velocity, and the time since the previous sample, s.
    pub(crate) fn take(&mut self, at_m: Vec3, said_m_s: Vec3, passed_s: f32) {
        self.window.push_back((at_m, said_m_s, passed_s));
        let first_m = *self.first_m.get_or_insert(at_m);
        self.farthest_m = self.farthest_m.max((at_m - first_m).norm());
        if self.window.len() <= STRIDE {
            return;
        }
        let Some((from_m, ..)) = self.window.pop_front() else {
            return;
        };
        let moved_m = at_m - from_m;
        let said_m: Vec3 = self.window.iter().map(|(_, said, s)| said * *s).sum();
        self.said_by_moved += said_m.dot(&moved_m);
        self.moved_by_moved += moved_m.norm_squared();
        self.said_by_said += said_m.norm_squared();
    }

    /// Notes that the next sample does not continue the last one.
    pub(crate) fn pause(&mut self) {
        self.window.clear();
    }

    /// Distance that the reported velocities add up to, as a share of the distance that the
    /// positions show. `None` if the handle hardly moved.
    pub(crate) fn gain(&self) -> Option<f32> {
        (self.farthest_m >= WAY_MIN_M).then(|| self.said_by_moved / self.moved_by_moved)
    }

    /// Judgement: whether velocity and positions agree, with words. `None` if the handle hardly
    /// moved.
    pub(crate) fn judged(&self) -> Option<(bool, String)> {
        let gain = self.gain()?;
        let alike = self.said_by_moved / (self.said_by_said * self.moved_by_moved).sqrt();
        let words = if self.said_by_said <= 0.0 {
            "it declares a velocity and leaves it zero. Send it, or clear bit 1 of the flags".into()
        } else if gain < 0.0 {
            format!("the velocity has the wrong sign: {gain:.2} of what the positions say")
        } else {
            format!(
                "the velocity is {gain:.2} of what the positions say, allowed is 0.7 to 1.4, at a \
                 correlation of {alike:.2}, allowed from 0.8"
            )
        };
        Some(((0.7..=1.4).contains(&gain) && alike >= 0.8, words))
    }
}

/// Comparison of the device's clock with this computer's.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    first: Option<(TimeNs, u32)>,
    last: Option<(TimeNs, u32)>,
}

impl Clock {
    /// Takes a sample: its arrival time, and the time of the device's clock, µs.
    pub(crate) fn take(&mut self, at_ns: TimeNs, device_us: u32) {
        self.first.get_or_insert((at_ns, device_us));
        self.last = Some((at_ns, device_us));
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

    /// A handle that swings along x by 30 mm, and says its velocity times `by`.
    fn swung(by: f32) -> Motion {
        let mut motion = Motion::default();
        for ms in 0..2000 {
            let turn = ms as f32 * 1.0e-3 * std::f32::consts::TAU;
            let at_m = Vec3::x() * (0.03 * turn.sin());
            let said_m_s = Vec3::x() * (0.03 * std::f32::consts::TAU * turn.cos() * by);
            motion.take(at_m, said_m_s, 1.0e-3);
        }
        motion
    }

    #[test]
    fn wrong_signs_units_and_empty_fields_are_told_apart() {
        assert!(swung(1.0).judged().unwrap().0);
        for (by, words) in [(-1.0, "wrong sign"), (0.001, "0.00 of what"), (0.0, "zero")] {
            let (good, said) = swung(by).judged().unwrap();
            assert!(!good && said.contains(words), "{said}");
        }
        assert!(Motion::default().judged().is_none());
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
