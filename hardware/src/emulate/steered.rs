//! The emulated haptic device in a steered hand, without lines or clocks. Equal steering commands
//! and forces give equal movements.

use nalgebra::UnitQuaternion;
use rt_core::math::{Pose, Vec3};
use rt_core::port::Buttons;

use super::hand::{Hand, HandScript};
use super::operated::{SteeringState, Wish};
use super::touch::{Body, Grip, Touch};
use crate::HardwareError;
use crate::rig::wire::Switches;

/// A hand at an emulated Touch.
#[derive(Debug, Clone)]
pub struct LedHand {
    hand: Hand,
    operated: SteeringState,
    touch: Touch,
    /// Last target pose of the handle, device frame.
    wanted: Pose,
}

/// Measurements of the devices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Pose of the handle, device frame.
    pub device_from_handle: Pose,
    /// Velocity of the handle, device frame, m/s.
    pub velocity_m_s: Vec3,
    /// Buttons at the handle.
    pub buttons: Buttons,
    /// Pressed pedal switches.
    pub switches: Switches,
    /// Pose of the endoscope's sensor in the tracker's frame.
    pub tracker_from_sensor: Pose,
}

impl LedHand {
    /// A hand at rest at the start of the script. Later steering commands count relative to `wish`.
    ///
    /// # Errors
    /// When the devices do not reach the script's workplace.
    pub fn new(script: HandScript, wish: &Wish) -> Result<Self, HardwareError> {
        let hand = Hand::new(script, 0)?;
        let operated = SteeringState::begin(hand.intent(0.0).tip_m, wish);
        let wanted = operated.handle(&hand);
        Ok(Self {
            touch: Touch::new(Body::TOUCH, Grip::STYLUS, wanted.translation.vector),
            hand,
            operated,
            wanted,
        })
    }

    /// Simulates one millisecond in which the motors render `force_n` (device frame).
    pub fn step(&mut self, wish: &Wish, force_n: Vec3) -> Measured {
        self.operated.follow(Some(wish), &self.hand);
        let before_m = self.wanted.translation.vector;
        self.wanted = self.operated.handle(&self.hand);
        let target_m = self.wanted.translation.vector;
        self.touch
            .step(target_m, (target_m - before_m) / 1e-3, force_n);
        let position_m = self.touch.measured_m();
        let roll: UnitQuaternion<f32> = self.operated.roll();
        let rotation = self.hand.handle_at(position_m).rotation * roll;
        Measured {
            device_from_handle: Pose::from_parts(position_m.into(), rotation),
            velocity_m_s: self.touch.measured_velocity_m_s(),
            buttons: self.operated.buttons(),
            switches: self.operated.switches(),
            tracker_from_sensor: self.hand.sensor(self.operated.scope()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::hand::tests::workplace;

    #[test]
    fn a_guided_hand_follows_its_target_yields_to_force_and_is_deterministic() {
        let wish = Wish {
            moved_m: [0.004, 0.0, 0.0],
            ..Wish::default()
        };
        let work = |force_n: Vec3| {
            let mut led = LedHand::new(workplace(), &Wish::default()).unwrap();
            let mut measured = led.step(&wish, force_n);
            for _ in 0..1000 {
                measured = led.step(&wish, force_n);
            }
            measured
        };
        let hand = Hand::new(workplace(), 0).unwrap();
        let tip_m = |it: &Measured| hand.tip_of(it.device_from_handle.translation.vector);
        let free = work(Vec3::zeros());
        let way_m = tip_m(&free) - hand.intent(0.0).tip_m;
        assert!((way_m.norm() - 0.004).abs() < 0.001, "{way_m}");
        let pushed = work(Vec3::new(0.0, 1.0, 0.0));
        assert!((tip_m(&pushed) - tip_m(&free)).norm() > 0.001);
        assert_eq!(pushed, work(Vec3::new(0.0, 1.0, 0.0)));
    }
}
