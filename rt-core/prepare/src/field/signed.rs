//! Signed distance on a grid: exact near the surface, approximate farther away.

use super::{Grid, closest_on_triangle, crossing};
use crate::Vec3;
use crate::mesh::Mesh;

const NONE: u32 = u32::MAX;
/// Width of the near band, in cells: a triangle is tried for all points this close to its box.
const BAND: f64 = 1.5;

/// Method that tells the inside from the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sign<'a> {
    /// Count the crossings of grid lines with the mesh, which must be closed.
    Closed,
    /// Take this value for each grid point: true is inside.
    Given(&'a [bool]),
}

/// Signed distance to a mesh on a grid, negative inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The points.
    pub grid: Grid,
    /// Signed distance of each point from the mesh, m. With [`Sign::Closed`], distances outside are
    /// at most one and a half cells, the width of the near band.
    pub distance_m: Vec<f32>,
}

impl Field {
    /// Computes the distance to a mesh on this grid.
    #[must_use]
    pub fn new(mesh: &Mesh, grid: Grid, sign: Sign<'_>) -> Self {
        let computed;
        let (inside, everywhere) = match sign {
            Sign::Given(inside) => (inside, true),
            Sign::Closed => {
                computed = crossing::inside(mesh, &grid);
                (computed.as_slice(), false)
            }
        };
        // Far outside a closed mesh only a lower bound is needed.
        let unknown = (BAND * grid.cell_m).powi(2);
        let start = |&inside: &bool| {
            if inside || everywhere {
                f64::INFINITY
            } else {
                unknown
            }
        };
        let mut sweep = Sweep {
            mesh,
            squared: inside.iter().map(start).collect(),
            nearest: vec![NONE; grid.len()],
            grid: &grid,
        };
        sweep.near_band();
        sweep.carry();
        let squared = sweep.squared;
        let signed = |(squared, inside): (&f64, &bool)| {
            let distance = squared.sqrt() as f32;
            if *inside { -distance } else { distance }
        };
        Self {
            distance_m: squared.iter().zip(inside).map(signed).collect(),
            grid,
        }
    }

    /// True if a grid point lies inside.
    #[must_use]
    pub fn is_inside(&self, index: usize) -> bool {
        self.distance_m[index] < 0.0
    }

    /// Signed distance at a place, interpolated, m. A place beyond the grid has the distance of the
    /// nearest place of the grid's border.
    #[must_use]
    pub fn at(&self, p: &Vec3) -> f64 {
        let (low, share) = self.cell_of(p);
        let mut sum = 0.0;
        for corner in 0..8 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f64 = (0..3)
                .map(|k| {
                    if step[k] == 1 {
                        share[k]
                    } else {
                        1.0 - share[k]
                    }
                })
                .product();
            let index = self
                .grid
                .index([low[0] + step[0], low[1] + step[1], low[2] + step[2]]);
            sum += weight * f64::from(self.distance_m[index]);
        }
        sum
    }

    /// Direction in which the distance grows fastest: near the surface the outward normal. A unit
    /// vector, or zero.
    #[must_use]
    pub fn outward(&self, p: &Vec3) -> Vec3 {
        let step = self.grid.cell_m;
        let slope = |axis: Vec3| self.at(&(p + axis * step)) - self.at(&(p - axis * step));
        Vec3::new(slope(Vec3::x()), slope(Vec3::y()), slope(Vec3::z()))
            .try_normalize(1e-12)
            .unwrap_or_else(Vec3::zeros)
    }

    fn cell_of(&self, p: &Vec3) -> ([usize; 3], [f64; 3]) {
        let mut low = [0; 3];
        let mut share = [0.0; 3];
        for k in 0..3 {
            let last = (self.grid.size[k] - 2) as f64;
            let at = (p[k] - self.grid.origin[k]) / self.grid.cell_m;
            let cell = at.floor().clamp(0.0, last);
            low[k] = cell as usize;
            share[k] = (at - cell).clamp(0.0, 1.0);
        }
        (low, share)
    }
}

struct Sweep<'a> {
    mesh: &'a Mesh,
    grid: &'a Grid,
    squared: Vec<f64>,
    nearest: Vec<u32>,
}

impl Sweep<'_> {
    /// Computes exact distances near the triangles.
    fn near_band(&mut self) {
        let band = BAND * self.grid.cell_m;
        for (number, &triangle) in self.mesh.triangles.iter().enumerate() {
            let corners = self.mesh.corners(triangle);
            let low = corners[0].inf(&corners[1]).inf(&corners[2]);
            let high = corners[0].sup(&corners[1]).sup(&corners[2]);
            let span = |k: usize| self.grid.span(k, low[k] - band, high[k] + band);
            let (xs, ys, zs) = (span(0), span(1), span(2));
            for z in zs {
                for y in ys.clone() {
                    for x in xs.clone() {
                        self.offer([x, y, z], number as u32, &corners);
                    }
                }
            }
        }
    }

    fn offer(&mut self, at: [usize; 3], number: u32, corners: &[Vec3; 3]) {
        let index = self.grid.index(at);
        let p = self.grid.position(at);
        let squared = (closest_on_triangle(&p, corners) - p).norm_squared();
        if squared < self.squared[index] {
            self.squared[index] = squared;
            self.nearest[index] = number;
        }
    }

    /// Lets each point beyond the near band try the nearest triangles of its neighbours, in sweeps
    /// of eight directions.
    fn carry(&mut self) {
        let [nx, ny, nz] = self.grid.size;
        let far = (BAND * self.grid.cell_m).powi(2);
        for direction in 0..8 {
            let order = |k: usize, n: usize, i: usize| {
                if direction >> k & 1 == 0 {
                    i
                } else {
                    n - 1 - i
                }
            };
            for k in 0..nz {
                for j in 0..ny {
                    for i in 0..nx {
                        let at = [order(0, nx, i), order(1, ny, j), order(2, nz, k)];
                        // Distances up to the width of the near band are exact already.
                        if self.squared[self.grid.index(at)] > far {
                            self.try_neighbours(at, direction);
                        }
                    }
                }
            }
        }
    }

    fn try_neighbours(&mut self, at: [usize; 3], direction: usize) {
        for k in 0..3 {
            let mut neighbour = at;
            if direction >> k & 1 == 0 {
                if at[k] == 0 {
                    continue;
                }
                neighbour[k] -= 1;
            } else {
                if at[k] + 1 == self.grid.size[k] {
                    continue;
                }
                neighbour[k] += 1;
            }
            let number = self.nearest[self.grid.index(neighbour)];
            if number != NONE && number != self.nearest[self.grid.index(at)] {
                let corners = self.mesh.corners(self.mesh.triangles[number as usize]);
                self.offer(at, number, &corners);
            }
        }
    }
}
