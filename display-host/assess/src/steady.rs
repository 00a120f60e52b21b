//! Sway of the endoscope's picture, and tilt of its horizon.

use session::Movement;

use crate::tally::Sight;
use crate::vector::{Vec3, axis, dot, sub, wide};

/// Distance in front of the lens at which the sway of the picture is measured, m. It is a usual
/// working distance: with a field of view of 70° the picture is 14 cm wide there.
const WORK_M: f64 = 0.1;

/// Movement of the picture since the last identity image.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Held {
    /// Time without pauses and gaps, s.
    pub(crate) seconds: f64,
    /// Path of the picture's middle at the working distance, m.
    pub(crate) path_m: f64,
    /// Tilt of the horizon at the last pose, degrees.
    pub(crate) tilt_deg: f64,
}

impl Held {
    /// Mean speed of the picture's middle, mm/s.
    pub(crate) fn sway_mm_s(&self) -> f64 {
        1e3 * self.path_m / self.seconds.max(1e-6)
    }
}

/// Measures the movement of the picture from one identity image to the next.
#[derive(Debug, Clone, Default)]
pub(crate) struct Steady {
    sight: Sight,
    /// Path of the picture's middle at the last identity image, m.
    path_before_m: f64,
    held: Held,
}

impl Steady {
    /// Takes a pose of the camera, `seconds` after the last one; 0 s after a pause or a gap. `up`
    /// points upwards in the world.
    pub(crate) fn moved(&mut self, moved: &Movement, seconds: f64, up: Vec3) {
        let camera = &moved.world_from_camera;
        // The camera looks along −z.
        let back_m = axis(camera, 2).map(|x| x * WORK_M);
        let middle_m = sub(wide(camera.position_m), back_m);
        self.sight.step(middle_m, seconds);
        self.held.seconds += seconds;
        let tilt_sine = dot(axis(camera, 0), up).clamp(-1.0, 1.0);
        self.held.tilt_deg = tilt_sine.asin().abs().to_degrees();
    }

    /// Movement since the last call.
    pub(crate) fn take(&mut self) -> Held {
        let path_m = self.sight.path_m();
        let held = Held {
            path_m: path_m - self.path_before_m,
            ..self.held
        };
        self.path_before_m = path_m;
        self.held.seconds = 0.0;
        held
    }
}
