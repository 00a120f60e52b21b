//! Fit of spheres to their organ.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::{Ball, Interior};
use crate::Vec3;
use crate::mesh::Mesh;

/// Figures of the fit of spheres to their organ.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Quality {
    /// Share of the grid points inside that lie in at least one sphere.
    pub coverage: f64,
    /// Mean distance from the skin to the nearest sphere, m.
    pub gap_mean_m: f64,
    /// Distance from the nearest sphere within which 95 % of the skin lies, m.
    pub gap_95_m: f64,
    /// Largest distance from the skin to the nearest sphere, m.
    pub gap_max_m: f64,
    /// Length by which the worst sphere sticks out of the skin, m.
    pub protrusion_max_m: f64,
}

impl Quality {
    /// Measures the fit of spheres to the skin `mesh`. Gaps are measured at the triangles' middles
    /// and weighted by the triangles' areas.
    #[must_use]
    pub fn measure(interior: &Interior<'_>, mesh: &Mesh, balls: &[Ball]) -> Self {
        let gap = |p: &Vec3| {
            let distance = |b: &Ball| (b.center - p).norm() - b.radius_m;
            balls
                .iter()
                .map(distance)
                .fold(f64::INFINITY, f64::min)
                .max(0.0)
        };
        let mut gaps: Vec<(f64, f64)> = mesh
            .triangles
            .par_iter()
            .map(|&t| {
                let corners = mesh.corners(t);
                let area = crate::mesh::scaled_normal(corners).norm();
                (gap(&((corners[0] + corners[1] + corners[2]) / 3.0)), area)
            })
            .collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = gaps.iter().map(|(_, area)| area).sum();
        let mut below = 0.0;
        let at_95 = gaps.iter().find(|(_, area)| {
            below += area;
            below >= 0.95 * total
        });
        let protrusion = |b: &Ball| b.radius_m - interior.depth(&b.center);
        Self {
            coverage: coverage(interior, balls),
            gap_mean_m: gaps.iter().map(|(gap, area)| gap * area).sum::<f64>() / total,
            gap_95_m: at_95.map_or(0.0, |(gap, _)| *gap),
            gap_max_m: gaps.last().map_or(0.0, |(gap, _)| *gap),
            protrusion_max_m: balls.iter().map(protrusion).fold(0.0, f64::max),
        }
    }
}

fn coverage(interior: &Interior<'_>, balls: &[Ball]) -> f64 {
    let grid = &interior.field.grid;
    let mut covered = vec![false; grid.len()];
    for b in balls {
        let center = interior.frame.own(&b.center);
        let span = |k: usize| grid.span(k, center[k] - b.radius_m, center[k] + b.radius_m);
        for z in span(2) {
            for y in span(1) {
                let line = grid.position([0, y, z]);
                let off = (line.y - center.y).powi(2) + (line.z - center.z).powi(2);
                let half = b.radius_m * b.radius_m - off;
                if half >= 0.0 {
                    let half = half.sqrt();
                    let row = grid.index([0, y, z]);
                    for x in grid.span(0, center.x - half, center.x + half) {
                        covered[row + x] = true;
                    }
                }
            }
        }
    }
    let inside = interior
        .points
        .iter()
        .filter(|&&i| covered[i as usize])
        .count();
    inside as f64 / interior.points.len() as f64
}

/// Isotropy of the links' directions: λmin/λmax of Σddᵀ over the unit directions `d` of a sphere's
/// links, mean over the spheres.
#[must_use]
pub fn isotropy(balls: &[Ball], links: &[[u32; 2]]) -> f64 {
    let mut sums = vec![Matrix3::<f64>::zeros(); balls.len()];
    for &[a, b] in links {
        let d = balls[b as usize].center - balls[a as usize].center;
        if let Some(d) = d.try_normalize(0.0) {
            sums[a as usize] += d * d.transpose();
            sums[b as usize] += d * d.transpose();
        }
    }
    let ratio = |sum: &Matrix3<f64>| {
        let eigenvalues = sum.symmetric_eigenvalues();
        let max = eigenvalues.max();
        if max > 0.0 {
            eigenvalues.min().max(0.0) / max
        } else {
            0.0
        }
    };
    sums.iter().map(ratio).sum::<f64>() / balls.len().max(1) as f64
}
