//! Skin between closing jaws.
//!
//! The controller's jaws hold inner spheres, which lie some mm below the skin and far apart. Skin
//! that follows only those spheres would stay next to the jaws. Skin near closing jaws is therefore
//! drawn to their mouth and flattened between them, less with distance. This affects only the
//! picture, like a press.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::words::CapsuleRole;

/// Jaws that hold tissue, in the layout of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Bite {
    /// Joint of the jaws, m. The fourth number is their closure: 0 if open or nothing is held, up
    /// to 1.
    pub joint: [f32; 4],
    /// Middle between the jaws' tips, m.
    pub tip: [f32; 4],
    /// Unit vector along which the jaws open.
    pub across: [f32; 4],
}

/// Place to which tissue is drawn, as a share of the way from the joint to the tip. `skinning.wgsl`
/// has the same number.
const MOUTH: f32 = 0.72;
/// Distance of skin from the jaws' line up to which it follows completely, m.
/// `FADES_M`, m.
/// Distance beyond `CORE_M` over which the effect fades, m.
const CORE_M: f32 = 0.0025;
const FADES_M: f32 = 0.0045;
/// Share by which a fold is narrowed along the jaws' hinge.
const NARROWED: f32 = 0.2;

/// The tissue held by the jaws at this moment.
#[must_use]
pub fn bite(spheres: &[SphereState], tools: &ToolFrame) -> Bite {
    let holds = spheres.iter().any(|s| s.bits & SphereState::GRASPED != 0);
    let capsules = tools.capsules().unwrap_or(&[]);
    let jaw = |role| capsules.iter().find(|capsule| capsule.is(role));
    let (Some(upper), Some(lower), true) = (
        jaw(CapsuleRole::UpperJaw),
        jaw(CapsuleRole::LowerJaw),
        holds,
    ) else {
        return Bite::default();
    };
    let middle = |a: [f32; 3], b: [f32; 3]| 0.5 * (Vec3::from(a) + Vec3::from(b));
    let closed = (1.0 - tools.jaw).clamp(0.0, 1.0);
    let across = Quat::from_array(tools.world_from_instrument.orientation) * Vec3::Y;
    Bite {
        joint: middle(upper.a_m, lower.a_m).extend(closed).to_array(),
        tip: middle(upper.b_m, lower.b_m).extend(0.0).to_array(),
        across: across.extend(0.0).to_array(),
    }
}

/// Displacement of a vertex into the jaws, m. Twin of `bitten` in `skinning.wgsl`.
pub(super) fn bitten(bite: &Bite, at: Vec3) -> Vec3 {
    let closed = bite.joint[3];
    let (joint, tip) = (Vec3::from_slice(&bite.joint), Vec3::from_slice(&bite.tip));
    let axis = tip - joint;
    let length2 = axis.length_squared();
    if closed <= 0.0 || length2 <= 1e-12 {
        return Vec3::ZERO;
    }
    let share = ((at - joint).dot(axis) / length2).clamp(0.0, 1.0);
    let away = (at - joint - axis * share).length();
    let x = (away - CORE_M).max(0.0) / FADES_M;
    let held = closed * (-x * x).exp();
    let off = at - joint - axis * MOUTH;
    let across = Vec3::from_slice(&bite.across);
    let flat = off - across * off.dot(across);
    let along = axis * (flat.dot(axis) / length2);
    // The skin is drawn flat between the jaws and up to their mouth, and made a little narrower.
    (across * off.dot(across) + along + (flat - along) * NARROWED) * -held
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use shared_mem::message::{CapsuleMsg, PoseMsg};

    use super::*;

    /// Jaws that point down (−z) and open along y, with their tips at the origin.
    fn tools(jaw: f32) -> ToolFrame {
        let mut tools = ToolFrame {
            world_from_handle: PoseMsg::IDENTITY,
            world_from_instrument: PoseMsg {
                position_m: [0.0, 0.0, 0.015],
                ..PoseMsg::IDENTITY
            },
            world_from_camera: PoseMsg::IDENTITY,
            capsule_count: 3,
            jaw,
            ..Zeroable::zeroed()
        };
        for (slot, role) in tools.capsules.iter_mut().zip([0, 1, 2]) {
            *slot = CapsuleMsg {
                a_m: [0.0, 0.0, 0.015],
                b_m: [0.0, [0.0, 1.0, -1.0][role] * 0.005 * jaw, 0.0],
                radius_m: 0.001,
                role: role as u32,
            };
        }
        tools
    }

    fn spheres(bits: u32) -> [SphereState; 1] {
        [SphereState {
            center_m: [0.0; 3],
            bits,
        }]
    }

    #[test]
    fn only_jaws_that_hold_something_and_close_draw_skin_in() {
        let held = spheres(SphereState::GRASPED);
        let below = Vec3::new(0.0, 0.001, -0.003);
        let drawn = |bite: &Bite| bitten(bite, below).length();
        assert!(drawn(&bite(&held, &tools(0.1))) > 0.004);
        assert!(drawn(&bite(&held, &tools(1.0))) <= 0.0);
        assert!(drawn(&bite(&spheres(0), &tools(0.1))) <= 0.0);
        let mut hook = tools(0.1);
        hook.capsule_count = 2;
        assert!(drawn(&bite(&held, &hook)) <= 0.0);
    }

    #[test]
    fn skin_before_the_tips_comes_between_the_jaws() {
        let bite = bite(&spheres(SphereState::GRASPED), &tools(0.05));
        for y in [-0.002f32, 0.0, 0.002] {
            let at = Vec3::new(0.001, y, -0.001);
            let now = at + bitten(&bite, at);
            // The skin is above the tips, and in the gap of the closed jaws.
            assert!(now.z > 0.002 && now.y.abs() < 0.0003, "{at}: {now}");
        }
    }

    proptest! {
        /// For any input the skin stays finite, moves no farther than to the mouth, and does not
        /// move if it is far away.
        #[test]
        fn a_bite_is_smooth_and_ends(
            jaw in 0.0f32..1.0, x in -0.04f32..0.04, y in -0.04f32..0.04, z in -0.04f32..0.06,
        ) {
            let bite = bite(&spheres(SphereState::GRASPED), &tools(jaw));
            let at = Vec3::new(x, y, z);
            let moved = bitten(&bite, at);
            let mouth = Vec3::new(0.0, 0.0, 0.015 * (1.0 - MOUTH));
            prop_assert!(moved.length() <= at.distance(mouth) + 1e-6);
            let away = Vec3::new(x, y, (z - z.clamp(0.0, 0.015)).abs()).length();
            if away > 0.02 {
                prop_assert!(moved.length() < 1e-6, "{moved}");
            }
            let beside = bitten(&bite, at + Vec3::splat(1e-5));
            prop_assert!((beside - moved).length() < 1e-4, "{moved} then {beside}");
        }
    }
}
