//! What the hand feels does not end from one tick to the next because something was decided: a pause, another
//! instrument, jaws that let go, a new beginning. What is felt less for that reason fades.

use crate::time::TICK_S;
use crate::tool::Wrench;

/// Time in which it does, s.
const FADE_S: f32 = 0.02;

/// What is felt of what is no more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fade {
    /// What was felt in the last tick.
    last: Wrench,
    /// The rest of what is no more, and how much of it is still to be felt.
    rest: Wrench,
    left: f32,
    /// Something was decided since.
    has_leapt: bool,
}

impl Fade {
    /// Nothing.
    pub(crate) const NOTHING: Self = Self {
        last: Wrench::ZERO,
        rest: Wrench::ZERO,
        left: 0.0,
        has_leapt: false,
    };

    /// What is felt from now on has nothing to do with what was.
    pub(crate) fn leap(&mut self) {
        self.has_leapt = true;
    }

    /// What the hand feels in this tick where the tissue does `wrench`, at the handle.
    pub(crate) fn felt(&mut self, wrench: &Wrench) -> Wrench {
        if self.has_leapt {
            let rest = self.last.plus(wrench, -1.0);
            self.rest = if rest.is_finite() { rest } else { Wrench::ZERO };
            self.left = 1.0;
            self.has_leapt = false;
        }
        self.left = (self.left - TICK_S / FADE_S).max(0.0);
        self.last = wrench.plus(&self.rest, self.left);
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{self, Vec3};

    fn pulls(x_n: f32) -> Wrench {
        Wrench {
            force_n: Vec3::x() * x_n,
            torque_n_m: Vec3::y() * (0.1 * x_n),
        }
    }

    #[test]
    fn what_ends_by_decision_fades_and_what_tissue_does_is_felt_at_once() {
        let mut fade = Fade::NOTHING;
        assert_eq!(fade.felt(&pulls(1.0)), pulls(1.0));
        assert_eq!(fade.felt(&pulls(0.2)), pulls(0.2));
        let mut last = fade.felt(&pulls(2.0));
        fade.leap();
        // Twice, the second on top of what is left of the first.
        for tick in 0..60 {
            if tick == 10 {
                fade.leap();
            }
            let now = fade.felt(&pulls(if tick < 10 { 0.0 } else { 0.5 }));
            assert!(math::norm(&(now.force_n - last.force_n)) < 0.101, "{tick}");
            last = now;
        }
        assert!(math::norm(&(last.force_n - pulls(0.5).force_n)) < 1.0e-6);
        assert!(math::norm(&(last.torque_n_m - pulls(0.5).torque_n_m)) < 1.0e-6);
    }

    #[test]
    fn what_is_no_number_does_not_stay() {
        let mut fade = Fade::NOTHING;
        let _ = fade.felt(&pulls(f32::NAN));
        fade.leap();
        assert_eq!(fade.felt(&pulls(1.0)), pulls(1.0));
    }
}
