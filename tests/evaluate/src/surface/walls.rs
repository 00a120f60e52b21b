//! Finds pairs of vertices on opposite walls of a thin organ.

use std::collections::HashMap;

use display_host::skinning::SkinMesh;
use glam::{IVec3, Vec3};

/// Largest thickness between walls that are compared, m.
const THICK_MAX_M: f32 = 0.012;
/// Smallest thickness, m, because nearer vertices lie on one edge of the organ.
const THICK_MIN_M: f32 = 0.0005;
/// Largest distance of the opposite vertex from the line along the normal, m.
const ASIDE_M: f32 = 0.0015;
/// Largest cosine between the normals of opposite walls.
const OPPOSITE: f32 = -0.7;

/// Pairs of a vertex and the nearest vertex behind it on the opposite wall.
pub(super) fn opposites(mesh: &SkinMesh, vertices: &[u32]) -> Vec<[u32; 2]> {
    let at = |v: u32| Vec3::from(mesh.vertices[v as usize].position);
    let normal = |v: u32| Vec3::from(mesh.vertices[v as usize].normal);
    let side_m = 2.0 * ASIDE_M;
    let cell = |p: Vec3| (p / side_m).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
    for &v in vertices {
        cells.entry(cell(at(v))).or_default().push(v);
    }
    let behind = |v: u32| {
        let steps = (THICK_MAX_M / side_m) as i32 + 1;
        (0..=steps).find_map(|step| {
            let middle = cell(at(v) - normal(v) * (step as f32 * side_m));
            let around = (-1..=1).flat_map(|x| {
                (-1..=1).flat_map(move |y| (-1..=1).map(move |z| middle + IVec3::new(x, y, z)))
            });
            let near = around.filter_map(|c| cells.get(&c)).flatten().copied();
            let depth = |w: u32| (at(v) - at(w)).dot(normal(v));
            let is_behind = |w: &u32| {
                let deep = depth(*w);
                let aside = (at(v) - at(*w) - normal(v) * deep).length();
                (THICK_MIN_M..THICK_MAX_M).contains(&deep)
                    && aside < ASIDE_M
                    && normal(v).dot(normal(*w)) < OPPOSITE
            };
            let candidates = near.filter(is_behind);
            candidates.min_by(|a, b| depth(*a).total_cmp(&depth(*b)))
        })
    };
    let pair = |v: &u32| Some([*v, behind(*v)?]);
    vertices.iter().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use display_host::skinning::RestVertex;

    #[test]
    fn the_vertices_of_a_plate_face_each_other_and_those_of_a_block_do_not() {
        let plate = |thick_m: f32| {
            let vertex = |i: usize| RestVertex {
                position: [
                    (i % 5) as f32 * 0.002,
                    (i / 5 % 5) as f32 * 0.002,
                    if i < 25 { 0.0 } else { -thick_m },
                ],
                normal: [0.0, 0.0, if i < 25 { 1.0 } else { -1.0 }],
                ..bytemuck::Zeroable::zeroed()
            };
            SkinMesh {
                vertices: (0..50).map(vertex).collect(),
                ..SkinMesh::default()
            }
        };
        let all: Vec<u32> = (0..50).collect();
        let pairs = opposites(&plate(0.004), &all);
        assert_eq!(pairs.len(), 50);
        assert!(pairs.iter().all(|[a, b]| a % 25 == b % 25), "{pairs:?}");
        assert!(opposites(&plate(0.03), &all).is_empty());
    }
}
