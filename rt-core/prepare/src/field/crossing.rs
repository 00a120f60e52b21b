//! Crossings of grid lines with closed surfaces. Along each grid line parallel to x, the winding
//! number rises by one where the line enters a body and falls by one where it leaves.

use super::Grid;
use crate::Vec3;
use crate::mesh::Mesh;

/// Shares of a cell by which grid lines are shifted along y and z, so that they miss the vertices
/// and edges of meshes with round coordinates.
const SHIFT: [f64; 2] = [1.234_567e-4, -2.345_678e-4];

/// A crossing: its place along the line, in cells, and the change of the winding number there.
type Crossing = (f64, i32);

/// For each grid point, true if it lies inside (winding number above zero).
pub(super) fn inside(mesh: &Mesh, grid: &Grid) -> Vec<bool> {
    let mut inside = vec![false; grid.len()];
    let rows = crossings(mesh, grid);
    for (row, line) in rows.iter().zip(inside.chunks_mut(grid.size[0])) {
        let mut winding = 0;
        let mut next = row.iter().peekable();
        for (x, cell) in line.iter_mut().enumerate() {
            while let Some((_, step)) = next.next_if(|(at, _)| *at <= x as f64) {
                winding += step;
            }
            *cell = winding > 0;
        }
    }
    inside
}

/// Volume that a closed surface encloses, and the volume that it encloses more than once or inside
/// out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlap {
    /// Volume with a winding number above zero, m³.
    pub(crate) enclosed_m3: f64,
    /// Volume that is enclosed more than once, added for each further time, and volume inside a
    /// part turned inside out, m³.
    pub(crate) doubled_m3: f64,
    /// Middle of the longest stretch of a grid line in this doubled volume, m.
    pub(crate) at: Vec3,
}

/// Measures how a surface overlaps itself, along the grid lines. The lengths along x are exact.
#[must_use]
pub(crate) fn overlap(mesh: &Mesh, grid: &Grid) -> Overlap {
    let (mut enclosed, mut doubled, mut longest) = (0.0, 0.0, 0.0);
    let mut at = Vec3::zeros();
    for (number, row) in crossings(mesh, grid).iter().enumerate() {
        let mut winding = 0;
        for pair in row.windows(2) {
            let [(from, step), (to, _)] = [pair[0], pair[1]];
            winding += step;
            let length = to - from;
            if winding > 0 {
                enclosed += length;
            }
            if !(0..=1).contains(&winding) {
                doubled += length * f64::from(if winding > 1 { winding - 1 } else { -winding });
                if length > longest {
                    longest = length;
                    let line = grid.position([0, number % grid.size[1], number / grid.size[1]]);
                    at = line + Vec3::x() * ((from + to) / 2.0 * grid.cell_m);
                }
            }
        }
    }
    let cell_m3 = grid.cell_m.powi(3);
    Overlap {
        enclosed_m3: enclosed * cell_m3,
        doubled_m3: doubled * cell_m3,
        at,
    }
}

/// Stretches of the grid lines that lie inside both surfaces: the middle and the length of each, m.
#[must_use]
pub(crate) fn shared_stretches(one: &Mesh, other: &Mesh, grid: &Grid) -> Vec<(Vec3, f64)> {
    let rows = crossings(one, grid).into_iter().zip(crossings(other, grid));
    let mut found = Vec::new();
    for (number, (one, other)) in rows.enumerate() {
        if one.is_empty() || other.is_empty() {
            continue;
        }
        let marked = |row: Vec<Crossing>, which: usize| row.into_iter().map(move |it| (it, which));
        let mut both: Vec<(Crossing, usize)> = marked(one, 0).chain(marked(other, 1)).collect();
        both.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let mut winding = [0; 2];
        for pair in both.windows(2) {
            let [((from, step), which), ((to, _), _)] = [pair[0], pair[1]];
            winding[which] += step;
            if winding.iter().all(|it| *it > 0) && to > from {
                let line = grid.position([0, number % grid.size[1], number / grid.size[1]]);
                let middle = line + Vec3::x() * ((from + to) / 2.0 * grid.cell_m);
                found.push((middle, (to - from) * grid.cell_m));
            }
        }
    }
    found
}

/// For each grid line, its crossings in order. The winding number changes by +1 where the line
/// enters the body, by −1 where it leaves.
fn crossings(mesh: &Mesh, grid: &Grid) -> Vec<Vec<Crossing>> {
    let mut crossings: Vec<Vec<Crossing>> = vec![Vec::new(); grid.size[1] * grid.size[2]];
    let shift = [SHIFT[0] * grid.cell_m, SHIFT[1] * grid.cell_m];
    for &triangle in &mesh.triangles {
        let p = mesh.corners(triangle);
        let bound = |k: usize, pick: fn(f64, f64) -> f64| pick(pick(p[0][k], p[1][k]), p[2][k]);
        let ys = grid.span(
            1,
            bound(1, f64::min) - shift[0],
            bound(1, f64::max) - shift[0],
        );
        let zs = grid.span(
            2,
            bound(2, f64::min) - shift[1],
            bound(2, f64::max) - shift[1],
        );
        for z in zs {
            for y in ys.clone() {
                let line = grid.position([0, y, z]);
                let at = [line.y + shift[0], line.z + shift[1]];
                let side = |i: usize, j: usize| edge(&p, triangle, i, j, at);
                let (u, v, w) = (side(1, 2), side(2, 0), side(0, 1));
                let all_in = u >= 0.0 && v >= 0.0 && w >= 0.0;
                let all_out = u < 0.0 && v < 0.0 && w < 0.0;
                let area = u + v + w;
                if (all_in || all_out) && area != 0.0 {
                    let x = (p[0].x * u + p[1].x * v + p[2].x * w) / area;
                    let cells = (x - grid.origin.x) / grid.cell_m;
                    // A triangle whose area in the yz plane is positive faces +x, so the line
                    // leaves the body through it.
                    let step = if area > 0.0 { -1 } else { 1 };
                    crossings[y + grid.size[1] * z].push((cells, step));
                }
            }
        }
    }
    for row in &mut crossings {
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    crossings
}

/// Twice the signed area between a triangle's edge and a point, in the yz plane. The sign says on
/// which side of the edge the point lies. Both triangles at an edge compute the area from the same
/// end of the edge, so that no point falls between the triangles or into both.
fn edge(p: &[Vec3; 3], triangle: [u32; 3], i: usize, j: usize, at: [f64; 2]) -> f64 {
    let area = |a: &Vec3, b: &Vec3| (b.y - a.y) * (at[1] - a.z) - (b.z - a.z) * (at[0] - a.y);
    if triangle[i] < triangle[j] {
        area(&p[i], &p[j])
    } else {
        -area(&p[j], &p[i])
    }
}
