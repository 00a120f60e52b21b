//! Delaunay tetrahedra of points, by Bowyer and Watson's method with exact predicates.

use std::collections::HashMap;

use robust::{Coord3D, insphere, orient3d};

use crate::Vec3;

const NONE: u32 = u32::MAX;

/// A tetrahedron. Neighbour `i` lies across the face opposite to corner `i`.
#[derive(Debug, Clone, Copy)]
struct Tet {
    corners: [u32; 4],
    neighbours: [u32; 4],
    alive: bool,
}

struct Mesher {
    points: Vec<Coord3D<f64>>,
    tets: Vec<Tet>,
    free: Vec<u32>,
}

/// Returns the tetrahedra whose circumscribed spheres hold no other point. Corners are ordered so
/// that `det(b − a, c − a, d − a)` is positive. Each point is first moved by up to a ten-millionth
/// of the points' extent in a fixed direction of its own, so that no five points lie on one sphere.
#[must_use]
pub fn tetrahedra(points: &[Vec3]) -> Vec<[u32; 4]> {
    if points.len() < 4 {
        return Vec::new();
    }
    let low = points
        .iter()
        .copied()
        .reduce(|a, b| a.inf(&b))
        .unwrap_or_default();
    let high = points
        .iter()
        .copied()
        .reduce(|a, b| a.sup(&b))
        .unwrap_or_default();
    let extent = (high - low).max().max(f64::MIN_POSITIVE);
    let place = |(i, p): (usize, &Vec3)| {
        let q = (p - low) / extent + jitter(i as u64) * 1e-7;
        Coord3D {
            x: q.x,
            y: q.y,
            z: q.z,
        }
    };
    let count = points.len() as u32;
    let mut mesher = Mesher {
        points: points.iter().enumerate().map(place).collect(),
        tets: Vec::with_capacity(8 * points.len()),
        free: Vec::new(),
    };
    mesher.surround();
    let mut near = 0;
    for i in 0..count {
        near = mesher.insert(i, near);
    }
    let inner = mesher
        .tets
        .iter()
        .filter(|t| t.alive && t.corners.iter().all(|&c| c < count));
    // orient3d is positive when det(b − a, c − a, d − a) is negative.
    inner
        .map(|t| [t.corners[0], t.corners[2], t.corners[1], t.corners[3]])
        .collect()
}

/// A fixed, irregular vector for each number (SplitMix64). Its coordinates are −0.5 to 0.5.
pub(crate) fn jitter(i: u64) -> Vec3 {
    let mut state = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    Vec3::new(next(), next(), next())
}

impl Mesher {
    /// Adds one tetrahedron that contains all points with room to spare. Its corners are numbered
    /// after the points.
    fn surround(&mut self) {
        let first = self.points.len() as u32;
        let far = 1e4;
        for [x, y, z] in [
            [-1.0, -1.0, -1.0],
            [3.0, -1.0, -1.0],
            [-1.0, 3.0, -1.0],
            [-1.0, -1.0, 3.0],
        ] {
            self.points.push(Coord3D {
                x: x * far,
                y: y * far,
                z: z * far,
            });
        }
        let mut corners = [first, first + 1, first + 2, first + 3];
        if self.orientation(corners) < 0.0 {
            corners.swap(0, 1);
        }
        self.tets.push(Tet {
            corners,
            neighbours: [NONE; 4],
            alive: true,
        });
    }

    fn point(&self, i: u32) -> Coord3D<f64> {
        self.points[i as usize]
    }

    fn orientation(&self, c: [u32; 4]) -> f64 {
        orient3d(
            self.point(c[0]),
            self.point(c[1]),
            self.point(c[2]),
            self.point(c[3]),
        )
    }

    /// Walks from tetrahedron `start` to the one that contains point `p`.
    fn locate(&self, p: u32, start: u32) -> u32 {
        let mut at = start;
        let mut came_from = NONE;
        'walk: for _ in 0..self.tets.len() + 16 {
            let tet = &self.tets[at as usize];
            for face in 0..4 {
                let next = tet.neighbours[face];
                if next == NONE || next == came_from {
                    continue;
                }
                let mut corners = tet.corners;
                corners[face] = p;
                if self.orientation(corners) < 0.0 {
                    came_from = at;
                    at = next;
                    continue 'walk;
                }
            }
            return at;
        }
        at
    }

    fn circumsphere_holds(&self, tet: u32, p: u32) -> bool {
        let c = self.tets[tet as usize].corners.map(|i| self.point(i));
        insphere(c[0], c[1], c[2], c[3], self.point(p)) > 0.0
    }

    /// Replaces the tetrahedra whose circumscribed spheres hold the point by a fan around the
    /// point. Returns one tetrahedron of the fan.
    fn insert(&mut self, p: u32, near: u32) -> u32 {
        let first = self.locate(p, near);
        let mut cavity = vec![first];
        self.tets[first as usize].alive = false;
        // For each face of the cavity: the tetrahedron outside of it, the corners of the new
        // tetrahedron inside, and the face's number in the new one.
        let mut border: Vec<(u32, [u32; 4], usize)> = Vec::new();
        let mut next = 0;
        while next < cavity.len() {
            let tet = self.tets[cavity[next] as usize];
            next += 1;
            for face in 0..4 {
                let outer = tet.neighbours[face];
                if outer != NONE && !self.tets[outer as usize].alive {
                    continue;
                }
                if outer != NONE && self.circumsphere_holds(outer, p) {
                    self.tets[outer as usize].alive = false;
                    cavity.push(outer);
                } else {
                    let mut corners = tet.corners;
                    corners[face] = p;
                    border.push((outer, corners, face));
                }
            }
        }
        self.free.extend(&cavity);
        // Two neighbouring tetrahedra of the fan share an edge of the cavity's faces.
        let mut open: HashMap<[u32; 2], (u32, usize)> = HashMap::with_capacity(2 * border.len());
        let mut last = first;
        for (outer, corners, face) in border {
            let index = self.free.pop().unwrap_or_else(|| {
                self.tets.push(Tet {
                    corners,
                    neighbours: [NONE; 4],
                    alive: true,
                });
                self.tets.len() as u32 - 1
            });
            let mut neighbours = [NONE; 4];
            neighbours[face] = outer;
            self.tets[index as usize] = Tet {
                corners,
                neighbours,
                alive: true,
            };
            if outer != NONE {
                self.join_across(outer, corners, face, index);
            }
            for side in (0..4).filter(|&side| side != face) {
                let mut edge = [NONE; 2];
                let ends = (0..4).filter(|&k| k != face && k != side);
                for (slot, k) in edge.iter_mut().zip(ends) {
                    *slot = corners[k];
                }
                edge.sort_unstable();
                match open.remove(&edge) {
                    None => {
                        open.insert(edge, (index, side));
                    }
                    Some((other, other_side)) => {
                        self.tets[index as usize].neighbours[side] = other;
                        self.tets[other as usize].neighbours[other_side] = index;
                    }
                }
            }
            last = index;
        }
        last
    }

    /// Makes the new tetrahedron `index` a neighbour of the outer one across their common face.
    fn join_across(&mut self, outer: u32, corners: [u32; 4], face: usize, index: u32) {
        let tet = &mut self.tets[outer as usize];
        let is_common = |c: &u32| corners.iter().enumerate().any(|(k, d)| k != face && d == c);
        if let Some(opposite) = tet.corners.iter().position(|c| !is_common(c)) {
            tet.neighbours[opposite] = index;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(points: &[Vec3], t: &[u32; 4]) -> f64 {
        let [a, b, c, d] = t.map(|i| points[i as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    }

    #[test]
    fn cube_corners_are_filled_without_gap() {
        let corner = |i: u32| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let points: Vec<Vec3> = (0..8).map(corner).collect();
        let tets = tetrahedra(&points);
        let volumes: Vec<f64> = tets.iter().map(|t| volume(&points, t)).collect();
        assert!(
            (volumes.iter().sum::<f64>() - 1.0).abs() < 1e-9,
            "{volumes:?}"
        );
        assert!(volumes.iter().all(|&v| v > -1e-9));
    }

    #[test]
    fn no_point_lies_in_a_circumscribed_sphere() {
        let points: Vec<Vec3> = (0..150).map(jitter).collect();
        let tets = tetrahedra(&points);
        assert!(tets.len() > 600);
        let coordinate = |i: u32| {
            let p = points[i as usize];
            Coord3D {
                x: p.x,
                y: p.y,
                z: p.z,
            }
        };
        for t in &tets {
            assert!(volume(&points, t) > 0.0);
            let [a, b, c, d] = [t[0], t[2], t[1], t[3]].map(coordinate);
            for other in (0..150).filter(|i| !t.contains(i)) {
                assert!(insphere(a, b, c, d, coordinate(other)) < 1e-9);
            }
        }
    }
}
