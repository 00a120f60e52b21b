//! Stretching (paper Eq. 3–5).

/// Displacement of the two spheres of a link per inverse mass, as a factor on `p1 − p2`.
///
/// | paper | here |
/// |---|---|
/// | `C = |p1 − p2| − d0` (Eq. 3) | `length − rest_length` |
/// | `dp1 = −w1 / (w1 + w2) C n` (Eq. 4) | `−w1 · result · (p1 − p2)` |
/// | `dp2 = +w2 / (w1 + w2) C n` (Eq. 5) | `+w2 · result · (p1 − p2)` |
///
/// `length` is `|p1 − p2|`, `weight_sum` is `w1 + w2`, and `stiffness` is the share of the stretch
/// that is removed (1 in the paper). The result is 0 for two immovable spheres, and for two spheres
/// in one place, which have no direction.
#[must_use]
#[inline(always)]
pub fn stretch(length: f32, weight_sum: f32, rest_length: f32, stiffness: f32) -> f32 {
    let scale = length * weight_sum;
    let share = stiffness * (length - rest_length) / scale;
    if scale > f32::MIN_POSITIVE {
        share
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{self, Quat, Vec3};
    use crate::testing::vector;
    use proptest::prelude::*;

    /// Displacement of both spheres, per inverse mass.
    fn step(d: &Vec3, weight_sum: f32, rest_length: f32, stiffness: f32) -> Vec3 {
        d * stretch(math::norm(d), weight_sum, rest_length, stiffness)
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        math::norm(&(a - b)) < 1.0e-6
    }

    #[test]
    fn eq_3_to_5_by_hand() {
        // 3-4-5: length 5, rest 4, so C = 1, n = (0.6, 0.8, 0); w1 = 1, w2 = 3.
        let (p1, p2, w1, w2) = (Vec3::new(3.0, 4.0, 0.0), Vec3::zeros(), 1.0, 3.0);
        let g = step(&(p1 - p2), w1 + w2, 4.0, 1.0);
        let (dp1, dp2) = (-w1 * g, w2 * g);
        assert!(near(dp1, Vec3::new(-0.15, -0.2, 0.0)), "{dp1}");
        assert!(near(dp2, Vec3::new(0.45, 0.6, 0.0)), "{dp2}");
        // One projection of a lone link ends at its rest length.
        assert!((math::norm(&(p1 + dp1 - p2 - dp2)) - 4.0).abs() < 1.0e-6);
    }

    #[test]
    fn half_stiffness_moves_half_the_way_and_compression_pushes() {
        let difference = Vec3::new(0.0, 0.0, 2.0);
        assert!(near(
            step(&difference, 2.0, 3.0, 0.5),
            Vec3::new(0.0, 0.0, -0.25)
        ));
    }

    #[test]
    fn step_is_zero_without_mobility_or_direction() {
        assert!(near(
            step(&Vec3::new(1.0, 0.0, 0.0), 0.0, 0.5, 1.0),
            Vec3::zeros()
        ));
        assert!(near(step(&Vec3::zeros(), 2.0, 0.5, 1.0), Vec3::zeros()));
    }

    proptest! {
        /// Momentum: Σ m dp = 0.
        #[test]
        fn conserves_momentum(d in vector(1.0), m1 in 0.001f32..1.0, m2 in 0.001f32..1.0,
                              rest in 0.01f32..1.0, k in 0.0f32..1.0) {
            let (w1, w2) = (1.0 / m1, 1.0 / m2);
            let g = step(&d, w1 + w2, rest, k);
            let momentum = m1 * (-w1 * g) + m2 * (w2 * g);
            prop_assert!(math::norm(&momentum) < 1.0e-5 * (1.0 + math::norm(&g)));
        }

        /// It never overshoots: the remaining stretch is (1 − k) of the stretch before.
        #[test]
        fn leaves_the_rest_of_the_stretch(d in vector(1.0), w1 in 0.0f32..10.0, w2 in 0.1f32..10.0,
                                          rest in 0.01f32..1.0, k in 0.0f32..1.0) {
            prop_assume!(math::norm(&d) > 0.01);
            let g = step(&d, w1 + w2, rest, k);
            let after = math::unit(&d).unwrap().dot(&(d - (w1 + w2) * g)) - rest;
            let before = math::norm(&d) - rest;
            prop_assert!((after - (1.0 - k) * before).abs() < 1.0e-4);
        }

        /// Turning the world turns the correction.
        #[test]
        fn is_invariant_under_rotation(d in vector(1.0), q in vector(1.0), rest in 0.01f32..1.0) {
            let turn = Quat::from_quaternion(nalgebra::Quaternion::new(0.5, q.x, q.y, q.z));
            let turned = step(&(turn * d), 2.0, rest, 0.7);
            prop_assert!(math::norm(&(turned - turn * step(&d, 2.0, rest, 0.7))) < 1.0e-5);
        }
    }
}
