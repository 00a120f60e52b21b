//! Even packing: a centroidal Voronoi tessellation by Lloyd's iteration on the grid. Then the outer
//! layer of spheres is moved to one depth just under the skin.
//!
//! Evenly spaced spheres with an outer layer at one depth model mechanics better than spheres on
//! the medial axis, which are large and cannot follow a small dent. They cover less of the volume.

use super::{Ball, Interior};
use crate::Vec3;

/// Lloyd iterations before the outer layer is set.
const ITERATIONS: usize = 12;
/// Further Lloyd iterations. Each also moves the outer layer to its depth, and the next iteration
/// lets the other spheres follow.
const SETTING: usize = 8;
/// Factor by which centres move farther than to the middle of their points. It halves the number of
/// iterations needed.
const OVERSTEP: f64 = 1.4;
/// Depth of the outer layer, in spacings. A deeper layer covers more and leaves smaller gaps (depth
/// 0.55: 88 % of the liver, 95 % gap 0.27 spacings; 0.65: 90 %, 0.24; 0.75: 92 %, 0.21). It takes
/// mass and spheres away from the skin.
const LAYER_DEPTH: f64 = 0.65;
/// Centres nearer to the skin than this belong to the outer layer, in spacings.
const LAYER_LIMIT: f64 = 0.95;
/// Largest radius, in spacings. Larger spheres would hide dents.
const RADIUS_MAX: f64 = 1.15;
/// Centres claim points up to this far, in spacings. For a point that no centre claims, all centres
/// are searched.
const REACH: f64 = 1.45;

/// Squared distances that differ by less than this count as equal, cells². Starting points lie on
/// the grid, so many distances are equal, and rounding must not decide which centre owns a point.
/// Single precision errs by 5e-6 at the largest distance.
const EQUAL: f32 = 1e-3;

const NONE: u32 = u32::MAX;

/// Packs `count` spheres, or as many as there are grid points inside, if these are fewer.
#[must_use]
pub fn pack_evenly(interior: &Interior<'_>, count: usize) -> Vec<Ball> {
    let mut owners = Owners::new(interior);
    let mut centers = spread(interior, count);
    let h = interior.spacing_m;
    for iteration in 0..ITERATIONS + SETTING {
        owners.move_to_middles(&mut centers);
        if iteration >= ITERATIONS {
            for center in &mut centers {
                *center = set_to_layer(interior, *center, h);
            }
        }
    }
    let balls = centers
        .into_iter()
        .map(|c| interior.inscribed(interior.frame.world(&c), RADIUS_MAX * h));
    balls.collect()
}

/// Moves a centre of the outer layer along the surface's normal to the layer's depth or, if the
/// organ is too thin there, by a smaller step. Other centres stay. Centres are places in the
/// organ's own frame.
fn set_to_layer(interior: &Interior<'_>, center: Vec3, h: f64) -> Vec3 {
    let depth = -interior.field.at(&center);
    if depth > LAYER_LIMIT * h {
        return center;
    }
    let inward = -interior.field.outward(&center);
    let mut step = LAYER_DEPTH * h - depth;
    for _ in 0..4 {
        let moved = center + inward * step;
        let gained = -interior.field.at(&moved) - depth;
        // A step that crosses the middle of a thin part gains less than its length.
        if gained > 0.7 * step || (step < 0.0 && gained > -1.3 * step.abs()) {
            return moved;
        }
        step /= 2.0;
    }
    center
}

/// Starting points in the organ's own frame: grid points at equal intervals in Morton order.
fn spread(interior: &Interior<'_>, count: usize) -> Vec<Vec3> {
    let grid = &interior.field.grid;
    let mut keyed: Vec<(u64, u32)> = interior
        .points
        .iter()
        .map(|&i| {
            let [x, y, z] = grid.coordinates(i as usize).map(|c| interleave(c as u64));
            (x | y << 1 | z << 2, i)
        })
        .collect();
    keyed.sort_unstable();
    let count = count.min(keyed.len());
    let pick = |i: usize| keyed[(2 * i + 1) * keyed.len() / (2 * count)].1;
    (0..count).map(|i| interior.own_position(pick(i))).collect()
}

/// Spreads the low 21 bits, with two zeros between neighbouring bits.
fn interleave(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Assigns each grid point inside to its nearest centre.
pub(super) struct Owners<'a, 'm> {
    interior: &'a Interior<'m>,
    /// Squared distance of each grid point from its owner (the nearest centre), cells²; negative
    /// infinity outside.
    best: Vec<f32>,
    owner: Vec<u32>,
    result: Vec<u32>,
}

impl<'a, 'm> Owners<'a, 'm> {
    pub(super) fn new(interior: &'a Interior<'m>) -> Self {
        let size = interior.field.grid.len();
        Self {
            interior,
            best: vec![f32::NEG_INFINITY; size],
            owner: vec![NONE; size],
            result: vec![NONE; interior.points.len()],
        }
    }

    /// The nearest centre of each point of [`Interior::points`]; of equally near centres the first.
    /// Centres are places in the organ's own frame.
    pub(super) fn assign(&mut self, centers: &[Vec3]) -> &[u32] {
        for &i in &self.interior.points {
            self.best[i as usize] = f32::INFINITY;
            self.owner[i as usize] = NONE;
        }
        let reach = REACH * self.interior.spacing_m;
        for (number, center) in centers.iter().enumerate() {
            self.claim(number as u32, center, reach);
        }
        for (result, &i) in self.result.iter_mut().zip(&self.interior.points) {
            *result = self.owner[i as usize];
            if *result == NONE {
                let p = self.interior.own_position(i);
                let near = centers.iter().map(|c| (c - p).norm_squared()).enumerate();
                let near = near.min_by(|a, b| a.1.total_cmp(&b.1));
                *result = near.map_or(0, |(number, _)| number as u32);
            }
        }
        &self.result
    }

    fn claim(&mut self, number: u32, center: &Vec3, reach: f64) {
        let grid = &self.interior.field.grid;
        let span = |k: usize| grid.span(k, center[k] - reach, center[k] + reach);
        let at = (center - grid.origin) / grid.cell_m;
        let (xs, ys, zs) = (span(0), span(1), span(2));
        for z in zs {
            let dz = (z as f64 - at.z) as f32;
            for y in ys.clone() {
                let dy = (y as f64 - at.y) as f32;
                let off_line = dz * dz + dy * dy;
                let row = grid.index([xs.start, y, z]);
                let best = &mut self.best[row..row + xs.len()];
                let owner = &mut self.owner[row..row + xs.len()];
                let first = (xs.start as f64 - at.x) as f32;
                for (i, (best, owner)) in best.iter_mut().zip(owner).enumerate() {
                    let dx = first + i as f32;
                    let squared = off_line + dx * dx;
                    let nearer = squared + EQUAL < *best;
                    *best = if nearer { squared } else { *best };
                    *owner = if nearer { number } else { *owner };
                }
            }
        }
    }

    /// Lloyd's step: moves each centre towards the middle of the points that it owns, by
    /// [`OVERSTEP`] or, if that place lies outside, to the middle. Points at the skin count by the
    /// share of their cell that is inside.
    fn move_to_middles(&mut self, centers: &mut [Vec3]) {
        self.assign(centers);
        let field = &self.interior.field;
        let mut sums = vec![(Vec3::zeros(), 0.0); centers.len()];
        for (&owner, &i) in self.result.iter().zip(&self.interior.points) {
            let depth = f64::from(-field.distance_m[i as usize]);
            let weight = (0.5 + depth / field.grid.cell_m).min(1.0);
            let sum = &mut sums[owner as usize];
            sum.0 += self.interior.own_position(i) * weight;
            sum.1 += weight;
        }
        for (center, (sum, weight)) in centers.iter_mut().zip(sums) {
            if weight > 0.0 {
                let ahead = *center + (sum / weight - *center) * OVERSTEP;
                *center = if field.at(&ahead) < 0.0 {
                    ahead
                } else {
                    sum / weight
                };
            }
        }
    }
}
