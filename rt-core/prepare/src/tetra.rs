//! Tetrahedra between sphere centres. Tissue outside all of them is counted with the nearest one,
//! so their volumes sum to the organ's.

use crate::Vec3;
use crate::delaunay;
use crate::held::Plane;
use crate::order;
use crate::pack::{Ball, Interior};

/// Smallest `V/L³` (volume over the cube of the longest edge) of a tetrahedron. A regular one has
/// 0.118. A tetrahedron below this limit is a sliver: it is so flat that the solver's rounding
/// errors grow in it. With slivers down to 0.006, a gallbladder at rest moved by a millimetre in
/// half a second; with this limit it moved by 20 nm.
pub const SHAPE_MIN: f64 = 0.015;

/// A tetrahedron of four spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tetra {
    /// The corners a, b, c, d. `det(b − a, c − a, d − a)` is positive at rest.
    pub spheres: [u32; 4],
    /// Volume of tissue that this tetrahedron represents, m³: its own volume, and a part of the
    /// tissue outside all tetrahedra, which counts with the nearest one.
    pub volume_m3: f64,
}

/// Fills the space between the centres with Delaunay tetrahedra. A tetrahedron that reaches outside
/// the organ is left out, unless a sphere would then be in none. Slivers are always left out. The
/// volumes sum to `volume_m3`.
#[must_use]
pub fn fill(interior: &Interior<'_>, balls: &[Ball], volume_m3: f64) -> Vec<Tetra> {
    fill_between(interior, balls, volume_m3, &[])
}

/// Fills the space as [`fill`] does, with held tissue beyond `planes`. Held tissue is counted only
/// with tetrahedra of four held corners, free tissue only with the others.
#[must_use]
pub fn fill_between(
    interior: &Interior<'_>,
    balls: &[Ball],
    volume_m3: f64,
    planes: &[Plane],
) -> Vec<Tetra> {
    let own = |b: &Ball| interior.frame.own(&b.center);
    let centers: Vec<Vec3> = balls.iter().map(own).collect();
    let all = delaunay::tetrahedra(&centers);
    let mut kept: Vec<[u32; 4]> = Vec::new();
    let mut in_use = vec![false; balls.len()];
    for t in all
        .iter()
        .filter(|t| shape(&centers, t) >= SHAPE_MIN && lies_inside(interior, &centers, t))
    {
        kept.push(*t);
        for &i in t {
            in_use[i as usize] = true;
        }
    }
    // A sphere may be in no tetrahedron. Then the best-shaped one at this sphere is kept after all,
    // unless it is a sliver.
    for i in 0..balls.len() as u32 {
        if in_use[i as usize] {
            continue;
        }
        let around = all.iter().filter(|t| t.contains(&i));
        let best = around.max_by(|a, b| shape(&centers, a).total_cmp(&shape(&centers, b)));
        if let Some(t) = best.filter(|t| shape(&centers, t) >= SHAPE_MIN) {
            kept.push(*t);
            for &i in t {
                in_use[i as usize] = true;
            }
        }
    }
    kept.sort_unstable();
    let is_held = |own: &Vec3| {
        let p = interior.frame.world(own);
        planes.iter().any(|plane| plane.holds(&p))
    };
    let (shares, left_out) = shares(interior, &centers, &kept, is_held);
    let total: f64 = shares.iter().sum::<f64>() + left_out;
    let carry = |(&spheres, share): (&[u32; 4], f64)| Tetra {
        spheres,
        volume_m3: volume_m3 * share / total,
    };
    let tets: Vec<Tetra> = kept.iter().zip(shares).map(carry).collect();
    let order = order::spread(&kept, balls.len());
    order.into_iter().map(|i| tets[i]).collect()
}

/// `V/L³`: 0.118 for a regular tetrahedron, 0 for a flat one, negative for an inverted one.
#[must_use]
pub fn shape(centers: &[Vec3], t: &[u32; 4]) -> f64 {
    let [a, b, c, d] = t.map(|i| centers[i as usize]);
    let longest = [b - a, c - a, d - a, c - b, d - b, d - c]
        .iter()
        .map(Vec3::norm)
        .fold(0.0, f64::max);
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0 / longest.powi(3)
}

fn lies_inside(interior: &Interior<'_>, centers: &[Vec3], t: &[u32; 4]) -> bool {
    let p = t.map(|i| centers[i as usize]);
    let inside = |q: &Vec3| interior.field.at(q) < 0.0;
    let middle = p.iter().sum::<Vec3>() / 4.0;
    let edges = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    inside(&middle) && edges.iter().all(|&(i, j)| inside(&((p[i] + p[j]) / 2.0)))
}

const NONE: u32 = u32::MAX;

/// Counts the grid points inside the organ that belong to each tetrahedron: the points inside it,
/// and those points outside all tetrahedra that are nearest to it, in steps of the grid. The count
/// is at least the tetrahedron's own volume in grid cells. Held points belong only to tetrahedra of
/// four held corners, free points only to the others. The second result counts the held points that
/// belong to no tetrahedron.
fn shares(
    interior: &Interior<'_>,
    centers: &[Vec3],
    tets: &[[u32; 4]],
    is_held: impl Fn(&Vec3) -> bool,
) -> (Vec<f64>, f64) {
    let grid = &interior.field.grid;
    let mut owner = vec![NONE; grid.len()];
    let mut held_points = vec![false; grid.len()];
    for &i in &interior.points {
        held_points[i as usize] = is_held(&interior.own_position(i));
    }
    let corners = tets.iter().map(|t| t.map(|i| centers[i as usize]));
    let held_tets: Vec<bool> = corners.clone().map(|c| c.iter().all(&is_held)).collect();
    for (number, corners) in corners.enumerate() {
        let may_own = |point: usize| held_points[point] == held_tets[number];
        claim(interior, corners, number as u32, may_own, &mut owner);
    }
    // Each round, the neighbours of owned points get the same owner.
    let mut front: Vec<u32> = interior
        .points
        .iter()
        .copied()
        .filter(|&i| owner[i as usize] != NONE)
        .collect();
    while !front.is_empty() {
        let mut reached = Vec::new();
        for &i in &front {
            for next in grid.neighbours(i as usize) {
                let by = owner[i as usize];
                let may_own = held_points[next] == held_tets[by as usize];
                if owner[next] == NONE && may_own && interior.field.is_inside(next) {
                    owner[next] = by;
                    reached.push(next as u32);
                }
            }
        }
        front = reached;
    }
    let (mut shares, mut left_out) = (vec![0.0; tets.len()], 0.0);
    for &i in &interior.points {
        match shares.get_mut(owner[i as usize] as usize) {
            Some(share) => *share += 1.0,
            None if held_points[i as usize] => left_out += 1.0,
            None => {}
        }
    }
    let cell_m3 = grid.cell_m.powi(3);
    for (share, t) in shares.iter_mut().zip(tets) {
        let [a, b, c, d] = t.map(|i| centers[i as usize]);
        let own = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0 / cell_m3;
        *share = f64::max(*share, own.max(1e-3));
    }
    (shares, left_out)
}

/// Makes a tetrahedron the owner of the grid points in it that have no owner yet.
fn claim(
    interior: &Interior<'_>,
    [a, b, c, d]: [Vec3; 4],
    number: u32,
    may_own: impl Fn(usize) -> bool,
    owner: &mut [u32],
) {
    let grid = &interior.field.grid;
    let low = a.inf(&b).inf(&c).inf(&d);
    let high = a.sup(&b).sup(&c).sup(&d);
    let axes = nalgebra::Matrix3::from_columns(&[b - a, c - a, d - a]);
    let Some(inverse) = axes.try_inverse() else {
        return;
    };
    let span = |k: usize| grid.span(k, low[k], high[k]);
    for z in span(2) {
        for y in span(1) {
            for x in span(0) {
                let index = grid.index([x, y, z]);
                if owner[index] != NONE || !may_own(index) || !interior.field.is_inside(index) {
                    continue;
                }
                let w = inverse * (grid.position([x, y, z]) - a);
                if w.min() >= 0.0 && w.sum() <= 1.0 {
                    owner[index] = number;
                }
            }
        }
    }
}
