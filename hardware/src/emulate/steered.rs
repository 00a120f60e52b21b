//! Emulated devices in a hand that obeys steering commands, without serial lines and clocks. Equal
//! steering commands and forces give equal movements.

use nalgebra::UnitQuaternion;
use rt_core::math::{Pose, Vec3};
use rt_core::port::Buttons;

use super::hand::{Hand, HandScript};
use super::operated::{SteeringState, Wish};
use super::touch::{Body, Grip, Touch};
use crate::HardwareError;
use crate::rig::wire::Switches;

/// A steered hand at an emulated Touch.
#[derive(Debug, Clone)]
pub struct SteeredHand {
    hand: Hand,
    steering: SteeringState,
    touch: Touch,
    /// Last pose towards which the hand moved the handle, device frame.
    target: Pose,
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

impl SteeredHand {
    /// A hand at rest in the first pose of the script. Later steering commands count relative to
    /// `wish`.
    ///
    /// # Errors
    /// When the emulated devices cannot reach the script's workplace.
    pub fn new(script: HandScript, wish: &Wish) -> Result<Self, HardwareError> {
        let hand = Hand::new(script, 0)?;
        let steering = SteeringState::begin(hand.intent(0.0).tip_m, wish);
        let target = steering.handle(&hand);
        Ok(Self {
            touch: Touch::new(Body::TOUCH, Grip::STYLUS, target.translation.vector),
            hand,
            steering,
            target,
        })
    }

    /// Simulates one millisecond. `force_n` is the force of the motors, device frame.
    pub fn step(&mut self, wish: &Wish, force_n: Vec3) -> Measured {
        self.steering.follow(Some(wish), &self.hand);
        let before_m = self.target.translation.vector;
        self.target = self.steering.handle(&self.hand);
        let target_m = self.target.translation.vector;
        self.touch
            .step(target_m, (target_m - before_m) / 1e-3, force_n);
        let position_m = self.touch.measured_m();
        let roll: UnitQuaternion<f32> = self.steering.roll();
        let rotation = self.hand.handle_at(position_m).rotation * roll;
        Measured {
            device_from_handle: Pose::from_parts(position_m.into(), rotation),
            velocity_m_s: self.touch.measured_velocity_m_s(),
            buttons: self.steering.buttons(),
            switches: self.steering.switches(),
            tracker_from_sensor: self.hand.sensor(self.steering.scope()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::hand::tests::workplace;

    #[test]
    fn a_steered_hand_follows_commands_yields_to_force_and_is_deterministic() {
        let wish = Wish {
            moved_m: [0.004, 0.0, 0.0],
            ..Wish::default()
        };
        let work = |force_n: Vec3| {
            let mut hand = SteeredHand::new(workplace(), &Wish::default()).unwrap();
            let mut measured = hand.step(&wish, force_n);
            for _ in 0..1000 {
                measured = hand.step(&wish, force_n);
            }
            measured
        };
        let hand = Hand::new(workplace(), 0).unwrap();
        let tip_m = |it: &Measured| hand.tip_of(it.device_from_handle.translation.vector);
        let free = work(Vec3::zeros());
        let travel_m = tip_m(&free) - hand.intent(0.0).tip_m;
        assert!((travel_m.norm() - 0.004).abs() < 0.001, "{travel_m}");
        let pushed = work(Vec3::new(0.0, 1.0, 0.0));
        assert!((tip_m(&pushed) - tip_m(&free)).norm() > 0.001);
        assert_eq!(pushed, work(Vec3::new(0.0, 1.0, 0.0)));
    }
}
