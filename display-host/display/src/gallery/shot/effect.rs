//! Pictures of effects: site, viewpoint and instrument of each.

use glam::{Quat, Vec3};
use shared_mem::message::{CapsuleMsg, PoseMsg, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};

use super::{Chapter, Shot, best_side, bounds, camera_only, is_free, judges, lying, others};
use crate::effects::{Effect, Flow, Kind};
use crate::render::camera::upright;

/// Position of the hook's tip relative to its joint, m.
const HOOK_TIP_M: Vec3 = Vec3::new(0.0, -0.0042, -0.0119);

/// Number of the stones in a picture, and their radius, m.
const STONES: usize = 9;
const STONE_RADIUS_M: f32 = 0.002_5;

/// Clearance between the line of sight and the spheres of an organ, m.
const CLEAR_M: f32 = 0.004;

/// A picture of each effect at its usual site, some time after its start. The hook touches the
/// tissue that burns. Blood and bile are seen from the side of the flow. Gravity points down.
pub(super) fn all(scene: &SceneFile) -> Vec<Shot> {
    use OrganKind as Organ;
    let burns = Site::on(scene, &[Organ::Fat, Organ::ConnectiveTissue, Organ::Liver]);
    let bleeds = Site::on(scene, &[Organ::CysticArtery, Organ::Vessel, Organ::Liver]);
    let leaks = Site::on(
        scene,
        &[Organ::Gallbladder, Organ::CysticDuct, Organ::Liver],
    );
    let rules = assess::Rules::default();
    let up = (-Vec3::from(scene.room().gravity_m_s2)).normalize_or(Vec3::Y);
    let burnt = vec![Kind::Smoke, Kind::Steam, Kind::Char];
    let kinds = [
        ("Smoke", vec![Kind::Smoke], 1.1, burns),
        ("Coagulation", burnt, 0.8, burns),
        ("Dense smoke", vec![Kind::Smoke], 20.0, burns),
        ("Sparks of a cut", vec![Kind::Sparks], 0.15, burns),
        ("Fresh bleeding", vec![Kind::Blood], 0.25, bleeds),
        ("Older bleeding", vec![Kind::Blood], 12.0, bleeds),
        ("Bile", vec![Kind::Bile], 12.0, leaks),
        ("Spilled stones", vec![Kind::Bile], 12.0, leaks),
    ];
    let shots = kinds
        .into_iter()
        .filter_map(|(title, kinds, seconds, site)| {
            let Site { at, out, from, .. } = site;
            let is_wet = matches!(kinds[0], Kind::Blood | Kind::Bile);
            let is_burnt = matches!(kinds[0], Kind::Smoke | Kind::Sparks);
            let begin = kinds.into_iter().map(|kind| Effect {
                kind,
                at_m: at + out * 0.001,
                along: out + 0.4 * up,
                strength: 1.0,
                lasts_s: if is_wet {
                    Effect::LEAK_S
                } else {
                    seconds + 2.0
                },
                flow: match site.organ.filter(|_| is_wet) {
                    Some(organ) => Flow::of_organ(&rules, organ),
                    None => Flow::default(),
                },
            });
            let begin = begin.collect();
            let far_m = if is_wet { 0.075 } else { 0.06 };
            let world_from_camera = upright(at + from * far_m, at - up * 0.004, up);
            let tools = match is_burnt {
                true => hook_at(scene, at, from, world_from_camera),
                false => camera_only(scene, world_from_camera),
            };
            let has_stones = title == "Spilled stones";
            let stones = match has_stones {
                true => lying(scene, at, STONES, STONE_RADIUS_M),
                false => Vec::new(),
            };
            // Where no stone finds room, the picture would be that of the bile.
            if has_stones && stones.is_empty() {
                return None;
            }
            Some(Shot {
                stones,
                effects: (begin, seconds),
                ..Shot::new(Chapter::Effects, title, tools)
            })
        });
    shots.collect()
}

/// A site on an organ, its outward direction, and the direction of view.
#[derive(Clone, Copy)]
struct Site {
    organ: Option<OrganKind>,
    at: Vec3,
    out: Vec3,
    from: Vec3,
}

impl Site {
    /// A visible site on the first of these organs that the scene has, or else the scene's target.
    fn on(scene: &SceneFile, kinds: &[OrganKind]) -> Self {
        let room = scene.room();
        let organs = scene.organs();
        let found = kinds
            .iter()
            .find_map(|kind| organs.iter().find(|organ| organ.kind == *kind as u32));
        let eye = Vec3::from(room.world_from_camera.position_m);
        let site = found.and_then(|organ| {
            let side = best_side(scene, organ, true);
            let others = others(scene, organ);
            let judges = judges(scene, organ);
            let (low, high) = bounds(&judges);
            let middle = (low + high) / 2.0 + side * (high - low).length() / 4.0;
            let seen = judges
                .into_iter()
                .filter(|(at, normal)| normal.dot(side) > 0.5 && is_free(*at, side, &others));
            let near = |it: &(Vec3, Vec3)| it.0.distance_squared(middle);
            let (at, out) = seen.min_by(|a, b| near(a).total_cmp(&near(b)))?;
            Some((at, out, side))
        });
        let (at, out, side) = site.unwrap_or_else(|| {
            let at = Vec3::from(room.target_m);
            let out = Vec3::from(room.target_normal).normalize_or(Vec3::Y);
            (at, out, (eye - at).normalize_or(out))
        });
        // The camera does not look along the path of the particles if another direction is free.
        let beside = side
            .reject_from(out)
            .normalize_or(out.any_orthonormal_vector());
        let over = out.cross(beside);
        let hides = found.map_or_else(Vec::new, |organ| others(scene, organ));
        let wider: Vec<_> = hides.iter().map(|(at, r)| (*at, r + CLEAR_M)).collect();
        let ways = [beside, over, -over, -beside].map(|way| (side + 0.6 * way).normalize_or(side));
        let free = ways.into_iter().find(|from| is_free(at, *from, &wider));
        let from = free.unwrap_or(side);
        let organ = found.and_then(|organ| OrganKind::from_u32(organ.kind));
        Self {
            organ,
            at,
            out,
            from,
        }
    }
}

/// Tools with the hook's tip on a visible place `at`, for the camera at `world_from_camera`.
fn hook_at(scene: &SceneFile, at: Vec3, from: Vec3, world_from_camera: PoseMsg) -> ToolFrame {
    let port = Vec3::from(scene.room().instrument_port_m);
    let mut tools = camera_only(scene, world_from_camera);
    // The hook comes from its port, but is turned towards the viewer so that no tissue hides it.
    let back = ((port - at).normalize_or(from) + from).normalize_or(from);
    let x = from
        .reject_from(back)
        .normalize_or(back.any_orthonormal_vector());
    let turn = Quat::from_mat3(&glam::Mat3::from_cols(x, back.cross(x), back));
    let joint = at - turn * HOOK_TIP_M;
    tools.world_from_instrument = PoseMsg {
        position_m: joint.to_array(),
        orientation: turn.normalize().to_array(),
    };
    tools.world_from_handle = tools.world_from_instrument;
    tools.instrument = 1;
    let capsule = |a: Vec3, b: Vec3, radius_m, role| CapsuleMsg {
        a_m: a.to_array(),
        radius_m,
        b_m: b.to_array(),
        role,
    };
    tools.capsule_count = 2;
    tools.capsules[0] = capsule(joint + back * 0.3, joint, 0.0025, 0);
    tools.capsules[1] = capsule(joint, at, 0.0006, 3);
    tools
}
