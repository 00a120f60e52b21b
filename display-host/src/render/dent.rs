//! The dent that inner spheres are too coarse to show.
//!
//! Spheres lie some 14 mm apart; an instrument's tip is 3 mm thick and goes between them. Where
//! the controller says that it touches an organ, the skin before the tip is shown pressed down to
//! it. Only the picture: force and tissue are the controller's.

use glam::{Quat, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::scene::SphereRecord;

/// Radius of the dent's rim, m: where it has fallen to a third.
const RIM_M: f32 = 0.018;
/// Deeper than this is not a press but an instrument behind the organ, m.
const DEEPEST_M: f32 = 0.03;

/// Adds the dent to the spheres' `displacements` (m).
pub(super) fn press(
    rest: &[SphereRecord],
    spheres: &[SphereState],
    tools: &ToolFrame,
    displacements: &mut [[f32; 4]],
) {
    let grasped = spheres.iter().any(|s| s.bits & SphereState::GRASPED != 0);
    let Some((tip, forward)) = tip(tools).filter(|_| tools.contact_count > 0 && !grasped) else {
        return;
    };
    let moving = rest.iter().zip(spheres).zip(displacements);
    for ((rest, now), displacement) in moving.filter(|((rest, _), _)| rest.held == 0) {
        let from_tip = Vec3::from(now.center_m) - tip;
        let along = from_tip.dot(forward);
        // How far the tip is beyond the sphere's near side.
        let depth_m = rest.radius_m - along;
        if !(0.0..DEEPEST_M).contains(&depth_m) {
            continue;
        }
        let across = (from_tip - forward * along).length() / RIM_M;
        let dent = forward * (depth_m * (-across * across).exp());
        for (to, by) in displacement.iter_mut().zip(dent.to_array()) {
            *to += by;
        }
    }
}

/// The instrument's tip and the way that it points, unless it has no jaws in the body.
fn tip(tools: &ToolFrame) -> Option<(Vec3, Vec3)> {
    let ends = tools
        .capsules()?
        .iter()
        .filter(|c| c.role != 0)
        .map(|c| Vec3::from(c.b_m));
    let (sum, count) = ends.fold((Vec3::ZERO, 0.0), |(sum, count), end| {
        (sum + end, count + 1.0)
    });
    let forward = Quat::from_array(tools.world_from_instrument.orientation) * Vec3::NEG_Z;
    (count > 0.0).then_some((sum / count, forward))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use shared_mem::message::{CapsuleMsg, PoseMsg};

    use super::*;

    /// A sphere of 8 mm whose near side is at z = 0, and one 60 mm beside it; the tip `depth_m`
    /// in, coming down along −z.
    fn pressed(depth_m: f32, contact_count: u32, bits: u32) -> [[f32; 4]; 2] {
        let center = |x: f32| [x, 0.0, -0.008];
        let rest = [0.0, 0.06].map(|x| SphereRecord {
            center_m: center(x),
            radius_m: 0.008,
            mass_kg: 0.001,
            held: 0,
        });
        let spheres = rest.map(|s| SphereState {
            center_m: s.center_m,
            bits,
        });
        let mut tools = ToolFrame {
            world_from_handle: PoseMsg::IDENTITY,
            world_from_instrument: PoseMsg::IDENTITY,
            world_from_camera: PoseMsg::IDENTITY,
            contact_count,
            capsule_count: 1,
            ..ToolFrame::zeroed()
        };
        tools.capsules[0] = CapsuleMsg {
            a_m: [0.0; 3],
            radius_m: 0.0015,
            b_m: [0.0, 0.0, -depth_m],
            role: 1,
        };
        let mut displacements = [[0.0; 4]; 2];
        press(&rest, &spheres, &tools, &mut displacements);
        displacements
    }

    #[test]
    fn the_skin_before_the_tip_goes_down_to_it() {
        let [near, far] = pressed(0.01, 1, 0);
        assert!(
            (near[2] + 0.01).abs() < 1e-6 && near[0].abs() < 1e-6,
            "{near:?}"
        );
        assert!(far[2].abs() < 1e-6, "{far:?}");
    }

    #[test]
    fn nothing_is_dented_without_contact_in_a_grasp_or_from_behind() {
        for case in [
            pressed(0.01, 0, 0),
            pressed(0.01, 1, SphereState::GRASPED),
            pressed(0.05, 1, 0),
        ] {
            assert_eq!(case, [[0.0; 4]; 2]);
        }
    }
}
