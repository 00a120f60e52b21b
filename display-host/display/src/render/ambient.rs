//! Ambient light at rest. The spheres of all organs shade each vertex, and a share of the cavity's
//! light reaches it. The share is computed once, when the scene loads.

use glam::Vec3;
use shared_mem::scene::SphereRecord;

use crate::skinning::{RestVertex, SkinMesh};

/// Rays per vertex.
const RAYS: usize = 48;
/// Distance beyond which a sphere casts no shade, m.
const REACH_M: f32 = 0.045;

/// Multiplies [`RestVertex::ambient`] by the open share. The open share is the mean length of rays
/// from the vertex to the nearest sphere, of at most [`REACH_M`], as a share of [`REACH_M`]. The
/// cost is O(vertices · (spheres + rays · near spheres)), on every core that the process may use.
pub(super) fn bake(mesh: &mut SkinMesh, spheres: &[SphereRecord]) {
    let directions = hemisphere();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let share = mesh.vertices.len().div_ceil(cores).max(1);
    std::thread::scope(|scope| {
        for part in mesh.vertices.chunks_mut(share) {
            let directions = &directions;
            scope.spawn(move || {
                for vertex in part {
                    vertex.ambient *= open_share(vertex, spheres, directions);
                }
            });
        }
    });
    smooth(mesh);
}

fn open_share(vertex: &RestVertex, spheres: &[SphereRecord], directions: &[Vec3]) -> f32 {
    let at = Vec3::from(vertex.position);
    let normal = Vec3::from(vertex.normal);
    let from = at + normal * 0.0005;
    let near: Vec<(Vec3, f32)> = spheres
        .iter()
        .map(|s| (Vec3::from(s.center_m) - from, s.radius_m))
        .filter(|(to, radius)| {
            let before = to.dot(normal) > -0.9 * radius;
            before && to.length_squared() < (REACH_M + radius) * (REACH_M + radius)
        })
        .collect();
    if near.is_empty() {
        return 1.0;
    }
    let side = normal.any_orthonormal_vector();
    let up = normal.cross(side);
    let mut open = 0.0;
    for d in directions {
        let ray = side * d.x + up * d.y + normal * d.z;
        let hit = near.iter().filter_map(|(to, radius)| {
            let along = to.dot(ray);
            let miss2 = to.length_squared() - along * along;
            let depth2 = radius * radius - miss2;
            let entry = along - depth2.max(0.0).sqrt();
            (along > 0.0 && depth2 > 0.0 && entry < REACH_M).then_some(entry.max(0.0))
        });
        let nearest = hit.fold(REACH_M, f32::min);
        open += nearest / REACH_M;
    }
    // The exponent makes gaps darker than their open share, because a gap absorbs part of the light
    // on its way.
    (open / directions.len() as f32).powf(1.4)
}

/// Directions about +z with cosine-weighted density, so that all rays count equally.
fn hemisphere() -> Vec<Vec3> {
    (0..RAYS)
        .map(|i| {
            let share = (i as f32 + 0.5) / RAYS as f32;
            let turn = i as f32 * 2.399_963_2;
            let flat = share.sqrt();
            Vec3::new(flat * turn.cos(), flat * turn.sin(), (1.0 - share).sqrt())
        })
        .collect()
}

/// Averages each vertex twice with its neighbours, because so few rays leave noise.
fn smooth(mesh: &mut SkinMesh) {
    for _ in 0..2 {
        let before: Vec<f32> = mesh.vertices.iter().map(|v| v.ambient).collect();
        for (i, vertex) in mesh.vertices.iter_mut().enumerate() {
            let ring = &mesh.ring[mesh.ring_first[i] as usize..mesh.ring_first[i + 1] as usize];
            let corners = ring.iter().flat_map(|&t| mesh.triangles[t as usize]);
            let (sum, count) = corners.fold((before[i], 1.0), |(sum, count), v| {
                (sum + before[v as usize], count + 1.0)
            });
            vertex.ambient = sum / count;
        }
    }
}
