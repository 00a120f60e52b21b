//! Instruments on the shaft, and their capsules.

use heapless::Vec;

use crate::capacity::MAX_CAPSULES;
use crate::math::{self, Pose, Vec3};

/// Radius of the shaft, m: a 5 mm instrument.
const SHAFT_RADIUS_M: f32 = 0.0025;
/// Radius of a jaw, m.
const JAW_RADIUS_M: f32 = 0.0015;
/// Radius of the endoscope, m: a 10 mm laparoscope.
const ENDOSCOPE_RADIUS_M: f32 = 0.005;

/// Instrument on the end of the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Instrument {
    /// Two jaws that hold.
    #[default]
    Grasper = 0,
    /// Cautery hook.
    Hook = 1,
    /// Two blades.
    Scissors = 2,
    /// Clip applier.
    ClipApplier = 3,
    /// Tube that sucks and rinses. The simulation knows only its shape; the display computes the
    /// fluids.
    Irrigator = 4,
}

impl Instrument {
    /// The next instrument, in the order in which the handle's button changes them.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Grasper => Self::Hook,
            Self::Hook => Self::Scissors,
            Self::Scissors => Self::ClipApplier,
            Self::ClipApplier => Self::Irrigator,
            Self::Irrigator => Self::Grasper,
        }
    }

    /// Distance from the jaw joint to the tip, m.
    #[must_use]
    pub const fn jaw_length_m(self) -> f32 {
        match self {
            Self::Grasper => 0.020,
            Self::Hook => 0.012,
            Self::Scissors => 0.016,
            Self::ClipApplier => 0.014,
            Self::Irrigator => 0.012,
        }
    }

    /// Distance of the end of an open jaw from the shaft's axis, m; 0 for an instrument without
    /// jaws.
    #[must_use]
    pub const fn jaw_opening_m(self) -> f32 {
        match self {
            Self::Grasper => 0.008,
            Self::Hook | Self::Irrigator => 0.0,
            Self::Scissors => 0.006,
            Self::ClipApplier => 0.004,
        }
    }
}

/// Part of a tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Role {
    /// From the port to the jaw joint.
    Shaft = 0,
    /// Jaw on the side of +y; for the hook, its straight part.
    UpperJaw = 1,
    /// Jaw on the side of −y.
    LowerJaw = 2,
    /// The hook's bent end; the end of the irrigator's tube.
    Tip = 3,
    /// The endoscope, from its port to the camera.
    Endoscope = 4,
}

/// Tool to which a part belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tool {
    /// The instrument, whose handle the hand holds.
    Instrument,
    /// The endoscope, which another hand holds.
    Endoscope,
}

impl Role {
    /// The tool that has this part.
    #[must_use]
    pub const fn tool(self) -> Tool {
        match self {
            Self::Endoscope => Tool::Endoscope,
            Self::Shaft | Self::UpperJaw | Self::LowerJaw | Self::Tip => Tool::Instrument,
        }
    }
}

/// A capsule, world frame. Its ends are hemispheres, which extend beyond the axis by the radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// One end of the axis, m.
    pub a_m: Vec3,
    /// Other end of the axis, m.
    pub b_m: Vec3,
    /// Radius, m.
    pub radius_m: f32,
    /// Part of the tool.
    pub role: Role,
}

/// Capsules of `instrument`, world frame: shaft and two jaws, as in the inner-sphere paper; for the
/// hook, shaft, straight part and bent end. `jaw` is the opening, 0 closed to 1 open. The round end
/// of a jaw extends to the tip of the jaw. A shaft that is not in the body yet is omitted.
#[must_use]
pub fn capsules(
    instrument: Instrument,
    world_from_instrument: &Pose,
    port_m: &Vec3,
    jaw: f32,
) -> Vec<Capsule, MAX_CAPSULES> {
    let world = |x: f32, y: f32, z: f32| {
        world_from_instrument.rotation * Vec3::new(x, y, z)
            + world_from_instrument.translation.vector
    };
    let joint = world(0.0, 0.0, 0.0);
    let length = instrument.jaw_length_m();
    let mut parts = Vec::new();
    let mut add = |a_m, b_m, radius_m, role| {
        let _ = parts.push(Capsule {
            a_m,
            b_m,
            radius_m,
            role,
        }); // MAX_CAPSULES > 3
    };
    if world_from_instrument
        .inverse_transform_vector(&(port_m - joint))
        .z
        > 0.0
    {
        add(*port_m, joint, SHAFT_RADIUS_M, Role::Shaft);
    }
    if instrument == Instrument::Hook {
        let heel = world(0.0, 0.0, -length);
        add(joint, heel, 0.001, Role::UpperJaw);
        add(heel, world(0.0, -0.004, -length), 0.0008, Role::Tip);
    } else if instrument == Instrument::Irrigator {
        let mouth = world(0.0, 0.0, SHAFT_RADIUS_M - length);
        add(joint, mouth, SHAFT_RADIUS_M, Role::Tip);
    } else {
        let side_m = instrument.jaw_opening_m() * jaw.clamp(0.0, 1.0);
        let axial_m = -math::sqrt(length * length - side_m * side_m);
        let axis = 1.0 - JAW_RADIUS_M / length;
        // Closed jaws lie next to each other and do not overlap.
        let (side_m, axial_m) = (axis * side_m + 0.001, axis * axial_m);
        add(
            joint,
            world(0.0, side_m, axial_m),
            JAW_RADIUS_M,
            Role::UpperJaw,
        );
        add(
            joint,
            world(0.0, -side_m, axial_m),
            JAW_RADIUS_M,
            Role::LowerJaw,
        );
    }
    parts
}

/// Capsule of the endoscope, from its port to the camera's front, where its round end lies; `None`
/// while the camera is outside the body.
#[must_use]
pub fn endoscope(port_m: &Vec3, world_from_camera: &Pose) -> Option<Capsule> {
    let front_m = world_from_camera.translation.vector;
    let ahead = world_from_camera.rotation * Vec3::new(0.0, 0.0, -1.0);
    ((front_m - port_m).dot(&ahead) > 2.0 * ENDOSCOPE_RADIUS_M).then_some(Capsule {
        a_m: *port_m,
        b_m: front_m - ahead * ENDOSCOPE_RADIUS_M,
        radius_m: ENDOSCOPE_RADIUS_M,
        role: Role::Endoscope,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;
    use crate::tool::Kinematics;

    const LEVER: Kinematics = Kinematics {
        port_m: Vec3::new(0.0, 0.0, 0.1),
        length_m: 0.33,
    };

    fn handle(x: f32, y: f32, z: f32) -> Pose {
        Pose::from_parts(Vec3::new(x, y, z).into(), Quat::identity())
    }

    #[test]
    fn every_instrument_ends_at_its_tip() {
        let h = handle(0.01, -0.02, 0.25);
        for instrument in [
            Instrument::Grasper,
            Instrument::Hook,
            Instrument::Scissors,
            Instrument::ClipApplier,
            Instrument::Irrigator,
        ] {
            let pose = LEVER.instrument(&h, instrument.jaw_length_m());
            let parts = capsules(instrument, &pose, &LEVER.port_m, 0.0);
            let is_tube = instrument == Instrument::Irrigator;
            assert_eq!(parts.len(), if is_tube { 2 } else { 3 });
            // Distance by which each part reaches beyond the tip, along the shaft.
            let axis = LEVER.axis(&h);
            let beyond_m = |c: &Capsule| (c.b_m - LEVER.tip(&h)).dot(&axis) + c.radius_m;
            let farthest_m = parts.iter().map(beyond_m).fold(f32::MIN, f32::max);
            let is_jawed = instrument.jaw_opening_m() > 0.0;
            let allowed_m = if is_jawed { 1.0e-6 } else { 0.001_001 };
            assert!(farthest_m.abs() < allowed_m, "{instrument:?} {farthest_m}");
            assert!(parts.iter().all(|c| c.radius_m > 0.0));
        }
    }

    #[test]
    fn open_jaws_turn_about_their_joint() {
        let h = handle(0.01, -0.02, 0.25);
        let pose = LEVER.instrument(&h, Instrument::Grasper.jaw_length_m());
        let ends = [0.0, 0.5, 1.0].map(|jaw| {
            let parts = capsules(Instrument::Grasper, &pose, &LEVER.port_m, jaw);
            let end = pose.inverse_transform_point(&parts[1].b_m.into()).coords;
            math::norm(&(end - Vec3::new(0.0, 0.001, 0.0)))
        });
        assert!(ends.iter().all(|m| (m - 0.0185).abs() < 1.0e-6), "{ends:?}");
    }

    #[test]
    fn the_endoscope_reaches_to_its_camera_s_front() {
        let camera = Pose::from_parts(Vec3::new(0.0, 0.0, -0.05).into(), Quat::identity());
        let scope = endoscope(&LEVER.port_m, &camera).expect("in the body");
        assert!(
            (scope.b_m.z - scope.radius_m + 0.05).abs() < 1.0e-6,
            "{scope:?}"
        );
        let outside = Pose::from_parts(Vec3::new(0.0, 0.0, 0.095).into(), Quat::identity());
        assert!(endoscope(&LEVER.port_m, &outside).is_none());
    }
}
