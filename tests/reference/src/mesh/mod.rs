//! Meshes of quadratic (10-node) tetrahedra.

mod cut;
mod lattice;
mod locate;
mod octree;
mod structured;

use std::collections::{BTreeMap, HashMap};

pub use crate::element::EDGES;
pub use lattice::lattice;
pub use locate::Locator;
pub use octree::graded;
pub use structured::{block, shell_octant};

use crate::element;
use crate::{FemError, Vec3};

/// Corners of each side, counter-clockwise as seen from outside.
const SIDES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// A solid body at rest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Positions at rest, m.
    pub nodes: Vec<Vec3>,
    /// Nodes of each element: four corners, then the middles of [`EDGES`]; positively oriented.
    pub tets: Vec<[u32; 10]>,
    /// Boundary triangles: three corners, counter-clockwise as seen from outside, then the middles
    /// of the sides 01, 12, 20.
    pub faces: Vec<[u32; 6]>,
}

impl Mesh {
    /// Makes quadratic elements from linear ones. Reorders the corners of inverted elements.
    #[must_use]
    pub fn from_linear(corners: Vec<Vec3>, tets: &[[u32; 4]]) -> Self {
        let mut mesh = Self {
            nodes: corners,
            ..Self::default()
        };
        let mut middles = HashMap::new();
        for &(mut t) in tets {
            let at = |i: usize| mesh.nodes[t[i] as usize];
            if (at(1) - at(0))
                .cross(&(at(2) - at(0)))
                .dot(&(at(3) - at(0)))
                < 0.0
            {
                t.swap(1, 2);
            }
            let mut element = [0; 10];
            element[..4].copy_from_slice(&t);
            for (k, [i, j]) in EDGES.into_iter().enumerate() {
                let key = (t[i].min(t[j]), t[i].max(t[j]));
                element[4 + k] = *middles.entry(key).or_insert_with(|| {
                    let middle = (mesh.nodes[key.0 as usize] + mesh.nodes[key.1 as usize]) / 2.0;
                    mesh.nodes.push(middle);
                    mesh.nodes.len() as u32 - 1
                });
            }
            mesh.tets.push(element);
        }
        mesh.find_faces();
        mesh
    }

    fn find_faces(&mut self) {
        let mut count = HashMap::new();
        let side = |t: &[u32; 10], s: [usize; 3]| {
            let mut key = s.map(|i| t[i]);
            key.sort_unstable();
            key
        };
        for t in &self.tets {
            for s in SIDES {
                *count.entry(side(t, s)).or_insert(0) += 1;
            }
        }
        self.faces.clear();
        for t in &self.tets {
            for s in SIDES {
                if count[&side(t, s)] == 1 {
                    let middle = |i: usize, j: usize| {
                        let k = EDGES.iter().position(|e| *e == [i, j] || *e == [j, i]);
                        t[4 + k.unwrap_or(0)]
                    };
                    let [a, b, c] = s;
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    self.faces.push([t[a], t[b], t[c], ab, bc, ca]);
                }
            }
        }
    }

    /// Moves every node, also the middles of edges. Straight edges may become curved.
    #[must_use]
    pub fn mapped(mut self, place: impl Fn(&Vec3) -> Vec3) -> Self {
        for node in &mut self.nodes {
            *node = place(node);
        }
        for t in &mut self.tets {
            let at = |i: usize| self.nodes[t[i] as usize];
            if (at(1) - at(0))
                .cross(&(at(2) - at(0)))
                .dot(&(at(3) - at(0)))
                < 0.0
            {
                t.swap(1, 2);
                t.swap(4, 6);
                t.swap(8, 9);
            }
        }
        self.find_faces();
        self
    }

    /// Joins meshes. Nodes within `tolerance_m` of each other become one.
    #[must_use]
    pub fn joined(parts: &[Self], tolerance_m: f64) -> Self {
        let mut mesh = Self::default();
        let mut known: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let cell = |p: &Vec3, k: usize| (p[k] / (4.0 * tolerance_m)).round() as i64;
        for part in parts {
            let mut number = Vec::with_capacity(part.nodes.len());
            for p in &part.nodes {
                let home = [cell(p, 0), cell(p, 1), cell(p, 2)];
                let near = neighbour_cells(home)
                    .filter_map(|c| known.get(&c))
                    .flatten()
                    .find(|&&n| (mesh.nodes[n as usize] - p).norm() <= tolerance_m);
                let n = near.copied().unwrap_or_else(|| {
                    mesh.nodes.push(*p);
                    mesh.nodes.len() as u32 - 1
                });
                if near.is_none() {
                    known.entry(home).or_default().push(n);
                }
                number.push(n);
            }
            let renumbered = part.tets.iter().map(|t| t.map(|n| number[n as usize]));
            mesh.tets.extend(renumbered);
        }
        mesh.find_faces();
        mesh
    }

    /// Moves corners on the boundary, and the middles of their edges half as far, unless that would
    /// distort an adjacent element too much. `place` receives a corner and the other corners of its
    /// boundary faces, and returns the corner's new position.
    pub fn stretch_corners(&mut self, place: impl Fn(&Vec3, &[Vec3]) -> Vec3) {
        let mut beside: BTreeMap<u32, Vec<Vec3>> = BTreeMap::new();
        for face in &self.faces {
            for &n in &face[..3] {
                let others = face[..3].iter().filter(|&&m| m != n);
                let others = others.map(|&m| self.nodes[m as usize]);
                beside.entry(n).or_default().extend(others);
            }
        }
        let mut owners: HashMap<u32, Vec<usize>> = HashMap::new();
        for (e, t) in self.tets.iter().enumerate() {
            for &n in &t[..4] {
                owners.entry(n).or_default().push(e);
            }
        }
        for (n, beside) in beside {
            let from = self.nodes[n as usize];
            let by = place(&from, &beside) - from;
            if by.norm_squared() == 0.0 {
                continue;
            }
            let mut moved = BTreeMap::from([(n, by)]);
            for &e in &owners[&n] {
                let t = &self.tets[e];
                for (k, [i, j]) in EDGES.iter().enumerate() {
                    if t[*i] == n || t[*j] == n {
                        moved.insert(t[4 + k], by / 2.0);
                    }
                }
            }
            // Try the whole displacement first, then half of it, then a quarter.
            for share in [1.0, 0.5, 0.25] {
                for (&m, by) in &moved {
                    self.nodes[m as usize] += by * share;
                }
                let is_valid = |e: &usize| {
                    let x = self.tets[*e].map(|n| self.nodes[n as usize]);
                    element::smallest_jacobian(&x) > 0.3 * element::straight_jacobian(&x)
                        && element::straight_jacobian(&x) > 0.0
                };
                if owners[&n].iter().all(is_valid) {
                    break;
                }
                for (&m, by) in &moved {
                    self.nodes[m as usize] -= by * share;
                }
            }
        }
    }

    /// Moves the middles of boundary edges onto the true surface, unless that would distort an
    /// adjacent element too much. Returns the number of middles that stayed on their straight edge.
    pub fn curve_boundary(&mut self, onto_surface: impl Fn(&Vec3) -> Vec3) -> usize {
        let mut owners: HashMap<u32, Vec<usize>> = HashMap::new();
        for (e, t) in self.tets.iter().enumerate() {
            for &n in &t[4..] {
                owners.entry(n).or_default().push(e);
            }
        }
        let mut done = vec![false; self.nodes.len()];
        let mut kept = 0;
        for face in self.faces.clone() {
            for n in face[3..].iter().map(|&n| n as usize) {
                if std::mem::replace(&mut done[n], true) {
                    continue;
                }
                let old = self.nodes[n];
                self.nodes[n] = onto_surface(&old);
                let is_valid = |e: &usize| {
                    let x = self.tets[*e].map(|n| self.nodes[n as usize]);
                    element::smallest_jacobian(&x) > 0.3 * element::straight_jacobian(&x)
                };
                if !owners[&(n as u32)].iter().all(is_valid) {
                    self.nodes[n] = old;
                    kept += 1;
                }
            }
        }
        kept
    }

    /// Volume with every node displaced, m³; at rest for `None`.
    ///
    /// # Errors
    /// [`FemError::Element`] if the mesh has an element that is inside out at rest.
    pub fn volume_m3(&self, displacement: Option<&[Vec3]>) -> Result<f64, FemError> {
        let elements = element::prepare(&self.nodes, &self.tets)?;
        let mut volume = 0.0;
        for (element, t) in elements.iter().zip(&self.tets) {
            for q in &element.points {
                let f = displacement.map_or_else(nalgebra::Matrix3::identity, |u| q.gradient(t, u));
                volume += q.weight_m3 * f.determinant();
            }
        }
        Ok(volume)
    }

    /// Indices of the nodes whose rest position `pick` accepts.
    #[must_use]
    pub fn nodes_where(&self, pick: impl Fn(&Vec3) -> bool) -> Vec<u32> {
        let chosen = |&n: &u32| pick(&self.nodes[n as usize]);
        (0..self.nodes.len() as u32).filter(chosen).collect()
    }

    /// Indices of the boundary faces for which `pick` accepts the rest positions of all corners.
    #[must_use]
    pub fn faces_where(&self, pick: impl Fn(&Vec3) -> bool) -> Vec<u32> {
        let inside = |f: &[u32; 6]| f[..3].iter().all(|&n| pick(&self.nodes[n as usize]));
        let chosen = |&i: &u32| inside(&self.faces[i as usize]);
        (0..self.faces.len() as u32).filter(chosen).collect()
    }
}

fn neighbour_cells(home: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |i| {
        [
            home[0] + i % 3 - 1,
            home[1] + i / 3 % 3 - 1,
            home[2] + i / 9 - 1,
        ]
    })
}
