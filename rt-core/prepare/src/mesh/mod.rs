//! Triangle meshes: reading, mending, measuring.

mod close;
mod frame;
mod pieces;
mod read;
mod repair;
mod touch;
mod weld;
mod wrap;

pub use frame::OwnFrame;
pub use read::{Format, parse, read};
pub(crate) use repair::mend_body;
pub use repair::{Mended, mend};

use crate::Vec3;

/// A triangle surface. In a mended mesh, corners run anticlockwise seen from outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners of the triangles, m.
    pub vertices: Vec<Vec3>,
    /// Indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|i| self.vertices[i as usize])
    }

    /// Signed volume of a closed mesh, m³: positive if the mesh is oriented outward.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let Some(&origin) = self.vertices.first() else {
            return 0.0;
        };
        let six: f64 = self
            .triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = self.corners(t).map(|p| p - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        six / 6.0
    }

    /// Area of the surface, m².
    #[must_use]
    pub fn area(&self) -> f64 {
        let normals = self
            .triangles
            .iter()
            .map(|&t| scaled_normal(self.corners(t)));
        normals.map(|n| n.norm()).sum::<f64>() / 2.0
    }

    /// Smallest and largest coordinates; zeros for an empty mesh.
    #[must_use]
    pub fn bounds(&self) -> [Vec3; 2] {
        let Some(&first) = self.vertices.first() else {
            return [Vec3::zeros(); 2];
        };
        let all = self.vertices.iter();
        all.fold([first; 2], |[min, max], p| [min.inf(p), max.sup(p)])
    }

    /// Unit normals of the vertices: the mean of the normals of each vertex's triangles, weighted
    /// by the triangles' angles at the vertex.
    #[must_use]
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.vertices.len()];
        for &t in &self.triangles {
            let p = self.corners(t);
            let Some(n) = scaled_normal(p).try_normalize(0.0) else {
                continue;
            };
            for k in 0..3 {
                let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                normals[t[k] as usize] += n * libm::atan2(u.cross(&v).norm(), u.dot(&v));
            }
        }
        for n in &mut normals {
            *n = n.try_normalize(1e-12).unwrap_or_else(Vec3::z);
        }
        normals
    }

    /// True if every edge joins exactly two triangles, which run along the edge in opposite
    /// directions.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let mut edges: Vec<[u32; 2]> = self.triangles.iter().flat_map(|&t| sides(t)).collect();
        edges.sort_unstable();
        let unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
        unique
            && edges
                .iter()
                .all(|&[a, b]| edges.binary_search(&[b, a]).is_ok())
    }

    /// The mesh without the vertices that no triangle uses. If a triangle uses a vertex that does
    /// not exist, the mesh stays as it is.
    #[must_use]
    pub(crate) fn without_unused(self) -> Self {
        let mut used = vec![false; self.vertices.len()];
        for &i in self.triangles.as_flattened() {
            let Some(used) = used.get_mut(i as usize) else {
                return self;
            };
            *used = true;
        }
        let mut new_index = vec![0u32; self.vertices.len()];
        let mut vertices = Vec::new();
        for (i, p) in self.vertices.iter().enumerate() {
            if used[i] {
                new_index[i] = vertices.len() as u32;
                vertices.push(*p);
            }
        }
        let renumbered = self.triangles.iter();
        let renumbered = renumbered.map(|t| t.map(|i| new_index[i as usize]));
        Self {
            vertices,
            triangles: renumbered.collect(),
        }
    }

    /// Appends another mesh.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        let shifted = other.triangles.iter().map(|t| t.map(|i| i + first));
        self.triangles.extend(shifted);
    }
}

/// Normal of a triangle, as long as twice its area.
pub(crate) fn scaled_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// Directed edges of a triangle.
pub(crate) fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
