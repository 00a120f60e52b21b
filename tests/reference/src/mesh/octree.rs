//! Fills any closed shape with tetrahedra of graded size (Labelle and Shewchuk, "Isosurface
//! stuffing", 2007). Their corners are the corners and centres of the cubes of an octree. Equal
//! inputs give equal meshes.

use std::collections::{BTreeSet, HashMap};

use super::Mesh;
use super::cut::cut;
use crate::{FemError, Vec3};

/// Largest number of doublings from the finest cube's edge to the coarsest's.
const DOUBLINGS_MAX: u32 = 12;

/// A cube is divided if the wanted element size is smaller than this share of its edge. So a cube's
/// edge is between two thirds and four thirds of the wanted size.
const SIZE_SHARE_MIN: f64 = 0.75;

/// Fills the shape where `distance` (the signed distance to its surface, m) is negative, between
/// `min_m` and `max_m`. A cube's edge is `finest_m` times a power of two, and about `size_m` at its
/// middle unless that is below `finest_m`. Neighbouring cubes differ by a factor of two at
/// most. Elements are about as long as their cube.
///
/// # Errors
/// [`FemError::NoElements`] if nothing lies inside.
pub fn graded(
    min_m: Vec3,
    max_m: Vec3,
    finest_m: f64,
    size_m: impl Fn(&Vec3) -> f64,
    distance: impl Fn(&Vec3) -> f64,
) -> Result<Mesh, FemError> {
    let none = FemError::NoElements { size_m: finest_m };
    let usable = finest_m.is_finite() && finest_m > 0.0;
    if !usable || (max_m - min_m).iter().any(|l| l.is_nan() || *l <= 0.0) {
        return Err(none);
    }
    let mut tree = Octree::new(min_m, max_m, finest_m, &size_m);
    tree.balance();
    let (numbers, points) = tree.points();
    let value: Vec<f64> = points.iter().map(&distance).collect();
    let mut tets = tree.tets(&numbers);
    tets.retain(|tet| tet.iter().any(|&n| value[n] < 0.0));
    cut(&points, value, &tets, &distance).ok_or(none)
}

/// A cube: the number of doublings from the finest edge to its edge, and its position in units of
/// its edge.
type Cube = (u32, [i64; 3]);
/// A point in units of half the finest edge.
type GridPoint = [i64; 3];

struct Octree {
    origin: Vec3,
    finest_m: f64,
    largest: u32,
    cubes: BTreeSet<Cube>,
}

fn corner((doublings, at): Cube, corner: [i64; 3]) -> GridPoint {
    [0, 1, 2].map(|k| (at[k] + corner[k]) << (doublings + 1))
}

fn centre((doublings, at): Cube) -> GridPoint {
    at.map(|a| (a << (doublings + 1)) + (1 << doublings))
}

fn children((doublings, at): Cube) -> impl Iterator<Item = Cube> {
    (0..8_i64).map(move |c| {
        let [i, j, k] = at.map(|a| 2 * a);
        (doublings - 1, [i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)])
    })
}

impl Octree {
    fn new(min_m: Vec3, max_m: Vec3, finest_m: f64, size_m: &impl Fn(&Vec3) -> f64) -> Self {
        let span_m = (max_m - min_m).max();
        let largest = (span_m / finest_m).log2().ceil().max(0.0) as u32;
        let largest = largest.min(DOUBLINGS_MAX);
        let edge_m = finest_m * f64::from(1 << largest);
        // One cube of room on every side.
        let counts = (max_m - min_m).map(|l| (l / edge_m).ceil() as i64 + 2);
        let mut tree = Self {
            origin: (min_m + max_m) / 2.0 - counts.map(|n| 0.5 * n as f64 * edge_m),
            finest_m,
            largest,
            cubes: BTreeSet::new(),
        };
        let mut pending: Vec<Cube> = Vec::new();
        for k in 0..counts.z {
            for j in 0..counts.y {
                pending.extend((0..counts.x).map(|i| (largest, [i, j, k])));
            }
        }
        while let Some(cube) = pending.pop() {
            let edge_m = finest_m * f64::from(1 << cube.0);
            if cube.0 > 0 && size_m(&tree.at(centre(cube))) < edge_m * SIZE_SHARE_MIN {
                pending.extend(children(cube));
            } else {
                tree.cubes.insert(cube);
            }
        }
        tree
    }

    fn at(&self, place: GridPoint) -> Vec3 {
        self.origin + Vec3::from(place.map(|p| p as f64)) * (0.5 * self.finest_m)
    }

    /// The given cube, or the undivided cube that contains it. `None` outside the octree, or if the
    /// given cube is divided.
    fn containing(&self, (doublings, at): Cube) -> Option<Cube> {
        (doublings..=self.largest)
            .map(|d| (d, at.map(|a| a >> (d - doublings))))
            .find(|cube| self.cubes.contains(cube))
    }

    /// Divides cubes until neighbours across faces, edges and corners differ by a factor of two at
    /// most.
    fn balance(&mut self) {
        let mut pending: Vec<Cube> = self.cubes.iter().rev().copied().collect();
        while let Some(cube) = pending.pop() {
            if !self.cubes.contains(&cube) {
                continue;
            }
            for step in 0..27 {
                let by = [step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1];
                let beside = [0, 1, 2].map(|k| cube.1[k] + by[k]);
                while let Some(large) = self
                    .containing((cube.0, beside))
                    .filter(|l| l.0 > cube.0 + 1)
                {
                    self.cubes.remove(&large);
                    self.cubes.extend(children(large));
                    pending.extend(children(large));
                }
            }
        }
    }

    /// Indices and positions of all corners and centres.
    fn points(&self) -> (HashMap<GridPoint, usize>, Vec<Vec3>) {
        let corners =
            |cube: Cube| (0..8_i64).map(move |c| corner(cube, [c & 1, c >> 1 & 1, c >> 2]));
        let all = self.cubes.iter();
        let places: BTreeSet<GridPoint> = all
            .flat_map(|&cube| corners(cube).chain([centre(cube)]))
            .collect();
        let points = places.iter().map(|&place| self.at(place)).collect();
        (places.into_iter().zip(0..).collect(), points)
    }

    /// Tetrahedra between the centres of neighbouring cubes and their common face.
    fn tets(&self, numbers: &HashMap<GridPoint, usize>) -> Vec<[usize; 4]> {
        let mut tets = Vec::new();
        for &cube in &self.cubes {
            for (axis, up) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                let mut beside = cube;
                beside.1[axis] += if up { 1 } else { -1 };
                let Some(other) = self.containing(beside) else {
                    continue; // outside, or smaller cubes, which add their own tetrahedra
                };
                let ring = ring(cube, axis, up);
                let [from, to] = [cube, other].map(|c| numbers[&centre(c)]);
                if other.0 == cube.0 {
                    if up {
                        for side in 0..4 {
                            let ends = [ring[side], ring[(side + 1) % 4]];
                            for [a, b] in halves(ends, numbers) {
                                tets.push([from, to, a, b]);
                            }
                        }
                    }
                } else {
                    for [a, b, c] in triangles(ring, middle_of_face(other, axis, !up), numbers) {
                        tets.extend([[from, a, b, c], [to, a, b, c]]);
                    }
                }
            }
        }
        tets
    }
}

/// Corners of a cube's face, in order around it.
fn ring(cube: Cube, axis: usize, up: bool) -> [GridPoint; 4] {
    [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
        let mut at = [0; 3];
        at[axis] = i64::from(up);
        at[(axis + 1) % 3] = a;
        at[(axis + 2) % 3] = b;
        corner(cube, at)
    })
}

fn middle_of_face(cube: Cube, axis: usize, up: bool) -> GridPoint {
    let mut middle = centre(cube);
    middle[axis] += if up { 1 << cube.0 } else { -(1 << cube.0) };
    middle
}

/// An edge, or its two halves if a smaller cube has a corner in its middle.
fn halves([a, b]: [GridPoint; 2], numbers: &HashMap<GridPoint, usize>) -> Vec<[usize; 2]> {
    let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2);
    let [a, b] = [a, b].map(|place| numbers[&place]);
    match numbers.get(&middle) {
        Some(&m) => vec![[a, m], [m, b]],
        None => vec![[a, b]],
    }
}

/// The face of a small cube as two triangles that meet in the middle of the large cube's face.
fn triangles(
    ring: [GridPoint; 4],
    meet: GridPoint,
    numbers: &HashMap<GridPoint, usize>,
) -> [[usize; 3]; 2] {
    let first = ring.iter().position(|place| *place == meet).unwrap_or(0);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| numbers[&ring[(first + i) % 4]]);
    [[a, b, c], [a, c, d]]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::element;

    /// A ball with elements of the `finest` size at one point of its surface and larger ones
    /// farther away.
    fn ball(finest: f64) -> Mesh {
        let touched = Vec3::new(0.3, 0.2, 1.0).normalize();
        let size = |p: &Vec3| (0.4 * (p - touched).norm()).clamp(finest, 0.5);
        let box_m = Vec3::repeat(1.0);
        graded(-box_m, box_m, finest, size, |p| p.norm() - 1.0).expect("filled")
    }

    #[test]
    fn a_ball_is_filled_with_valid_elements() {
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        for finest in [0.09, 0.05, 0.031] {
            let mut mesh = ball(finest);
            mesh.curve_boundary(|p| p.normalize());
            let volume = mesh.volume_m3(None).expect("sound");
            assert!((volume / exact - 1.0).abs() < 0.01, "{finest}: {volume}");
            for t in &mesh.tets {
                let x = t.map(|n| mesh.nodes[n as usize]);
                let longest = crate::mesh::EDGES
                    .iter()
                    .map(|[i, j]| (x[*i] - x[*j]).norm())
                    .fold(0.0, f64::max);
                let shape = element::straight_jacobian(&x) / longest.powi(3);
                assert!(shape > 0.01, "V/L³ is {shape} at {finest}");
            }
        }
    }

    /// Elements of different sizes fit together: every side is a boundary or lies between two
    /// elements, and the boundary is on the surface.
    #[test]
    fn elements_of_all_sizes_fit_together() {
        let mesh = ball(0.05);
        let mut edges = BTreeMap::new();
        for f in &mesh.faces {
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                *edges.entry((f[i], f[j])).or_insert(0) += 1;
                assert!((mesh.nodes[f[i] as usize].norm() - 1.0).abs() < 1e-3);
            }
        }
        let closed = |(&(a, b), &n): (&(u32, u32), &i32)| n == 1 && edges.contains_key(&(b, a));
        assert!(edges.iter().all(closed));
    }

    #[test]
    fn elements_are_small_only_where_requested() {
        let (coarse, fine) = (ball(0.1), ball(0.05));
        assert!(fine.nodes.len() < 4 * coarse.nodes.len());
        assert!(fine.nodes.len() > coarse.nodes.len());
    }

    #[test]
    fn nothing_inside_is_an_error() {
        let box_m = Vec3::repeat(1.0);
        assert!(graded(-box_m, box_m, 0.1, |_| 0.5, |_| 1.0).is_err());
        assert!(graded(-box_m, box_m, 0.0, |_| 0.5, |p| p.norm() - 1.0).is_err());
    }
}
