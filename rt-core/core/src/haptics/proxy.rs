//! Proxy pose: the pose of the instrument. It differs from the device pose while the hand pushes
//! harder than the device can push back.
//!
//! The device's force is limited. A hand that pushed on beyond the limit would drive the instrument
//! through organs with forces that it does not feel. So beyond the limit the instrument follows a
//! virtual handle. The virtual handle is displaced from the device pose just so far that the
//! tissue's force stays at the limit. The instrument is a god-object (Zilles and Salisbury 1995) on
//! a spring that yields at the limit. Below the limit the proxy pose is the device pose, and the
//! tissue's force reaches the hand without a virtual coupling.

use crate::math::{self, Pose, Vec3};

/// Share of the excess force that one tick removes by moving the proxy. The share is below 1,
/// because the tissue responds a tick later. With a larger share the proxy follows faster, and may
/// oscillate.
const GAIN: f32 = 0.25;
/// Lower bound of the stiffness by which the excess force is divided, N/m. On softer contact, the
/// excess vanishes more slowly.
const STIFFNESS_MIN_N_M: f32 = 50.0;
/// Largest change of the displacement in a tick, m.
const STEP_MAX_M: f32 = 0.001;
/// Largest displacement of the instrument from the hand, m.
const DISPLACEMENT_MAX_M: f32 = 0.05;
/// Lower bound of the force limit, N. The instrument must be able to press on tissue even with a
/// device that renders less.
const LIMIT_MIN_N: f32 = 0.5;

/// Displacement of the instrument from the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Proxy {
    /// Vector from the real handle to the virtual one, world frame, m.
    displacement_m: Vec3,
}

impl Proxy {
    /// No displacement.
    pub(crate) const NONE: Self = Self {
        displacement_m: Vec3::new(0.0, 0.0, 0.0),
    };

    /// Pose of the virtual handle, which the instrument follows.
    pub(crate) fn handle(&self, world_from_hand: &Pose) -> Pose {
        let mut handle = *world_from_hand;
        handle.translation.vector += self.displacement_m;
        handle
    }

    /// Updates the displacement after a tick in which tissue pushed the handle with `force_n`
    /// (world frame). Its contact is at most as stiff as `stiffness_n_m`. The device can render
    /// forces up to `limit_n`.
    pub(crate) fn update(&mut self, force_n: &Vec3, stiffness_n_m: f32, limit_n: f32) {
        let excess_n = math::norm(force_n) - limit_n.max(LIMIT_MIN_N);
        let step_m = GAIN * excess_n.abs() / stiffness_n_m.max(STIFFNESS_MIN_N_M);
        let step_m = step_m.min(STEP_MAX_M);
        if excess_n > 0.0 {
            let direction = math::unit(force_n).unwrap_or_else(Vec3::zeros);
            let displacement_m = self.displacement_m + direction * step_m;
            let scale = DISPLACEMENT_MAX_M / math::norm(&displacement_m).max(DISPLACEMENT_MAX_M);
            self.displacement_m = displacement_m * scale;
        } else {
            let length_m = math::norm(&self.displacement_m);
            let remaining_m = (length_m - step_m).max(0.0);
            self.displacement_m *= remaining_m / length_m.max(f32::MIN_POSITIVE);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::testing::vector;
    use proptest::prelude::*;

    #[test]
    fn proxy_gives_way_and_comes_back_as_computed_by_hand() {
        let mut proxy = Proxy::NONE;
        proxy.update(&Vec3::new(0.0, 0.0, 3.0), 200.0, 3.0);
        assert_eq!(proxy, Proxy::NONE);
        // 0.2 N too much, 200 N/m: a quarter of 1 mm.
        proxy.update(&Vec3::new(0.0, 0.0, 3.2), 200.0, 3.0);
        assert!(math::norm(&(proxy.displacement_m - Vec3::z() * 0.000_25)) < 1.0e-8);
        // A force that is 0.1 N below the limit halves the displacement. Without force it vanishes.
        proxy.update(&Vec3::new(0.0, 0.0, 2.9), 200.0, 3.0);
        assert!(math::norm(&(proxy.displacement_m - Vec3::z() * 0.000_125)) < 1.0e-8);
        proxy.update(&Vec3::zeros(), 0.0, 3.0);
        assert_eq!(proxy, Proxy::NONE);
    }

    proptest! {
        /// Displacement and step are bounded for any force; without a force the proxy returns to
        /// the hand.
        #[test]
        fn proxy_is_continuous_and_comes_back(
            all in prop::collection::vec((vector(1.0e4), 0.0f32..1.0e6, 0.0f32..5.0), 0..200),
        ) {
            let mut proxy = Proxy::NONE;
            for (force_n, stiffness_n_m, limit_n) in all {
                let before = proxy;
                proxy.update(&force_n, stiffness_n_m, limit_n);
                let step_m = math::norm(&(proxy.displacement_m - before.displacement_m));
                prop_assert!(step_m <= STEP_MAX_M * 1.001, "{}", step_m);
                prop_assert!(math::norm(&proxy.displacement_m) <= DISPLACEMENT_MAX_M * 1.001);
            }
            for _ in 0..60 {
                proxy.update(&Vec3::zeros(), 0.0, 3.3);
            }
            prop_assert_eq!(proxy, Proxy::NONE);
        }

        /// On a spring of the stated stiffness, or a softer one, the force converges to the limit.
        #[test]
        fn the_force_comes_to_the_limit(
            depth_m in 0.0f32..0.03, stiffness in 60.0f32..1000.0, softer in 0.5f32..1.0,
        ) {
            let mut proxy = Proxy::NONE;
            let force = |proxy: &Proxy| {
                Vec3::z() * (stiffness * softer * (depth_m - proxy.displacement_m.z)).max(0.0)
            };
            for _ in 0..200 {
                proxy.update(&force(&proxy), stiffness, 3.0);
            }
            let expected = (stiffness * softer * depth_m).min(3.0);
            prop_assert!((force(&proxy).z - expected).abs() < 0.05, "{}", force(&proxy).z);
        }
    }
}
