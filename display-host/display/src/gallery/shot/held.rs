//! Tissue in the jaws: a fold of the gallbladder, grasped and pulled away.

use glam::Vec3;
use shared_mem::message::SphereState;
use shared_mem::scene::{OrganKind, SceneFile};

use super::{Chapter, Shot, is_free, judges, near, others};

/// Displacement of the fold, m.
const DRAWN_M: f32 = 0.008;
/// Distance from the fold, m, at which tissue moves by 1/e of the fold's displacement.
const FOLLOWS_M: f32 = 0.014;
/// Depth of the tips below the displaced skin, m.
const UNDER_M: f32 = 0.002;
/// Opening of jaws that hold a fold: 0 is closed, 1 is open.
const JAW: f32 = 0.12;

/// The picture. `None` if there is no gallbladder, or other organs hide it from the port.
pub(super) fn shot(scene: &SceneFile) -> Option<Shot> {
    let is_it = |kind: u32| kind == OrganKind::Gallbladder as u32;
    let bladder = scene.organs().iter().find(|it| is_it(it.kind))?;
    let port = Vec3::from(scene.room().instrument_port_m);
    let others = others(scene, bladder);
    // The fold lies at the visible place that faces the port best.
    let judges = judges(scene, bladder);
    let free = judges
        .iter()
        .filter(|(at, _)| is_free(*at, (port - *at).normalize_or_zero(), &others));
    let faces = |(at, normal): &(Vec3, Vec3)| normal.dot((port - *at).normalize_or_zero());
    let (at, normal) = *free.max_by(|a, b| faces(a).total_cmp(&faces(b)))?;
    let own = bladder.spheres[0]..bladder.spheres[0] + bladder.spheres[1];
    let spheres = (0u32..).zip(scene.spheres()).map(|(number, sphere)| {
        let center = Vec3::from(sphere.center_m);
        let x = center.distance(at) / FOLLOWS_M;
        let share = if own.contains(&number) {
            (-x * x).exp()
        } else {
            0.0
        };
        SphereState {
            center_m: (center + normal * (DRAWN_M * share)).to_array(),
            bits: SphereState::AWAKE | if share > 0.8 { SphereState::GRASPED } else { 0 },
        }
    });
    let tip = at + normal * (DRAWN_M - UNDER_M);
    Some(Shot {
        spheres: Some(spheres.collect()),
        ..Shot::new(
            Chapter::Instruments,
            "Tissue in the jaws",
            near(scene, (tip, normal), 0, JAW),
        )
    })
}
