//! Merges vertices that are split along seams, and drops degenerate and repeated triangles.

use std::collections::{HashMap, HashSet};

use super::Mesh;
use crate::Vec3;

/// Counts of merged vertices and dropped triangles.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Welded {
    pub(super) merged: usize,
    pub(super) degenerate: usize,
    pub(super) duplicate: usize,
}

/// Merges vertices that are at most `tolerance_m` apart. Then drops triangles of which two corners
/// merged, triangles that repeat another one (in either direction), and vertices that no triangle
/// uses.
pub(super) fn weld(mesh: &Mesh, tolerance_m: f64) -> (Mesh, Welded) {
    let mut report = Welded::default();
    let mut kept: Vec<Vec3> = Vec::new();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    // Cells are much larger than the tolerance, so that nearly every lookup stays in one cell.
    let cell_m = 64.0 * tolerance_m;
    let cell = |x: f64| (x / cell_m).floor() as i64;
    let mut new_index = Vec::with_capacity(mesh.vertices.len());
    for p in &mesh.vertices {
        let low = p.map(|x| cell(x - tolerance_m));
        let high = p.map(|x| cell(x + tolerance_m));
        let mut found = None;
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let near = cells.get(&[x, y, z]).into_iter().flatten();
                    let near = near.filter(|&&i| (kept[i as usize] - p).norm() <= tolerance_m);
                    found = near.copied().chain(found).min();
                }
            }
        }
        new_index.push(found.unwrap_or_else(|| {
            let index = kept.len() as u32;
            kept.push(*p);
            cells
                .entry([cell(p.x), cell(p.y), cell(p.z)])
                .or_default()
                .push(index);
            index
        }));
    }
    report.merged = mesh.vertices.len() - kept.len();

    let mut seen = HashSet::new();
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for t in &mesh.triangles {
        let t = t.map(|i| new_index[i as usize]);
        if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
            report.degenerate += 1;
            continue;
        }
        let mut corners = t;
        corners.sort_unstable();
        if seen.insert(corners) {
            triangles.push(t);
        } else {
            report.duplicate += 1;
        }
    }
    let welded = Mesh {
        vertices: kept,
        triangles,
    };
    (welded.without_unused(), report)
}
