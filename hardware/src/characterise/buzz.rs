//! Detects a handle that buzzes, which means that its movement reverses again and again, faster
//! than a hand trembles.

use std::collections::VecDeque;

/// Smallest swing that counts, m: five encoder steps of a Touch. In `evaluate haptics` a contact
/// counts as still up to the same swing.
pub const SWING_M: f64 = 0.275e-3;
/// Number of consecutive swings that make a buzz, if they all happen within `WITHIN_S`.
const SWINGS: usize = 6;
/// Longest time from the end of the first of these swings, s. The other five swings in this time
/// have 10 Hz. A tremor has 8 to 12 Hz, but its swings are smaller than `SWING_M`. Deliberate
/// movements stay below 5 Hz.
const WITHIN_S: f64 = 0.25;

/// Ratio of the last two swings to the first two below which the movement counts as decaying. It is
/// then the ringing of an impact, and the wall may be still afterwards.
const DECAY_RATIO: f64 = 0.97;
/// Time after which quick swings count as a buzz even if they die away, s.
const LASTS_S: f64 = 0.5;

/// The turning points of a movement along one line.
#[derive(Debug, Clone, Default)]
pub(super) struct Buzz {
    /// Farthest position since the last turning point, m.
    extreme_m: Option<f64>,
    /// Sign of the movement towards that position; 0 before the first movement.
    direction: f64,
    /// Times, s, and sizes, m, of the last swings.
    swings: VecDeque<(f64, f64)>,
    turning_point_m: f64,
    /// Time since which the swings are quick, s.
    quick_since_s: Option<f64>,
}

impl Buzz {
    /// Takes a position. Returns true if the handle buzzes.
    pub(super) fn add(&mut self, at_s: f64, at_m: f64) -> bool {
        let Some(extreme_m) = self.extreme_m else {
            (self.extreme_m, self.turning_point_m) = (Some(at_m), at_m);
            return false;
        };
        if self.direction == 0.0 {
            if (at_m - extreme_m).abs() >= SWING_M {
                self.direction = (at_m - extreme_m).signum();
                self.extreme_m = Some(at_m);
            }
            return false;
        }
        if (at_m - extreme_m) * self.direction >= 0.0 {
            self.extreme_m = Some(at_m);
        } else if (extreme_m - at_m).abs() >= SWING_M {
            self.swings
                .push_back((at_s, (extreme_m - self.turning_point_m).abs()));
            if self.swings.len() > SWINGS {
                self.swings.pop_front();
            }
            (self.turning_point_m, self.direction) = (extreme_m, -self.direction);
            self.extreme_m = Some(at_m);
        }
        self.is_buzz(at_s)
    }

    fn is_buzz(&mut self, at_s: f64) -> bool {
        let size = |at: usize| self.swings.get(at).map_or(0.0, |it| it.1);
        let first = self.swings.front();
        let is_quick = self.swings.len() == SWINGS
            && first.is_some_and(|(then_s, _)| at_s - then_s <= WITHIN_S);
        if !is_quick {
            self.quick_since_s = None;
            return false;
        }
        let since_s = *self.quick_since_s.get_or_insert(at_s);
        let grows = size(SWINGS - 1) + size(SWINGS - 2) >= DECAY_RATIO * (size(0) + size(1));
        grows || at_s - since_s >= LASTS_S
    }

    /// True while swings follow each other quickly, even if they die away.
    pub(super) const fn is_quick(&self) -> bool {
        self.quick_since_s.is_some()
    }

    /// Frequency of the last swings, Hz, and the largest of them, m.
    pub(super) fn frequency_and_swing(&self) -> Option<(f64, f64)> {
        let (first, last) = (self.swings.front()?, self.swings.back()?);
        let halves = self.swings.len() as f64 - 1.0;
        let largest_m = self.swings.iter().map(|it| it.1).fold(0.0, f64::max);
        (last.0 > first.0).then(|| (0.5 * halves / (last.0 - first.0), largest_m))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Time at which a swinging handle is found to buzz, s.
    fn found_s(hz: f64, amplitude_m: f64) -> Option<f64> {
        let mut buzz = Buzz::default();
        let times = (0..2000).map(|ms| f64::from(ms) * 1e-3);
        let mut times = times.map(|at_s| (at_s, amplitude_m * (TAU * hz * at_s).sin()));
        times.find(|it| buzz.add(it.0, it.1)).map(|it| it.0)
    }

    #[test]
    fn a_buzz_is_found_within_a_few_periods_and_a_tremor_is_no_buzz() {
        for hz in [15.0, 40.0, 120.0, 300.0] {
            let at_s = found_s(hz, 0.5e-3).unwrap();
            assert!(at_s <= 4.0 / hz + 0.01, "{hz} Hz: {at_s} s");
        }
        assert_eq!(found_s(8.0, 0.5e-3), None, "a slow hand");
        assert_eq!(found_s(11.0, 0.1e-3), None, "a tremor");
        assert_eq!(found_s(100.0, 0.1e-3), None, "an encoder's flicker");
    }

    #[test]
    fn a_decaying_oscillation_after_an_impact_is_no_buzz() {
        let mut buzz = Buzz::default();
        let found = (0..500).any(|ms| {
            let at_s = f64::from(ms) * 1e-3;
            let at_m = 3e-3 * (-20.0 * at_s).exp() * (TAU * 40.0 * at_s).sin();
            buzz.add(at_s, at_m)
        });
        assert!(!found);
    }

    #[test]
    fn a_buzz_is_reported_with_its_frequency_and_amplitude() {
        let mut buzz = Buzz::default();
        for ms in 0..500 {
            let at_s = f64::from(ms) * 1e-3;
            buzz.add(at_s, 1e-3 * (TAU * 50.0 * at_s).sin());
        }
        let (hz, swing_m) = buzz.frequency_and_swing().unwrap();
        assert!((hz - 50.0).abs() < 5.0, "{hz}");
        assert!((swing_m - 2e-3).abs() < 1e-4, "{swing_m}");
    }
}
