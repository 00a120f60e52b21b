//! The scripted hand: target of the instrument's tip, pressed switches, and sway of the endoscope,
//! as a pure function of time and seed.

use rt_core::math::{Pose, Vec3};
use rt_core::port::Buttons;
use rt_core::tool::Kinematics;

use super::random::Random;
use crate::HardwareError;
use crate::bird::wire::{Hemisphere, Scale};
use crate::rig::wire::Switches;

/// Workplace of the scripted hand in a scene, in the world frame and SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandScript {
    /// The instrument's trocar, m.
    pub instrument_port_m: Vec3,
    /// Distance from the handle to the tip, m.
    pub instrument_length_m: f32,
    /// Base frame of the haptic device.
    pub world_from_device: Pose,
    /// Transmitter frame of the tracker. The tracker's protocol reaches 0.91 m and covers one
    /// hemisphere, so the endoscope must stay at z < 0 of this frame.
    pub world_from_tracker: Pose,
    /// Rest pose of the endoscope's camera.
    pub world_from_camera: Pose,
    /// Trocar about which the endoscope sways, m.
    pub endoscope_port_m: Vec3,
    /// Point on the organ's skin that the hand presses and grasps, m.
    pub target_m: Vec3,
    /// Outward normal at the target.
    pub target_normal: Vec3,
}

/// A key frame of the hand.
struct KeyFrame {
    at_s: f32,
    /// Height of the tip above the skin, along the normal. Negative: the tip presses into the
    /// tissue.
    height_mm: f32,
    /// Action until the next key frame.
    name: &'static str,
}

const fn key_frame(at_s: f32, height_mm: f32, name: &'static str) -> KeyFrame {
    KeyFrame {
        at_s,
        height_mm,
        name,
    }
}

/// One round of the hand: all actions within 10 s. Between two key frames the hand moves smoothly,
/// from rest to rest.
const ROUND: [KeyFrame; 13] = [
    key_frame(0.0, 45.0, "rest"),
    key_frame(0.3, 45.0, "approach"),
    key_frame(1.4, 3.0, "hover"),
    key_frame(1.7, 3.0, "press"),
    key_frame(2.9, -20.0, "hold"),
    key_frame(4.1, -20.0, "release"),
    key_frame(4.6, 2.0, "touch"),
    key_frame(5.1, -9.0, "grasp"),
    key_frame(5.6, -9.0, "pull"),
    key_frame(6.8, 20.0, "hold the tissue"),
    key_frame(8.0, 20.0, "let go"),
    key_frame(8.4, 20.0, "retreat"),
    key_frame(9.4, 45.0, "rest"),
];
/// Length of a round, s.
pub const ROUND_S: f32 = 10.0;
/// Period of the whole motion, s: a whole number of rounds, sways and oscillations of the tremor.
pub(super) const REPEAT_S: f32 = 630.0;
/// Intervals with closed jaws, s. The hand presses with closed jaws, because open ones would
/// straddle the tissue. Then the jaws open above the tissue and grasp it.
const CLOSED_S: [std::ops::Range<f32>; 2] = [0.3..4.7, 5.3..8.0];
/// Interval in which the foot presses the pedal to coagulate, s.
const COAGULATE_S: std::ops::Range<f32> = 3.3..3.9;
/// Interval in which the foot presses the pedal that holds the camera, s.
const CAMERA_LOCK_S: std::ops::Range<f32> = 9.4..9.7;
/// Amplitude of each oscillation of the tremor, m (physiological: 8–12 Hz).
const TREMOR_M: f32 = 0.05e-3;
/// Sways of the endoscope: amplitude, rad, and period, s.
const SWAY: [(f32, f32); 2] = [(0.05, 9.0), (0.03, 7.0)];

/// Intent of the hand at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intent {
    /// Tip of the instrument, world frame, m.
    pub tip_m: Vec3,
    /// Handle pose that brings the tip there, device frame.
    pub device_from_handle: Pose,
    /// Buttons pressed.
    pub buttons: Buttons,
    /// Pressed pedal switches.
    pub switches: Switches,
    /// Name of the action.
    pub doing: &'static str,
}

/// The scripted hand with its seed.
#[derive(Debug, Clone)]
pub struct Hand {
    pub(super) script: HandScript,
    pub(super) kinematics: Kinematics,
    tremor: [[Oscillation; 2]; 3],
    sway_phase: [f32; 2],
}

#[derive(Debug, Clone, Copy)]
struct Oscillation {
    hz: f32,
    phase: f32,
}

impl Hand {
    /// Makes a hand. Fails if the devices do not reach the script's workplace.
    pub fn new(script: HandScript, seed: u64) -> Result<Self, HardwareError> {
        let mut random = Random::new(seed, 1);
        let tremor = [(); 3].map(|()| {
            [(); 2].map(|()| Oscillation {
                hz: (random.between(8.0, 12.0) * REPEAT_S).round() / REPEAT_S,
                phase: random.between(0.0, std::f32::consts::TAU),
            })
        });
        let sway_phase = [(); 2].map(|()| random.between(0.0, std::f32::consts::TAU));
        let kinematics = Kinematics {
            port_m: script.instrument_port_m,
            length_m: script.instrument_length_m,
        };
        let hand = Self {
            script,
            kinematics,
            tremor,
            sway_phase,
        };
        hand.check()?;
        Ok(hand)
    }

    fn check(&self) -> Result<(), HardwareError> {
        let normal = self.script.target_normal.norm();
        let refuse = |what, value: f32, allowed, remedy| {
            Err(HardwareError::Emulation {
                what,
                value: value.into(),
                allowed,
                remedy,
            })
        };
        if !(0.99..=1.01).contains(&normal) {
            let remedy = "Give the target's outward normal";
            return refuse("the length of the target's normal", normal, "1", remedy);
        }
        for step in 0..=100 {
            let time_s = ROUND_S * step as f32 / 100.0;
            let handle = self.intent(time_s).device_from_handle.translation.vector;
            if !(0.0..HANDLE_REACH_M).contains(&handle.norm()) {
                let what = "the handle's distance from the haptic device's base frame, m";
                let remedy = "Place world_from_device where the handle is at rest";
                return refuse(what, handle.norm(), "less than 0.1", remedy);
            }
            let sensor = self.tracker_from_sensor(time_s).translation.vector;
            if !(0.0..Scale::Inches36.full_m()).contains(&sensor.amax()) {
                let what = "the endoscope's distance from the tracker's transmitter, m";
                let remedy = "Place world_from_tracker nearer to the endoscope";
                return refuse(
                    what,
                    sensor.amax(),
                    "less than 0.91 along each axis",
                    remedy,
                );
            }
            let depth = Hemisphere::Upper.depth(sensor.into());
            if depth <= 0.0 {
                let what = "the endoscope's z in the tracker's frame, m";
                let remedy = "Turn world_from_tracker so that its -z points to the endoscope";
                return refuse(what, -depth, "less than 0", remedy);
            }
        }
        Ok(())
    }

    /// Intent of the hand `time_s` after its start.
    #[must_use]
    pub fn intent(&self, time_s: f32) -> Intent {
        let round_s = time_s.rem_euclid(ROUND_S);
        let (height_m, doing) = height(round_s);
        let tremor = Vec3::from(self.tremor.map(|axis| {
            axis.iter()
                .map(|o| TREMOR_M * (std::f32::consts::TAU * o.hz * time_s + o.phase).sin())
                .sum()
        }));
        let tip_m = self.script.target_m + self.script.target_normal * height_m + tremor;
        Intent {
            tip_m,
            device_from_handle: self.handle_of(&tip_m),
            buttons: if CLOSED_S.iter().any(|closed| closed.contains(&round_s)) {
                Buttons::GRASP
            } else {
                Buttons::default()
            },
            switches: Switches {
                cut: false,
                coagulate: COAGULATE_S.contains(&round_s),
                camera_lock: CAMERA_LOCK_S.contains(&round_s),
            },
            doing,
        }
    }

    /// Handle pose at `position_m` of the device frame. Its rotation keeps the shaft in the port.
    #[must_use]
    pub fn handle_at(&self, position_m: Vec3) -> Pose {
        self.handle_of(&self.tip_of(position_m))
    }

    /// Handle pose that brings the tip to a world position, device frame.
    pub(super) fn handle_of(&self, tip_m: &Vec3) -> Pose {
        let device = &self.script.world_from_device;
        let up = device.rotation * Vec3::y();
        device.inverse() * self.kinematics.handle_from_tip(tip_m, &up)
    }

    /// Tip position of a handle at `position_m` of the device frame, world frame, m.
    pub(super) fn tip_of(&self, position_m: Vec3) -> Vec3 {
        let device = &self.script.world_from_device;
        let world = device * nalgebra::Point3::from(position_m);
        let at = Pose::from_parts(world.into(), device.rotation);
        self.kinematics.tip(&at)
    }

    /// Direction from the trocar to the target.
    pub(super) fn script_direction(&self) -> Vec3 {
        (self.script.target_m - self.script.instrument_port_m).normalize()
    }

    /// Pose of the endoscope's sensor, which sits on the camera, in the transmitter's frame.
    #[must_use]
    pub fn tracker_from_sensor(&self, time_s: f32) -> Pose {
        let [yaw, pitch]: [f32; 2] = std::array::from_fn(|axis| {
            let (angle, period_s) = SWAY[axis];
            let phase = self.sway_phase[axis];
            let turn = std::f32::consts::TAU * time_s / period_s;
            // The sway at time 0 is subtracted, so that the picture begins at the scene's camera
            // pose.
            angle * ((turn + phase).sin() - phase.sin())
        });
        self.sensor([yaw, pitch, 0.0])
    }

    /// Pose of the sensor for a turned and advanced endoscope; see [`Self::camera`].
    pub(super) fn sensor(&self, scope: [f32; 3]) -> Pose {
        self.script.world_from_tracker.inverse() * self.camera(scope)
    }

    /// Camera turned about its port to the left and up, rad, and advanced, m; world frame.
    pub(super) fn camera(&self, [yaw, pitch, advance_m]: [f32; 3]) -> Pose {
        let camera = self.script.world_from_camera;
        let about = camera.rotation * Vec3::new(pitch, yaw, 0.0);
        let turn = nalgebra::UnitQuaternion::from_scaled_axis(about);
        let port = self.script.endoscope_port_m;
        let ahead = camera.rotation * Vec3::new(0.0, 0.0, -advance_m);
        let position = port + turn * (camera.translation.vector + ahead - port);
        Pose::from_parts(position.into(), turn * camera.rotation)
    }
}

/// Radius of the Touch's stops less a margin for the tremor, m.
pub(super) const HANDLE_REACH_M: f32 = 0.099;

/// Height of the tip above the skin, m, and the action at this time of the round.
fn height(round_s: f32) -> (f32, &'static str) {
    let next = ROUND
        .iter()
        .position(|key_frame| key_frame.at_s > round_s)
        .unwrap_or(ROUND.len());
    let from = &ROUND[next.saturating_sub(1)];
    let Some(to) = ROUND.get(next) else {
        return (from.height_mm * 1e-3, from.name);
    };
    let part = ((round_s - from.at_s) / (to.at_s - from.at_s)).clamp(0.0, 1.0);
    let smooth = part * part * (3.0 - 2.0 * part);
    (
        (from.height_mm + (to.height_mm - from.height_mm) * smooth) * 1e-3,
        from.name,
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    /// A workplace like that of a prepared scene, with the handle at rest in the device's origin.
    pub(crate) fn workplace() -> HandScript {
        let port = Vec3::new(0.0, 0.0, 0.0);
        let target = Vec3::new(0.02, -0.01, -0.2);
        let length = 0.33;
        let handle = port - target.normalize() * (length - target.norm());
        let camera = Vec3::new(0.05, 0.05, -0.1);
        HandScript {
            instrument_port_m: port,
            instrument_length_m: length,
            world_from_device: Pose::from_parts(handle.into(), UnitQuaternion::identity()),
            world_from_tracker: Translation3::new(0.05, 0.05, 0.1).into(),
            world_from_camera: Pose::from_parts(camera.into(), UnitQuaternion::identity()),
            endoscope_port_m: Vec3::new(0.05, 0.05, 0.05),
            target_m: target,
            target_normal: Vec3::new(0.0, 0.6, 0.8),
        }
    }

    fn hand() -> Hand {
        Hand::new(workplace(), 1).unwrap()
    }

    #[test]
    fn a_round_presses_grasps_pulls_and_releases_within_ten_seconds() {
        let hand = hand();
        let height_mm = |time_s: f32| {
            let script = workplace();
            (hand.intent(time_s).tip_m - script.target_m).dot(&script.target_normal) * 1e3
        };
        assert!(height_mm(0.0) > 40.0);
        assert!((-20.5..-19.5).contains(&height_mm(3.5)));
        assert!(hand.intent(3.5).switches.coagulate);
        assert!(hand.intent(5.5).buttons.contains(Buttons::GRASP) && height_mm(5.5) < -3.0);
        assert!(hand.intent(7.0).buttons.contains(Buttons::GRASP) && height_mm(7.0) > 19.0);
        assert!(!hand.intent(8.2).buttons.contains(Buttons::GRASP));
        assert!(
            (height_mm(12.0) - height_mm(2.0)).abs() < 0.5,
            "the next round does the same"
        );
    }

    #[test]
    fn scripted_hand_moves_without_jumps_at_the_speed_of_a_hand() {
        let hand = hand();
        let mut last = hand.intent(0.0).device_from_handle.translation.vector;
        for ms in 1..20_000 {
            let next = hand
                .intent(ms as f32 * 1e-3)
                .device_from_handle
                .translation
                .vector;
            let speed = (next - last).norm() / 1e-3;
            assert!(speed < 0.2, "{speed} m/s at {ms} ms");
            last = next;
        }
    }

    #[test]
    fn the_seed_decides_the_tremor() {
        let other = Hand::new(workplace(), 2).unwrap();
        assert_eq!(hand().intent(1.234), hand().intent(1.234));
        assert_ne!(hand().intent(1.234).tip_m, other.intent(1.234).tip_m);
    }

    #[test]
    fn the_target_of_the_handle_puts_the_tip_at_its_target() {
        let hand = hand();
        for step in 0..100 {
            let intent = hand.intent(step as f32 * 0.1);
            let world = workplace().world_from_device * intent.device_from_handle;
            let tip = hand.kinematics.tip(&world);
            assert!((tip - intent.tip_m).norm() < 1e-5);
            let position = intent.device_from_handle.translation.vector;
            let again = hand.handle_at(position);
            assert!(again.rotation.angle_to(&intent.device_from_handle.rotation) < 1e-3);
        }
    }

    #[test]
    fn devices_that_cannot_reach_the_scene_are_refused_by_name() {
        let far = Translation3::new(0.0, 0.0, 0.5);
        let script = HandScript {
            world_from_device: far.into(),
            ..workplace()
        };
        let error = Hand::new(script, 0).unwrap_err().to_string();
        assert!(error.contains("world_from_device"), "{error}");
        let script = HandScript {
            world_from_tracker: (-far.vector).into(),
            ..workplace()
        };
        let error = Hand::new(script, 0).unwrap_err().to_string();
        assert!(error.contains("world_from_tracker"), "{error}");
        let script = HandScript {
            target_normal: Vec3::zeros(),
            ..workplace()
        };
        assert!(Hand::new(script, 0).is_err());
    }

    #[test]
    fn the_endoscope_begins_where_the_scene_puts_it_and_sways_slowly() {
        let hand = hand();
        let rest = workplace().world_from_tracker.inverse() * workplace().world_from_camera;
        let begin = hand.tracker_from_sensor(0.0);
        assert!((begin.translation.vector - rest.translation.vector).norm() < 1e-6);
        for step in 0..200 {
            let now = hand.tracker_from_sensor(step as f32 * 0.1);
            assert!((now.translation.vector - rest.translation.vector).norm() < 0.04);
        }
    }
}
