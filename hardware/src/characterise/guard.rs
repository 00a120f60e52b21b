//! Limits of the handle's position and speed, checked at every tick.

use nalgebra::{Vector3, Vector4};
use rt_core::port::DeviceCapabilities;

use super::halt::Halt;

/// A vector in the device's base frame, followed by its part along the opening. Zero is half open,
/// positive is more open. The fourth part is 0 until [`Guard::opening_m`] is set.
pub(super) type Vector = Vector4<f64>;
/// Index of the opening in a [`Vector`].
pub(super) const OPENING: usize = 3;

/// The three base-frame components of a vector, without the opening.
pub(super) fn of_handle(vector: &Vector) -> Vector3<f64> {
    vector.fixed_rows::<3>(0).into_owned()
}

/// Share of the declared workspace's radius in which experiments are made. A handle of 45 g at 0.5
/// m/s coasts for 22 mm against 0.26 N of friction (Touch). That is less than the remaining 40 mm
/// of the workspace.
const REGION: f64 = 0.6;
/// Largest speed of the handle, m/s: less than half of the speed at which the safety chain cuts the
/// force.
const SPEED_MAX_M_S: f64 = 0.5;

/// State of the handle at a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct HandleState {
    /// Time since the start, s.
    pub(super) at_s: f64,
    /// Position, m.
    pub(super) at_m: Vector,
    /// Mean velocity over the last milliseconds, m/s.
    pub(super) v_m_s: Vector,
}

impl HandleState {
    pub(super) fn start() -> Self {
        Self {
            at_s: 0.0,
            at_m: Vector::zeros(),
            v_m_s: Vector::zeros(),
        }
    }
}

/// The limits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Guard {
    /// Largest distance from the middle of the workspace, m.
    pub(super) region_m: f64,
    /// Half of the travel of the fingers, m, while the opening is measured.
    pub(super) opening_m: Option<f64>,
    /// Start of the present experiment, m, and largest distance from it, m.
    pub(super) excursion_limit: Option<(Vector, f64)>,
}

impl Guard {
    pub(super) fn new(can: &DeviceCapabilities) -> Self {
        Self {
            region_m: REGION * f64::from(can.workspace_radius_m),
            opening_m: None,
            excursion_limit: None,
        }
    }

    /// Largest distance from the middle along an axis, m.
    pub(super) fn reach_m(&self, axis: usize) -> f64 {
        match self.opening_m {
            Some(half_m) if axis == OPENING => half_m,
            _ => self.region_m,
        }
    }

    /// Checks position and speed. Comparisons are written so that NaN ends the experiment.
    pub(super) fn judge(&self, now: &HandleState) -> Result<(), Halt> {
        let distance_m = of_handle(&now.at_m).norm();
        let is_inside = distance_m <= self.region_m;
        if !is_inside {
            return Err(Halt::Outside {
                at_mm: distance_m * 1e3,
                allowed_mm: self.region_m * 1e3,
            });
        }
        let speed_m_s = of_handle(&now.v_m_s).norm().max(now.v_m_s[OPENING].abs());
        let is_slow = speed_m_s <= SPEED_MAX_M_S;
        if !is_slow {
            return Err(Halt::Fast {
                speed_m_s,
                allowed_m_s: SPEED_MAX_M_S,
            });
        }
        match self.excursion_limit {
            Some((from_m, reach_m)) if (now.at_m - from_m).norm() > reach_m => Err(Halt::Away {
                moved_mm: (now.at_m - from_m).norm() * 1e3,
                allowed_mm: reach_m * 1e3,
            }),
            _ => Ok(()),
        }
    }
}
