//! Force and torque at the handle: the contacts' wrench about the port, transmitted by the shaft as
//! a lever.

use nalgebra::Matrix3;

use crate::contact::contact_force::{ContactForce, Pull};
use crate::math::{self, Pose, Vec3};
use crate::tool::{Kinematics, Tool, Wrench};

/// Force that the hand feels, and its stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Felt {
    /// Wrench at the handle, world frame.
    pub(crate) wrench: Wrench,
    /// Stiffness at the handle in its stiffest direction, N/m; never too low, at most 15 % too
    /// high.
    pub(crate) stiffness_n_m: f32,
    /// Stiffness at the handle within a tick, before the grasped tissue yields, N/m; never too low.
    pub(crate) instant_stiffness_n_m: f32,
}

/// Sums the forces of all contacts and of the grasped tissue at the handle. If `renders_torque` is
/// false, the shaft rolls freely in the hand, and its roll torque is not felt. O(contacts).
pub(crate) fn felt(
    contacts: &[ContactForce],
    pull: Option<&Pull>,
    kinematics: &Kinematics,
    world_from_handle: &Pose,
    renders_torque: bool,
) -> Felt {
    let mut at_port = Wrench::ZERO;
    // Springs of stiffness k along n at the instrument have the stiffness matrix Σ k (T n)(T n)ᵀ at
    // the handle. T maps a force at the instrument to a force at the handle.
    let mut stiffness_n_m = Matrix3::zeros();
    let mut grip_n_m = 0.0;
    let mut add_spring = |at_m: &Vec3, normal: &Vec3, k: f32| {
        let direction = force_at_handle(kinematics, world_from_handle, at_m, normal);
        stiffness_n_m += direction * direction.transpose() * k;
    };
    let is_on_instrument = |contact: &&ContactForce| contact.tool == Tool::Instrument;
    for contact in contacts.iter().filter(is_on_instrument) {
        at_port += kinematics.wrench(&contact.at_m, &contact.whole_force_n());
        add_spring(&contact.at_m, &contact.normal, contact.stiffness_n_m);
        if contact.friction_stiffness_n_m > 0.0 {
            let x = math::perpendicular(&contact.normal);
            for along in [x, contact.normal.cross(&x)] {
                add_spring(&contact.at_m, &along, contact.friction_stiffness_n_m);
            }
        }
    }
    if let Some(pull) = pull {
        at_port += kinematics.wrench(&pull.at_m, &pull.force_n);
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            add_spring(&pull.at_m, &axis, pull.stiffness_n_m);
            let direction = force_at_handle(kinematics, world_from_handle, &pull.at_m, &axis);
            grip_n_m += direction.norm_squared() * pull.grip_n_m;
        }
    }
    if !renders_torque {
        at_port = at_port.without_roll(&kinematics.axis(world_from_handle));
    }
    let stiffness_n_m = stiffest_direction_n_m(&stiffness_n_m);
    Felt {
        wrench: kinematics.at_handle(world_from_handle, &at_port),
        stiffness_n_m,
        instant_stiffness_n_m: stiffness_n_m + grip_n_m,
    }
}

/// Force on the hand from a unit force along `normal` on the instrument at `at_m`, if the shaft
/// rolls freely in the hand.
fn force_at_handle(
    kinematics: &Kinematics,
    world_from_handle: &Pose,
    at_m: &Vec3,
    normal: &Vec3,
) -> Vec3 {
    let free = kinematics
        .wrench(at_m, normal)
        .without_roll(&kinematics.axis(world_from_handle));
    kinematics.at_handle(world_from_handle, &free).force_n
}

/// Upper bound of the largest eigenvalue of a positive semidefinite matrix: `tr(M⁸)^⅛`, between
/// that eigenvalue and `3^⅛ = 1.15` times it. When one contact's share of the matrix changes, the
/// bound changes by no more than the stiffness of this share.
fn stiffest_direction_n_m(m: &Matrix3<f32>) -> f32 {
    let size = m.trace();
    if size <= f32::MIN_POSITIVE {
        return 0.0;
    }
    let squared = |m: Matrix3<f32>| m * m;
    let eighth = squared(squared(squared(m / size)));
    size * math::sqrt(math::sqrt(math::sqrt(eighth.trace())))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::Quat;
    use crate::testing::vector;
    use proptest::prelude::*;

    const LEVER: Kinematics = Kinematics {
        port_m: Vec3::new(0.0, 0.0, 0.0),
        length_m: 0.3,
    };

    fn handle() -> Pose {
        // The shaft is 0.2 m outside the body and 0.1 m inside.
        Pose::from_parts(Vec3::new(0.0, 0.0, 0.2).into(), Quat::identity())
    }

    fn contact(at_m: Vec3, normal: Vec3) -> ContactForce {
        ContactForce {
            tool: Tool::Instrument,
            organ: Some(0),
            at_m,
            normal,
            force_n: 2.0,
            stiffness_n_m: 400.0,
            friction_n: Vec3::zeros(),
            friction_stiffness_n_m: 0.0,
        }
    }

    #[test]
    fn friction_is_felt_across_the_contact() {
        let rubbed = ContactForce {
            friction_n: Vec3::new(0.2, 0.0, 0.0),
            friction_stiffness_n_m: 800.0,
            stiffness_n_m: 100.0,
            ..contact(Vec3::new(0.0, 0.0, -0.1), Vec3::z())
        };
        let felt = felt(&[rubbed], None);
        assert!(is_force(&felt, -0.1, 0.0, 2.0), "{felt:?}");
        // 800 · (1/2)² in two directions and 100 in the third; the bound is at most 2^⅛ times too
        // high.
        assert!((200.0..=219.0).contains(&felt.stiffness_n_m), "{felt:?}");
    }

    fn felt(contacts: &[ContactForce], pull: Option<&Pull>) -> Felt {
        super::felt(contacts, pull, &LEVER, &handle(), true)
    }

    fn is_force(felt: &Felt, x: f32, y: f32, z: f32) -> bool {
        math::norm(&(felt.wrench.force_n - Vec3::new(x, y, z))) < 1.0e-6
    }

    #[test]
    fn handle_without_contact_has_no_force() {
        let none = felt(&[], None);
        assert!(none.wrench == Wrench::ZERO && none.stiffness_n_m.to_bits() == 0);
    }

    #[test]
    fn axial_force_passes_and_lateral_force_is_levered() {
        let tip = Vec3::new(0.0, 0.0, -0.1);
        let along = felt(&[contact(tip, Vec3::z())], None);
        assert!(is_force(&along, 0.0, 0.0, 2.0));
        assert!((along.stiffness_n_m - 400.0).abs() < 1.0e-3);
        let side = contact(tip, Vec3::x());
        let across = felt(&[side], None);
        assert!(is_force(&across, -1.0, 0.0, 0.0));
        assert!((across.stiffness_n_m - 100.0).abs() < 1.0e-3); // 400 · (1/2)²
        // The forces of two contacts on one side add. The forces of two opposite contacts cancel,
        // but their stiffness is the same.
        let both = felt(&[side, side], None);
        assert!(is_force(&both, -2.0, 0.0, 0.0));
        let squeezed = felt(&[side, contact(tip, -Vec3::x())], None);
        assert!(is_force(&squeezed, 0.0, 0.0, 0.0));
        assert!((squeezed.stiffness_n_m - 200.0).abs() < 1.0e-3);
    }

    #[test]
    fn push_off_the_shaft_twists_the_handle_only_if_the_device_renders_torque() {
        let jaw = contact(Vec3::new(0.01, 0.0, -0.1), Vec3::y());
        let held = super::felt(&[jaw], None, &LEVER, &handle(), true);
        assert!(math::norm(&(held.wrench.torque_nm - Vec3::z() * 0.02)) < 1.0e-7);
        let free = super::felt(&[jaw], None, &LEVER, &handle(), false);
        assert!(math::norm(&free.wrench.torque_nm) < 1.0e-9);
        assert!(is_force(&held, 0.0, -1.0, 0.0) && is_force(&free, 0.0, -1.0, 0.0));
    }

    #[test]
    fn held_tissue_pulls_the_hand() {
        let pull = Pull {
            at_m: Vec3::new(0.0, 0.0, -0.1),
            force_n: Vec3::new(0.0, 0.0, -1.5),
            stiffness_n_m: 300.0,
            grip_n_m: 500.0,
        };
        let felt = felt(&[], Some(&pull));
        assert!(is_force(&felt, 0.0, 0.0, -1.5));
        assert!((felt.stiffness_n_m - 300.0).abs() < 1.0, "{felt:?}");
    }

    fn contacts() -> impl Strategy<Value = std::vec::Vec<ContactForce>> {
        let any = (vector(0.05), vector(1.0), 0.0f32..3.0, 0.0f32..1000.0);
        prop::collection::vec(any, 0..12).prop_map(|drawn| {
            let made = drawn
                .into_iter()
                .map(|(at, direction, force_n, stiffness_n_m)| ContactForce {
                    at_m: Vec3::new(0.0, 0.0, -0.1) + at,
                    normal: math::unit(&direction).unwrap_or_else(Vec3::z),
                    force_n,
                    stiffness_n_m,
                    ..contact(Vec3::zeros(), Vec3::z())
                });
            made.collect()
        })
    }

    proptest! {
        /// A small motion of the hand changes the springs' force by no more than the stiffness
        /// predicts, and in some direction by at least 1/1.15 of the predicted change.
        #[test]
        fn handle_stiffness_is_that_of_the_stiffest_direction(all in contacts(), direction in vector(1.0)) {
            let stiffness = felt(&all, None).stiffness_n_m;
            let response = |direction: &Vec3| {
                let mut sum = Vec3::zeros();
                for c in &all {
                    let normal_travel = LEVER.displacement_at(&handle(), &c.at_m, direction).dot(&c.normal);
                    let wrench = LEVER.wrench(&c.at_m, &(c.normal * (normal_travel * c.stiffness_n_m)));
                    let wrench = wrench.without_roll(&LEVER.axis(&handle()));
                    sum += LEVER.at_handle(&handle(), &wrench).force_n;
                }
                sum
            };
            let direction = math::unit(&direction).unwrap_or_else(Vec3::x);
            prop_assert!(math::norm(&response(&direction)) <= stiffness * 1.001 + 1.0e-3);
            // Power iteration finds the stiffest direction.
            let mut stiff = direction;
            for _ in 0..200 {
                stiff = math::unit(&response(&stiff)).unwrap_or(stiff);
            }
            let found = math::norm(&response(&stiff));
            prop_assert!(found * 1.16 + 1.0e-2 >= stiffness || all.is_empty(), "{found} {stiffness}");
        }

        /// The hand's work equals the contacts' work, in any direction of motion.
        #[test]
        fn work_of_the_hand_equals_work_of_the_contacts(all in contacts(), direction in vector(1.0)) {
            let felt = super::felt(&all, None, &LEVER, &handle(), false);
            let contact_work: f32 = all.iter().map(|c| {
                (c.normal * c.force_n).dot(&LEVER.displacement_at(&handle(), &c.at_m, &direction))
            }).sum();
            let tolerance = 1.0e-5 * (1.0 + all.len() as f32);
            prop_assert!((felt.wrench.force_n.dot(&direction) - contact_work).abs() < tolerance);
        }

        /// Force and stiffness are invariant under rotation of the room and reflection.
        #[test]
        fn force_is_invariant_under_rotation_and_reflection(all in contacts(), turn in vector(3.0)) {
            let here = felt(&all, None);
            let turn = Quat::from_scaled_axis(turn);
            let turned: std::vec::Vec<ContactForce> = all.iter().map(|c| ContactForce {
                at_m: turn * c.at_m, normal: turn * c.normal, ..*c
            }).collect();
            let at = Pose::from_parts(nalgebra::Translation::identity(), turn) * handle();
            let there = super::felt(&turned, None, &LEVER, &at, true);
            let difference_n = there.wrench.force_n - turn * here.wrench.force_n;
            prop_assert!(math::norm(&difference_n) < 1.0e-4, "{difference_n}");
            prop_assert!((there.stiffness_n_m - here.stiffness_n_m).abs()
                < 1.0e-3 * (1.0 + here.stiffness_n_m));
            let mirror = |v: &Vec3| Vec3::new(-v.x, v.y, v.z);
            let mirrored: std::vec::Vec<ContactForce> = all.iter().map(|c| ContactForce {
                at_m: mirror(&c.at_m), normal: mirror(&c.normal), ..*c
            }).collect();
            let seen = felt(&mirrored, None);
            prop_assert!(math::norm(&(seen.wrench.force_n - mirror(&here.wrench.force_n))) < 1.0e-5);
            prop_assert!((seen.stiffness_n_m - here.stiffness_n_m).abs()
                < 1.0e-3 * (1.0 + here.stiffness_n_m));
        }
    }
}
