//! Skin wraps around the tool.
//!
//! Spheres lie some 14 mm apart, and a tool's tip is 3 mm thick. The tip passes between spheres and
//! would cut through skin that only follows them. After skinning, every vertex behind the tool's
//! surface is therefore pushed in the direction of the press until it lies in front of the tool.
//! Its neighbours are pushed with it, less with distance. This affects only the picture: force and
//! tissue belong to the controller, and nothing here depends on its solver.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::scene::SphereRecord;
use shared_mem::words::CapsuleRole;

use super::SkinMesh;
use super::motion::{Motion, turned};

/// Largest number of pressing capsules.
pub const PRESSES: usize = 8;
/// Gap between a tool and a sphere below which the sphere begins to count as touched, m.
const NEAR_M: f32 = 0.008;
/// Weight of the tool's own direction relative to that of the touched tissue.
const OWN_WAY: f32 = 0.3;

/// A capsule that presses on skin, in the layout of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Press {
    /// One end of its axis, m; the fourth number is its radius, m.
    pub a: [f32; 4],
    /// The other end of its axis, m.
    pub b: [f32; 4],
    /// Unit vector into the tissue; the fourth number is the degree of contact, 0 to 1.
    pub into: [f32; 4],
}

/// Width of the shoulder between displaced and undisturbed skin, m. `skinning.wgsl` has the same
/// number.
const SHOULDER_M: f32 = 0.003;
/// Growth of the shoulder's width with the displacement. `skinning.wgsl` has the same number.
const SHOULDER_PER_DEPTH: f32 = 0.35;
/// Depths over which a press fades to none, m, because a deeper tool is behind the organ.
const DEEPEST_M: [f32; 2] = [0.025, 0.035];
/// Number of sample points on a capsule's axis.
const STEPS: u32 = 6;

/// The pressing capsules at this moment; none while tissue is grasped, or without contact.
#[must_use]
pub fn presses(
    mesh: &SkinMesh,
    rest: &[SphereRecord],
    motions: &[Motion],
    spheres: &[SphereState],
    tools: &ToolFrame,
) -> [Press; PRESSES] {
    let mut found = [Press::default(); PRESSES];
    let grasped = spheres.iter().any(|s| s.bits & SphereState::GRASPED != 0);
    let capsules = tools.capsules().unwrap_or(&[]);
    if tools.contact_count == 0 || grasped {
        return found;
    }
    let own_way = Quat::from_array(tools.world_from_instrument.orientation) * Vec3::NEG_Z;
    // The shaft has a direction of its own, because it rests on tissue by itself. Jaws and tip
    // share one.
    let [shaft, head] = [true, false].map(|is_shaft| {
        let mut into = Vec3::ZERO;
        let mut touch = 0.0;
        for capsule in capsules
            .iter()
            .filter(|c| c.is(CapsuleRole::Shaft) == is_shaft)
        {
            let ends = [capsule.a_m, capsule.b_m].map(Vec3::from);
            for (i, (rest, now)) in rest.iter().zip(spheres).enumerate() {
                let center = Vec3::from(now.center_m);
                let to_tool = nearest(ends, center) - center;
                let distance = to_tool.length();
                let gap = distance - rest.radius_m - capsule.radius_m;
                let share = (1.0 - gap / NEAR_M).clamp(0.0, 1.0);
                if share > 0.0 {
                    let carried = mesh.outward.get(i).zip(motions.get(i));
                    let outward = carried.map_or(Vec3::ZERO, |(o, motion)| turned(motion, *o));
                    let away = to_tool / distance.max(1e-6);
                    into -= (outward + 0.5 * away) * share;
                    touch += share;
                }
            }
        }
        let into = (into + own_way * (OWN_WAY * touch)).normalize_or(own_way);
        into.extend(touch.min(1.0)).to_array()
    });
    for (slot, capsule) in found.iter_mut().zip(capsules) {
        let end = |at: [f32; 3]| Vec3::from(at).extend(capsule.radius_m).to_array();
        *slot = Press {
            a: end(capsule.a_m),
            b: end(capsule.b_m),
            into: if capsule.is(CapsuleRole::Shaft) {
                shaft
            } else {
                head
            },
        };
    }
    found
}

/// Displacement of a vertex by the tools, m. Skin within `around_m` of a tool, the distance of the
/// vertex's neighbours, goes down with the tool. Otherwise a triangle would cut through it. Twin of
/// `pushed` in `skinning.wgsl`.
pub(super) fn pushed(presses: &[Press; PRESSES], at: Vec3, normal: Vec3, around_m: f32) -> Vec3 {
    let mut push = Vec3::ZERO;
    let mut most = 0.0;
    for press in presses {
        let into = Vec3::from_slice(&press.into);
        // Skin that the tool reaches from behind is not pressed.
        let facing = smoothstep(0.0, 0.5, -normal.dot(into)) * press.into[3];
        if facing <= 0.0 {
            continue;
        }
        let (a, b, radius) = (
            Vec3::from_slice(&press.a),
            Vec3::from_slice(&press.b),
            press.a[3],
        );
        // The deepest point lies between the deeper end and the axis point next to the vertex.
        let (deep, other) = if (b - a).dot(into) >= 0.0 {
            (b, a)
        } else {
            (a, b)
        };
        let beside = beside(other, deep, at, into);
        for step in 0..STEPS {
            let q = beside.lerp(deep, step as f32 / (STEPS - 1) as f32) - at;
            let along = q.dot(into);
            let depth = along + radius;
            if depth <= 0.0 {
                continue;
            }
            let across = ((q - into * along).length() - radius - around_m).max(0.0);
            let x = across / (SHOULDER_M + SHOULDER_PER_DEPTH * depth);
            let behind = smoothstep(DEEPEST_M[0], DEEPEST_M[1], depth);
            let length = depth * (-x * x).exp() * (1.0 - behind) * facing;
            if length > most {
                most = length;
                push = into * length;
            }
        }
    }
    push
}

/// Point of a segment nearest to the line through `at` along `into`.
fn beside(from: Vec3, to: Vec3, at: Vec3, into: Vec3) -> Vec3 {
    let flat = |v: Vec3| v - into * v.dot(into);
    let (axis, offset) = (flat(to - from), flat(at - from));
    let share = offset.dot(axis) / axis.length_squared().max(1e-12);
    from.lerp(to, share.clamp(0.0, 1.0))
}

fn nearest([a, b]: [Vec3; 2], to: Vec3) -> Vec3 {
    let axis = b - a;
    let share = (to - a).dot(axis) / axis.length_squared().max(1e-12);
    a + axis * share.clamp(0.0, 1.0)
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use shared_mem::message::{CapsuleMsg, PoseMsg};

    use super::*;

    /// Edge of the squares in the tests' skin, m.
    const EDGE_M: f32 = 0.003;
    const SIDE: usize = 41;
    const STILL: [Motion; 81] = [[[0.0; 4]; 3]; 81];

    /// A tool with its tip at `tip`, coming from `back` (unit vector).
    fn tool(tip: Vec3, back: Vec3, contact_count: u32) -> ToolFrame {
        let mut tools = ToolFrame {
            world_from_handle: PoseMsg::IDENTITY,
            world_from_instrument: PoseMsg {
                position_m: (tip + back * 0.02).to_array(),
                orientation: Quat::from_rotation_arc(Vec3::Z, back).to_array(),
            },
            world_from_camera: PoseMsg::IDENTITY,
            contact_count,
            capsule_count: 2,
            ..bytemuck::Zeroable::zeroed()
        };
        let capsule = |a: f32, b: f32, radius_m, role| CapsuleMsg {
            a_m: (tip + back * a).to_array(),
            b_m: (tip + back * b).to_array(),
            radius_m,
            role,
        };
        tools.capsules[0] = capsule(0.3, 0.02, 0.0025, 0);
        tools.capsules[1] = capsule(0.02, 0.0, 0.0012, 1);
        tools
    }

    /// Spheres of 7 mm under the skin at z = 0, spaced as in an organ, and their skin.
    fn organ() -> (SkinMesh, Vec<SphereRecord>, Vec<SphereState>) {
        let rest: Vec<SphereRecord> = (0..81)
            .map(|i| SphereRecord {
                center_m: [
                    (i % 9) as f32 * 0.014 - 0.056,
                    (i / 9) as f32 * 0.014 - 0.056,
                    -0.007,
                ],
                radius_m: 0.007,
                mass_kg: 0.001,
                held: 0,
            })
            .collect();
        let now = rest.iter().map(|s| SphereState {
            center_m: s.center_m,
            bits: 0,
        });
        let now = now.collect();
        let mesh = SkinMesh {
            outward: vec![Vec3::Z; rest.len()],
            ..SkinMesh::default()
        };
        (mesh, rest, now)
    }

    fn flat(i: usize) -> Vec3 {
        let at = |k: usize| (k as f32 - (SIDE / 2) as f32) * EDGE_M;
        Vec3::new(at(i % SIDE), at(i / SIDE), 0.0)
    }

    /// Neighbour distance as the skin computes it: diagonals are edges too.
    const AROUND_M: f32 = EDGE_M * 1.154_7 * super::super::FARTHEST;

    /// The skin's vertices under these presses.
    fn skin(presses: &[Press; PRESSES]) -> Vec<Vec3> {
        (0..SIDE * SIDE)
            .map(|i| flat(i) + pushed(presses, flat(i), Vec3::Z, AROUND_M))
            .collect()
    }

    proptest! {
        #[test]
        fn the_skin_lies_before_the_tool_and_never_cuts_through_it(
            x in -0.01f32..0.01, y in -0.01f32..0.01, depth_m in 0.001f32..0.02,
            lean in 0.0f32..0.9, turn in 0.0f32..6.3,
        ) {
            let back = Vec3::new(lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos());
            let tools = tool(Vec3::new(x, y, -depth_m), back, 1);
            let (mesh, rest, now) = organ();
            let skin = skin(&presses(&mesh, &rest, &STILL, &now, &tools));
            let capsules = tools.capsules().unwrap();
            for cell in (0..SIDE * SIDE).filter(|i| i % SIDE + 1 < SIDE && i / SIDE + 1 < SIDE) {
                let corners = [cell, cell + 1, cell + SIDE + 1, cell + SIDE].map(|i| skin[i]);
                for triangle in [[0, 1, 2], [0, 2, 3]] {
                    let [a, b, c] = triangle.map(|i: usize| corners[i]);
                    for k in 0..36 {
                        let (u, v) = ((k % 6) as f32 / 5.0, (k / 6) as f32 / 5.0);
                        if u + v > 1.0 { continue; }
                        let at = a + (b - a) * u + (c - a) * v;
                        for capsule in capsules {
                            let ends = [capsule.a_m, capsule.b_m].map(Vec3::from);
                            let gap = nearest(ends, at).distance(at) - capsule.radius_m;
                            prop_assert!(gap > -1.5e-4, "{at} is {gap} m off a capsule");
                        }
                    }
                }
            }
        }

        #[test]
        fn a_push_is_smooth_and_ends(depth_m in 0.001f32..0.02) {
            let tools = tool(Vec3::new(0.0, 0.0, -depth_m), Vec3::Z, 1);
            let (mesh, rest, now) = organ();
            let presses = presses(&mesh, &rest, &STILL, &now, &tools);
            let push = |x: f32| -pushed(&presses, Vec3::X * x, Vec3::Z, EDGE_M).z;
            prop_assert!((push(0.0) - depth_m - 0.0012).abs() < 1e-4, "{}", push(0.0));
            for k in 0..600 {
                let x = k as f32 * 1e-4;
                let fall = push(x) - push(x + 1e-4);
                // The steepest slope is less than 3.
                prop_assert!((-1e-6..3e-4).contains(&fall), "falls by {fall} m at {x} m");
            }
            prop_assert!(push(0.04) < 2e-5, "{} m at 40 mm", push(0.04));
        }
    }

    #[test]
    fn skin_is_pushed_only_from_outside_by_a_near_tool_that_touches_it() {
        let pushes = |tools: &ToolFrame, normal: Vec3, bits: u32| {
            let (mesh, rest, mut now) = organ();
            now[40].bits = bits;
            pushed(
                &presses(&mesh, &rest, &STILL, &now, tools),
                Vec3::ZERO,
                normal,
                EDGE_M,
            )
            .length()
        };
        let at = |z: f32, contacts| tool(Vec3::new(0.0, 0.0, z), Vec3::Z, contacts);
        assert!(pushes(&at(-0.01, 1), Vec3::Z, 0) > 0.009);
        for (tools, normal, bits) in [
            (at(-0.01, 0), Vec3::Z, 0),
            (at(-0.01, 1), Vec3::Z, SphereState::GRASPED),
            (at(-0.01, 1), Vec3::NEG_Z, 0),
            (at(0.02, 1), Vec3::Z, 0),
        ] {
            let pushed_m = pushes(&tools, normal, bits);
            assert!(pushed_m <= 0.0, "{pushed_m} m");
        }
    }
}
