//! The separate pieces of a surface.

use std::collections::HashMap;

use super::Mesh;
use crate::field::Nearest;

/// The piece to which each triangle belongs, and the number of pieces. Triangles that share a
/// vertex belong to one piece.
pub(super) fn pieces(mesh: &Mesh) -> (Vec<usize>, usize) {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for t in &mesh.triangles {
        let a = root(&mut parent, t[0]);
        for &other in &t[1..] {
            let b = root(&mut parent, other);
            parent[b as usize] = a;
        }
    }
    let mut number: HashMap<u32, usize> = HashMap::new();
    let of_triangle = mesh
        .triangles
        .iter()
        .map(|t| {
            let next = number.len();
            *number.entry(root(&mut parent, t[0])).or_insert(next)
        })
        .collect();
    (of_triangle, number.len())
}

/// Each piece as a mesh of its own.
pub(super) fn piece_meshes(mesh: &Mesh) -> Vec<Mesh> {
    let (of_triangle, count) = pieces(mesh);
    let mut triangles = vec![Vec::new(); count];
    for (t, &piece) in mesh.triangles.iter().zip(&of_triangle) {
        triangles[piece].push(*t);
    }
    // All pieces share one table, because a scanned organ may come with thousands of specks.
    let mut new_index = vec![0u32; mesh.vertices.len()];
    let mut alone = |triangles: Vec<[u32; 3]>| {
        let mut used = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for (new, &old) in (0..).zip(&used) {
            new_index[old as usize] = new;
        }
        let shifted = triangles.iter().map(|t| t.map(|i| new_index[i as usize]));
        Mesh {
            triangles: shifted.collect(),
            vertices: used.iter().map(|&i| mesh.vertices[i as usize]).collect(),
        }
    };
    triangles.into_iter().map(&mut alone).collect()
}

/// Distance of each piece except the largest from the nearest larger one, m. It is measured from
/// the piece's vertices to the larger one's surface.
pub(super) fn gaps(mesh: &Mesh) -> Vec<f64> {
    let mut all = piece_meshes(mesh);
    all.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    let mut larger = Mesh::default();
    let mut gaps = Vec::new();
    for piece in &all {
        if let Some(nearest) = Nearest::new(&larger) {
            let distances = piece.vertices.iter().map(|p| nearest.distance(p));
            gaps.push(distances.fold(f64::INFINITY, f64::min));
        }
        larger.append(piece);
    }
    gaps
}
