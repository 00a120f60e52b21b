//! The lever about the trocar, through which the shaft always passes.
//!
//! With handle position `h` (outside the body), port `p` and shaft length `L`:
//! `d = unit(p − h)`, tip `= h + L d`.

use crate::math::{self, Pose, Quat, Vec3};

/// Shortest part outside the body that the lever law divides by, m: nearer than that the hand
/// would hold the trocar itself.
const OUTSIDE_MIN_M: f32 = 0.02;
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
