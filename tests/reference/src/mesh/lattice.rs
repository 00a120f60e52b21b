//! Fills any closed shape with a body-centred cubic lattice, and cuts the lattice at the surface
//! (after Labelle and Shewchuk, "Isosurface stuffing", 2007). Equal inputs give equal meshes.

use super::Mesh;
use super::cut::cut;
use crate::{FemError, Vec3};

/// Fills the shape where `distance` (the signed distance to its surface, m) is negative, between
/// `min_m` and `max_m`. `size_m` is the edge of the lattice's cubes; elements are about as long.
///
/// # Errors
/// [`FemError::NoElements`] if nothing lies inside.
pub fn lattice(
    min_m: Vec3,
    max_m: Vec3,
    size_m: f64,
    distance: impl Fn(&Vec3) -> f64,
) -> Result<Mesh, FemError> {
    let none = FemError::NoElements { size_m };
    let usable = size_m.is_finite() && size_m > 0.0;
    if !usable || (max_m - min_m).iter().any(|l| l.is_nan() || *l <= 0.0) {
        return Err(none);
    }
    let origin = min_m - Vec3::repeat(1.5 * size_m);
    let cells = (max_m - min_m).map(|l| (l / size_m).ceil() as usize + 3);
    let grid = Grid::new(origin, size_m, [cells.x, cells.y, cells.z]);
    let value: Vec<f64> = grid.points.iter().map(&distance).collect();
    let tets = grid.tets(&value);
    cut(&grid.points, value, &tets, &distance).ok_or(none)
}

struct Grid {
    points: Vec<Vec3>,
    cells: [usize; 3],
}

impl Grid {
    fn new(origin: Vec3, size_m: f64, cells: [usize; 3]) -> Self {
        let mut points = Vec::new();
        // The cubes' corners come first, then their centres.
        for (extra, shift) in [(1, 0.0), (0, 0.5)] {
            for k in 0..cells[2] + extra {
                for j in 0..cells[1] + extra {
                    for i in 0..cells[0] + extra {
                        let at = Vec3::new(i as f64, j as f64, k as f64).add_scalar(shift);
                        points.push(origin + at * size_m);
                    }
                }
            }
        }
        Self { points, cells }
    }

    fn corner(&self, at: [usize; 3]) -> usize {
        at[0] + (self.cells[0] + 1) * (at[1] + (self.cells[1] + 1) * at[2])
    }

    fn centre(&self, at: [usize; 3]) -> usize {
        let corners = (self.cells[0] + 1) * (self.cells[1] + 1) * (self.cells[2] + 1);
        corners + at[0] + self.cells[0] * (at[1] + self.cells[1] * at[2])
    }

    /// Four tetrahedra around each segment that joins the centres of two neighbouring cubes. Those
    /// without a corner inside the shape are left out.
    fn tets(&self, value: &[f64]) -> Vec<[usize; 4]> {
        let mut tets = Vec::new();
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for k in 0..self.cells[2] {
                for j in 0..self.cells[1] {
                    for i in 0..self.cells[0] {
                        let mut next = [i, j, k];
                        next[axis] += 1;
                        if next[axis] == self.cells[axis] {
                            continue;
                        }
                        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
                            let mut at = next;
                            at[u] += a;
                            at[v] += b;
                            self.corner(at)
                        });
                        let (from, to) = (self.centre([i, j, k]), self.centre(next));
                        for side in 0..4 {
                            let tet = [from, to, ring[side], ring[(side + 1) % 4]];
                            if tet.iter().any(|&n| value[n] < 0.0) {
                                tets.push(tet);
                            }
                        }
                    }
                }
            }
        }
        tets
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::element;

    fn ball(size_m: f64) -> Mesh {
        let box_m = Vec3::repeat(1.0);
        lattice(-box_m, box_m, size_m, |p| p.norm() - 1.0).expect("filled")
    }

    #[test]
    fn a_ball_is_filled_and_its_volume_converges() {
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        let error = |size: f64| {
            let mut mesh = ball(size);
            let straight = 1.0 - mesh.volume_m3(None).expect("sound") / exact;
            let kept = mesh.curve_boundary(|p| p.normalize());
            let curved = 1.0 - mesh.volume_m3(None).expect("sound") / exact;
            assert!(kept * 20 < mesh.faces.len(), "{kept} edges stayed straight");
            (straight, curved.abs())
        };
        let (coarse, fine) = (error(0.5), error(0.25));
        assert!(coarse.0 > 0.0 && fine.0 > 0.0, "chords lie inside");
        assert!(fine.0 < coarse.0 / 3.0, "straight: {coarse:?} {fine:?}");
        assert!(fine.1 < fine.0 / 5.0, "curved: {coarse:?} {fine:?}");
    }

    /// Straight element edges cut off a sharp edge of the body. Corners that are moved out to the
    /// sharp edge restore most of the volume.
    #[test]
    fn a_sharp_edge_is_reached() {
        let exact = 2.0 / 3.0 * std::f64::consts::PI;
        let box_m = Vec3::repeat(1.0);
        let half = |p: &Vec3| (p.norm() - 1.0).max(-p.z);
        let mut mesh = lattice(-box_m, box_m, 0.3, half).expect("filled");
        let on_plane = |p: &Vec3| p.z < 1e-3;
        let round = |p: &Vec3| if on_plane(p) { *p } else { p.normalize() };
        let mut blunt = mesh.clone();
        blunt.curve_boundary(round);
        mesh.stretch_corners(|p, beside| {
            let is_rim = on_plane(p) && beside.iter().any(|other| !on_plane(other));
            let flat = Vec3::new(p.x, p.y, 0.0);
            if is_rim { flat.normalize() } else { *p }
        });
        mesh.curve_boundary(round);
        let error = |mesh: &Mesh| 1.0 - mesh.volume_m3(None).expect("sound") / exact;
        let (blunt, sharp) = (error(&blunt), error(&mesh));
        assert!(sharp.abs() < 0.5 * blunt, "{sharp} {blunt}");
    }

    #[test]
    fn the_boundary_is_closed_and_on_the_surface() {
        let mesh = ball(0.3);
        let mut edges = HashMap::new();
        for f in &mesh.faces {
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                *edges.entry((f[i], f[j])).or_insert(0) += 1;
                assert!((mesh.nodes[f[i] as usize].norm() - 1.0).abs() < 1e-3);
            }
        }
        assert!(
            edges
                .iter()
                .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
        );
    }

    #[test]
    fn elements_are_not_slivers() {
        for size in [0.21, 0.3, 0.47] {
            let mesh = ball(size);
            for t in &mesh.tets {
                let x = t.map(|n| mesh.nodes[n as usize]);
                let longest = crate::mesh::EDGES
                    .iter()
                    .map(|[i, j]| (x[*i] - x[*j]).norm())
                    .fold(0.0, f64::max);
                let shape = element::straight_jacobian(&x) / longest.powi(3);
                assert!(shape > 0.02, "V/L³ is {shape} at size {size}");
            }
        }
    }

    #[test]
    fn nothing_inside_is_an_error() {
        let box_m = Vec3::repeat(1.0);
        assert!(lattice(-box_m, box_m, 0.5, |_| 1.0).is_err());
        assert!(lattice(-box_m, box_m, 0.0, |p| p.norm() - 1.0).is_err());
        assert!(lattice(-box_m, box_m, f64::NAN, |p| p.norm() - 1.0).is_err());
    }
}
