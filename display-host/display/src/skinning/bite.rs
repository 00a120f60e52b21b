//! Skin that jaws hold lies between them.
//!
//! The controller's jaws hold inner spheres, which lie some mm under the skin and far apart: skin that only
//! follows those would stay beside the jaws. So what is near to closing jaws is drawn to their mouth
//! and pressed flat between them, less the farther it is. Only the picture, like a press.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::words::CapsuleRole;

/// Jaws that hold tissue, as the shader sees them.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Bite {
    /// The jaws' joint, m; the fourth is how far they have closed, 0 (open, or nothing held) to 1.
    pub joint: [f32; 4],
    /// Between their tips, m.
    pub tip: [f32; 4],
    /// Unit direction in which they open.
    pub across: [f32; 4],
}

/// Where between joint and tip tissue is drawn to. `skinning.wgsl` has the same numbers.
const MOUTH: f32 = 0.72;
/// All that is so near to the jaws' line goes with them, what is farther off by some `FADES_M` does not, m.
const CORE_M: f32 = 0.0025;
const FADES_M: f32 = 0.0045;
/// How much a fold is narrowed along the jaws' hinge.
const NARROWED: f32 = 0.2;

/// What the jaws hold at this moment.
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

/// How far a vertex is drawn into the jaws, m. Twin of `bitten` in `skinning.wgsl`.
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
    // Flat between the jaws, up to their mouth, and a little narrower.
    (across * off.dot(across) + along + (flat - along) * NARROWED) * -held
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use shared_mem::message::{CapsuleMsg, PoseMsg};

    use super::*;

    /// Jaws that point down (−z), open along y, their tips at the origin.
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
            // Over the tips, and in the gap of closed jaws.
            assert!(now.z > 0.002 && now.y.abs() < 0.0003, "{at}: {now}");
        }
    }

    proptest! {
        /// Whatever comes over the border: skin stays finite, moves no farther than to the mouth, and what
        /// is far off does not move.
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
