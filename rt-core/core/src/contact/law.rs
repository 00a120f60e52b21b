//! Contact of a rigid tool with an elastic half-space: the part of the dent that the spheres do not
//! supply.
//!
//! A rigid tool makes a dent δ with a force F over a contact of half-width a. The spheres supply
//! the part `c F` of this dent. They yield as a half-space does under a load that is spread over a
//! Gaussian patch `exp(−r²/A²)` of its skin; c is the compliance of this patch. This module adds
//! the rest, `δ − c F`. [`crate::contact`] explains why that is allowed.
//!
//! Sources: Sneddon 1965 (ball), Hertz (cylinder), Zhang, Cao, Li and Feng 2014 (neo-Hookean
//! softening).

use crate::contact::friction;
use crate::math;

/// A tool's shape where it touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A round end: a spherical punch at any depth (Sneddon 1965), with the softening of
    /// neo-Hookean tissue.
    Ball { radius_m: f32 },
    /// A piece of a shaft that lies on the skin: Hertz's line contact of this length. A half-space
    /// under a line yields most at its middle, and the dent there counts.
    Cylinder { radius_m: f32, length_m: f32 },
}

/// Lower bound of the skin's curvature times the ball's radius. The law of a half-space does not
/// hold for concave skin that fits more closely around the ball.
const RELATIVE_CURVATURE_MIN: f32 = -0.5;
/// Upper bound of the skin's curvature times the ball's radius.
const RELATIVE_CURVATURE_MAX: f32 = 3.0;
/// Margin of stiffness, as a share of the spheres' stiffness `1/c`. At the largest half-width of
/// the law, the dent's stiffness lies below `1/c` by at least this share. On convex skin the
/// stiffness is largest a little before that half-width, so the margin grows by the share again for
/// each unit of relative curvature.
const STIFFNESS_MARGIN: f32 = 0.01;

/// Softening of a neo-Hookean half-space: the force of a linear half-space is divided by `1 + this
/// δ/R`. Sneddon's force then becomes Hertz's times `1 − 0.15 δ/R` (Zhang, Cao, Li and Feng 2014).
/// The source is valid up to δ = R; deeper dents extrapolate.
const SOFTENING: f32 = 0.06;
/// Contact half-width at which a ball counts as buried, as a share of its radius. The law has a
/// pole at 1.
const BURIED_RADII: f32 = 0.97;

/// Force and depth of a dent at a given half-width of the contact, and their slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Indentation {
    force_n: f32,
    depth_m: f32,
    /// Change of the depth per change of the half-width, m/m.
    depth_slope: f32,
    /// dF/dδ, N/m.
    stiffness_n_m: f32,
}

/// Law of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Law {
    shape: Shape,
    /// Mean curvature of the skin at rest divided by the curvature of the ball; 0 for a cylinder.
    relative_curvature: f32,
    /// `E / (1 − ν²)`, Pa.
    modulus_pa: f32,
    /// c: compliance of the spheres' own patch, m/N.
    mesh_compliance_m_n: f32,
    /// A: width of the Gaussian patch, m.
    patch_width_m: f32,
    /// Largest half-width of the law, m. Beyond it, the dent would be stiffer than the spheres
    /// alone, or the tool would be buried.
    half_width_max_m: f32,
}

impl Law {
    /// Law on tissue of modulus `E / (1 − ν²)` (Pa), whose spheres spread a force over a patch of
    /// this width (m). The curvature is the mean of the skin at rest (1/m), positive where the skin
    /// is convex. A cylinder ignores the curvature, because its force hardly depends on it.
    pub(crate) fn new(
        shape: Shape,
        modulus_pa: f32,
        patch_width_m: f32,
        curvature_per_m: f32,
    ) -> Self {
        // The compliance of a Gaussian load is its mean displacement per force. The mean is
        // weighted by the load.
        let mesh_compliance_m_n = GAUSSIAN_SELF_INFLUENCE / (modulus_pa * patch_width_m);
        let (buried_m, relative_curvature) = match shape {
            Shape::Ball { radius_m } => (
                BURIED_RADII * radius_m,
                (curvature_per_m * radius_m).clamp(RELATIVE_CURVATURE_MIN, RELATIVE_CURVATURE_MAX),
            ),
            Shape::Cylinder { radius_m, length_m } => (radius_m.min(length_m), 0.0),
        };
        let mut law = Self {
            shape,
            relative_curvature,
            modulus_pa,
            mesh_compliance_m_n,
            patch_width_m,
            half_width_max_m: buried_m,
        };
        let mesh_share_max = 1.0 - STIFFNESS_MARGIN * (1.0 + relative_curvature.max(0.0));
        for _ in 0..END_STEPS_MAX {
            let end = law.indentation(law.half_width_max_m);
            if end.stiffness_n_m * mesh_compliance_m_n <= mesh_share_max {
                break;
            }
            law.half_width_max_m *= 0.8;
        }
        law
    }

    fn indentation(&self, half_width_m: f32) -> Indentation {
        match self.shape {
            Shape::Ball { radius_m } => {
                let x = half_width_m / radius_m;
                let (force, depth, slope) = sneddon(x);
                // Depth and force of a punch are linear in its profile (Sneddon 1965). So the
                // curvature of the skin adds the share of a paraboloid to both.
                let curvature_term = self.relative_curvature * x;
                let force = force + 4.0 / 3.0 * curvature_term * x * x;
                let (depth, slope) = (depth + curvature_term * x, slope + 2.0 * curvature_term);
                let softening = 1.0 + SOFTENING * depth;
                let force = force / softening;
                Indentation {
                    force_n: self.modulus_pa * radius_m * radius_m * force,
                    depth_m: radius_m * depth,
                    depth_slope: slope,
                    stiffness_n_m: self.modulus_pa * radius_m * (2.0 * x - SOFTENING * force)
                        / softening,
                }
            }
            Shape::Cylinder { radius_m, length_m } => {
                let line_n_m = core::f32::consts::PI * self.modulus_pa * length_m;
                let squared = half_width_m * half_width_m;
                let log = ln(2.0 * length_m / half_width_m);
                Indentation {
                    force_n: line_n_m * squared / (4.0 * radius_m),
                    depth_m: squared / (2.0 * radius_m) * (log + 0.5),
                    depth_slope: half_width_m / radius_m * log,
                    stiffness_n_m: line_n_m / (2.0 * log),
                }
            }
        }
    }

    /// Force F ≥ 0 that solves `separation + y F + δ(F) − c F = 0`, and its slope, N/m. The
    /// separation is negative where tool and skin overlap; y is `sphere_compliance_m_n`, the
    /// spheres' compliance within the step. The left side is monotone in F, so there is one
    /// solution.
    pub(crate) fn force_n(&self, separation_m: f32, sphere_compliance_m_n: f32) -> (f32, f32) {
        if separation_m >= 0.0 || separation_m.is_nan() {
            return (0.0, 0.0);
        }
        let residual_compliance_m_n = sphere_compliance_m_n - self.mesh_compliance_m_n;
        let end = self.indentation(self.half_width_max_m);
        let residual_m = |indentation: &Indentation| {
            separation_m + indentation.depth_m + residual_compliance_m_n * indentation.force_n
        };
        if residual_m(&end) < 0.0 {
            // Beyond the end the stiffness stays constant, at most that of the spheres alone.
            let compliance_m_n = (end.stiffness_n_m.recip() + residual_compliance_m_n)
                .max(sphere_compliance_m_n)
                .max(COMPLIANCE_MIN_M_N);
            let slope = compliance_m_n.recip();
            return (end.force_n - residual_m(&end) * slope, slope);
        }
        // Newton's method with bisection: it stays in the interval that brackets the solution.
        let (mut low, mut high) = (0.0, self.half_width_max_m);
        let mut half_width_m = self
            .first_guess_m(separation_m)
            .max(1.0e-3 * high)
            .min(high);
        let mut indentation = self.indentation(half_width_m);
        for _ in 0..NEWTON_STEPS_MAX {
            let error_m = residual_m(&indentation);
            if error_m < 0.0 {
                low = half_width_m;
            } else {
                high = half_width_m;
            }
            let slope = indentation.depth_slope
                * (1.0 + residual_compliance_m_n * indentation.stiffness_n_m);
            let newton = half_width_m - error_m / slope;
            let next = if newton >= low && newton <= high {
                newton
            } else {
                0.5 * (low + high)
            };
            let has_converged = (next - half_width_m).abs() <= 1.0e-4 * half_width_m;
            half_width_m = next;
            indentation = self.indentation(half_width_m);
            if has_converged {
                break;
            }
        }
        let compliance_m_n =
            (indentation.stiffness_n_m.recip() + residual_compliance_m_n).max(COMPLIANCE_MIN_M_N);
        (indentation.force_n, compliance_m_n.recip())
    }

    /// Half-width if all of the overlap were a dent, m.
    fn first_guess_m(&self, separation_m: f32) -> f32 {
        let radius_m = match self.shape {
            Shape::Ball { radius_m } | Shape::Cylinder { radius_m, .. } => radius_m,
        };
        math::sqrt(-separation_m * radius_m)
    }

    /// Approximate half-width of the contact under this force, m.
    pub(crate) fn half_width_m(&self, force_n: f32) -> f32 {
        match self.shape {
            Shape::Ball { radius_m } => {
                cube_root(self.ball_half_width_cubed_m3(radius_m, force_n)).min(radius_m)
            }
            Shape::Cylinder { radius_m, length_m } => {
                math::sqrt(self.cylinder_half_width_squared_m2(radius_m, length_m, force_n))
                    .min(radius_m)
            }
        }
    }

    /// Cube of the half-width of a ball on flat skin (Hertz).
    fn ball_half_width_cubed_m3(&self, radius_m: f32, force_n: f32) -> f32 {
        0.75 * force_n * radius_m / self.modulus_pa
    }

    /// Square of the half-width of a cylinder's contact on flat skin (Hertz).
    fn cylinder_half_width_squared_m2(&self, radius_m: f32, length_m: f32, force_n: f32) -> f32 {
        4.0 * force_n * radius_m / (core::f32::consts::PI * self.modulus_pa * length_m)
    }

    /// Stiffness of the contact along the skin under this force, N/m, without the compliance that
    /// the spheres supply.
    pub(crate) fn tangential_stiffness_n_m(&self, force_n: f32, poisson: f32) -> f32 {
        let half_width_m = match self.shape {
            Shape::Ball { .. } => self.half_width_m(force_n),
            // A round contact with the area of the strip.
            Shape::Cylinder { length_m, .. } => {
                let strip_m2 = 2.0 * self.half_width_m(force_n) * length_m;
                math::sqrt(strip_m2 * core::f32::consts::FRAC_1_PI)
            }
        };
        friction::stiffness_n_m(
            self.modulus_pa,
            poisson,
            half_width_m,
            self.mesh_compliance_m_n,
        )
    }

    /// Self-influence distance of the contact under this force, m. Under a small additional load
    /// the contact yields by some length. At this distance from a point load of the same size, a
    /// half-space yields by the same length. A deeply indented ball keeps Hertz's distance.
    pub(crate) fn self_influence_distance_m(&self, force_n: f32) -> f32 {
        let force_n = force_n.max(0.0); // `max` also turns NaN into 0
        match self.shape {
            Shape::Ball { radius_m } => {
                SELF_INFLUENCE_HALF_WIDTHS
                    * cube_root(
                        self.ball_half_width_cubed_m3(radius_m, force_n)
                            / (1.0 + self.relative_curvature),
                    )
            }
            Shape::Cylinder { radius_m, length_m } => {
                let half_width_m =
                    math::sqrt(self.cylinder_half_width_squared_m2(radius_m, length_m, force_n));
                let half_width_m = half_width_m
                    .min(self.half_width_max_m)
                    .max(HALF_WIDTH_MIN_LENGTHS * length_m);
                length_m / (2.0 * ln(2.0 * length_m / half_width_m))
            }
        }
    }

    /// Influence coefficient, m/N. A force of another contact, at this distance on the same skin,
    /// displaces the skin here. The coefficient is this displacement per force, less the
    /// displacement that the spheres transmit. `self_influence_distance_m` is the larger of the two
    /// contacts' [`Law::self_influence_distance_m`]. Around a round contact of half-width a, the
    /// coefficient is within 4 % of Hertz's at the distance 2 a, and a fifth below it at the rim.
    /// The coefficient never exceeds the compliance of the other contact under its own load.
    /// Otherwise the heavier of two adjacent contacts could keep the lighter off the tissue, until
    /// it snaps on.
    pub(crate) fn influence_m_n(&self, distance_m: f32, self_influence_distance_m: f32) -> f32 {
        let cubed = |m: f32| m * m * m;
        let effective_distance_m =
            cube_root(cubed(distance_m) + cubed(self_influence_distance_m)).max(1.0e-5);
        let half_space_m_n =
            (core::f32::consts::PI * self.modulus_pa * effective_distance_m).recip();
        (half_space_m_n
            - self.mesh_compliance_m_n * gaussian_influence(distance_m, self.patch_width_m))
        .max(0.0)
    }
}

/// Displacement of a patch by a Gaussian load on an equal patch at this distance. It is given as a
/// share of the displacement of the loaded patch itself.
pub(crate) fn gaussian_influence(distance_m: f32, patch_width_m: f32) -> f32 {
    scaled_bessel_i0(distance_m * distance_m / (4.0 * patch_width_m * patch_width_m))
}

/// As [`gaussian_influence`], for patches of spheres. Beyond one patch width, spheres transmit more
/// than a half-space does; the excess is largest at two patch widths.
pub(crate) fn mesh_influence(distance_m: f32, patch_width_m: f32) -> f32 {
    let widths = distance_m / patch_width_m;
    let excess = 4.0 * (widths - 1.0).max(0.0) / (widths * widths).max(1.0);
    gaussian_influence(distance_m, patch_width_m) + MESH_EXCESS * excess
}

/// Excess influence of spheres at two patch widths. It is fitted so that gallbladders of 250 and
/// 2500 spheres react equally to a 10 mm tip; without it they differ by 10 %.
const MESH_EXCESS: f32 = 0.04;
/// Mean of `A / (π r)` over the distances r of two random points, `1 / √(2π)`. The Gaussian
/// `exp(−r²/A²)` is the density of each point about the middle of the patch.
const GAUSSIAN_SELF_INFLUENCE: f32 = 0.398_942_3;
/// Self-influence distance of a round contact, as a share of its half-width a (Hertz: `dδ/dF = 1 /
/// (2 E* a)`).
const SELF_INFLUENCE_HALF_WIDTHS: f32 = 2.0 * core::f32::consts::FRAC_1_PI;
/// Lower bound of a cylinder's half-width as a share of its length. The self-influence distance is
/// computed from the half-width within this bound.
const HALF_WIDTH_MIN_LENGTHS: f32 = 0.01;
/// Largest number of steps of the search for the largest half-width; each step takes a fifth off
/// it.
const END_STEPS_MAX: u32 = 24;
/// Largest number of steps of Newton's method. Three mostly give six digits; a ball that is nearly
/// buried takes more.
const NEWTON_STEPS_MAX: u32 = 20;
/// Least compliance of a contact, m/N.
const COMPLIANCE_MIN_M_N: f32 = 1.0e-6;

/// `F / (E* R²)`, `δ / R` and `dδ/da` of a ball at `x = a/R` (Sneddon 1965): force `(1 + x²) artanh
/// x − x` and indentation `x artanh x`.
fn sneddon(x: f32) -> (f32, f32, f32) {
    let y = x * x;
    let (force, artanh) = if x < 0.4 {
        // At small x the two terms of the force cancel, so their series is used.
        let force = 4.0 / 3.0
            + y * (8.0 / 15.0 + y * (12.0 / 35.0 + y * (16.0 / 63.0 + y * (20.0 / 99.0))));
        let artanh = 1.0 + y * (1.0 / 3.0 + y * (0.2 + y * (1.0 / 7.0 + y * (1.0 / 9.0))));
        (x * y * force, x * artanh)
    } else {
        let artanh = 0.5 * ln((1.0 + x) / (1.0 - x));
        ((1.0 + y) * artanh - x, artanh)
    };
    (force, x * artanh, artanh + x / (1.0 - y))
}

/// Natural logarithm of a positive number in plain arithmetic, with the same bits on every machine.
fn ln(x: f32) -> f32 {
    let bits = x.to_bits();
    let mut exponent = ((bits >> 23) & 0xff) as i32 - 127;
    let mut mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    if mantissa > core::f32::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let y = s * s;
    let series = 2.0 + y * (2.0 / 3.0 + y * (0.4 + y * (2.0 / 7.0 + y * (2.0 / 9.0))));
    exponent as f32 * core::f32::consts::LN_2 + s * series
}

/// `e^−z I₀(z)` to 2 %: decay of a Gaussian load's influence with distance.
fn scaled_bessel_i0(z: f32) -> f32 {
    let second = 4.0 * core::f32::consts::PI * core::f32::consts::PI * z * z * z / (z + 1.2);
    math::sqrt(math::sqrt(1.0 + 4.0 * z + second)).recip()
}

fn cube_root(x: f32) -> f32 {
    if x <= 0.0 || x.is_nan() {
        return 0.0;
    }
    let mut root = f32::from_bits(x.to_bits() / 3 + 0x2a51_19f2);
    for _ in 0..3 {
        root -= (root - x / (root * root)) / 3.0;
    }
    root
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    const MODULUS_PA: f32 = 5000.0 / (1.0 - 0.45 * 0.45);

    /// A law on a patch so wide that the spheres supply no part of the dent.
    fn without_spheres(shape: Shape) -> Law {
        Law::new(shape, MODULUS_PA, 100.0, 0.0)
    }

    #[test]
    fn shallow_ball_is_hertz() {
        let law = without_spheres(Shape::Ball { radius_m: 0.01 });
        for depth_m in [1.0e-5f32, 1.0e-4, 5.0e-4] {
            let (force_n, stiffness_n_m) = law.force_n(-depth_m, 0.0);
            let hertz = 4.0 / 3.0 * MODULUS_PA * (0.01f32).sqrt() * depth_m.powf(1.5);
            assert!((force_n / hertz - 1.0).abs() < 0.02, "{force_n} {hertz}");
            let slope = 1.5 * hertz / depth_m;
            assert!(
                (stiffness_n_m / slope - 1.0).abs() < 0.03,
                "{stiffness_n_m} {slope}"
            );
        }
    }

    /// Hertz's contact of two balls, and of a ball in a cup.
    #[test]
    fn shallow_ball_on_curved_skin_is_hertz() {
        let radius_m = 0.005f32;
        for curvature_per_m in [150.0f32, 60.0, -60.0] {
            let law = Law::new(Shape::Ball { radius_m }, MODULUS_PA, 100.0, curvature_per_m);
            let relative_m = (radius_m.recip() + curvature_per_m).recip();
            for depth_m in [1.0e-5f32, 1.0e-4] {
                let (force_n, _) = law.force_n(-depth_m, 0.0);
                let hertz = 4.0 / 3.0 * MODULUS_PA * relative_m.sqrt() * depth_m.powf(1.5);
                assert!((force_n / hertz - 1.0).abs() < 0.01, "{force_n} {hertz}");
            }
        }
    }

    #[test]
    fn logarithm_root_and_bessel_match_tables() {
        for x in [1.0e-4f32, 0.3, 0.999, 1.0, 1.5, 60.0, 3.0e7] {
            assert!(
                (ln(x) - x.ln()).abs() <= 2.0e-6 * x.ln().abs().max(1.0),
                "{x}"
            );
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 1.0e-6, "{x}");
        }
        // e^−z I₀(z) from tables.
        for (z, value) in [
            (0.0, 1.0),
            (0.5, 0.6450),
            (1.0, 0.4658),
            (2.0, 0.3085),
            (5.0, 0.1835),
        ] {
            assert!(
                (scaled_bessel_i0(z) / value - 1.0).abs() < 0.02,
                "{z}: {}",
                scaled_bessel_i0(z)
            );
        }
        let below = sneddon(0.399_99);
        let above = sneddon(0.400_01);
        assert!(
            (below.0 / above.0 - 1.0).abs() < 3.0e-4 && (below.1 / above.1 - 1.0).abs() < 2.0e-4
        );
    }

    #[test]
    fn open_or_nan_separation_has_no_force() {
        let law = without_spheres(Shape::Ball { radius_m: 0.005 });
        assert_eq!(law.force_n(0.001, 1.0e-4), (0.0, 0.0));
        assert_eq!(law.force_n(f32::NAN, 1.0e-4), (0.0, 0.0));
    }

    fn shape() -> impl Strategy<Value = Shape> {
        prop_oneof![
            (0.0008f32..0.02).prop_map(|radius_m| Shape::Ball { radius_m }),
            (0.0008f32..0.02, 1.0f32..4.0).prop_map(|(radius_m, aspect)| Shape::Cylinder {
                radius_m,
                length_m: aspect * radius_m
            }),
        ]
    }

    /// Inside the patch, and far away, spheres transmit as much as a half-space does.
    #[test]
    fn spheres_carry_more_only_beyond_a_patch() {
        let more = |widths: f32| {
            mesh_influence(widths * 0.004, 0.004) - gaussian_influence(widths * 0.004, 0.004)
        };
        assert!(more(0.0).abs() < 1.0e-6 && more(1.0).abs() < 1.0e-6 && more(100.0) < 0.002);
        assert!(
            (more(2.0) - MESH_EXCESS).abs() < 1.0e-5
                && more(1.7) < more(2.0)
                && more(2.5) < more(2.0)
        );
    }

    proptest! {
        /// The force solves the equation, grows with depth, and has no steps.
        #[test]
        fn force_grows_with_depth_without_steps(
            shape in shape(), patch_width_m in 0.003f32..0.03, separation_m in 1.0e-5f32..0.03, sphere_compliance_m_n in 1.0e-6f32..1.0e-3,
            curvature_per_m in -600.0f32..600.0,
        ) {
            let law = Law::new(shape, MODULUS_PA, patch_width_m, curvature_per_m);
            let (force_n, _) = law.force_n(-separation_m, sphere_compliance_m_n);
            let (more_n, _) = law.force_n(-separation_m * 1.01, sphere_compliance_m_n);
            prop_assert!(force_n > 0.0 && force_n.is_finite());
            prop_assert!(more_n >= force_n * 0.9999);
            // No contact is stiffer than the spheres alone.
            prop_assert!(more_n - force_n <= 0.011 * separation_m / sphere_compliance_m_n + 1.0e-4 * force_n);
        }

        /// At one place, the influence equals the contact's own compliance. If the influence were
        /// larger, the first of two tool points at one place would keep the second off the skin,
        /// until the second snaps on.
        #[test]
        fn influence_at_one_place_is_self_compliance(shape in shape(), shallow in 0.003f32..0.1) {
            let (Shape::Ball { radius_m } | Shape::Cylinder { radius_m, .. }) = shape;
            let law = without_spheres(shape);
            let (force_n, stiffness_n_m) = law.force_n(-shallow * radius_m, 0.0);
            let share = law.influence_m_n(0.0, law.self_influence_distance_m(force_n)) * stiffness_n_m;
            prop_assert!((share - 1.0).abs() < 0.1, "{share}");
        }

        /// The influence times the force grows no faster than the contact's own dent, at any
        /// distance. Otherwise two contacts side by side would have two answers.
        #[test]
        fn influence_grows_no_faster_than_the_contacts_own_dent(
            shape in shape(), deep in 0.01f32..3.0, aside in 0.0f32..5.0, curvature_per_m in -300.0f32..300.0,
        ) {
            let (Shape::Ball { radius_m } | Shape::Cylinder { radius_m, .. }) = shape;
            let law = Law::new(shape, MODULUS_PA, 100.0, curvature_per_m);
            let adjacent_m = |force_n: f32| force_n * law.influence_m_n(aside * radius_m, law.self_influence_distance_m(force_n));
            let (depth_m, more_m) = (deep * radius_m, 1.05 * deep * radius_m);
            let (force_n, more_n) = (law.force_n(-depth_m, 0.0).0, law.force_n(-more_m, 0.0).0);
            let grown_m = adjacent_m(more_n) - adjacent_m(force_n);
            prop_assert!(grown_m < 1.1 * (more_m - depth_m), "{grown_m} {}", more_m - depth_m);
        }

        /// The influence of a contact decays with distance.
        #[test]
        fn influence_decays_with_distance(shape in shape(), patch_width_m in 0.003f32..0.03, near in 0.0f32..0.01, far in 0.02f32..0.05) {
            let law = Law::new(shape, MODULUS_PA, patch_width_m, 0.0);
            prop_assert!(law.influence_m_n(far, 0.001) <= law.influence_m_n(near, 0.001));
        }
    }
}
