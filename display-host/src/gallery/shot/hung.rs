//! The sutures that hang an organ on the abdominal wall: as they hold it, and one of them cut.

use glam::Vec3;
use shared_mem::scene::{AttachmentRecord, SceneFile, WORLD};

use super::{Chapter, Shot, is_free, nothing, sides};
use crate::render::camera::looking;

/// Distance of the camera, m; it looks at a place so far along the first suture, of its length.
const FAR_M: f32 = 0.055;
const ALONG: f32 = 0.3;
/// A suture is looked at across: no nearer to its own direction than this cosine.
const ACROSS: f32 = 0.6;

/// None if nothing hangs by a suture.
pub(super) fn shots(scene: &SceneFile) -> Vec<Shot> {
    let threads = scene.attachments().iter().filter(|tie| tie.is_thread != 0);
    let to_wall = |(_, tie): &(usize, &AttachmentRecord)| tie.b == WORLD;
    let Some((bit, first)) = threads.take(32).enumerate().find(to_wall) else {
        return Vec::new();
    };
    let [from, to] = [
        Vec3::from(scene.spheres()[first.a as usize].center_m),
        Vec3::from(first.anchor_m),
    ];
    let (middle, out) = (from.lerp(to, ALONG), (to - from).normalize_or(Vec3::Y));
    let eye = Vec3::from(scene.room().world_from_camera.position_m);
    let home = (eye - middle).normalize_or(Vec3::Z);
    let spheres: Vec<(Vec3, f32)> = (scene.spheres().iter())
        .map(|it| (Vec3::from(it.center_m), it.radius_m))
        .collect();
    let seen = |side: &Vec3| side.dot(out).abs() < ACROSS && is_free(middle, *side, &spheres);
    let nearest = |a: &Vec3, b: &Vec3| a.dot(home).total_cmp(&b.dot(home));
    let side = sides().filter(seen).max_by(nearest).unwrap_or(home);
    let tools = nothing(scene, looking(middle + side * FAR_M, middle));
    let shot = |title: &str, cut_sutures: u32| Shot {
        cut_sutures,
        ..Shot::new(Chapter::Instruments, title, tools)
    };
    vec![shot("Sutures", 0), shot("A suture cut through", 1 << bit)]
}
