//! Instruments: the lever about the trocar, the shapes, and what the tick shows of them.
//!
//! The shaft always passes through its port. With handle position `h` (outside the body), port
//! `p` and shaft length `L`: `d = unit(p − h)`, tip `= h + L d`. The instrument frame has its
//! origin at the jaw joint and −z along the shaft towards the tip; its roll is the handle's.

use heapless::Vec;

use crate::capacity::MAX_CAPSULES;
use crate::math::{self, Pose, Quat, Vec3};
use crate::port::{Buttons, PedalSample};

/// Shortest part outside the body that the lever law divides by, m: nearer than that the hand
/// would hold the trocar itself.
const OUTSIDE_MIN_M: f32 = 0.02;
/// Radius of the shaft, m: a 5 mm instrument.
const SHAFT_RADIUS_M: f32 = 0.0025;

/// The shaft and the port that it pivots about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics {
    /// The trocar, world frame, m.
    pub port_m: Vec3,
    /// From the handle to the tip, m.
    pub length_m: f32,
}

impl Kinematics {
    /// Direction of the shaft, from the handle through the port. A handle in the port has none:
    /// then the handle's own −z.
    #[must_use]
    pub fn axis(&self, world_from_handle: &Pose) -> Vec3 {
        math::unit(&(self.port_m - world_from_handle.translation.vector))
            .unwrap_or_else(|| world_from_handle.rotation * Vec3::new(0.0, 0.0, -1.0))
    }

    /// Position of the tip, m.
    #[must_use]
    pub fn tip(&self, world_from_handle: &Pose) -> Vec3 {
        world_from_handle.translation.vector + self.axis(world_from_handle) * self.length_m
    }

    /// Pose of the instrument whose jaws are `jaw_length_m` long: origin at the jaw joint, −z
    /// towards the tip, y as near to the handle's y as that allows.
    #[must_use]
    pub fn instrument(&self, world_from_handle: &Pose, jaw_length_m: f32) -> Pose {
        let axis = self.axis(world_from_handle);
        let joint = self.tip(world_from_handle) - axis * jaw_length_m;
        let up = world_from_handle.rotation * Vec3::new(0.0, 1.0, 0.0);
        Pose::from_parts(joint.into(), facing(&axis, &up))
    }

    /// The handle pose that brings the tip to `tip_m`, rolled so that its y is as near to `up`
    /// as the shaft allows. The inverse of [`Self::tip`] for tips within the shaft's reach; a tip
    /// in the port itself has no solution and gives a shaft along −z.
    #[must_use]
    pub fn handle_from_tip(&self, tip_m: &Vec3, up: &Vec3) -> Pose {
        let axis = math::unit(&(tip_m - self.port_m)).unwrap_or(Vec3::new(0.0, 0.0, -1.0));
        Pose::from_parts((tip_m - axis * self.length_m).into(), facing(&axis, up))
    }

    /// What a force `force_n` on the instrument at `at_m` does to the hand at the handle: along
    /// the shaft it passes through, across it turns about the port (virtual work:
    /// `−(l_in / l_out) F⊥`). Forces outside the body do not exist: `l_in` is at least 0.
    #[must_use]
    pub fn handle_force(&self, world_from_handle: &Pose, at_m: &Vec3, force_n: &Vec3) -> Vec3 {
        let axis = self.axis(world_from_handle);
        let along = axis * axis.dot(force_n);
        along - (force_n - along) * self.lever(world_from_handle, at_m)
    }

    /// `l_in / l_out` of a point of the instrument.
    #[must_use]
    pub fn lever(&self, world_from_handle: &Pose, at_m: &Vec3) -> f32 {
        let inside_m = self.axis(world_from_handle).dot(&(at_m - self.port_m));
        let outside_m = math::norm(&(self.port_m - world_from_handle.translation.vector));
        inside_m.max(0.0) / outside_m.max(OUTSIDE_MIN_M)
    }
}

/// The rotation whose −z is `axis` (a unit vector) and whose y is as near to `up` as it can be.
fn facing(axis: &Vec3, up: &Vec3) -> Quat {
    let z = -axis;
    let y = math::unit(&(up - z * z.dot(up))).unwrap_or_else(|| math::across(&z));
    Quat::from_basis_unchecked(&[y.cross(&z), y, z])
}

/// What is on the end of the shaft.
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
}

impl Instrument {
    /// The next one, in the order that the handle's button walks through.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Grasper => Self::Hook,
            Self::Hook => Self::Scissors,
            Self::Scissors => Self::ClipApplier,
            Self::ClipApplier => Self::Grasper,
        }
    }

    /// From the jaw joint to the tip, m.
    #[must_use]
    pub const fn jaw_length_m(self) -> f32 {
        match self {
            Self::Grasper => 0.020,
            Self::Hook => 0.012,
            Self::Scissors => 0.016,
            Self::ClipApplier => 0.014,
        }
    }

    /// How far a jaw's end lies off the shaft's axis when open, m; 0: nothing opens.
    #[must_use]
    pub const fn jaw_opening_m(self) -> f32 {
        match self {
            Self::Grasper => 0.008,
            Self::Hook => 0.0,
            Self::Scissors => 0.006,
            Self::ClipApplier => 0.004,
        }
    }
}

/// Part of an instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Role {
    /// From the port to the jaw joint.
    Shaft = 0,
    /// Jaw on the side of +y.
    UpperJaw = 1,
    /// Jaw on the side of −y.
    LowerJaw = 2,
    /// The hook's bent end.
    Tip = 3,
}

/// A round bar, world frame. Collision takes its ends as flat (paper Algorithm 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// One end of the axis, m.
    pub a_m: Vec3,
    /// Other end of the axis, m.
    pub b_m: Vec3,
    /// Radius, m.
    pub radius_m: f32,
    /// Which part it is.
    pub role: Role,
}

/// The capsules of `instrument` (the paper's three: two blades and the shaft), world frame.
/// `jaw` is its opening, 0 closed to 1 open. A shaft that is not in the body yet is left out.
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
    } else {
        let off = instrument.jaw_opening_m() * jaw.clamp(0.0, 1.0);
        let reach = -math::sqrt(length * length - off * off);
        // Closed jaws lie beside each other, not in each other.
        let off = off + 0.001;
        add(joint, world(0.0, off, reach), 0.0015, Role::UpperJaw);
        add(joint, world(0.0, -off, reach), 0.0015, Role::LowerJaw);
    }
    parts
}

/// Switches that a person or the host has set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Switches {
    /// Foot pedal.
    pub pedal: PedalSample,
    /// The simulation stands still.
    pub paused: bool,
    /// Force may leave.
    pub force_enabled: bool,
}

/// Everything about the tools that a tick shows. World frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolState {
    /// The handle in the hand.
    pub world_from_handle: Pose,
    /// The instrument: origin at the jaw joint, −z along the shaft towards the tip.
    pub world_from_instrument: Pose,
    /// The endoscope's camera: looks along −z, y up.
    pub world_from_camera: Pose,
    /// Tip of the instrument, m.
    pub tip_m: Vec3,
    /// Speed of the handle, m/s.
    pub handle_velocity_m_s: Vec3,
    /// What is on the shaft.
    pub instrument: Instrument,
    /// Opening of the jaws: 0 closed, 1 open.
    pub jaw: f32,
    /// Buttons of the handle.
    pub buttons: Buttons,
    /// Collision shapes.
    pub capsules: Vec<Capsule, MAX_CAPSULES>,
    /// Force on the hand as sent to the device, N.
    pub force_n: Vec3,
    /// Spheres that the instrument touches.
    pub contact_count: u32,
    /// Spheres between closed jaws.
    pub grasped_count: u32,
    /// Switches.
    pub switches: Switches,
}

impl ToolState {
    /// Nothing sampled yet: everything in the port, no capsules, so that nothing is touched.
    pub(crate) fn new(port_m: Vec3, world_from_camera: Pose) -> Self {
        let at_port = Pose::from_parts(port_m.into(), Quat::identity());
        Self {
            world_from_handle: at_port,
            world_from_instrument: at_port,
            world_from_camera,
            tip_m: port_m,
            handle_velocity_m_s: Vec3::zeros(),
            instrument: Instrument::default(),
            jaw: 1.0,
            buttons: Buttons::default(),
            capsules: Vec::new(),
            force_n: Vec3::zeros(),
            contact_count: 0,
            grasped_count: 0,
            switches: Switches::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LEVER: Kinematics = Kinematics {
        port_m: Vec3::new(0.0, 0.0, 0.1),
        length_m: 0.33,
    };

    fn handle(x: f32, y: f32, z: f32) -> Pose {
        Pose::from_parts(Vec3::new(x, y, z).into(), Quat::identity())
    }

    #[test]
    fn straight_down_by_hand() {
        let h = handle(0.0, 0.0, 0.3); // 0.2 above the port: 0.13 of 0.33 is inside
        assert!(math::norm(&(LEVER.tip(&h) - Vec3::new(0.0, 0.0, -0.03))) < 1.0e-6);
        let instrument = LEVER.instrument(&h, 0.02);
        let joint = instrument.translation.vector;
        assert!(math::norm(&(joint - Vec3::new(0.0, 0.0, -0.01))) < 1.0e-6);
        let tip_in_instrument = instrument.inverse_transform_point(&LEVER.tip(&h).into());
        assert!(math::norm(&(tip_in_instrument.coords - Vec3::new(0.0, 0.0, -0.02))) < 1.0e-6);
    }

    #[test]
    fn force_through_the_lever_by_hand() {
        let h = handle(0.0, 0.0, 0.3);
        let tip = LEVER.tip(&h);
        // 3 N along the shaft pass; 2 N across become −2 · 0.13 / 0.2.
        let hand = LEVER.handle_force(&h, &tip, &Vec3::new(2.0, 0.0, 3.0));
        assert!(
            math::norm(&(hand - Vec3::new(-1.3, 0.0, 3.0))) < 1.0e-5,
            "{hand}"
        );
        // Outside the body there is nothing to push.
        let outside = Vec3::new(0.0, 0.0, 0.2);
        let hand = LEVER.handle_force(&h, &outside, &Vec3::new(2.0, 0.0, 0.0));
        assert!(math::norm(&hand) < 1.0e-6);
    }

    #[test]
    fn roll_follows_the_handle() {
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let turned = Quat::from_quaternion(nalgebra::Quaternion::new(half, 0.0, 0.0, half));
        let h = Pose::from_parts(Vec3::new(0.0, 0.0, 0.3).into(), turned);
        let y = LEVER.instrument(&h, 0.02).rotation * Vec3::new(0.0, 1.0, 0.0);
        assert!(math::norm(&(y - Vec3::new(-1.0, 0.0, 0.0))) < 1.0e-5, "{y}");
    }

    #[test]
    fn a_handle_in_the_port_still_has_a_tip() {
        let h = handle(0.0, 0.0, 0.1);
        assert!(math::is_finite(&LEVER.tip(&h)));
        assert!(math::is_rigid(&LEVER.instrument(&h, 0.02)));
    }

    #[test]
    fn every_instrument_ends_at_its_tip() {
        let h = handle(0.01, -0.02, 0.25);
        for instrument in [
            Instrument::Grasper,
            Instrument::Hook,
            Instrument::Scissors,
            Instrument::ClipApplier,
        ] {
            let pose = LEVER.instrument(&h, instrument.jaw_length_m());
            let parts = capsules(instrument, &pose, &LEVER.port_m, 0.0);
            assert_eq!(parts.len(), 3);
            let to_tip = |c: &Capsule| math::norm(&(c.b_m - LEVER.tip(&h)));
            assert!(parts.iter().any(|c| to_tip(c) < 0.0045), "{instrument:?}");
            assert!(parts.iter().all(|c| c.radius_m > 0.0));
        }
    }

    proptest! {
        /// `handle_from_tip` undoes `tip`, wherever the shaft reaches.
        #[test]
        fn handle_from_tip_is_the_inverse(
            x in -0.1f32..0.1, y in -0.1f32..0.1, z in -0.15f32..0.05,
        ) {
            let tip = Vec3::new(x, y, z);
            let h = LEVER.handle_from_tip(&tip, &Vec3::new(0.0, 1.0, 0.0));
            prop_assert!(math::norm(&(LEVER.tip(&h) - tip)) < 1.0e-5);
            prop_assert!(math::is_rigid(&h));
        }

        /// Virtual work: the hand's power equals what the tissue takes, for a small motion.
        #[test]
        fn the_lever_conserves_work(
            fx in -3.0f32..3.0, fy in -3.0f32..3.0, fz in -3.0f32..3.0,
            dx in -1.0f32..1.0, dy in -1.0f32..1.0, dz in -1.0f32..1.0,
        ) {
            let (force, step) = (Vec3::new(fx, fy, fz), Vec3::new(dx, dy, dz) * 1.0e-3);
            let before = handle(0.03, 0.01, 0.28);
            let after = Pose::from_parts(
                (before.translation.vector + step).into(),
                before.rotation,
            );
            let work_tip = force.dot(&(LEVER.tip(&after) - LEVER.tip(&before)));
            let hand = LEVER.handle_force(&before, &LEVER.tip(&before), &force);
            prop_assert!((hand.dot(&step) - work_tip).abs() < 2.0e-4, "{work_tip}");
        }
    }
}
