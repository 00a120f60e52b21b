//! The lever about the trocar, through which the shaft always passes.
//!
//! With handle position `h` (outside the body), port `p` and shaft length `L`:
//! `d = unit(p − h)`, tip `= h + L d`.

use crate::math::{self, Pose, Quat, Vec3};

/// Lower bound, in the lever law, of the length of the shaft outside the body, m. A hand nearer to
/// the port would hold the trocar itself.
const OUTSIDE_MIN_M: f32 = 0.02;
/// The shaft and the port that it pivots about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics {
    /// The trocar, world frame, m.
    pub port_m: Vec3,
    /// Length of the shaft from the handle to the tip, m.
    pub length_m: f32,
}

impl Kinematics {
    /// Direction of the shaft, from the handle through the port; the handle's −z for a handle in
    /// the port.
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

    /// Pose of the instrument with jaws of `jaw_length_m`: origin at the jaw joint, −z towards the
    /// tip, y as close to the handle's y as the shaft allows.
    #[must_use]
    pub fn instrument(&self, world_from_handle: &Pose, jaw_length_m: f32) -> Pose {
        let axis = self.axis(world_from_handle);
        let joint = self.tip(world_from_handle) - axis * jaw_length_m;
        let up = world_from_handle.rotation * Vec3::new(0.0, 1.0, 0.0);
        Pose::from_parts(
            joint.into(),
            Quat::from_basis_unchecked(&shaft_frame(&axis, &up)),
        )
    }

    /// Handle pose that brings the tip to `tip_m`, rolled so that its y is as close to `up` as the
    /// shaft allows. The inverse of [`Self::tip`] for tips within the shaft's reach. For a tip in
    /// the port, any direction would do; the shaft then lies along −z.
    #[must_use]
    pub fn handle_from_tip(&self, tip_m: &Vec3, up: &Vec3) -> Pose {
        let axis = math::unit(&(tip_m - self.port_m)).unwrap_or(Vec3::new(0.0, 0.0, -1.0));
        let turned = Quat::from_basis_unchecked(&shaft_frame(&axis, up));
        Pose::from_parts((tip_m - axis * self.length_m).into(), turned)
    }

    /// Wrench on the hand from a wrench on the instrument, by virtual work. The port bears the rest
    /// of the force across the shaft.
    ///
    /// With the force `F`, the torque `τ` about the port and the length `l_out` outside the body:
    /// force `d (d·F) + d × τ / l_out`, torque `d (d·τ)`. The roll of the shaft follows the
    /// handle's y (see [`Self::instrument`]). If this y is tilted along the shaft, part of the roll
    /// torque acts on the hand about y, and as a push across the shaft.
    #[must_use]
    pub fn at_handle(&self, world_from_handle: &Pose, at_port: &Wrench) -> Wrench {
        let axis = self.axis(world_from_handle);
        let outside_m = self.outside_m(world_from_handle);
        let along_n = axis * axis.dot(&at_port.force_n);
        let roll_nm = -axis.dot(&at_port.torque_nm); // about z
        let up = world_from_handle.rotation * Vec3::new(0.0, 1.0, 0.0);
        let [x, y, z] = shaft_frame(&axis, &up);
        let tilt = tilt_tangent(&y, &z, &up);
        let across_nm = axis.cross(&at_port.torque_nm) + x * (tilt * roll_nm);
        Wrench {
            force_n: along_n + across_nm / outside_m,
            torque_nm: (z - y * tilt) * roll_nm,
        }
    }

    /// Wrench about the port of a force on the instrument at `at_m`.
    #[must_use]
    pub fn wrench(&self, at_m: &Vec3, force_n: &Vec3) -> Wrench {
        Wrench {
            force_n: *force_n,
            torque_nm: (at_m - self.port_m).cross(force_n),
        }
    }

    /// Displacement of the instrument's point at `at_m` when the handle moves by `travel_m` without
    /// rolling the shaft: the transpose of [`Self::at_handle`].
    #[cfg(test)]
    pub(crate) fn displacement_at(
        &self,
        world_from_handle: &Pose,
        at_m: &Vec3,
        travel_m: &Vec3,
    ) -> Vec3 {
        let axis = self.axis(world_from_handle);
        let turn = -axis.cross(travel_m) / self.outside_m(world_from_handle);
        axis * axis.dot(travel_m) + turn.cross(&(at_m - self.port_m))
    }

    /// Length of the shaft outside the body, m, with a lower bound for the lever law.
    pub(crate) fn outside_m(&self, world_from_handle: &Pose) -> f32 {
        math::norm(&(self.port_m - world_from_handle.translation.vector)).max(OUTSIDE_MIN_M)
    }
}

/// A force, and a torque about the port or the handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    /// Force, world frame, N.
    pub force_n: Vec3,
    /// Torque, world frame, N m.
    pub torque_nm: Vec3,
}

impl Wrench {
    /// No force and no torque.
    pub const ZERO: Self = Self {
        force_n: Vec3::new(0.0, 0.0, 0.0),
        torque_nm: Vec3::new(0.0, 0.0, 0.0),
    };

    /// Without the torque about the unit vector `axis`.
    #[must_use]
    pub fn without_roll(&self, axis: &Vec3) -> Self {
        Self {
            torque_nm: self.torque_nm - axis * axis.dot(&self.torque_nm),
            ..*self
        }
    }

    /// Sum of this and `share` times another.
    pub(crate) fn plus(&self, other: &Self, share: f32) -> Self {
        Self {
            force_n: self.force_n + other.force_n * share,
            torque_nm: self.torque_nm + other.torque_nm * share,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        math::is_finite(&self.force_n) && math::is_finite(&self.torque_nm)
    }
}

impl core::ops::AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.force_n += other.force_n;
        self.torque_nm += other.torque_nm;
    }
}

/// Axes of the instrument: −z along the shaft (a unit vector), y as close to `up` as that allows.
fn shaft_frame(axis: &Vec3, up: &Vec3) -> [Vec3; 3] {
    let z = -axis;
    let y = math::unit(&(up - z * z.dot(up))).unwrap_or_else(|| math::perpendicular(&z));
    [y.cross(&z), y, z]
}

/// Tangent of the tilt of the unit vector `up` from y towards z; limited to 45°, because a handle
/// whose y lies along the shaft could not roll the shaft at all. Beyond 45° the hand feels too
/// little roll torque.
fn tilt_tangent(y: &Vec3, z: &Vec3, up: &Vec3) -> f32 {
    let (across, along) = (up.dot(y).max(f32::MIN_POSITIVE), up.dot(z));
    along.max(-across).min(across) / across
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vector;
    use proptest::prelude::*;

    const LEVER: Kinematics = Kinematics {
        port_m: Vec3::new(0.0, 0.0, 0.1),
        length_m: 0.33,
    };

    fn handle(x: f32, y: f32, z: f32) -> Pose {
        Pose::from_parts(Vec3::new(x, y, z).into(), Quat::identity())
    }

    #[test]
    fn tip_and_joint_of_a_vertical_shaft_are_as_computed_by_hand() {
        let h = handle(0.0, 0.0, 0.3); // 0.2 above the port: 0.13 of 0.33 is inside
        assert!(math::norm(&(LEVER.tip(&h) - Vec3::new(0.0, 0.0, -0.03))) < 1.0e-6);
        let instrument = LEVER.instrument(&h, 0.02);
        let joint = instrument.translation.vector;
        assert!(math::norm(&(joint - Vec3::new(0.0, 0.0, -0.01))) < 1.0e-6);
        let tip_in_instrument = instrument.inverse_transform_point(&LEVER.tip(&h).into());
        assert!(math::norm(&(tip_in_instrument.coords - Vec3::new(0.0, 0.0, -0.02))) < 1.0e-6);
    }

    fn felt(h: &Pose, at_m: Vec3, force_n: Vec3) -> Wrench {
        LEVER.at_handle(h, &LEVER.wrench(&at_m, &force_n))
    }

    fn near(a: &Vec3, b: [f32; 3]) -> bool {
        math::norm(&(a - Vec3::from(b))) < 1.0e-5
    }

    #[test]
    fn lever_transmits_a_wrench_as_computed_by_hand() {
        let h = handle(0.0, 0.0, 0.3);
        let tip = LEVER.tip(&h);
        // 3 N along the shaft pass unchanged; 2 N across it become −2 · 0.13 / 0.2.
        let hand = felt(&h, tip, Vec3::new(2.0, 0.0, 3.0));
        assert!(near(&hand.force_n, [-1.3, 0.0, 3.0]), "{hand:?}");
        assert!(near(&hand.torque_nm, [0.0; 3]), "{hand:?}");
        // At 10 mm from the axis, 2 N along the shaft also bend it: 20 mN m / 0.2 m. 2 N across the
        // shaft also roll it.
        let jaw = tip + Vec3::new(0.01, 0.0, 0.0);
        let hand = felt(&h, jaw, Vec3::new(0.0, 0.0, 2.0));
        assert!(near(&hand.force_n, [-0.1, 0.0, 2.0]), "{hand:?}");
        let hand = felt(&h, jaw, Vec3::new(0.0, 2.0, 0.0));
        assert!(near(&hand.force_n, [0.0, -1.3, 0.0]), "{hand:?}");
        assert!(near(&hand.torque_nm, [0.0, 0.0, 0.02]), "{hand:?}");
        // In the port itself there is no lever.
        let hand = felt(&h, LEVER.port_m, Vec3::new(2.0, 0.0, 0.0));
        assert!(near(&hand.force_n, [0.0; 3]), "{hand:?}");
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
        /// `handle_from_tip` undoes `tip` at every place that the shaft reaches.
        #[test]
        fn handle_from_tip_is_the_inverse(
            x in -0.1f32..0.1, y in -0.1f32..0.1, z in -0.15f32..0.05,
        ) {
            let tip = Vec3::new(x, y, z);
            let h = LEVER.handle_from_tip(&tip, &Vec3::new(0.0, 1.0, 0.0));
            prop_assert!(math::norm(&(LEVER.tip(&h) - tip)) < 1.0e-5);
            prop_assert!(math::is_rigid(&h));
        }

        /// Virtual work: in a small motion, the work at the handle equals the work at the
        /// instrument. The motion is a finite difference of the kinematics in `f32`, hence the
        /// tolerance.
        #[test]
        fn work_at_the_handle_equals_work_at_the_instrument(
            f in vector(3.0), step in vector(1.0), turn in vector(1.0), arm in vector(0.02),
            x in -0.1f32..0.1, y in -0.1f32..0.1, z in 0.2f32..0.35, tilt in vector(0.7),
        ) {
            let (step, turn) = (step * 2.0e-3, turn * 0.01);
            let at = |share: f32| Pose::from_parts(
                (Vec3::new(x, y, z) + step * share).into(),
                Quat::from_scaled_axis(turn * share) * Quat::from_scaled_axis(tilt),
            );
            // A point that the instrument carries.
            let point = |h: &Pose| {
                let pose = LEVER.instrument(h, 0.02);
                pose.rotation * arm + pose.translation.vector
            };
            let up = at(0.0).rotation * Vec3::y();
            let [_, y, z] = shaft_frame(&LEVER.axis(&at(0.0)), &up);
            prop_assume!(tilt_tangent(&y, &z, &up).abs() < 0.99); // see `tilt_tangent`
            let (before, middle, after) = (at(-0.5), at(0.0), at(0.5));
            let work_j = f.dot(&(point(&after) - point(&before)));
            let hand = felt(&middle, point(&middle), f);
            let felt_j = hand.force_n.dot(&step) + hand.torque_nm.dot(&turn);
            prop_assert!((felt_j - work_j).abs() < 5.0e-6 + 2.0e-3 * f.norm() * step.norm(),
                "{felt_j} {work_j}");
            // Without roll the force alone does the work.
            let wrench = LEVER.wrench(&point(&middle), &f).without_roll(&LEVER.axis(&middle));
            let travel_m = LEVER.displacement_at(&middle, &point(&middle), &step);
            let felt_j = LEVER.at_handle(&middle, &wrench).force_n.dot(&step);
            prop_assert!((felt_j - f.dot(&travel_m)).abs() < 1.0e-6 + 1.0e-4 * f.norm() * step.norm());
        }

        /// The lever is invariant under rotation, translation and reflection of the room.
        #[test]
        fn lever_is_invariant_under_rotation_translation_and_reflection(
            f in vector(3.0), arm in vector(0.05), travel_m in vector(0.1), turn in vector(3.0),
        ) {
            let h = handle(0.03, 0.01, 0.28);
            let at_m = LEVER.tip(&h) + arm;
            let here = felt(&h, at_m, f);
            let room = Pose::from_parts(travel_m.into(), Quat::from_scaled_axis(turn));
            let there = Kinematics { port_m: room.rotation * LEVER.port_m + travel_m, ..LEVER };
            let moved = room.rotation * at_m + travel_m;
            let hand = there.at_handle(&(room * h), &there.wrench(&moved, &(room.rotation * f)));
            prop_assert!(math::norm(&(hand.force_n - room.rotation * here.force_n)) < 2.0e-4);
            prop_assert!(math::norm(&(hand.torque_nm - room.rotation * here.torque_nm)) < 2.0e-5);
            // A reflection (x → −x here) reverses torques as axial vectors; forces are polar
            // vectors.
            let mirror = |v: &Vec3| Vec3::new(-v.x, v.y, v.z);
            let seen = felt(&handle(-0.03, 0.01, 0.28), mirror(&at_m), mirror(&f));
            prop_assert!(math::norm(&(seen.force_n - mirror(&here.force_n))) < 1.0e-5);
            prop_assert!(math::norm(&(seen.torque_nm + mirror(&here.torque_nm))) < 1.0e-6);
        }
    }
}
