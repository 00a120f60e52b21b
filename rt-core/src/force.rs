//! What the tissue does to the instrument, felt at the handle: Hooke's law on the penetration,
//! through the lever about the port.

use crate::collision::tool_contact::Contact;
use crate::math::{self, Pose, Vec3};
use crate::tool::Kinematics;

/// Force at the handle and the stiffness behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Felt {
    /// World frame, N.
    pub(crate) force_n: Vec3,
    /// Along that force, at the handle, N/m.
    pub(crate) stiffness_n_m: f32,
}

/// A pull of tissue on the instrument that is no contact: what the jaws hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pull {
    /// Where, world frame, m.
    pub(crate) at_m: Vec3,
    /// World frame, N.
    pub(crate) force_n: Vec3,
    /// N/m.
    pub(crate) stiffness_n_m: f32,
}

/// Adds up what every contact and the held tissue do at the handle. O(contacts).
pub(crate) fn felt(
    contacts: &[Contact],
    pull: Option<&Pull>,
    kinematics: &Kinematics,
    world_from_handle: &Pose,
) -> Felt {
    let at_handle =
        |at_m: &Vec3, force: &Vec3| kinematics.handle_force(world_from_handle, at_m, force);
    let mut force_n = Vec3::zeros();
    for contact in contacts {
        force_n += at_handle(&contact.at_m, &(contact.normal * contact.force_n));
    }
    if let Some(pull) = pull {
        force_n += at_handle(&pull.at_m, &pull.force_n);
    }
    // A spring k along n feels like k (T n · f)² along f at the handle, T the lever.
    let direction = math::unit(&force_n).unwrap_or_else(Vec3::zeros);
    let mut stiffness_n_m = 0.0;
    for contact in contacts {
        let share = at_handle(&contact.at_m, &contact.normal).dot(&direction);
        stiffness_n_m += contact.stiffness_n_m * share * share;
    }
    if let Some(pull) = pull {
        let share = math::norm(&at_handle(&pull.at_m, &direction));
        stiffness_n_m += pull.stiffness_n_m * share * share;
    }
    Felt {
        force_n,
        stiffness_n_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;

    const LEVER: Kinematics = Kinematics {
        port_m: Vec3::new(0.0, 0.0, 0.0),
        length_m: 0.3,
    };

    fn handle() -> Pose {
        // 0.2 outside, 0.1 inside.
        Pose::from_parts(Vec3::new(0.0, 0.0, 0.2).into(), Quat::identity())
    }

    fn contact(at_m: Vec3, normal: Vec3) -> Contact {
        Contact {
            organ: 0,
            at_m,
            normal,
            force_n: 2.0,
            stiffness_n_m: 400.0,
        }
    }

    #[test]
    fn no_contact_no_force() {
        let felt = felt(&[], None, &LEVER, &handle());
        assert!(math::norm(&felt.force_n) < f32::EPSILON && felt.stiffness_n_m < f32::EPSILON);
    }

    #[test]
    fn along_the_shaft_it_passes_across_it_the_lever_turns_it() {
        let tip = Vec3::new(0.0, 0.0, -0.1);
        let up = contact(tip, Vec3::new(0.0, 0.0, 1.0));
        let along = felt(&[up], None, &LEVER, &handle());
        assert!(math::norm(&(along.force_n - Vec3::new(0.0, 0.0, 2.0))) < 1.0e-6);
        assert!((along.stiffness_n_m - 400.0).abs() < 1.0e-3);
        let side = contact(tip, Vec3::new(1.0, 0.0, 0.0));
        let across = felt(&[side], None, &LEVER, &handle());
        assert!(math::norm(&(across.force_n - Vec3::new(-1.0, 0.0, 0.0))) < 1.0e-6);
        assert!((across.stiffness_n_m - 100.0).abs() < 1.0e-3); // 400 · (1/2)²
        // Two that press against each other cancel; two on one side add.
        let other = contact(tip, Vec3::new(-1.0, 0.0, 0.0));
        assert!(math::norm(&felt(&[side, other], None, &LEVER, &handle()).force_n) < 1.0e-6);
        let both = felt(&[side, side], None, &LEVER, &handle());
        assert!(math::norm(&(both.force_n - Vec3::new(-2.0, 0.0, 0.0))) < 1.0e-6);
    }

    #[test]
    fn held_tissue_pulls() {
        let at_m = Vec3::new(0.0, 0.0, -0.1);
        let pull = Pull {
            at_m,
            force_n: Vec3::new(0.0, 0.0, -1.5),
            stiffness_n_m: 300.0,
        };
        let felt = felt(&[], Some(&pull), &LEVER, &handle());
        assert!(math::norm(&(felt.force_n - Vec3::new(0.0, 0.0, -1.5))) < 1.0e-6);
        assert!((felt.stiffness_n_m - 300.0).abs() < 1.0e-3);
    }
}
