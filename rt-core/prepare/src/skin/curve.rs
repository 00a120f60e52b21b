//! Curvature of the contact skin at its vertices.

use rayon::prelude::*;

use super::ContactSkin;
use super::patch::Rest;

/// Width of the Gaussian over which the curvature is averaged, m. A tip's contact is about as wide.
const WIDTH_M: f64 = 0.005;
/// Vertices farther away than this multiple of `WIDTH_M` do not count.
const REACH_WIDTHS: f64 = 2.5;
/// Largest curvature, of either sign, 1/m.
const CURVATURE_MAX_PER_M: f64 = 500.0;

/// Sets the mean curvature of every vertex.
pub(super) fn bake(skin: &mut ContactSkin, rest: &Rest) {
    let all: Vec<f64> = (0..rest.places.len())
        .into_par_iter()
        .map(|i| curvature_per_m(i, rest))
        .collect();
    for (vertex, curvature_per_m) in skin.vertices.iter_mut().zip(all) {
        vertex.curvature_per_m = curvature_per_m as f32;
    }
}

/// Mean curvature at vertex `i`. Each vertex around it contributes the curvature of the circle that
/// passes through both vertices and is tangent to the skin at `i`. On a ball's skin the mean is
/// exactly 1 / radius.
fn curvature_per_m(i: usize, rest: &Rest) -> f64 {
    let (at, normal) = (rest.places[i], rest.normals[i]);
    let (mut sum, mut shares) = (0.0, 0.0);
    let around = rest.places.iter().zip(&rest.normals).zip(&rest.areas);
    for ((place, other), area) in around {
        let arm = at - place;
        let squared = arm.norm_squared();
        let widths = squared / (WIDTH_M * WIDTH_M);
        if squared <= 0.0 || widths > REACH_WIDTHS * REACH_WIDTHS || other.dot(&normal) < 0.3 {
            continue;
        }
        let share = area * libm::exp(-widths);
        sum += share * 2.0 * normal.dot(&arm) / squared;
        shares += share;
    }
    if shares > 0.0 {
        (sum / shares).clamp(-CURVATURE_MAX_PER_M, CURVATURE_MAX_PER_M)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    /// The places lie on a golden spiral on a ball, each with the same area.
    #[test]
    fn a_ball_is_as_curved_as_it_is_and_a_hollow_the_other_way() {
        let radius_m = 0.02;
        let count = 1500;
        let place = |i: usize| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / f64::from(count);
            let (turn, flat) = (2.399_963_229_728_653 * i as f64, libm::sqrt(1.0 - z * z));
            Vec3::new(flat * libm::cos(turn), flat * libm::sin(turn), z)
        };
        let normals: Vec<Vec3> = (0..count as usize).map(place).collect();
        let mut rest = Rest {
            places: normals.iter().map(|n| n * radius_m).collect(),
            areas: vec![1e-6; normals.len()],
            normals,
        };
        for i in [3, 700, 1400] {
            let found = curvature_per_m(i, &rest);
            assert!((found * radius_m - 1.0).abs() < 1e-9, "{found}");
        }
        for normal in &mut rest.normals {
            *normal = -*normal;
        }
        let found = curvature_per_m(700, &rest);
        assert!((found * radius_m + 1.0).abs() < 1e-9, "{found}");
    }

    /// A round bar is curved only across its axis. The mean of both directions is half that
    /// curvature.
    #[test]
    fn a_bar_is_curved_by_half() {
        let (radius_m, step_m) = (0.016, 0.001);
        let (mut places, mut normals) = (Vec::new(), Vec::new());
        for along in -30..=30 {
            for around in -30..=30 {
                let turn = f64::from(around) * step_m / radius_m;
                let normal = Vec3::new(0.0, libm::sin(turn), libm::cos(turn));
                places.push(normal * radius_m + Vec3::x() * (f64::from(along) * step_m));
                normals.push(normal);
            }
        }
        let rest = Rest {
            areas: vec![step_m * step_m; places.len()],
            places,
            normals,
        };
        let found = curvature_per_m(30 * 61 + 30, &rest);
        assert!((found * radius_m - 0.5).abs() < 0.02, "{found}");
    }
}
