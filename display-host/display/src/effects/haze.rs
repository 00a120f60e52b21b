//! Smoke that has spread through the cavity: a haze that gathers, and is drawn off through the
//! instrument's trocar.

use super::{Kind, Particle};

/// Light that a puff takes from a beam once it has spread through the cavity, 1/m: ten seconds of
/// full coagulation, some 480 puffs, take a quarter of the light from 7 cm, there and back.
const PUFF_PER_M: f32 = 0.006;
/// Thicker than this nothing is seen any more, 1/m.
const THICKEST_PER_M: f32 = 40.0;
/// By itself it settles and leaks out so slowly: what is left after a minute is a third, s.
const SETTLES_S: f32 = 55.0;
/// A trocar's open valve changes the cavity's gas in this time, s.
const DRAWN_OFF_S: f32 = 4.0;
/// Speed of puffs towards the trocar, m/s, and so near to it they have left, m.
pub(super) const DRAUGHT_M_S: f32 = 0.06;
pub(super) const MOUTH_M: f32 = 0.01;

/// How thick it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Haze {
    pub(super) per_m: f32,
}

impl Haze {
    /// A particle has ended: what smoked has not gone, it has spread.
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
