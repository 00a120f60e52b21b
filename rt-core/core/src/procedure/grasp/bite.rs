//! Bite: the tissue between two jaws. Its resistance to the squeeze, its friction on the jaws, and
//! the stiffness of the tissue behind it.

use crate::math::{self, Vec3};
use crate::scene::{Inside, Scene};
use crate::tissue::Bodies;

/// Largest force of jaws that a button closes, N. To hold bowel against a pull of 5 N, profiled
/// jaws need 3 N, and smooth jaws 22 N. Forces from 15 N harm bowel (10.1007/s00464-003-9153-2).
pub(crate) const GRIP_MAX_N: f32 = 4.0;
/// Friction of a profiled jaw divided by that of a smooth jaw. The value is assumed for an
/// atraumatic jaw. It lies between 1 and 22 N / 3 N, the ratio for the best profile in the source
/// of [`GRIP_MAX_N`].
const PROFILE_FACTOR: f32 = 4.0;
/// Width of a jaw, m.
const JAW_WIDTH_M: f32 = 0.003;
/// Stiffness of the grip itself, N/m. It is below the largest stiffness of a Touch-class device.
pub(super) const GRIP_N_M: f32 = 500.0;
/// Smallest thickness of the compressed bite, as a share of its thickness without load. Below it
/// the force no longer grows.
const STRETCH_MIN: f32 = 0.05;

/// Pressure of jaws that crushes tissue, Pa. Damage to porcine liver, bowel and ureter grows from
/// 100 to 300 kPa (De et al. 2007, 10.1177/0278364907082847). Liver is damaged first. The values of
/// the other organs are assumed within that range.
pub(super) fn crush_pressure_pa(inside: Inside) -> f32 {
    match inside {
        Inside::Liver => 1.5e5,
        Inside::Food => 1.8e5,
        Inside::Bile | Inside::Blood => 2.0e5,
        Inside::Solid => 3.0e5,
    }
}

/// Tissue between the jaws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bite {
    /// Thickness without load, m.
    thickness_m: f32,
    /// Contact area with each jaw, m².
    area_m2: f32,
    /// Shear modulus, Pa.
    shear_pa: f32,
    /// Coefficient of Coulomb friction on a smooth jaw.
    friction: f32,
    /// Stiffness of the tissue behind the bite, N/m. The tissue is a half-space under a disc as
    /// wide as the bite.
    backing_n_m: f32,
}

impl Bite {
    /// Bite of these spheres. The jaws are `gap_m` apart along `across`, and `length_m` long along
    /// `along` (unit vectors).
    pub(super) fn new(
        spheres: impl ExactSizeIterator<Item = u32> + Clone,
        (gap_m, length_m): (f32, f32),
        (across, along): (&Vec3, &Vec3),
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) -> Self {
        let share = (spheres.len().max(1) as f32).recip();
        let center = |sphere| bodies.nodes.at(sphere).center_m();
        let middle_m: Vec3 = spheres.clone().map(center).sum::<Vec3>() * share;
        let (mut thick, mut long) = (Extent::NONE, Extent::NONE);
        let (mut radius_max_m, mut plane_pa) = (0.0f32, 0.0);
        let mut bite = Self::default();
        for sphere in spheres {
            let (from_m, radius_m) = (center(sphere) - middle_m, *bodies.radius_m.at(sphere));
            thick.add(from_m.dot(across), radius_m);
            long.add(from_m.dot(along), radius_m);
            radius_max_m = radius_max_m.max(math::norm(&from_m) + radius_m);
            let material = scene.material_of(*bodies.organ.at(sphere));
            bite.shear_pa += share * material.young_pa / (2.0 * (1.0 + material.poisson));
            plane_pa += share * material.young_pa / (1.0 - material.poisson * material.poisson);
            bite.friction += share * material.friction;
        }
        bite.thickness_m = thick.length_m().min(gap_m);
        bite.area_m2 = JAW_WIDTH_M * long.length_m().min(length_m);
        bite.backing_n_m = 2.0 * plane_pa * radius_max_m;
        bite
    }

    /// Force on jaws that are `gap_m` apart, N. The bite is a neo-Hookean slab between two plates:
    /// `A G (1/λ² − λ)`.
    pub(super) fn squeeze_n(&self, gap_m: f32) -> f32 {
        let stretch = gap_m / self.thickness_m.max(f32::MIN_POSITIVE);
        if stretch >= 1.0 {
            return 0.0;
        }
        let stretch = stretch.max(STRETCH_MIN);
        self.area_m2 * self.shear_pa * ((stretch * stretch).recip() - stretch)
    }

    /// Pull that overcomes the friction on both jaws, N. Each jaw presses with `grip_n`.
    pub(super) fn slip_n(&self, grip_n: f32) -> f32 {
        2.0 * PROFILE_FACTOR * self.friction * grip_n
    }

    /// Pressure of jaws that press with `grip_n`, Pa.
    pub(super) fn pressure_pa(&self, grip_n: f32) -> f32 {
        grip_n / self.area_m2.max(f32::MIN_POSITIVE)
    }

    /// Stiffness against a slow pull, N/m: `share` of the grip's stiffness, in series with that of
    /// the tissue behind the bite.
    pub(super) fn pull_stiffness_n_m(&self, share: f32) -> f32 {
        let grip_n_m = GRIP_N_M * share;
        grip_n_m * self.backing_n_m / (grip_n_m + self.backing_n_m).max(f32::MIN_POSITIVE)
    }
}

/// Interval that balls cover on a line.
#[derive(Clone, Copy)]
struct Extent {
    low_m: f32,
    high_m: f32,
}

impl Extent {
    const NONE: Self = Self {
        low_m: f32::MAX,
        high_m: f32::MIN,
    };

    fn add(&mut self, at_m: f32, radius_m: f32) {
        self.low_m = self.low_m.min(at_m - radius_m);
        self.high_m = self.high_m.max(at_m + radius_m);
    }

    fn length_m(&self) -> f32 {
        (self.high_m - self.low_m).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use proptest::prelude::*;
    use std::boxed::Box;

    /// Two spheres of 2 mm, 10 mm apart along the shaft, of E = 5 kPa and ν = 0.45.
    fn bite(gap_m: f32) -> Bite {
        let mut organs = [organ(0, 2, 0, 0)];
        organs[0].material.friction = 0.1;
        let spheres = [0.0, 0.01].map(|z| sphere(Vec3::new(0.0, 0.0, z), 0.002));
        let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
        let mut bodies = Box::new(Bodies::new());
        bodies.load(&scene);
        let directions = (&Vec3::y(), &Vec3::z());
        Bite::new(
            [0, 1].into_iter(),
            (gap_m, 0.02),
            directions,
            &scene,
            &bodies,
        )
    }

    #[test]
    fn forces_and_stiffness_of_a_bite_are_as_computed_by_hand() {
        // 4 mm thick, 14 mm long, 3 mm wide: 42 mm²; G = 1724 Pa.
        let free = bite(0.01);
        assert!(free.squeeze_n(0.004) <= 0.0 && free.squeeze_n(0.1) <= 0.0);
        // Squeezed to a quarter: 42e-6 · 1724 · (16 − 0.25).
        let squeezed_n = free.squeeze_n(0.001);
        assert!((squeezed_n - 1.1405).abs() < 1.0e-3, "{squeezed_n}");
        // Friction on two jaws: 2 · 4 · 0.1 · 1.5 N.
        assert!((free.slip_n(1.5) - 1.2).abs() < 1.0e-5);
        // A disc of 7 mm on a half-space of 6270 Pa has 87.8 N/m, in series with the 500 N/m of the
        // grip.
        let pull_n_m = free.pull_stiffness_n_m(1.0);
        assert!((pull_n_m - 74.7).abs() < 0.1, "{pull_n_m}");
        assert!(free.pull_stiffness_n_m(0.0) <= 0.0);
        // Jaws that close from 3 mm squeeze only 3 mm of the tissue, here to a third.
        let pinched_n = bite(0.003).squeeze_n(0.001);
        assert!((pinched_n - 0.6276).abs() < 1.0e-3, "{pinched_n}");
    }

    proptest! {
        /// The force grows as the gap narrows; it is never a pull, and always bounded.
        #[test]
        fn squeezing_force_grows(a in 0.0f32..0.01, b in 0.0f32..0.01, open in 0.0f32..0.01) {
            let bite = bite(open);
            let (narrow, wide) = (bite.squeeze_n(a.min(b)), bite.squeeze_n(a.max(b)));
            prop_assert!(0.0 <= wide && wide <= narrow && narrow < 1.0e3);
        }
    }
}
