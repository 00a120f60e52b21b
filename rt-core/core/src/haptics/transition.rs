//! Transitions. Some actions of a person end a force in one tick: a pause, a change of the
//! instrument, jaws that open, a reset. At the handle this force fades instead. Only the part of
//! the force that is lost fades; a new force is felt at once.

use crate::time::TICK_S;
use crate::tool::Wrench;

/// Duration of a transition, s. A longer one makes the end of a force softer and later.
const TRANSITION_S: f32 = 0.02;

/// State of a transition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Transition {
    /// Wrench that was felt in the last tick.
    last: Wrench,
    /// Wrench that was lost at the start of the transition.
    lost: Wrench,
    /// Share of `lost` that is still felt.
    lost_share: f32,
    /// True if a transition begins with the next wrench.
    is_discontinuous: bool,
}

impl Transition {
    /// No transition.
    pub(crate) const NONE: Self = Self {
        last: Wrench::ZERO,
        lost: Wrench::ZERO,
        lost_share: 0.0,
        is_discontinuous: false,
    };

    /// Begins a transition: the next wrench is unrelated to the last.
    pub(crate) fn discontinuity(&mut self) {
        self.is_discontinuous = true;
    }

    /// Wrench that the hand feels in this tick, for the tissue's `wrench` at the handle.
    pub(crate) fn felt(&mut self, wrench: &Wrench) -> Wrench {
        if self.is_discontinuous {
            let lost = self.last.plus(wrench, -1.0);
            self.lost = if lost.is_finite() { lost } else { Wrench::ZERO };
            self.lost_share = 1.0;
            self.is_discontinuous = false;
        }
        self.lost_share = (self.lost_share - TICK_S / TRANSITION_S).max(0.0);
        self.last = wrench.plus(&self.lost, self.lost_share);
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
            torque_nm: Vec3::y() * (0.1 * x_n),
        }
    }

    #[test]
    fn force_that_an_action_ends_fades_and_new_force_is_felt_at_once() {
        let mut transition = Transition::NONE;
        assert_eq!(transition.felt(&pulls(1.0)), pulls(1.0));
        assert_eq!(transition.felt(&pulls(0.2)), pulls(0.2));
        let mut last = transition.felt(&pulls(2.0));
        transition.discontinuity();
        // Two transitions; the second begins before the first has ended.
        for tick in 0..60 {
            if tick == 10 {
                transition.discontinuity();
            }
            let now = transition.felt(&pulls(if tick < 10 { 0.0 } else { 0.5 }));
            assert!(math::norm(&(now.force_n - last.force_n)) < 0.101, "{tick}");
            last = now;
        }
        assert!(math::norm(&(last.force_n - pulls(0.5).force_n)) < 1.0e-6);
        assert!(math::norm(&(last.torque_nm - pulls(0.5).torque_nm)) < 1.0e-6);
    }

    #[test]
    fn nan_does_not_persist() {
        let mut transition = Transition::NONE;
        let _ = transition.felt(&pulls(f32::NAN));
        transition.discontinuity();
        assert_eq!(transition.felt(&pulls(1.0)), pulls(1.0));
    }
}
