//! Fingers in a handle that opens and shuts.

use rt_core::math::Vec3;

use super::touch::{Body, Grip, Touch};
use crate::rig::wire::Opening;

/// Moving half of the handle: a light ring on a hinge with little friction.
const RING: Body = Body {
    mass_kg: 0.02,
    friction_n: 0.05,
    damping_n_s_m: 0.2,
    encoder_step_m: 0.02e-3,
    workspace_radius_m: 1.0,
    force_max_n: f32::MAX,
    force_continuous_n: f32::MAX,
};
/// Time in which a hand closes a grasper, ms (Barrie et al.: 0.52 s).
const CLOSING_MS: f32 = 520.0;

/// The ring and the fingers that move it.
#[derive(Debug, Clone)]
pub(super) struct Fingers {
    handle: Opening,
    /// The ring, which moves along x. At 0 m the handle is shut.
    ring: Touch,
    /// Opening that the hand intends, 0 to 1.
    wanted: f32,
}

impl Fingers {
    /// Fingers in a handle that is wide open.
    pub(super) fn new(handle: Opening) -> Self {
        let open_m = Vec3::new(handle.travel_m, 0.0, 0.0);
        Self {
            handle,
            ring: Touch::new(RING, Grip::STYLUS, open_m),
            wanted: 1.0,
        }
    }

    /// Advances one millisecond. The fingers `shut` the handle or open it; the motor opens it with
    /// `opening_n`, N.
    pub(super) fn step(&mut self, shut: bool, opening_n: f32) {
        let before = self.wanted;
        let step = if shut { -1.0 } else { 1.0 } / CLOSING_MS;
        self.wanted = (self.wanted + step).clamp(0.0, 1.0);
        let at = |opening: f32| Vec3::new(opening * self.handle.travel_m, 0.0, 0.0);
        let speed_m_s = (at(self.wanted) - at(before)) / 1.0e-3;
        let force_n = Vec3::new(opening_n, 0.0, 0.0);
        self.ring.step(at(self.wanted), speed_m_s, force_n);
    }

    /// Opening that the device measures. The handle's stops are at 0 and 1.
    pub(super) fn opening(&self) -> f32 {
        (self.ring.measured_m().x / self.handle.travel_m).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::wire::Capabilities;

    fn pressed(opening_n: f32, shut: bool) -> f32 {
        let handle = Capabilities::touch_class_with_opening().opening.unwrap();
        let mut fingers = Fingers::new(handle);
        for _ in 0..2000 {
            fingers.step(shut, opening_n);
        }
        fingers.opening()
    }

    #[test]
    fn fingers_shut_and_open_the_handle_and_yield_to_its_motor() {
        assert!(pressed(0.0, true) < 0.01 && pressed(0.0, false) > 0.99);
        // 2 N against 400 N/m: 5 mm of 30, less the friction.
        let held = pressed(2.0, true);
        assert!((held - 0.1667).abs() < 0.01, "{held}");
    }
}
