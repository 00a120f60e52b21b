//! Fills any closed shape with a body-centred cubic lattice that is cut at the surface (after
//! Labelle and Shewchuk, "Isosurface stuffing", 2007). The same input gives the same mesh.

use std::collections::{BTreeMap, HashMap};

use super::Mesh;
use crate::{FemError, Vec3};

/// A lattice point is moved onto the surface if the surface crosses one of the point's edges nearer
/// to it than this share of the edge.
const WARP: f64 = 0.25;

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
    let mut grid = Grid::new(origin, size_m, [cells.x, cells.y, cells.z]);
    let value: Vec<f64> = grid.points.iter().map(&distance).collect();
    let tets = grid.tets(&value);
    let (points, value) = warp(&grid.points, value, &tets, &distance);
    let mut cut = Cut {
        points,
        value,
        crossings: HashMap::new(),
        tets: Vec::new(),
        distance: &distance,
    };
    for tet in &tets {
        cut.add(*tet);
    }
    grid.points = cut.points;
    compact(&grid.points, &cut.tets).ok_or(none)
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

/// Share of the edge from `a` to `b`, whose signs differ, at which the surface crosses it.
fn crossing(a: &Vec3, b: &Vec3, va: f64, vb: f64, distance: &impl Fn(&Vec3) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    let (mut vl, mut vh) = (va, vb);
    let mut share = 0.5;
    for _ in 0..8 {
        // Regula falsi, with the new point kept away from both ends.
        share = (low + (high - low) * vl / (vl - vh))
            .clamp(low + 0.05 * (high - low), high - 0.05 * (high - low));
        let v = distance(&(a + (b - a) * share));
        if (v < 0.0) == (vl < 0.0) {
            (low, vl) = (share, v);
        } else {
            (high, vh) = (share, v);
        }
    }
    share
}

/// Moves each lattice point that is near a crossing onto that crossing, where its value is 0.
fn warp(
    points: &[Vec3],
    mut value: Vec<f64>,
    tets: &[[usize; 4]],
    distance: &impl Fn(&Vec3) -> f64,
) -> (Vec<Vec3>, Vec<f64>) {
    let mut edges = BTreeMap::new();
    for t in tets {
        for [i, j] in super::EDGES {
            let (a, b) = (t[i].min(t[j]), t[i].max(t[j]));
            if (value[a] < 0.0) != (value[b] < 0.0) {
                edges.entry((a, b)).or_insert_with(|| {
                    crossing(&points[a], &points[b], value[a], value[b], distance)
                });
            }
        }
    }
    let mut nearest: BTreeMap<usize, (f64, Vec3)> = BTreeMap::new();
    for (&(a, b), &share) in &edges {
        let at = points[a] + (points[b] - points[a]) * share;
        for (end, gap) in [(a, share), (b, 1.0 - share)] {
            if gap < WARP {
                let best = nearest.entry(end).or_insert((f64::INFINITY, at));
                if gap < best.0 {
                    *best = (gap, at);
                }
            }
        }
    }
    let mut moved = points.to_vec();
    for (n, (_, at)) in nearest {
        moved[n] = at;
        value[n] = 0.0;
    }
    (moved, value)
}

struct Cut<'a, D> {
    points: Vec<Vec3>,
    value: Vec<f64>,
    crossings: HashMap<(usize, usize), usize>,
    tets: Vec<[usize; 4]>,
    distance: &'a D,
}

impl<D: Fn(&Vec3) -> f64> Cut<'_, D> {
    fn between(&mut self, i: usize, j: usize) -> usize {
        let (a, b) = (i.min(j), i.max(j));
        if let Some(&n) = self.crossings.get(&(a, b)) {
            return n;
        }
        let (pa, pb) = (self.points[a], self.points[b]);
        let share = crossing(&pa, &pb, self.value[a], self.value[b], self.distance);
        self.points.push(pa + (pb - pa) * share);
        self.value.push(0.0);
        let n = self.points.len() - 1;
        self.crossings.insert((a, b), n);
        n
    }

    /// Adds the part of one lattice tetrahedron that lies inside.
    fn add(&mut self, tet: [usize; 4]) {
        let pick = |sign: fn(f64) -> bool| -> Vec<usize> {
            tet.into_iter().filter(|&n| sign(self.value[n])).collect()
        };
        let inside = pick(|v| v < 0.0);
        let outside = pick(|v| v > 0.0);
        let on = pick(|v| v == 0.0);
        match (inside.as_slice(), outside.as_slice(), on.as_slice()) {
            ([], ..) => {}
            (_, [], _) => self.tets.push(tet),
            (&[a], _, _) => {
                let mut cut = vec![a];
                cut.extend_from_slice(&on);
                for &p in &outside {
                    cut.push(self.between(a, p));
                }
                self.tets.push([cut[0], cut[1], cut[2], cut[3]]);
            }
            (&[a, b], &[p], &[z]) => {
                let (ap, bp) = (self.between(a, p), self.between(b, p));
                // A pyramid over the quadrangle a b bp ap, which is cut along the diagonal from its
                // corner with the lowest number.
                if a.min(bp) < b.min(ap) {
                    self.tets.extend([[a, b, bp, z], [a, bp, ap, z]]);
                } else {
                    self.tets.extend([[a, b, ap, z], [b, bp, ap, z]]);
                }
            }
            (&[a, b], &[p, q], _) => {
                let [ap, aq] = [self.between(a, p), self.between(a, q)];
                let [bp, bq] = [self.between(b, p), self.between(b, q)];
                self.wedge([a, ap, aq], [b, bp, bq]);
            }
            (&[a, b, c], &[p], _) => {
                let cut = [self.between(a, p), self.between(b, p), self.between(c, p)];
                self.wedge([a, b, c], cut);
            }
            _ => {}
        }
    }

    /// Cuts a wedge into three tetrahedra. Every quadrangle is cut along the diagonal from its
    /// corner with the lowest number, so that neighbours agree (Dompierre et al. 1999).
    fn wedge(&mut self, bottom: [usize; 3], top: [usize; 3]) {
        let all = [bottom, top].concat();
        let lowest = (0..6).min_by_key(|&i| all[i]).unwrap_or(0);
        let turn = lowest % 3;
        let (mut low, mut high) = (bottom, top);
        if lowest >= 3 {
            (low, high) = (top, bottom);
        }
        low.rotate_left(turn);
        high.rotate_left(turn);
        let ([a, b, c], [x, y, z]) = (low, high);
        self.tets.push([a, x, y, z]);
        if b.min(z) < c.min(y) {
            self.tets.extend([[a, b, c, z], [a, b, z, y]]);
        } else {
            self.tets.extend([[a, b, c, y], [a, c, z, y]]);
        }
    }
}

/// Drops unused points and tetrahedra without volume, and keeps only the largest connected piece.
fn compact(points: &[Vec3], tets: &[[usize; 4]]) -> Option<Mesh> {
    let volume = |t: &[usize; 4]| {
        let at = |i: usize| points[t[i]];
        (at(1) - at(0))
            .cross(&(at(2) - at(0)))
            .dot(&(at(3) - at(0)))
            .abs()
            / 6.0
    };
    let mean = tets.iter().map(volume).sum::<f64>() / tets.len().max(1) as f64;
    let kept: Vec<_> = tets.iter().filter(|t| volume(t) > 1e-6 * mean).collect();
    let mut parent: Vec<usize> = (0..points.len()).collect();
    fn root(parent: &mut [usize], mut n: usize) -> usize {
        while parent[n] != n {
            parent[n] = parent[parent[n]];
            n = parent[n];
        }
        n
    }
    for t in &kept {
        for &n in &t[1..] {
            let (a, b) = (root(&mut parent, t[0]), root(&mut parent, n));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut pieces: BTreeMap<usize, f64> = BTreeMap::new();
    for t in &kept {
        *pieces.entry(root(&mut parent, t[0])).or_default() += volume(t);
    }
    let (&main, _) = pieces.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
    let mut number = vec![u32::MAX; points.len()];
    let mut corners = Vec::new();
    let mut linear = Vec::new();
    for t in kept {
        if root(&mut parent, t[0]) == main {
            linear.push(t.map(|n| {
                if number[n] == u32::MAX {
                    number[n] = corners.len() as u32;
                    corners.push(points[n]);
                }
                number[n]
            }));
        }
    }
    Some(Mesh::from_linear(corners, &linear))
}

#[cfg(test)]
mod tests {
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

    /// Straight chords cut a sharp edge off. Corners that are moved out to the edge bring most of
    /// the volume back.
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
