//! Steadiness of the endoscope's picture, and the tilt of its horizon.

use session::Movement;

use crate::tally::Sight;
use crate::vector::{Vec3, axis, dot, sub, wide};

/// Distance before the lens at which the sway of the picture is measured, m. It is a usual working
/// distance, at which a picture of 70° is 14 cm wide.
const WORK_M: f64 = 0.1;

/// Movement of the picture since the last identity image.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Held {
    /// Counted time, s.
    pub(crate) seconds: f64,
    /// Path of the picture's middle, m.
    pub(crate) path_m: f64,
    /// Present tilt of the horizon, degrees.
    pub(crate) tilt_deg: f64,
}

impl Held {
    /// Mean speed of the picture's middle, mm/s.
    pub(crate) fn sway_mm_s(&self) -> f64 {
        1e3 * self.path_m / self.seconds.max(1e-6)
    }
}

/// Follows the picture from one identity image to the next.
#[derive(Debug, Clone, Default)]
pub(crate) struct Steady {
    sight: Sight,
    from_m: f64,
    held: Held,
}

impl Steady {
    /// Takes a pose of the camera, `seconds` of counted time after the last one.
    pub(crate) fn moved(&mut self, moved: &Movement, seconds: f64, up: Vec3) {
        let camera = &moved.world_from_camera;
        let ahead = axis(camera, 2).map(|x| x * WORK_M);
        self.sight
            .step(sub(wide(camera.position_m), ahead), seconds);
        self.held.seconds += seconds;
        let level = dot(axis(camera, 0), up).clamp(-1.0, 1.0);
        self.held.tilt_deg = level.asin().abs().to_degrees();
    }

    /// Movement since the last call.
    pub(crate) fn take(&mut self) -> Held {
        let path_m = self.sight.path_m();
        let held = Held {
            path_m: path_m - self.from_m,
            ..self.held
        };
        self.from_m = path_m;
        self.held.seconds = 0.0;
        held
    }
}
