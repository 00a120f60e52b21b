//! Binding of skin vertices to the spheres that move them (paper Eq. 9–12).

use rayon::prelude::*;
use shared_mem::scene::{BINDINGS, VertexRecord, WEIGHT_SUM};

use crate::Vec3;
use crate::mesh::Mesh;
use crate::pack::Ball;

/// Width of the Gaussian, as a multiple of the sphere's radius (`c` of Eq. 9).
const WIDTH: f64 = 1.0;
/// Least weight with which a sphere moves a vertex (`T` of Eq. 10, where the paper prints the
/// relation the wrong way round).
const THRESHOLD: f64 = 0.02;

/// Paper Eq. 9: weight of a sphere of radius `radius_m` whose centre is `distance_m` away.
#[must_use]
pub fn gaussian(distance_m: f64, radius_m: f64) -> f64 {
    libm::exp(-(distance_m / (WIDTH * radius_m)).powi(2))
}

/// Binds every vertex to at most [`BINDINGS`] spheres. The first of `balls` has the number
/// `first_sphere`. A vertex that no sphere reaches is bound to the sphere whose centre is the
/// fewest radii away.
#[must_use]
pub fn bind(mesh: &Mesh, balls: &[Ball], first_sphere: u32) -> Vec<VertexRecord> {
    let normals = mesh.vertex_normals();
    let bind_one = |(p, normal): (&Vec3, &Vec3)| {
        let (spheres, weights) = binding(p, balls);
        VertexRecord {
            position_m: (*p).map(|x| x as f32).into(),
            normal: (*normal).map(|x| x as f32).into(),
            spheres: spheres.map(|i| (i + first_sphere) as u16),
            weights,
        }
    };
    mesh.vertices
        .par_iter()
        .zip(&normals)
        .map(bind_one)
        .collect()
}

fn binding(p: &Vec3, balls: &[Ball]) -> ([u32; BINDINGS], [u16; BINDINGS]) {
    let reach = |b: &Ball| gaussian((b.center - p).norm(), b.radius_m);
    let mut near: Vec<(f64, u32)> = Vec::with_capacity(64);
    for (i, b) in balls.iter().enumerate() {
        let weight = reach(b);
        if weight >= THRESHOLD {
            near.push((weight, i as u32));
        }
    }
    near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    near.truncate(BINDINGS);
    if near.is_empty() {
        let relative = |b: &Ball| (b.center - p).norm() / b.radius_m;
        let nearest = balls.iter().map(relative).enumerate();
        let nearest = nearest.min_by(|a, b| a.1.total_cmp(&b.1));
        near.push((1.0, nearest.map_or(0, |(i, _)| i as u32)));
    }
    let mut spheres = [near[0].1; BINDINGS];
    let mut weights = [0.0; BINDINGS];
    for (k, (weight, i)) in near.iter().enumerate() {
        spheres[k] = *i;
        weights[k] = *weight;
    }
    (spheres, quantise(weights))
}

/// Shares of the weights in whole numbers that sum to [`WEIGHT_SUM`]. Each share is rounded down,
/// then the shares with the largest remainders get one more.
fn quantise(weights: [f64; BINDINGS]) -> [u16; BINDINGS] {
    let total: f64 = weights.iter().sum();
    let exact = weights.map(|w| w / total * f64::from(WEIGHT_SUM));
    let mut whole = exact.map(|x| x as u32);
    let mut by_remainder: Vec<usize> = (0..BINDINGS).filter(|&i| weights[i] > 0.0).collect();
    by_remainder.sort_by(|&a, &b| {
        exact[b]
            .fract()
            .total_cmp(&exact[a].fract())
            .then(a.cmp(&b))
    });
    let missing = WEIGHT_SUM - whole.iter().sum::<u32>();
    for &i in by_remainder.iter().cycle().take(missing as usize) {
        whole[i] += 1;
    }
    whole.map(|x| x as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_9_by_hand() {
        assert!((gaussian(0.0, 0.01) - 1.0).abs() < 1e-12);
        // One radius away: e^-1; two: e^-4.
        assert!((gaussian(0.01, 0.01) - 0.367_879_441).abs() < 1e-9);
        assert!((gaussian(0.02, 0.01) - 0.018_315_639).abs() < 1e-9);
    }

    #[test]
    fn equation_10_leaves_out_what_is_below_the_threshold() {
        let ball = |x: f64| Ball {
            center: Vec3::new(x, 0.0, 0.0),
            radius_m: 1.0,
        };
        // Weights 1, e^-1 and e^-4 (below the threshold).
        let (spheres, weights) = binding(&Vec3::zeros(), &[ball(0.0), ball(1.0), ball(2.0)]);
        assert_eq!(spheres[..3], [0, 1, 0]);
        let share = 1.0 / (1.0 + libm::exp(-1.0));
        assert_eq!(weights[0], (share * 65_535.0).round() as u16);
        assert_eq!(u32::from(weights[0]) + u32::from(weights[1]), WEIGHT_SUM);
        assert_eq!(weights[2..], [0; 6]);
    }

    #[test]
    fn vertex_out_of_reach_follows_the_nearest_sphere() {
        let ball = |x: f64| Ball {
            center: Vec3::new(x, 0.0, 0.0),
            radius_m: 0.1,
        };
        let (spheres, weights) = binding(&Vec3::zeros(), &[ball(9.0), ball(5.0)]);
        assert_eq!((spheres, weights[0]), ([1; 8], 65_535));
    }

    #[test]
    fn quantised_weights_sum_exactly() {
        for seed in 1..200u32 {
            let weights = std::array::from_fn(|i| f64::from(seed * 7919 % (13 + i as u32)) + 1e-9);
            let sum: u32 = quantise(weights).iter().map(|&w| u32::from(w)).sum();
            assert_eq!(sum, WEIGHT_SUM);
        }
    }
}
