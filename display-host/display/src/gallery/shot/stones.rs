//! Gallstones on tissue, for pictures.

use glam::{Quat, Vec3};
use shared_mem::message::StoneMsg;
use shared_mem::scene::{CellRecord, SceneFile};

use crate::effects::chance;

/// Distance from the place within which stones lie, m.
const AROUND_M: f32 = 0.022;
/// Least cosine between the skin's normal and the direction against gravity where a stone lies.
const LEVEL: f32 = 0.35;

/// Stones of this radius that lie on the tissue at rest around a place, the nearest first. There
/// are fewer than `count` if there is no room.
#[must_use]
pub fn lying(scene: &SceneFile, at_m: Vec3, count: usize, radius_m: f32) -> Vec<StoneMsg> {
    let up = (-Vec3::from(scene.room().gravity_m_s2)).normalize_or(Vec3::Y);
    let skin = scene.vertices().iter();
    let mut places: Vec<(f32, Vec3)> = skin
        .map(|it| (Vec3::from(it.position_m), Vec3::from(it.normal)))
        .filter(|(_, normal)| normal.dot(up) > LEVEL)
        .map(|(place, normal)| (place.distance(at_m), place + normal * radius_m))
        .filter(|(far_m, _)| *far_m < AROUND_M)
        .collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_free = |at: Vec3| {
        let in_tissue = scene.spheres().iter().any(|it| {
            let far_m = Vec3::from(it.center_m).distance(at);
            far_m < it.radius_m + 0.8 * radius_m
        });
        let in_cells = |it: &CellRecord| Vec3::from(it.center_m).distance(at) < 0.8 * radius_m;
        !in_tissue && !scene.cells().iter().any(in_cells)
    };
    let mut stones: Vec<StoneMsg> = Vec::new();
    for (_, at) in places {
        let apart = |it: &StoneMsg| Vec3::from(it.at_m).distance(at) > 2.02 * radius_m;
        if stones.len() < count && stones.iter().all(apart) && is_free(at) {
            let number = stones.len() as u32;
            let turn = chance(number).extend(chance(number + 99).x);
            stones.push(StoneMsg {
                at_m: at.to_array(),
                radius_m,
                orientation: Quat::from_vec4(turn.normalize()).to_array(),
                number,
                is_held: 0,
            });
        }
    }
    stones
}
