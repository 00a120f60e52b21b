//! The separate pieces of a surface.

use std::collections::HashMap;

use super::{Mesh, sides};
use crate::field::Nearest;

/// Number of the piece to which each triangle belongs, and number of pieces. Triangles that share
/// an edge belong to one piece. Bodies that touch only in a corner are separate pieces.
pub(super) fn pieces(mesh: &Mesh) -> (Vec<usize>, usize) {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (i, &t) in (0..).zip(&mesh.triangles) {
        edges.extend(sides(t).map(|[a, b]| ([a.min(b), a.max(b)], i)));
    }
    edges.sort_unstable();
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [a, b] = [pair[0].1, pair[1].1].map(|i| root(&mut parent, i));
        parent[a.max(b) as usize] = a.min(b);
    }
    let mut number: HashMap<u32, usize> = HashMap::new();
    let of_triangle = (0..mesh.triangles.len() as u32)
        .map(|i| {
            let next = number.len();
            *number.entry(root(&mut parent, i)).or_insert(next)
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
    // All pieces share one table of new indices. A scanned organ may have thousands of specks, and
    // a table for each would take too long.
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

/// For each piece except the largest, the smallest distance of its vertices from the surfaces of
/// larger pieces, m.
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
