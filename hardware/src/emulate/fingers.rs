//! Fingers in a handle that opens and shuts.

use rt_core::math::Vec3;

use super::touch::{Body, Grip, Touch};
use crate::rig::wire::Opening;

/// Moving half of the handle: a light ring on a hinge with little friction. Its stops are at both
/// ends of the opening; [`Fingers::new`] replaces the radius.
pub(crate) const RING: Body = Body {
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
    /// Half of the travel of the fingers, m.
    half_m: f32,
    /// The ring, which moves along x. At 0 m the handle is half open.
    ring: Touch,
    /// Place that the hand intends, m.
    wanted_m: f32,
}

impl Fingers {
    /// Fingers that hold a handle with this grip. The handle begins wide open.
    pub(super) fn new(handle: Opening, ring: Body, grip: Grip) -> Self {
        let half_m = 0.5 * handle.travel_m;
        let ring = Body {
            workspace_radius_m: half_m,
            ..ring
        };
        Self {
            half_m,
            ring: Touch::new(ring, grip, Vec3::x() * half_m),
            wanted_m: half_m,
        }
    }

    /// Advances one millisecond. The fingers `shut` the handle or open it; the motor opens it with
    /// `opening_n`, N.
    pub(super) fn step(&mut self, shut: bool, opening_n: f32) {
        let step_m = 2.0 * self.half_m / CLOSING_MS;
        let step_m = if shut { -step_m } else { step_m };
        let wanted_m = (self.wanted_m + step_m).clamp(-self.half_m, self.half_m);
        self.pull(wanted_m, opening_n);
    }

    /// Advances one millisecond. The fingers pull towards a place, m from half open.
    pub(super) fn pull(&mut self, wanted_m: f32, opening_n: f32) {
        let speed_m_s = (wanted_m - self.wanted_m) / 1.0e-3;
        self.wanted_m = wanted_m;
        let [at, speed, force] = [wanted_m, speed_m_s, opening_n].map(|it| Vec3::x() * it);
        self.ring.step(at, speed, force);
    }

    /// Opening that the device measures.
    pub(super) fn opening(&self) -> f32 {
        (0.5 + 0.5 * self.ring.measured_m().x / self.half_m).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::wire::Capabilities;

    fn pressed(opening_n: f32, shut: bool) -> f32 {
        let handle = Capabilities::touch_class_with_opening().opening.unwrap();
        let mut fingers = Fingers::new(handle, RING, Grip::STYLUS);
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

    #[test]
    fn a_ring_that_nobody_holds_stays_within_its_stops() {
        let handle = Capabilities::touch_class_with_opening().opening.unwrap();
        let mut fingers = Fingers::new(handle, RING, Grip::NONE);
        for (opening_n, end) in [(-0.5, 0.0), (0.5, 1.0)] {
            for _ in 0..1000 {
                fingers.step(false, opening_n);
            }
            assert!(
                (fingers.opening() - end).abs() < 0.01,
                "{}",
                fingers.opening()
            );
            // Without force the ring stays at its stop.
            for _ in 0..1000 {
                fingers.step(false, 0.0);
            }
            assert!(
                (fingers.opening() - end).abs() < 0.1,
                "{}",
                fingers.opening()
            );
        }
    }
}
