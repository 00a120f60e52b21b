//! Organs that overlap at rest.
//!
//! Lines parallel to x run through the box that two organs share. The places where a line meets the
//! two skins are computed exactly, and so the stretches of the line that lie in both organs. The
//! depth at the middle of a stretch is the sum of the distances from there to both skins: between
//! two parallel faces the sum is the same everywhere.
//!
//! The cavity of a hollow organ is not part of the organ, so an organ in the cavity does not
//! overlap the hollow organ.

use crate::Vec3;
use crate::field::{Grid, Nearest, shared_stretches};
use crate::mesh::Mesh;
use crate::recipe::OrganPlan;
use crate::report::Overlap;

/// Organs that overlap by less than this only touch, m: half a voxel of 1 mm, the resolution of
/// scans from which surfaces of one patient are made.
const TOUCH_M: f64 = 0.5e-3;
/// Approximate number of lines through a shared box.
const LINES: f64 = 40_000.0;
/// Smallest distance between lines, m: a quarter of the least overlap that counts.
const LINE_MIN_M: f64 = 0.25 * TOUCH_M;
/// Largest number of places at which the depth of two organs' overlap is measured.
const PLACES: usize = 10_000;

/// Pairs of organs that overlap, in the recipe's order. `skins` are the skins of the `organs`.
pub(crate) fn overlaps(organs: &[OrganPlan], skins: &[Mesh]) -> Vec<Overlap> {
    let mut found = Vec::new();
    for (j, other) in organs.iter().enumerate() {
        for (i, one) in organs.iter().enumerate().take(j) {
            if is_around(one, other) || is_around(other, one) {
                continue;
            }
            if let Some((at, depth_m, volume_m3)) = overlap(&skins[i], &skins[j]) {
                found.push(Overlap {
                    organs: [one.name.clone(), other.name.clone()],
                    at_m: at.into(),
                    depth_mm: 1e3 * depth_m,
                    volume_ml: 1e6 * volume_m3,
                    attached: is_grown(one, other) || is_grown(other, one),
                });
            }
        }
    }
    found
}

/// True if `one` is layered tissue around `other`. The inner organ is not part of the layered
/// tissue.
fn is_around(one: &OrganPlan, other: &OrganPlan) -> bool {
    let layers = one.layers.as_ref();
    layers.is_some_and(|layers| layers.around == other.name)
}

fn is_grown(one: &OrganPlan, other: &OrganPlan) -> bool {
    one.attached.iter().any(|entry| entry.to == other.name)
}

/// Deepest place, depth, m, and volume, m³, of the overlap of two surfaces.
fn overlap(one: &Mesh, other: &Mesh) -> Option<(Vec3, f64, f64)> {
    let [low, high] = {
        let [a, b] = [one.bounds(), other.bounds()];
        [a[0].sup(&b[0]), a[1].inf(&b[1])]
    };
    let size = high - low;
    if size.min() <= TOUCH_M {
        return None;
    }
    let cell_m = (size.y * size.z / LINES).sqrt().max(LINE_MIN_M);
    let grid = Grid::around([low, high], cell_m, 1);
    let both = shared_stretches(one, other, &grid);
    if both.is_empty() {
        return None;
    }
    let length_m: f64 = both.iter().map(|(_, length_m)| length_m).sum();
    let nearest = (Nearest::new(one)?, Nearest::new(other)?);
    let mut deepest = (Vec3::zeros(), 0.0);
    for (middle, _) in both.iter().step_by(both.len().div_ceil(PLACES)) {
        let depth_m = nearest.0.distance(middle) + nearest.1.distance(middle);
        if depth_m > deepest.1 {
            deepest = (*middle, depth_m);
        }
    }
    let (at, depth_m) = deepest;
    (depth_m > TOUCH_M).then_some((at, depth_m, length_m * cell_m * cell_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box; `inward` turns it inside out.
    fn block(low: [f64; 3], high: [f64; 3], inward: bool) -> Mesh {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        let mut mesh = Mesh {
            vertices: (0..8).map(corner).collect(),
            ..Mesh::default()
        };
        for [a, b, c, d] in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            for t in [[a, b, c], [a, c, d]] {
                let [i, j, k] = t;
                mesh.triangles.push(if inward { [i, k, j] } else { t });
            }
        }
        mesh
    }

    #[test]
    fn depth_place_and_volume_of_two_plates_are_those_of_their_overlap() {
        let lower = block([0.0, 0.0, 0.0], [0.1, 0.06, 0.03], false);
        for (depth_m, found) in [(-0.01, false), (0.0, false), (0.001, true), (0.012, true)] {
            let from = 0.03 - depth_m;
            let upper = block([0.02, 0.01, from], [0.08, 0.05, from + 0.03], false);
            let overlap = overlap(&lower, &upper);
            assert_eq!(overlap.is_some(), found, "{depth_m}");
            if let Some((at, deep_m, volume_m3)) = overlap {
                assert!((deep_m - depth_m).abs() < 1e-6, "{deep_m} for {depth_m}");
                assert!(
                    (from..=0.03).contains(&at.z) && (0.02..0.08).contains(&at.x),
                    "{at}"
                );
                let expected_m3 = 0.06 * 0.04 * depth_m;
                assert!((volume_m3 / expected_m3 - 1.0).abs() < 0.3, "{volume_m3}");
            }
        }
    }

    /// The direction of the lines must not matter.
    #[test]
    fn plates_beside_each_other_overlap_as_deep_as_plates_on_each_other() {
        let one = block([0.0; 3], [0.03, 0.1, 0.1], false);
        for axis in 0..3 {
            let turn = |mut mesh: Mesh| {
                for p in &mut mesh.vertices {
                    *p = Vec3::new(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]);
                }
                mesh
            };
            let other = block([0.028, 0.0, 0.0], [0.05, 0.1, 0.1], false);
            let (_, depth_m, _) = overlap(&turn(one.clone()), &turn(other)).expect("an overlap");
            assert!((depth_m - 0.002).abs() < 1e-6, "axis {axis}: {depth_m}");
        }
    }

    #[test]
    fn what_lies_in_a_cavity_does_not_overlap_and_what_lies_in_a_body_does() {
        let mut hollow = block([0.0; 3], [0.1; 3], false);
        let stone = block([0.04; 3], [0.06; 3], false);
        assert!(overlap(&hollow, &stone).is_some());
        hollow.append(&block([0.02; 3], [0.08; 3], true));
        assert_eq!(overlap(&hollow, &stone), None);
    }
}
