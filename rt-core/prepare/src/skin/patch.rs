//! Width of the patch over which the spheres spread a force on a vertex of the contact skin.
//!
//! The spheres have the compliance `c_patch` under a force on the vertex, and `c_wide` under the
//! same force spread over a Gaussian of width `A` on the skin. The spheres are fine enough for the
//! Gaussian, whose local compliance on a half-space is `0.399 / (E* A)`. So the local compliance of
//! the spheres at the vertex is `c = c_patch − c_wide + 0.399 / (E* A)`. The spheres act as if they
//! spread the force over a patch of width `0.399 / (E* c)`. Distant influences (the organ's shape,
//! its attachments) are in both compliances and cancel, so a neighbourhood of a few spacings is
//! enough.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3};
use rayon::prelude::*;
use rt_core::tissue::neo_hookean::{POISSON_MAX, STIFFNESS_SHARE};

use super::ContactSkin;
use crate::Vec3;
use crate::pack::Ball;
use crate::tetra::Tetra;

/// Width `A` of the Gaussian, in spacings of the spheres.
const WIDE_SPACINGS: f64 = 1.5;
/// Radius of the neighbourhood, in spacings.
const NEIGHBOURHOOD_SPACINGS: f64 = 3.2;
/// Mean of `A / (π d)`, where d is the distance between two random points of a Gaussian
/// `exp(−r²/A²)`: `1 / √(2π)`.
const GAUSSIAN: f64 = 0.398_942_3;
/// Smallest and largest patch, in spacings.
const PATCH_SPACINGS: [f64; 2] = [0.25, 4.0];

/// The tissue under the skin, from which patches are computed.
pub(super) struct Tissue<'a> {
    pub(super) balls: &'a [Ball],
    pub(super) tets: &'a [Tetra],
    pub(super) poisson: f64,
    pub(super) spacing_m: f64,
}

/// The skin at rest.
pub(super) struct Rest {
    pub(super) places: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    /// A third of the area of each vertex's triangles, m².
    pub(super) areas: Vec<f64>,
}

/// Sets the patch of every vertex.
pub(super) fn bake(skin: &mut ContactSkin, rest: &Rest, tissue: &Tissue<'_>) {
    let mut of_sphere: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
    for (i, vertex) in skin.vertices.iter().enumerate() {
        of_sphere.entry(vertex.spheres[0]).or_default().push(i);
    }
    let elements = elements(tissue);
    let groups: Vec<_> = of_sphere.into_iter().collect();
    let patches: Vec<Vec<(usize, f64)>> = groups
        .par_iter()
        .map(|(sphere, vertices)| {
            let near = Neighbourhood::new(usize::from(*sphere), tissue, &elements);
            let patch = |&i: &usize| (i, near.patch_m(i, skin, rest, tissue));
            vertices.iter().map(patch).collect()
        })
        .collect();
    for (i, patch_m) in patches.into_iter().flatten() {
        skin.vertices[i].patch_m = patch_m as f32;
    }
}

/// Numbers of the tetrahedra at each sphere.
fn elements(tissue: &Tissue<'_>) -> Vec<Vec<u32>> {
    let mut of_sphere = vec![Vec::new(); tissue.balls.len()];
    for (number, tet) in (0u32..).zip(tissue.tets) {
        for &sphere in &tet.spheres {
            of_sphere[sphere as usize].push(number);
        }
    }
    of_sphere
}

/// First of the three rows of each sphere of a neighbourhood, by the sphere's number. `None` for a
/// sphere elsewhere.
type Rows = Vec<Option<u32>>;

/// The tissue around a sphere. Everything outside of it counts as held.
struct Neighbourhood {
    rows: Rows,
    /// Number of rows: three for each sphere of the neighbourhood.
    height: usize,
    /// Stiffness of the neighbourhood for a Young's modulus of 1 Pa, factorised. `None` if nothing
    /// holds the neighbourhood.
    stiffness: Option<Cholesky<f64, Dyn>>,
}

impl Neighbourhood {
    fn new(sphere: usize, tissue: &Tissue<'_>, elements: &[Vec<u32>]) -> Self {
        let center = tissue.balls[sphere].center;
        let radius_m = NEIGHBOURHOOD_SPACINGS * tissue.spacing_m;
        let is_near = |ball: &Ball| (ball.center - center).norm() < radius_m;
        let mut free = (0u32..).step_by(3);
        let row = |ball| is_near(ball).then(|| free.next()).flatten();
        let rows: Rows = tissue.balls.iter().map(row).collect();
        let height = 3 * rows.iter().flatten().count();
        let mut stiffness = DMatrix::zeros(height, height);
        let near = rows.iter().zip(elements).filter(|(row, _)| row.is_some());
        let mut tets: Vec<u32> = near.flat_map(|(_, tets)| tets).copied().collect();
        tets.sort_unstable();
        tets.dedup();
        for tet in tets {
            add(&mut stiffness, &tissue.tets[tet as usize], &rows, tissue);
        }
        // A sphere in no tetrahedron has no stiffness. It gets some, so that the matrix is not
        // singular.
        for i in 0..stiffness.nrows() {
            if stiffness[(i, i)] <= 0.0 {
                stiffness[(i, i)] = 1.0;
            }
        }
        Self {
            rows,
            height,
            stiffness: Cholesky::new(stiffness),
        }
    }

    /// Width of the patch of vertex `i`, m.
    fn patch_m(&self, i: usize, skin: &ContactSkin, rest: &Rest, tissue: &Tissue<'_>) -> f64 {
        let [least, most] = PATCH_SPACINGS.map(|spacings| spacings * tissue.spacing_m);
        let Some(stiffness) = &self.stiffness else {
            return tissue.spacing_m;
        };
        let yields = |load: &DVector<f64>| load.dot(&stiffness.solve(load));
        let normal = rest.normals[i];
        let at_vertex = self.load([(i, 1.0)].into_iter(), skin, &normal);
        let wide_m = WIDE_SPACINGS * tissue.spacing_m;
        let spread: Vec<(usize, f64)> = (0..rest.places.len())
            .filter_map(|j| {
                let off = (rest.places[j] - rest.places[i]).norm();
                let is_under = off < 2.5 * wide_m && rest.normals[j].dot(&normal) > 0.3;
                is_under.then(|| (j, rest.areas[j] * libm::exp(-(off / wide_m).powi(2))))
            })
            .collect();
        let sum: f64 = spread.iter().map(|(_, share)| share).sum();
        let shares = spread.iter().map(|(j, share)| (*j, share / sum));
        let widely = self.load(shares, skin, &normal);
        let modulus = 1.0 / (1.0 - tissue.poisson * tissue.poisson);
        let local = yields(&at_vertex) - yields(&widely) + GAUSSIAN / (modulus * wide_m);
        if local > 0.0 {
            (GAUSSIAN / (modulus * local)).clamp(least, most)
        } else {
            most
        }
    }

    /// Forces on the spheres from a unit force along `normal` that is shared among vertices.
    fn load(
        &self,
        shares: impl Iterator<Item = (usize, f64)>,
        skin: &ContactSkin,
        normal: &Vec3,
    ) -> DVector<f64> {
        let mut load = DVector::zeros(self.height);
        for (vertex, share) in shares {
            let vertex = &skin.vertices[vertex];
            for (sphere, weight) in vertex.spheres.iter().zip(vertex.weights) {
                if let Some(row) = self.rows[usize::from(*sphere)] {
                    let force = normal * (share * f64::from(weight));
                    let mut rows = load.fixed_rows_mut::<3>(row as usize);
                    rows += force;
                }
            }
        }
        load
    }
}

/// Adds a tetrahedron's stiffness, with the solver's share of Young's modulus and its limit of
/// Poisson's ratio. Between two corners it is `V (λ a bᵀ + μ b aᵀ + μ a·b)`, where a and b are the
/// gradients of the corners' shape functions.
fn add(stiffness: &mut DMatrix<f64>, tet: &Tetra, rows: &Rows, tissue: &Tissue<'_>) {
    let x = tet.spheres.map(|i| tissue.balls[i as usize].center);
    let edges = Matrix3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
    let Some(inverse) = edges.try_inverse() else {
        return;
    };
    let row = |k: usize| inverse.row(k).transpose();
    let slopes = [-(row(0) + row(1) + row(2)), row(0), row(1), row(2)];
    let poisson = tissue.poisson.min(f64::from(POISSON_MAX));
    let mu = f64::from(STIFFNESS_SHARE) / (2.0 * (1.0 + poisson));
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    for (a, i) in slopes.iter().zip(&tet.spheres) {
        for (b, j) in slopes.iter().zip(&tet.spheres) {
            let (Some(i), Some(j)) = (rows[*i as usize], rows[*j as usize]) else {
                continue;
            };
            let block = a * b.transpose() * lambda
                + b * a.transpose() * mu
                + Matrix3::identity() * (mu * a.dot(b));
            let mut view = stiffness.fixed_view_mut::<3, 3>(i as usize, j as usize);
            view += block * tet.volume_m3;
        }
    }
}
