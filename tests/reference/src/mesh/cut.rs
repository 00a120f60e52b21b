//! Cuts tetrahedra of a lattice at a surface and keeps the parts inside (after Labelle and
//! Shewchuk, "Isosurface stuffing", 2007).

use std::collections::{BTreeMap, HashMap};

use super::Mesh;
use crate::Vec3;

/// A lattice point is moved onto the surface if the surface crosses one of its edges and the
/// crossing is nearer than this share of the edge.
const WARP_SHARE_MAX: f64 = 0.25;

/// Mesh of the parts of the tetrahedra in which `distance` is negative. `value` has the distance at
/// each point. `None` if nothing is inside.
pub(super) fn cut(
    points: &[Vec3],
    value: Vec<f64>,
    tets: &[[usize; 4]],
    distance: &impl Fn(&Vec3) -> f64,
) -> Option<Mesh> {
    let (points, value) = warp(points, value, tets, distance);
    let mut cut = Cutter {
        points,
        value,
        crossings: HashMap::new(),
        tets: Vec::new(),
        distance,
    };
    for tet in tets {
        cut.add(*tet);
    }
    largest_piece(&cut.points, &cut.tets)
}

/// Share of the edge from `a` to `b` at which the surface crosses it. The distances `va` and `vb`
/// differ in sign.
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
            if gap < WARP_SHARE_MAX {
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

struct Cutter<'a, D> {
    points: Vec<Vec3>,
    value: Vec<f64>,
    crossings: HashMap<(usize, usize), usize>,
    tets: Vec<[usize; 4]>,
    distance: &'a D,
}

impl<D: Fn(&Vec3) -> f64> Cutter<'_, D> {
    fn crossing_point(&mut self, i: usize, j: usize) -> usize {
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
                    cut.push(self.crossing_point(a, p));
                }
                self.tets.push([cut[0], cut[1], cut[2], cut[3]]);
            }
            (&[a, b], &[p], &[z]) => {
                let (ap, bp) = (self.crossing_point(a, p), self.crossing_point(b, p));
                // A pyramid over the quadrangle a b bp ap, which is cut along the diagonal from its
                // corner with the lowest number.
                if a.min(bp) < b.min(ap) {
                    self.tets.extend([[a, b, bp, z], [a, bp, ap, z]]);
                } else {
                    self.tets.extend([[a, b, ap, z], [b, bp, ap, z]]);
                }
            }
            (&[a, b], &[p, q], _) => {
                let [ap, aq] = [self.crossing_point(a, p), self.crossing_point(a, q)];
                let [bp, bq] = [self.crossing_point(b, p), self.crossing_point(b, q)];
                self.add_wedge([a, ap, aq], [b, bp, bq]);
            }
            (&[a, b, c], &[p], _) => {
                let cut = [
                    self.crossing_point(a, p),
                    self.crossing_point(b, p),
                    self.crossing_point(c, p),
                ];
                self.add_wedge([a, b, c], cut);
            }
            _ => {}
        }
    }

    /// Cuts a wedge into three tetrahedra. Each quadrangle is cut along the diagonal from its
    /// corner with the lowest number. So two neighbours cut their common quadrangle along the same
    /// diagonal (Dompierre et al. 1999).
    fn add_wedge(&mut self, bottom: [usize; 3], top: [usize; 3]) {
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
fn largest_piece(points: &[Vec3], tets: &[[usize; 4]]) -> Option<Mesh> {
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
