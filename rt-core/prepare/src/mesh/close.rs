//! Closes open loops with patches.

use std::collections::HashMap;

use super::{Mesh, sides};
use crate::Vec3;

/// Loops of open edges. Each has its vertices in the order in which a patch runs along them.
pub(super) fn open_loops(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(|&t| sides(t)).collect();
    edges.sort_unstable();
    let open = edges
        .iter()
        .filter(|[a, b]| edges.binary_search(&[*b, *a]).is_err());
    // Along an open edge, a patch runs in the opposite direction to the triangle at that edge.
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut starts = Vec::new();
    for &[a, b] in open {
        next.entry(b).or_default().push(a);
        starts.push(b);
    }
    let mut loops = Vec::new();
    for start in starts {
        let mut walk: Vec<u32> = vec![start];
        while let Some(to) = next.get_mut(&walk[walk.len() - 1]).and_then(Vec::pop) {
            // Loops may touch in a vertex, so a loop is complete when the walk meets itself.
            match walk.iter().position(|&v| v == to) {
                Some(at) => {
                    let ring = walk.split_off(at);
                    walk.push(to);
                    loops.push(ring);
                }
                None => walk.push(to),
            }
        }
    }
    loops
}

/// Closes every loop: a loop of three edges with a triangle, a longer loop with rings of vertices
/// that shrink towards the middle and are then smoothed.
pub(super) fn fill(mesh: &mut Mesh, loops: &[Vec<u32>]) {
    for ring in loops {
        match ring.as_slice() {
            [] | [_] | [_, _] => {}
            &[a, b, c] => mesh.triangles.push([a, b, c]),
            ring => fill_with_rings(mesh, ring),
        }
    }
}

fn fill_with_rings(mesh: &mut Mesh, outer: &[u32]) {
    let points: Vec<Vec3> = outer.iter().map(|&i| mesh.vertices[i as usize]).collect();
    let count = points.len();
    let edge_m: f64 = (0..count)
        .map(|i| (points[(i + 1) % count] - points[i]).norm())
        .sum::<f64>()
        / count as f64;
    let middle = points.iter().sum::<Vec3>() / count as f64;
    let radius_m = points.iter().map(|p| (p - middle).norm()).sum::<f64>() / count as f64;
    let rings = ((radius_m / edge_m) as usize).clamp(1, 40);
    let first_new = mesh.vertices.len();
    let first_triangle = mesh.triangles.len();
    let mut previous: Vec<u32> = outer.to_vec();
    for ring in 1..rings {
        let inward = ring as f64 / rings as f64;
        let size = ((count as f64 * (1.0 - inward)).round() as usize).max(3);
        let mut current = Vec::with_capacity(size);
        for i in 0..size {
            let at = i as f64 / size as f64 * count as f64;
            let (low, share) = (at as usize, at.fract());
            let rim = points[low % count].lerp(&points[(low + 1) % count], share);
            current.push(mesh.vertices.len() as u32);
            mesh.vertices.push(rim.lerp(&middle, inward));
        }
        zip_rings(&mut mesh.triangles, &previous, &current);
        previous = current;
    }
    let tip = mesh.vertices.len() as u32;
    mesh.vertices.push(middle);
    for i in 0..previous.len() {
        mesh.triangles
            .push([previous[i], previous[(i + 1) % previous.len()], tip]);
    }
    smooth(mesh, first_new, first_triangle);
}

/// Adds triangles between two rings whose first vertices lie at the same angle.
fn zip_rings(triangles: &mut Vec<[u32; 3]>, outer: &[u32], inner: &[u32]) {
    let (n, m) = (outer.len(), inner.len());
    let (mut i, mut j) = (0, 0);
    while i < n || j < m {
        let outer_first = (i + 1) * m <= (j + 1) * n;
        if j >= m || (i < n && outer_first) {
            triangles.push([outer[i % n], outer[(i + 1) % n], inner[j % m]]);
            i += 1;
        } else {
            triangles.push([outer[i % n], inner[(j + 1) % m], inner[j % m]]);
            j += 1;
        }
    }
}

/// Moves the patch's own vertices to the mean of their neighbours, repeatedly.
fn smooth(mesh: &mut Mesh, first_new: usize, first_triangle: usize) {
    let patch = mesh.triangles[first_triangle..].to_vec();
    for _ in 0..60 {
        let mut sum = vec![(Vec3::zeros(), 0.0); mesh.vertices.len() - first_new];
        for [a, b] in patch.iter().flat_map(|&t| sides(t)) {
            if let Some(at) = (a as usize).checked_sub(first_new) {
                sum[at].0 += mesh.vertices[b as usize];
                sum[at].1 += 1.0;
            }
        }
        for (i, (total, weight)) in sum.into_iter().enumerate() {
            if weight > 0.0 {
                mesh.vertices[first_new + i] = total / weight;
            }
        }
    }
}
