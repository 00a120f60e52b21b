//! Sutures that suspend an organ from the abdominal wall: all intact, the first one cut, and the
//! first one on its way to the wall.

use glam::Vec3;
use shared_mem::message::SutureMsg;
use shared_mem::scene::SceneFile;

use super::{Chapter, Shot, camera_only, is_free, sides};
use crate::render::camera::looking;
use crate::render::sutures::given;

/// Distance from the camera to the point at which it looks, m.
const FAR_M: f32 = 0.055;
/// Share of the way along the first suture, from the organ, at which the point lies that the camera
/// looks at.
const ALONG: f32 = 0.3;
/// Largest cosine of the angle between the direction of view and the suture, so that the suture is
/// seen from the side.
const ACROSS: f32 = 0.6;

/// The pictures; empty if no organ hangs by a suture.
pub(super) fn shots(scene: &SceneFile) -> Vec<Shot> {
    let given = given(scene);
    let Some(first) = given.first() else {
        return Vec::new();
    };
    let [from, to] = [
        Vec3::from(scene.spheres()[first.sphere as usize].center_m),
        Vec3::from(first.at_m),
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
    let tools = camera_only(scene, looking(middle + side * FAR_M, middle));
    let shot = |title: &str, placed: u32, at_m: Vec3| {
        let mut sutures = given.clone();
        sutures[0].placed = placed;
        sutures[0].at_m = at_m.into();
        Shot {
            sutures: Some(sutures),
            ..Shot::new(Chapter::Instruments, title, tools)
        }
    };
    // The free end is at a place to which an instrument outside the picture could have carried it.
    let carried = middle.lerp(to, 0.2) + side.cross(out) * 0.01;
    vec![
        shot("Sutures", SutureMsg::HUNG, to),
        shot("A divided suture", SutureMsg::CUT, to),
        shot(
            "A suture on its way to the wall",
            SutureMsg::AT_HAND,
            carried,
        ),
    ]
}
