//! A new closed surface around triangles that cannot be closed: where the generalised winding
//! number (Jacobson et al. 2013) passes one half, drawn onto the triangles where they are near.

use rayon::prelude::*;

use super::{Mesh, scaled_normal};
use crate::Vec3;
use crate::field::{Field, Grid, Nearest, Sign};
use crate::surface_nets;

/// Cells along the longest side of the mesh.
const CELLS: f64 = 90.0;
/// Triangles in a leaf.
const LEAF: usize = 12;
/// A group of triangles this many radii away counts as one dipole (Barill et al. 2018).
const FAR: f64 = 2.3;

/// How often the surface winds around a point: 1 inside, 0 outside, between them where it is open.
pub(super) fn winding(mesh: &Mesh, p: &Vec3) -> f64 {
    let all = mesh.triangles.iter();
    all.map(|&t| solid_angle(mesh.corners(t), p)).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Signed solid angle of a triangle (van Oosterom and Strackee 1983).
fn solid_angle(corners: [Vec3; 3], p: &Vec3) -> f64 {
    let [a, b, c] = corners.map(|q| q - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// A closed surface around the triangles, or `None` if they enclose nothing.
pub(super) fn wrap(mesh: &Mesh) -> Option<Mesh> {
    let [min, max] = mesh.bounds();
    let cell_m = (max - min).max() / CELLS;
    let grid = Grid::around([min, max], cell_m, 3);
    let tree = Tree::new(mesh);
    let inside: Vec<bool> = (0..grid.len())
        .into_par_iter()
        .map(|i| tree.winding(&grid.position(grid.coordinates(i))) > 0.5)
        .collect();
    if !inside.contains(&true) {
        return None;
    }
    let field = Field::new(mesh, grid, Sign::Given(&inside));
    let values: Vec<f64> = field.distance_m.iter().map(|&d| f64::from(d)).collect();
    let mut wrapped = surface_nets::surface(&field.grid, &values);
    settle(&mut wrapped, &Nearest::new(mesh)?, cell_m);
    Some(wrapped)
}

/// Smooths the surface, and pulls vertices that are near the triangles onto them.
fn settle(wrapped: &mut Mesh, nearest: &Nearest<'_>, cell_m: f64) {
    let mut neighbours = vec![Vec::new(); wrapped.vertices.len()];
    for [a, b] in wrapped.triangles.iter().flat_map(|&t| super::sides(t)) {
        neighbours[a as usize].push(b);
    }
    for _ in 0..6 {
        let old = wrapped.vertices.clone();
        for (p, around) in wrapped.vertices.iter_mut().zip(&neighbours) {
            if around.is_empty() {
                continue;
            }
            let mean = around.iter().map(|&i| old[i as usize]).sum::<Vec3>() / around.len() as f64;
            *p = p.lerp(&mean, 0.5);
            let on_surface = nearest.point(p);
            if (on_surface - *p).norm() < cell_m {
                *p = on_surface;
            }
        }
    }
}

/// Triangles in nested groups, each with its dipole.
struct Tree<'a> {
    mesh: &'a Mesh,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

struct Node {
    first: usize,
    count: usize,
    /// Second child; the first follows its parent. 0: a leaf.
    second: usize,
    middle: Vec3,
    radius: f64,
    /// Sum of the triangles' areas times their normals.
    dipole: Vec3,
}

impl<'a> Tree<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let mut tree = Self {
            mesh,
            order: (0..mesh.triangles.len() as u32).collect(),
            nodes: Vec::new(),
        };
        tree.build(0, mesh.triangles.len());
        tree
    }

    fn corners(&self, i: usize) -> [Vec3; 3] {
        self.mesh
            .corners(self.mesh.triangles[self.order[i] as usize])
    }

    fn build(&mut self, first: usize, count: usize) -> usize {
        let mut sum = Vec3::zeros();
        let mut dipole = Vec3::zeros();
        let mut area = 0.0;
        for i in first..first + count {
            let corners = self.corners(i);
            let normal = scaled_normal(corners) / 2.0;
            dipole += normal;
            area += normal.norm();
            sum += (corners[0] + corners[1] + corners[2]) / 3.0 * normal.norm();
        }
        let middle = if area > 0.0 {
            sum / area
        } else {
            self.corners(first)[0]
        };
        let all = (first..first + count).flat_map(|i| self.corners(i));
        let radius = all.map(|p| (p - middle).norm()).fold(0.0, f64::max);
        let index = self.nodes.len();
        self.nodes.push(Node {
            first,
            count,
            second: 0,
            middle,
            radius,
            dipole,
        });
        if count > LEAF {
            let mesh = self.mesh;
            let center = |&i: &u32| {
                let [a, b, c] = mesh.corners(mesh.triangles[i as usize]);
                a + b + c
            };
            let group = &mut self.order[first..first + count];
            let low = group
                .iter()
                .map(center)
                .reduce(|a, b| a.inf(&b))
                .unwrap_or_default();
            let high = group
                .iter()
                .map(center)
                .reduce(|a, b| a.sup(&b))
                .unwrap_or_default();
            let axis = (high - low).imax();
            group.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b)));
            self.build(first, count / 2);
            let second = self.build(first + count / 2, count - count / 2);
            self.nodes[index].second = second;
        }
        index
    }

    fn winding(&self, p: &Vec3) -> f64 {
        let mut sum = 0.0;
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let to = node.middle - p;
            let distance = to.norm();
            if distance > FAR * node.radius {
                sum += node.dipole.dot(&to) / distance.powi(3);
            } else if node.second == 0 {
                let all = node.first..node.first + node.count;
                sum += all.map(|i| solid_angle(self.corners(i), p)).sum::<f64>();
            } else {
                stack.extend([index + 1, node.second]);
            }
        }
        sum / (4.0 * std::f64::consts::PI)
    }
}
