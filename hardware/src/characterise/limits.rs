//! Largest forces of the experiments.

use nalgebra::Vector3;
use rt_core::port::DeviceCapabilities;

use super::guard::{OPENING, Vector, of_handle};
use super::halt::Halt;

/// Largest force unless a person allows more, N: the weight of 100 g. A hand that does not expect
/// this force yields or resists without effort. The force is several times the dry friction of
/// desktop devices (0.1 to 0.3 N), so it moves their handles.
pub const FORCE_N: f64 = 1.0;
/// Share of the declared peak force that no experiment exceeds. A device that renders twice the
/// commanded force then still stays within its declared peak.
const PEAK_SHARE: f64 = 0.5;
/// Least force with which anything can be measured, N.
const FORCE_MIN_N: f64 = 0.05;
/// Largest change of force per tick, N. A chirp of 50 Hz and 0.88 N changes by up to 0.28 N per
/// tick.
const SLEW_N: f64 = 0.3;

/// Largest forces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Largest force at the handle, N.
    pub(super) handle_n: f64,
    /// Largest force along the opening, N. 0: the device renders none that can be used.
    pub(super) opening_n: f64,
}

impl Limits {
    /// Limits for a device. `force_n` is the largest force that a person allows.
    pub(super) fn new(can: &DeviceCapabilities, force_n: Option<f64>) -> Result<Self, Halt> {
        let peak_n = PEAK_SHARE * f64::from(can.force_max_n);
        let allowed_n = peak_n.min(f64::from(can.force_continuous_n));
        let handle_n = force_n.unwrap_or(FORCE_N.min(allowed_n));
        if !(FORCE_MIN_N..=allowed_n).contains(&handle_n) {
            let force_n = handle_n;
            return Err(Halt::Force { force_n, allowed_n });
        }
        // A motor along the opening can hold its peak for ever (PROTOCOL.md).
        let opening_n = match can.opening.is_rendered() {
            true => PEAK_SHARE * f64::from(can.opening.force_max_n),
            false => 0.0,
        };
        let opening_n = opening_n.min(force_n.unwrap_or(FORCE_N));
        Ok(Self {
            handle_n,
            opening_n: if opening_n < FORCE_MIN_N {
                0.0
            } else {
                opening_n
            },
        })
    }

    /// Largest force along an axis, N.
    pub(super) const fn of(&self, axis: usize) -> f64 {
        if axis == OPENING {
            self.opening_n
        } else {
            self.handle_n
        }
    }

    /// Largest force along an axis, N, in addition to the forces that carry the handle across that
    /// axis.
    pub(super) fn along_n(&self, axis: usize, carries_n: &Vector) -> f64 {
        if axis == OPENING {
            return self.opening_n;
        }
        let mut across_n = of_handle(carries_n);
        across_n[axis] = 0.0;
        let square = self.handle_n.powi(2) - across_n.norm_squared();
        square.max(0.0).sqrt()
    }

    /// A force, shortened to the limits.
    pub(super) fn bounded_n(&self, wanted_n: &Vector) -> Vector {
        let opening_n = self.opening_n;
        joined(
            &shortened(of_handle(wanted_n), self.handle_n),
            wanted_n[OPENING].clamp(-opening_n, opening_n),
        )
    }
}

/// The force of the next tick between `from_n` and `to_n`: the change is at most [`SLEW_N`].
pub(super) fn slewed_n(from_n: &Vector, to_n: &Vector) -> Vector {
    let change_n = to_n - from_n;
    let handle_n = shortened(of_handle(&change_n), SLEW_N);
    from_n + joined(&handle_n, change_n[OPENING].clamp(-SLEW_N, SLEW_N))
}

fn joined(handle: &Vector3<f64>, opening: f64) -> Vector {
    handle.push(opening)
}

/// `wanted`, shortened to `limit`.
fn shortened(wanted: Vector3<f64>, limit: f64) -> Vector3<f64> {
    let norm = wanted.norm();
    if norm <= limit {
        wanted
    } else {
        wanted * (limit / norm)
    }
}
