//! The emulated hand, steered by a person with mouse, keyboard or gamepad.

use nalgebra::UnitQuaternion;
use rt_core::math::{Pose, Vec3};
use rt_core::port::Buttons;

use super::hand::{HANDLE_REACH_M, Hand};
use crate::rig::wire::Switches;

/// A person's steering command. Movements are sums since the start, so that a lost message loses no
/// movement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wish {
    /// Movement of the instrument's tip along the picture's right, its up, and towards the viewer,
    /// m.
    pub moved_m: [f64; 3],
    /// Rotation of the instrument about its shaft, rad.
    pub rolled_rad: f64,
    /// Rotation of the endoscope about its port, to the left and up, rad.
    pub scope_turned_rad: [f64; 2],
    /// Advance of the endoscope along its axis, inwards, m.
    pub scope_advanced_m: f64,
    /// Buttons at the handle.
    pub buttons: Buttons,
    /// Pressed pedal switches.
    pub switches: Switches,
}

/// Smoothing time of a person's movements, ms. They arrive only at the frame rate of a screen.
const SMOOTH_MS: f64 = 20.0;
/// Fastest movement, m/s, well below the speed at which the safety chain cuts the force.
const SPEED_MAX_M_S: f64 = 0.4;
/// Fastest turn, rad/s.
const TURN_MAX_RAD_S: f64 = 2.0;
/// Largest movement still to be made, in seconds at full speed. A larger movement is cut.
const BEHIND_MAX_S: f64 = 0.125;
/// Smallest distance of tip and handle from the trocar, m.
const PORT_CLEAR_M: f32 = 0.03;
/// Largest turn of the endoscope from its pose in the scene, rad.
const SCOPE_TURN_MAX_RAD: f64 = 0.6;
/// Largest advance of the endoscope from its pose in the scene, m.
const SCOPE_ADVANCE_MAX_M: f64 = 0.06;

/// A movement of which a part is still to be made.
#[derive(Debug, Clone, Copy, Default)]
struct Pending {
    requested: f64,
    remaining: f64,
}

impl Pending {
    /// Takes the new sum and returns the part of the movement to be made in this millisecond.
    fn step(&mut self, requested: f64, speed_max: f64) -> f64 {
        if !requested.is_finite() {
            return 0.0;
        }
        let behind_max = speed_max * BEHIND_MAX_S;
        self.remaining =
            (self.remaining + requested - self.requested).clamp(-behind_max, behind_max);
        self.requested = requested;
        let most = speed_max * 1e-3;
        let step = (self.remaining / SMOOTH_MS).clamp(-most, most);
        self.remaining -= step;
        step
    }
}

/// State of instrument and endoscope under a person's control.
#[derive(Debug, Clone)]
pub(super) struct SteeringState {
    moved: [Pending; 3],
    rolled: Pending,
    scope_turned: [Pending; 2],
    scope_advanced: Pending,
    tip_m: Vec3,
    roll_rad: f64,
    turn_rad: [f64; 2],
    advance_m: f64,
    buttons: Buttons,
    switches: Switches,
}

impl SteeringState {
    /// Starts from the present position of the tip.
    pub(super) fn begin(tip_m: Vec3, wish: &Wish) -> Self {
        let from = |requested: f64| Pending {
            requested,
            remaining: 0.0,
        };
        Self {
            moved: wish.moved_m.map(from),
            rolled: from(wish.rolled_rad),
            scope_turned: wish.scope_turned_rad.map(from),
            scope_advanced: from(wish.scope_advanced_m),
            tip_m,
            roll_rad: 0.0,
            turn_rad: [0.0; 2],
            advance_m: 0.0,
            buttons: wish.buttons,
            switches: Switches::default(),
        }
    }

    /// Advances one millisecond. Without a steering command (its sender is silent) the hand holds
    /// still and the foot leaves the pedal.
    pub(super) fn follow(&mut self, wish: Option<&Wish>, hand: &Hand) {
        let Some(wish) = wish else {
            self.switches = Switches::default();
            return;
        };
        self.buttons = wish.buttons;
        self.switches = wish.switches;
        self.roll_rad += self.rolled.step(wish.rolled_rad, TURN_MAX_RAD_S);
        for ((turn, pending), &requested) in self
            .turn_rad
            .iter_mut()
            .zip(&mut self.scope_turned)
            .zip(&wish.scope_turned_rad)
        {
            let turned = *turn + pending.step(requested, TURN_MAX_RAD_S);
            *turn = turned.clamp(-SCOPE_TURN_MAX_RAD, SCOPE_TURN_MAX_RAD);
        }
        let advanced = self.advance_m
            + self
                .scope_advanced
                .step(wish.scope_advanced_m, SPEED_MAX_M_S);
        self.advance_m = advanced.clamp(-SCOPE_ADVANCE_MAX_M, SCOPE_ADVANCE_MAX_M);
        let mut step = Vec3::zeros();
        for ((part, pending), &requested) in step.iter_mut().zip(&mut self.moved).zip(&wish.moved_m)
        {
            *part = pending.step(requested, SPEED_MAX_M_S) as f32;
        }
        let way = hand.camera(self.scope()).rotation * step;
        self.tip_m = hand.within_reach(self.tip_m + way);
    }

    /// Handle pose that brings the tip to its target, device frame.
    pub(super) fn handle(&self, hand: &Hand) -> Pose {
        hand.handle_of(&self.tip_m)
    }

    /// Rotation of the handle about the shaft.
    pub(super) fn roll(&self) -> UnitQuaternion<f32> {
        UnitQuaternion::from_axis_angle(&Vec3::z_axis(), self.roll_rad as f32)
    }

    /// Turn of the endoscope to the left and up, rad, and its advance, m.
    pub(super) fn scope(&self) -> [f32; 3] {
        let [yaw, pitch] = self.turn_rad;
        [yaw as f32, pitch as f32, self.advance_m as f32]
    }

    pub(super) fn buttons(&self) -> Buttons {
        self.buttons
    }

    pub(super) fn switches(&self) -> Switches {
        self.switches
    }
}

impl Hand {
    /// Nearest tip position that handle and shaft reach, world frame, m.
    pub(super) fn within_reach(&self, tip_m: Vec3) -> Vec3 {
        let (port_m, length_m) = (self.kinematics.port_m, self.kinematics.length_m);
        let shaft = tip_m - port_m;
        let inside_m = shaft.norm();
        if inside_m.is_nan() || inside_m < 1e-6 {
            return port_m + self.script_direction() * PORT_CLEAR_M;
        }
        let kept_m = inside_m.clamp(PORT_CLEAR_M, (length_m - PORT_CLEAR_M).max(PORT_CLEAR_M));
        let tip_m = port_m + shaft * (kept_m / inside_m);
        let handle_m = self.handle_of(&tip_m).translation.vector;
        let reach_m = handle_m.norm();
        if reach_m < HANDLE_REACH_M {
            return tip_m;
        }
        self.tip_of(handle_m * (HANDLE_REACH_M / reach_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::hand::tests::workplace;
    use proptest::prelude::*;

    fn start() -> (Hand, SteeringState) {
        let hand = Hand::new(workplace(), 1).unwrap();
        let operated = SteeringState::begin(hand.intent(0.0).tip_m, &Wish::default());
        (hand, operated)
    }

    #[test]
    fn the_tip_moves_in_the_directions_of_the_picture_and_arrives() {
        let (hand, mut operated) = start();
        let before = operated.tip_m;
        let wish = Wish {
            moved_m: [0.004, -0.002, 0.003],
            ..Wish::default()
        };
        for _ in 0..400 {
            operated.follow(Some(&wish), &hand);
        }
        let way = workplace().world_from_camera.rotation.inverse() * (operated.tip_m - before);
        assert!(
            (way - Vec3::new(0.004, -0.002, 0.003)).norm() < 1e-5,
            "{way}"
        );
        let world = workplace().world_from_device * operated.handle(&hand);
        assert!((hand.kinematics.tip(&world) - operated.tip_m).norm() < 1e-5);
    }

    #[test]
    fn when_the_sender_is_silent_the_pedal_is_released_and_the_hand_rests() {
        let (hand, mut operated) = start();
        let wish = Wish {
            buttons: Buttons::GRASP,
            switches: Switches {
                coagulate: true,
                ..Switches::default()
            },
            ..Wish::default()
        };
        operated.follow(Some(&wish), &hand);
        assert!(operated.switches().coagulate);
        let tip_m = operated.tip_m;
        operated.follow(None, &hand);
        assert_eq!(operated.switches(), Switches::default());
        assert!(operated.buttons().contains(Buttons::GRASP));
        assert_eq!(operated.tip_m, tip_m);
    }

    proptest! {
        /// For any steering command the handle stays in the device's reach and moves without jumps.
        #[test]
        fn operated_hand_stays_within_reach(
            requested in prop::collection::vec(([-1.0f64..1.0, -1.0..1.0, -1.0..1.0], any::<f64>(), any::<f64>()), 1..20),
        ) {
            let (hand, mut operated) = start();
            for (moved_m, odd, turned) in requested {
                let wish = Wish {
                    moved_m,
                    rolled_rad: odd,
                    scope_turned_rad: [turned, odd],
                    scope_advanced_m: turned,
                    ..Wish::default()
                };
                for _ in 0..200 {
                    let before = operated.tip_m;
                    operated.follow(Some(&wish), &hand);
                    let handle = operated.handle(&hand);
                    prop_assert!(handle.translation.vector.norm() <= HANDLE_REACH_M + 1e-4);
                    prop_assert!(handle.rotation.coords.iter().all(|part| part.is_finite()));
                    prop_assert!((operated.tip_m - before).norm() < 4e-3);
                    let camera = hand.camera(operated.scope());
                    prop_assert!(camera.translation.vector.iter().all(|part| part.is_finite()));
                }
            }
        }
    }
}
