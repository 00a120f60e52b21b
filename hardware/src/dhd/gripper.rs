//! The opening of a gripper, and the virtual button that a closed gripper presses.

use super::model::GRIPPER_MAX_N;

/// Angle of a gripper that is wide open, degrees: omega.7 and sigma.7 in CHAI3D. The angle of a
/// lambda is assumed to be the same.
const OPEN_DEG: f64 = 30.0;
/// Opening below which a closing gripper presses the button.
const PRESSES: f32 = 0.25;
/// Opening at which an opening gripper releases the button. A hand that trembles between the two
/// limits changes nothing.
const RELEASES: f32 = 0.35;

/// A gripper, for the left or the right hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gripper {
    /// Sign of the library's angle and force for an opening gripper. Both are negative for a left
    /// hand's gripper (lambda.7 manual, page 18; CHAI3D).
    sign: f64,
    is_closed: bool,
}

impl Gripper {
    pub(super) const fn new(is_left_handed: bool) -> Self {
        Self {
            sign: if is_left_handed { -1.0 } else { 1.0 },
            is_closed: false,
        }
    }

    /// Opening for an angle of the library, degrees: 0 closed, 1 wide open. `None` when the angle
    /// is not finite.
    pub(super) fn take(&mut self, angle_deg: f64) -> Option<f32> {
        let share = (self.sign * angle_deg / OPEN_DEG) as f32;
        if !share.is_finite() {
            return None;
        }
        let opening = share.clamp(0.0, 1.0);
        self.is_closed = opening < if self.is_closed { RELEASES } else { PRESSES };
        Some(opening)
    }

    /// True while the gripper presses the button.
    pub(super) const fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Force to send to the library so that the gripper opens with `newtons`. A negative value
    /// closes the gripper.
    pub(super) fn force_n(&self, newtons: f32) -> f64 {
        let force_n = f64::from(newtons);
        if !force_n.is_finite() {
            return 0.0;
        }
        let most_n = f64::from(GRIPPER_MAX_N);
        self.sign * force_n.clamp(-most_n, most_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_gripper_stays_pressed_until_it_is_clearly_open() {
        let mut gripper = Gripper::new(false);
        let mut pressed_at = |deg: f64| {
            gripper.take(deg);
            gripper.is_closed()
        };
        let pressed = [30.0, 9.0, 7.0, 9.0, 10.0, 11.0, 9.0].map(&mut pressed_at);
        assert_eq!(pressed, [false, false, true, true, true, false, false]);
        assert_eq!(gripper.take(15.0), Some(0.5));
        assert_eq!(gripper.take(-3.0), Some(0.0));
        assert_eq!(gripper.take(f64::NAN), None);
    }

    #[test]
    fn a_left_hand_s_gripper_opens_the_other_way() {
        let mut gripper = Gripper::new(true);
        assert_eq!(gripper.take(-30.0), Some(1.0));
        assert!((gripper.force_n(2.0) + 2.0).abs() < 1e-9);
        assert!((gripper.force_n(-100.0) - 8.0).abs() < 1e-9);
        assert!(gripper.force_n(f32::NAN).abs() < 1e-9);
    }
}
