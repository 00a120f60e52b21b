//! Parts bodies that touch along an edge, as voxels of a segmentation do: an edge of four triangles
//! becomes two edges of two triangles.

use std::collections::{HashMap, HashSet};

use super::{Mesh, sides};
use crate::Vec3;

/// A triangle at an edge: its number, its direction along the edge, and its angle about the edge,
/// rad.
struct Leaf {
    triangle: u32,
    forward: bool,
    angle: f64,
}

/// Parts the bodies at every edge of more than two triangles. Returns the number of these edges. If
/// walls without an inside meet at one of these edges, the mesh stays as it was, and the number is
/// 0.
pub(super) fn part(mesh: &mut Mesh) -> usize {
    let mut around: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for (i, &t) in mesh.triangles.iter().enumerate() {
        for [a, b] in sides(t) {
            let edge = [a.min(b), a.max(b)];
            around.entry(edge).or_default().push(i as u32);
        }
    }
    let outward = vec![mesh.volume() > 0.0; mesh.triangles.len()];
    let own = each_outward(mesh, &around);
    let mut corners = Corners::new(mesh.triangles.len());
    let mut parted = HashSet::new();
    let mut edges = 0;
    for (&edge, triangles) in &around {
        let mut join = |a: u32, b: u32| {
            for vertex in edge {
                corners.join(corner(mesh, a, vertex), corner(mesh, b, vertex));
            }
        };
        match triangles.as_slice() {
            [_] => {}
            &[a, b] => join(a, b),
            many => {
                // The first try takes all triangles to face as the whole mesh does, because a
                // cavity that touches its body's skin has a negative volume of its own. The second
                // try takes each shell to face as its own volume tells, because bodies side by side
                // may be oriented differently.
                let found = pairs(mesh, edge, many, &outward);
                let Some(pairs) = found.or_else(|| pairs(mesh, edge, many, &own)) else {
                    return 0;
                };
                for [a, b] in pairs {
                    join(a, b);
                }
                parted.extend(edge);
                edges += 1;
            }
        }
    }
    if edges > 0 {
        corners.rename(mesh, &parted);
    }
    edges
}

/// For each triangle, true if its shell encloses a positive volume. A shell is connected across
/// edges of exactly two triangles.
fn each_outward(mesh: &Mesh, around: &HashMap<[u32; 2], Vec<u32>>) -> Vec<bool> {
    let mut shells = Corners::new(mesh.triangles.len());
    for triangles in around.values() {
        if let &[a, b] = triangles.as_slice() {
            shells.join(3 * a as usize, 3 * b as usize);
        }
    }
    let [min, max] = mesh.bounds();
    let origin = (min + max) / 2.0;
    let mut volume = vec![0.0; mesh.triangles.len()];
    for (i, &t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        volume[shells.root(3 * i) / 3] += a.dot(&b.cross(&c));
    }
    (0..volume.len())
        .map(|i| volume[shells.root(3 * i) / 3] > 0.0)
        .collect()
}

/// Number of a triangle's corner at this vertex.
fn corner(mesh: &Mesh, triangle: u32, vertex: u32) -> usize {
    let corners = mesh.triangles[triangle as usize];
    let k = corners.iter().position(|c| *c == vertex).unwrap_or(0);
    3 * triangle as usize + k
}

/// The triangles at an edge, in pairs with a body between the two. `outward` is true for triangles
/// that face out of their body. `None` if one of the triangles is a wall without an inside.
fn pairs(mesh: &Mesh, [a, b]: [u32; 2], all: &[u32], outward: &[bool]) -> Option<Vec<[u32; 2]>> {
    let [from, to] = [a, b].map(|i| mesh.vertices[i as usize]);
    let axis = (to - from).try_normalize(0.0)?;
    let least = if axis.x.abs() < 0.6 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let x = axis.cross(&least).try_normalize(0.0)?;
    let y = axis.cross(&x);
    let mut leaves = Vec::new();
    for &triangle in all {
        let corners = mesh.triangles[triangle as usize];
        let third = *corners.iter().find(|c| **c != a && **c != b)?;
        let out = mesh.vertices[third as usize] - from;
        leaves.push(Leaf {
            triangle,
            forward: sides(corners).contains(&[a, b]),
            angle: libm::atan2(out.dot(&y), out.dot(&x)),
        });
    }
    leaves.sort_by(|a, b| {
        a.angle
            .total_cmp(&b.angle)
            .then(a.triangle.cmp(&b.triangle))
    });
    // A turn about the edge enters a body through an outward triangle that runs back along the
    // edge. It leaves the body through an outward triangle that runs forward.
    let enters = |leaf: &Leaf| leaf.forward != outward[leaf.triangle as usize];
    let count = leaves.len();
    let alternate = (0..count).all(|i| enters(&leaves[i]) != enters(&leaves[(i + 1) % count]));
    if !alternate {
        return None;
    }
    let first = usize::from(!enters(&leaves[0]));
    let pair = |k: usize| [first + 2 * k, first + 2 * k + 1].map(|i| leaves[i % count].triangle);
    Some((0..count / 2).map(pair).collect())
}

/// Sets of triangles' corners that are one vertex.
struct Corners {
    parent: Vec<usize>,
}

impl Corners {
    fn new(triangles: usize) -> Self {
        Self {
            parent: (0..3 * triangles).collect(),
        }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Joins two sets. The smaller root wins, so that the order of joining does not matter.
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// Splits the vertices `parted`. The first set of corners at a vertex keeps the vertex. Each
    /// other set gets a copy of the vertex.
    fn rename(&mut self, mesh: &mut Mesh, parted: &HashSet<u32>) {
        let mut taken: HashSet<u32> = HashSet::new();
        let mut names: HashMap<usize, u32> = HashMap::new();
        for i in 0..self.parent.len() {
            let old = mesh.triangles[i / 3][i % 3];
            if !parted.contains(&old) {
                continue;
            }
            let root = self.root(i);
            let name = *names.entry(root).or_insert_with(|| {
                if taken.insert(old) {
                    return old;
                }
                mesh.vertices.push(mesh.vertices[old as usize]);
                mesh.vertices.len() as u32 - 1
            });
            mesh.triangles[i / 3][i % 3] = name;
        }
    }
}
