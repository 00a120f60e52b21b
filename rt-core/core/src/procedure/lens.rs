//! Motion of the endoscope's lens, from the poses of its tracker.
//!
//! A tracker at rest has noise, and it gives a pose only every few ticks. So a point follows the
//! lens on a leash. The lens moves while the point does.

use crate::math::{self, Vec3};
use crate::time::TICK_S;

/// Length of the leash, m: three standard deviations of a noise of 0.3 mm. The metrics of the
/// assessment bear that noise, too.
const LEASH_M: f32 = 0.001;
/// Shortest step of the point, m. After a step the lens is at the end of the leash, and rounding,
/// 0.1 µm at 1 m, must not count as the next step.
const STEP_MIN_M: f32 = 1.0e-6;
/// Longest time between two steps of the point over which a speed is measured, ticks. After a
/// longer rest, the first step counts as made within this time: a tracker with 10 Hz needs it.
const STEP_TICKS_MAX: u16 = 100;

/// The point on the leash.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lens {
    /// Place of the point, m; `None` while the lens is outside the body.
    held_m: Option<Vec3>,
    /// Ticks since the last step.
    ticks: u16,
}

impl Lens {
    pub(crate) const AWAY: Self = Self {
        held_m: None,
        ticks: 0,
    };

    /// Takes the place of the lens in this tick, m; `None` while it is outside the body. Returns
    /// the speed of the point in a tick with a step, m/s, and 0 in any other tick.
    pub(crate) fn follow(&mut self, lens_m: Option<Vec3>) -> f32 {
        self.ticks = self.ticks.saturating_add(1).min(STEP_TICKS_MAX);
        let (Some(lens_m), Some(held_m)) = (lens_m, self.held_m) else {
            self.held_m = lens_m;
            return 0.0;
        };
        let off_m = lens_m - held_m;
        let aoff_m = math::norm(&off_m);
        let step_m = aoff_m - LEASH_M;
        // A pose that is no number leaves the point where it is.
        if !(step_m > STEP_MIN_M && step_m.is_finite()) {
            return 0.0;
        }
        self.held_m = Some(held_m + off_m * (step_m / aoff_m));
        let seconds = f32::from(core::mem::take(&mut self.ticks)) * TICK_S;
        step_m / seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest speed of the point in the second half of 4 s. The tracker gives a pose every `every`
    /// ticks.
    fn speed_m_s(every: u16, lens_m: impl Fn(f32) -> f32) -> f32 {
        let (mut lens, mut at, mut most) = (Lens::AWAY, Vec3::zeros(), 0.0_f32);
        for tick in 0..4000_u16 {
            if tick.is_multiple_of(every) {
                at = Vec3::new(0.0, lens_m(f32::from(tick) * TICK_S), 0.1);
            }
            let now_m_s = lens.follow(Some(at));
            most = if tick < 2000 { most } else { most.max(now_m_s) };
        }
        most
    }

    #[test]
    fn a_swaying_lens_moves_as_fast_as_it_does_at_any_rate_of_the_tracker() {
        // 10 mm to both sides, once a second: 63 mm/s at most.
        let sways = |at_s: f32| 0.01 * (core::f32::consts::TAU * at_s).sin();
        for every in [1, 4, 10, 25] {
            let most = speed_m_s(every, sways);
            assert!((0.055..0.067).contains(&most), "{most} at {every}");
        }
    }

    #[test]
    fn noise_of_a_lens_at_rest_and_a_tremor_of_the_hand_are_no_motion() {
        let noise = |at_s: f32| 0.0005 * (1234.5 * at_s).sin();
        let tremor = |at_s: f32| 0.0002 * (core::f32::consts::TAU * 9.0 * at_s).sin();
        for every in [1, 4, 10] {
            let most = speed_m_s(every, noise).max(speed_m_s(every, tremor));
            assert!(most < f32::MIN_POSITIVE, "{most} at {every}");
        }
    }

    #[test]
    fn a_lens_that_comes_into_the_body_begins_at_rest() {
        let mut lens = Lens::AWAY;
        for place_m in [None, Some(0.1), Some(f32::NAN)] {
            let speed_m_s = lens.follow(place_m.map(|x_m| Vec3::new(x_m, 0.0, 0.0)));
            assert!(speed_m_s < f32::MIN_POSITIVE, "{speed_m_s} at {place_m:?}");
        }
        assert!(lens.follow(Some(Vec3::new(0.1, 0.02, 0.0))) > 0.1);
    }
}
