//! Makes a new closed surface around triangles that cannot be closed. Wrapping puts the surface
//! where the generalised winding number (Jacobson et al. 2013) passes one half; sealing puts it
//! where a ball that comes from outside is stopped. Both pull the surface onto near triangles.

use rayon::prelude::*;

use super::{Mesh, OwnFrame, scaled_normal};
use crate::Vec3;
use crate::field::{Field, Grid, Nearest, Sign};
use crate::surface_nets;

/// Number of grid cells along the longest side of the mesh.
const CELLS: f64 = 90.0;
/// Largest number of points of the grid, approximately.
const POINTS_MAX: f64 = 2.5e6;
/// Largest number of triangles in a leaf of the tree.
const LEAF: usize = 12;
/// A group of triangles counts as one dipole from this many of its radii away (Barill et al. 2018).
const FAR: f64 = 2.3;

/// Winding number of the surface around a point: 1 inside, 0 outside, between 0 and 1 near an
/// opening.
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
    2.0 * libm::atan2(numerator, denominator)
}

/// A closed surface around the space with a winding number above one half. `None` if there is no
/// such space.
pub(super) fn wrap(mesh: &Mesh) -> Option<Mesh> {
    let frame = OwnFrame::of(mesh);
    wrap_own(&frame.own_mesh(mesh)).map(|own| frame.world_mesh(&own))
}

fn wrap_own(mesh: &Mesh) -> Option<Mesh> {
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

/// A closed surface around everything that a ball cannot reach from outside. The ball's diameter is
/// a tenth of the mesh's extent. `None` if the ball reaches everything.
pub(super) fn seal(mesh: &Mesh) -> Option<Mesh> {
    let frame = OwnFrame::of(mesh);
    seal_own(&frame.own_mesh(mesh)).map(|own| frame.world_mesh(&own))
}

fn seal_own(mesh: &Mesh) -> Option<Mesh> {
    let [min, max] = mesh.bounds();
    let extent = (max - min).max();
    // A thin tube needs finer cells. Its radius is area / (4π length) if its wall has two sides.
    let tube_radius = mesh.area() / (4.0 * std::f64::consts::PI * extent);
    let finest = libm::cbrt((max - min).add_scalar(0.1 * extent).product() / POINTS_MAX);
    let cell_m = (extent / CELLS).min(0.25 * tube_radius).max(finest);
    let radius_m = extent / 20.0;
    let margin = (radius_m / cell_m).ceil() as usize + 3;
    let grid = Grid::around([min, max], cell_m, margin);
    let everywhere_outside = vec![false; grid.len()];
    let mut field = Field::new(mesh, grid, Sign::Given(&everywhere_outside));
    let outside = reached_from_outside(&field, radius_m);
    for (distance, outside) in field.distance_m.iter_mut().zip(&outside) {
        if !outside {
            *distance = -*distance;
        }
    }
    let values: Vec<f64> = field.distance_m.iter().map(|&d| f64::from(d)).collect();
    let mut sealed = surface_nets::surface(&field.grid, &values);
    if sealed.triangles.is_empty() {
        return None;
    }
    // Settle onto the outer triangles only: the inner side of a thin wall is about as near.
    let is_outer = |&t: &[u32; 3]| {
        let corners = mesh.corners(t);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let normal = scaled_normal(corners)
            .try_normalize(0.0)
            .unwrap_or_default();
        [1.0, -1.0].iter().any(|side| {
            let p = (middle + normal * (side * 1.2 * cell_m) - field.grid.origin) / cell_m;
            let at =
                [0, 1, 2].map(|k| (p[k].round().max(0.0) as usize).min(field.grid.size[k] - 1));
            outside[field.grid.index(at)]
        })
    };
    let outer = Mesh {
        vertices: mesh.vertices.clone(),
        triangles: mesh
            .triangles
            .iter()
            .filter(|t| is_outer(t))
            .copied()
            .collect(),
    };
    settle(&mut sealed, &Nearest::new(&outer)?, cell_m);
    Some(sealed)
}

/// For each grid point, true if a ball of this radius that comes from the grid's border and does
/// not touch the surface can cover the point.
fn reached_from_outside(field: &Field, radius_m: f64) -> Vec<bool> {
    let grid = &field.grid;
    let free = |i: usize| f64::from(field.distance_m[i]) > radius_m;
    let mut core = vec![false; grid.len()];
    let mut stack = vec![0];
    core[0] = true;
    while let Some(i) = stack.pop() {
        for next in grid.neighbours(i) {
            if !core[next] && free(next) {
                core[next] = true;
                stack.push(next);
            }
        }
    }
    let mut reached = core.clone();
    // The ball reaches half a cell farther, because its centre may lie between grid points.
    let reach_m = radius_m + 0.5 * grid.cell_m;
    for i in (0..grid.len()).filter(|&i| core[i] && grid.neighbours(i).any(|next| !core[next])) {
        let p = grid.position(grid.coordinates(i));
        for z in grid.span(2, p.z - reach_m, p.z + reach_m) {
            for y in grid.span(1, p.y - reach_m, p.y + reach_m) {
                let line = grid.position([0, y, z]);
                let off = (line.y - p.y).powi(2) + (line.z - p.z).powi(2);
                let half = (reach_m * reach_m - off).max(0.0).sqrt();
                if half > 0.0 {
                    let row = grid.index([0, y, z]);
                    for x in grid.span(0, p.x - half, p.x + half) {
                        reached[row + x] = true;
                    }
                }
            }
        }
    }
    reached
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

/// The triangles in nested groups. Each group has a dipole.
struct Tree<'a> {
    mesh: &'a Mesh,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

struct Node {
    first: usize,
    count: usize,
    /// Index of the second child; 0 for a leaf. The first child follows its parent.
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
