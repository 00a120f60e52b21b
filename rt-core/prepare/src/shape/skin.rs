//! Makes a surface of even triangles from a distance function.

use rayon::prelude::*;

use crate::Vec3;
use crate::field::Grid;
use crate::mesh::{Mesh, sides};
use crate::surface_nets;

/// Number of rounds in which vertices slide along the surface and are put back onto it.
const ROUNDS: usize = 12;

/// The surface where `distance` is zero within the bounds. The triangles' sides are about `edge_m`
/// long. Surface nets give the first mesh. Then vertices slide along the surface until they are
/// evenly spaced, so that the grid leaves no pattern, and Newton steps put them back onto it.
#[must_use]
pub fn skin(distance: &(dyn Fn(&Vec3) -> f64 + Sync), bounds: [Vec3; 2], edge_m: f64) -> Mesh {
    let grid = Grid::around(bounds, edge_m, 1);
    let values: Vec<f64> = (0..grid.len())
        .into_par_iter()
        .map(|i| distance(&grid.position(grid.coordinates(i))))
        .collect();
    let mut mesh = surface_nets::surface(&grid, &values);
    let mut neighbours = vec![Vec::new(); mesh.vertices.len()];
    for [a, b] in mesh.triangles.iter().flat_map(|&t| sides(t)) {
        neighbours[a as usize].push(b);
    }
    for _ in 0..ROUNDS {
        let old = mesh.vertices.clone();
        mesh.vertices = old
            .par_iter()
            .zip(&neighbours)
            .map(|(p, around)| {
                let mean = around.iter().map(|&i| old[i as usize]).sum::<Vec3>()
                    / around.len().max(1) as f64;
                let normal = slope(distance, p, edge_m).normalize();
                let along = mean - p;
                let slid = p + (along - normal * along.dot(&normal)) * 0.6;
                onto(distance, slid, edge_m)
            })
            .collect();
    }
    mesh
}

/// Moves a point onto the surface by two Newton steps, none longer than half a triangle's side.
fn onto(distance: &(dyn Fn(&Vec3) -> f64 + Sync), mut p: Vec3, edge_m: f64) -> Vec3 {
    for _ in 0..2 {
        let gradient = slope(distance, &p, edge_m);
        let step = gradient * (distance(&p) / gradient.norm_squared().max(1e-6));
        p -= step.cap_magnitude(edge_m / 2.0);
    }
    p
}

fn slope(distance: &(dyn Fn(&Vec3) -> f64 + Sync), p: &Vec3, edge_m: f64) -> Vec3 {
    let h = 0.05 * edge_m;
    let along = |axis: Vec3| (distance(&(p + axis * h)) - distance(&(p - axis * h))) / (2.0 * h);
    Vec3::new(along(Vec3::x()), along(Vec3::y()), along(Vec3::z()))
}
