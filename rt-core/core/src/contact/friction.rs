//! Dry friction of a contact: a bristle (a spring along the skin) that the tool bends until it
//! slides.
//!
//! The compliance of the bristle is that of a half-space under a contact of half-width a (stiffness
//! `8 G a / (2 − ν)`, Mindlin 1949), less the compliance of the spheres. The bristle never pulls
//! harder than `μ F` (return mapping), so there is no step between sticking and sliding, and none
//! at a reversal.

use crate::math::{self, Vec3};

/// Bristle of a contact at the end of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bristle {
    /// Displacement of the tool relative to the skin point to which it sticks, along the skin, m.
    deflection_m: Vec3,
    /// Stiffness, N/m; 0 before the first touch.
    stiffness_n_m: f32,
}

/// Least share of the half-space's compliance that the bristle keeps. Under a contact wider than
/// the spacing of the spheres, the spheres already supply all of this compliance. Without this
/// share the bristle would be rigid there, and chatter. A larger share softens the friction of wide
/// contacts.
const COMPLIANCE_SHARE_MIN: f32 = 0.25;

/// Stiffness of the bristle, N/m, on tissue with modulus `E / (1 − ν²)` under a contact of this
/// half-width. `mesh_compliance_m_n` is the compliance of the spheres normal to the skin.
pub(crate) fn stiffness_n_m(
    modulus_pa: f32,
    poisson: f32,
    half_width_m: f32,
    mesh_compliance_m_n: f32,
) -> f32 {
    let normal_m_n = (2.0 * modulus_pa * half_width_m.max(HALF_WIDTH_MIN_M)).recip();
    (tangential_over_normal_compliance(poisson)
        * (normal_m_n - mesh_compliance_m_n).max(COMPLIANCE_SHARE_MIN * normal_m_n))
    .recip()
}

/// Compliance of the tissue along its skin over its compliance normal to the skin (Cerruti's mean
/// over Boussinesq's).
pub(crate) fn tangential_over_normal_compliance(poisson: f32) -> f32 {
    (2.0 - poisson) / (2.0 * (1.0 - poisson))
}

/// Least half-width, m; a narrower contact would have almost no stiffness.
const HALF_WIDTH_MIN_M: f32 = 1.0e-5;

impl Bristle {
    /// Bristle of a contact that has not begun.
    pub(crate) const RELAXED: Self = Self {
        deflection_m: Vec3::new(0.0, 0.0, 0.0),
        stiffness_n_m: 0.0,
    };

    /// This bristle with a new normal of the skin and a new stiffness, N/m. A bristle that stiffens
    /// keeps its force; a bristle that softens keeps its deflection. So neither change adds energy.
    pub(crate) fn on(&self, normal: &Vec3, stiffness_n_m: f32) -> Self {
        let scale = if stiffness_n_m > self.stiffness_n_m {
            self.stiffness_n_m / stiffness_n_m
        } else {
            1.0
        };
        Self {
            deflection_m: tangential(&self.deflection_m, normal) * scale,
            stiffness_n_m,
        }
    }

    /// Force on the tool, N, at most `force_max_n`. The tool has travelled by `travel_m` relative
    /// to the skin before this force acts. The skin yields to the force with
    /// `sphere_compliance_m_n`.
    pub(crate) fn pull_n(
        &self,
        travel_m: &Vec3,
        normal: &Vec3,
        sphere_compliance_m_n: f32,
        force_max_n: f32,
    ) -> Vec3 {
        let deflection_m = self.deflection_m + tangential(travel_m, normal);
        let stuck_n = deflection_m
            * (-self.stiffness_n_m / (1.0 + self.stiffness_n_m * sphere_compliance_m_n));
        let stuck_size_n = math::norm(&stuck_n);
        if stuck_size_n <= force_max_n {
            stuck_n
        } else {
            stuck_n * (force_max_n / stuck_size_n)
        }
    }

    /// Stiffness that the tool feels in a step in which the skin yields with
    /// `sphere_compliance_m_n`, N/m.
    pub(crate) fn felt_stiffness_n_m(&self, sphere_compliance_m_n: f32) -> f32 {
        self.stiffness_n_m / (1.0 + self.stiffness_n_m * sphere_compliance_m_n)
    }

    /// The bristle after it has pulled with this force. Its deflection is the one that gives this
    /// force; any further travel was sliding.
    pub(crate) fn after(&self, pull_n: &Vec3) -> Self {
        let per_n = self.stiffness_n_m.max(f32::MIN_POSITIVE).recip();
        let deflection_m = -pull_n * per_n;
        Self {
            deflection_m: if math::is_finite(&deflection_m) {
                deflection_m
            } else {
                Vec3::zeros()
            },
            ..*self
        }
    }
}

/// Component of `v` along the skin.
fn tangential(v: &Vec3, normal: &Vec3) -> Vec3 {
    v - normal * normal.dot(v)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::Quat;
    use crate::testing::vector;
    use proptest::prelude::*;

    const UP: Vec3 = Vec3::new(0.0, 0.0, 1.0);

    /// One tick on skin that does not yield.
    fn tick(
        bristle: Bristle,
        travel_m: Vec3,
        stiffness_n_m: f32,
        force_max_n: f32,
    ) -> (Bristle, Vec3) {
        let now = bristle.on(&UP, stiffness_n_m);
        let pull_n = now.pull_n(&travel_m, &UP, 0.0, force_max_n);
        (now.after(&pull_n), pull_n)
    }

    #[test]
    fn bristle_has_mindlins_stiffness() {
        // E 5 kPa, ν 0.45: G = 1724 Pa; under 3 mm of half-width 8 G a / (2 − ν) = 26.7 N/m.
        let modulus_pa = 5000.0 / (1.0 - 0.45 * 0.45);
        let alone = stiffness_n_m(modulus_pa, 0.45, 0.003, 0.0);
        assert!((alone - 26.7).abs() < 0.05, "{alone}");
        // Spheres with half of the compliance leave twice the stiffness to the bristle; spheres
        // with all of it or more leave four times.
        let half = stiffness_n_m(modulus_pa, 0.45, 0.003, 0.5 / (2.0 * modulus_pa * 0.003));
        assert!((half / alone - 2.0).abs() < 1.0e-3);
        assert!((stiffness_n_m(modulus_pa, 0.45, 0.003, 1.0) / alone - 4.0).abs() < 1.0e-3);
    }

    #[test]
    fn bristle_sticks_slides_and_reverses() {
        // At 100 N/m and at most 20 mN, the bristle sticks for 0.2 mm.
        let (at_rest, none) = tick(Bristle::RELAXED, Vec3::zeros(), 100.0, 0.02);
        assert!(math::norm(&none) <= 0.0);
        let (stuck, pull_n) = tick(at_rest, Vec3::new(1.0e-4, 0.0, 0.0), 100.0, 0.02);
        assert!(math::norm(&(pull_n - Vec3::new(-0.01, 0.0, 0.0))) < 1.0e-8);
        let (back, pull_n) = tick(stuck, Vec3::new(-1.0e-4, 0.0, 0.0), 100.0, 0.02);
        assert!(math::norm(&pull_n) < 1.0e-8 && math::norm(&back.deflection_m) < 1.0e-10);
        let (slid, pull_n) = tick(stuck, Vec3::new(5.0e-4, 0.0, 0.0), 100.0, 0.02);
        assert!(math::norm(&(pull_n - Vec3::new(-0.02, 0.0, 0.0))) < 1.0e-8);
        // Reversed: after 0.2 mm back the bristle is straight, and a tick without motion has no
        // force.
        let (straight, pull_n) = tick(slid, Vec3::new(-2.0e-4, 0.0, 0.0), 100.0, 0.02);
        assert!(math::norm(&pull_n) < 1.0e-8, "{pull_n}");
        let (_, pull_n) = tick(straight, Vec3::zeros(), 100.0, 0.02);
        assert!(math::norm(&pull_n) < 1.0e-8, "{pull_n}");
        // Lifted off the skin, the bristle is straight again.
        let (lifted, pull_n) = tick(slid, Vec3::zeros(), 100.0, 0.0);
        assert!(math::norm(&pull_n) <= 0.0 && math::norm(&lifted.deflection_m) <= 0.0);
    }

    #[test]
    fn compliant_skin_halves_the_pull() {
        // Skin that is as compliant as the bristle takes half of the travel, so the force is
        // halved.
        let bristle = Bristle::RELAXED.on(&UP, 100.0);
        let pull_n = bristle.pull_n(&Vec3::new(1.0e-4, 0.0, 0.5), &UP, 0.01, 1.0);
        assert!(math::norm(&(pull_n - Vec3::new(-0.005, 0.0, 0.0))) < 1.0e-8);
        assert!((bristle.felt_stiffness_n_m(0.01) - 50.0).abs() < 1.0e-4);
    }

    proptest! {
        /// Friction never exceeds μ F, never acts along the normal, and never makes energy.
        #[test]
        fn friction_makes_no_energy(
            travels_m in prop::collection::vec((vector(3.0e-4), 1.0f32..300.0, 0.0f32..0.05), 1..60),
        ) {
            let (mut bristle, mut given_j) = (Bristle::RELAXED, 0.0f64);
            for (travel_m, stiffness_n_m, force_max_n) in travels_m {
                let (next, pull_n) = tick(bristle, travel_m, stiffness_n_m, force_max_n);
                prop_assert!(math::norm(&pull_n) <= force_max_n * 1.0001);
                prop_assert!(pull_n.z.abs() < 1.0e-9);
                // Work of an implicit step: the force at its end over its whole travel.
                given_j -= f64::from(pull_n.dot(&travel_m));
                bristle = next;
                let stored_j = f64::from(0.5 * stiffness_n_m * bristle.deflection_m.norm_squared());
                prop_assert!(stored_j <= given_j + 1.0e-9, "{stored_j} of {given_j}");
            }
        }

        /// A sliding bristle pulls against the travel.
        #[test]
        fn sliding_friction_opposes_the_travel(travel_m in vector(1.0e-3), force_max_n in 1.0e-4f32..0.01) {
            prop_assume!(math::norm(&tangential(&travel_m, &UP)) > 1.0e-4);
            let (_, pull_n) = tick(Bristle::RELAXED, travel_m, 300.0, force_max_n);
            let against = -pull_n.dot(&tangential(&travel_m, &UP));
            let size = math::norm(&pull_n) * math::norm(&tangential(&travel_m, &UP));
            prop_assert!(against > 0.999 * size);
        }

        /// Friction is the same in a turned and in a mirrored frame.
        #[test]
        fn friction_is_isotropic(first in vector(3.0e-4), travel_m in vector(3.0e-4), turn in vector(3.0)) {
            let pull = |map: &dyn Fn(&Vec3) -> Vec3| {
                let up = map(&UP);
                let begun = Bristle::RELAXED.on(&up, 100.0);
                let begun = begun.after(&begun.pull_n(&map(&first), &up, 0.001, 0.02));
                begun.on(&up, 120.0).pull_n(&map(&travel_m), &up, 0.001, 0.02)
            };
            let here = pull(&|v| *v);
            let turn = Quat::from_scaled_axis(turn);
            prop_assert!(math::norm(&(pull(&|v| turn * v) - turn * here)) < 1.0e-6);
            let mirror = |v: &Vec3| Vec3::new(-v.x, v.y, v.z);
            prop_assert!(math::norm(&(pull(&mirror) - mirror(&here))) < 1.0e-7);
        }
    }
}
