//! Finds the ends of ducts and vessels that lie on other organs.

use glam::Vec3;
use shared_mem::scene::{OrganKind, SceneFile};

/// Distance from the end's sphere within which another organ's skin counts as joined, m.
const REACH_M: f32 = 0.012;

/// An end of a tube on another organ.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) sphere: u32,
    /// Vertex of the other organ nearest to the sphere at rest.
    pub(super) vertex: u32,
    /// Distance between both at rest, m.
    pub(super) rest_m: f32,
}

/// The ends of a tube: spheres whose neighbours all lie on one side and that are near the skin of
/// another organ. Empty for an organ that is no tube.
pub(super) fn ends(scene: &SceneFile, organ: usize) -> Vec<End> {
    let tubes = [
        OrganKind::BileDuct,
        OrganKind::CysticArtery,
        OrganKind::CysticDuct,
        OrganKind::Vessel,
    ];
    let own = &scene.organs()[organ];
    if tubes.iter().all(|kind| own.kind != *kind as u32) {
        return Vec::new();
    }
    let [first, count] = own.links.map(|x| x as usize);
    let links = &scene.links()[first..first + count];
    let neighbours = |sphere: u32| {
        let joins = links.iter().filter(|l| l.a == sphere || l.b == sphere);
        let mut others: Vec<u32> = joins
            .map(|l| if l.a == sphere { l.b } else { l.a })
            .collect();
        others.sort_unstable();
        others.dedup();
        others
    };
    let at = |sphere: u32| Vec3::from(scene.spheres()[sphere as usize].center_m);
    // Links also join each sphere to the next but one, so an end may have two neighbours.
    let is_end = |sphere: &u32| {
        let others = neighbours(*sphere);
        let ways = others
            .iter()
            .map(|o| (at(*o) - at(*sphere)).normalize_or_zero());
        let ways: Vec<Vec3> = ways.collect();
        !ways.is_empty() && ways.iter().all(|a| ways.iter().all(|b| a.dot(*b) > 0.3))
    };
    let soft = [OrganKind::Fat as u32, OrganKind::ConnectiveTissue as u32];
    let range = own.spheres[0]..own.spheres[0] + own.spheres[1];
    let joined = |sphere: u32| {
        let others = (scene.organs().iter().enumerate())
            .filter(|(number, it)| *number != organ && !soft.contains(&it.kind));
        let skins = others.flat_map(|(_, it)| it.vertices[0]..it.vertices[0] + it.vertices[1]);
        let away =
            |v: u32| at(sphere).distance(Vec3::from(scene.vertices()[v as usize].position_m));
        let nearest = skins
            .map(|v| (v, away(v)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        (nearest.1 < REACH_M).then_some(End {
            sphere,
            vertex: nearest.0,
            rest_m: nearest.1,
        })
    };
    range.filter(is_end).filter_map(joined).collect()
}
