//! Smoke spread through the cavity: a haze that accumulates and is evacuated through the
//! instrument's trocar.

use super::{Kind, Particle};

/// Attenuation of light that a puff adds once it has spread through the cavity, 1/m. Ten seconds of
/// full coagulation, some 480 puffs, take a fifth of the light from tissue 7 cm away.
const PUFF_PER_M: f32 = 0.006;
/// Largest attenuation of light, 1/m. Nothing is visible through such smoke.
const THICKEST_PER_M: f32 = 40.0;
/// Time constant with which smoke settles and leaks out, s. A third is left after a minute.
const SETTLES_S: f32 = 55.0;
/// Time constant with which an open trocar valve exchanges the cavity's gas, s.
const DRAWN_OFF_S: f32 = 4.0;
/// Speed of puffs towards the trocar, m/s.
pub(super) const DRAUGHT_M_S: f32 = 0.06;
/// Distance from the trocar at which puffs leave the cavity, m.
pub(super) const MOUTH_M: f32 = 0.01;

/// Density of the spread smoke, as the attenuation of light, 1/m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Haze {
    pub(super) per_m: f32,
}

impl Haze {
    /// Adds the smoke of a puff that has ended. Other particles add nothing.
    pub(super) fn take(&mut self, particle: &Particle) {
        if particle.kind == Kind::Smoke {
            self.per_m = (self.per_m + PUFF_PER_M).min(THICKEST_PER_M);
        }
    }

    pub(super) fn step(&mut self, step_s: f32, is_drawn_off: bool) {
        let lasts_s = if is_drawn_off { DRAWN_OFF_S } else { SETTLES_S };
        self.per_m *= 1.0 - step_s / lasts_s;
    }
}
