//! The endoscope's front lens. It fogs while it is colder than the cavity, smoke settles on it, and
//! it can be wiped.

use glam::Vec3;

use crate::effects::{Kind, Particle};

/// Temperature inside the body, °C.
const BODY_C: f32 = 37.0;
/// Dew point of the moist air in the cavity, °C.
const DEW_C: f32 = 34.5;
/// Time constant of the lens's warming, s.
const WARM_UP_S: f32 = 60.0;
/// Growth of `fog` per second on a lens 10 °C below the dew point.
const FOG_PER_S: f32 = 0.12;
/// `fog` of a lens that an instructor fogs.
const FOGGED: f32 = 0.6;
/// Distance from a puff's surface within which its smoke settles on the lens, m.
const SETTLES_M: f32 = 0.03;
/// Growth of `soot` per second from one puff near the lens.
const SETTLES_PER_S: f32 = 0.012;

/// State of the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Condensed water: 0 clear, 1 opaque.
    pub fog: f32,
    /// Settled smoke: 0 clean, 1 opaque. Smoke alone brings it to 0.7 at most.
    pub soot: f32,
    /// Temperature of the lens, °C.
    pub warmth_c: f32,
}

impl Default for Lens {
    fn default() -> Self {
        Self::warm()
    }
}

impl Lens {
    /// A lens at body temperature, as from a lens warmer. It does not fog.
    #[must_use]
    pub fn warm() -> Self {
        Self {
            fog: 0.0,
            soot: 0.0,
            warmth_c: BODY_C,
        }
    }

    /// A lens at room temperature, 21 °C.
    #[must_use]
    pub fn cold() -> Self {
        Self {
            warmth_c: 21.0,
            ..Self::warm()
        }
    }

    /// Cools the lens, and fogs it at once.
    pub fn fog_up(&mut self) {
        let fog = self.fog.max(FOGGED);
        *self = Self {
            fog,
            soot: self.soot,
            ..Self::cold()
        };
    }

    /// Wipes the lens, which becomes clean but no warmer.
    pub fn wipe(&mut self) {
        (self.fog, self.soot) = (0.0, 0.0);
    }

    /// Advances by `seconds`, of which at most 0.25 count. Puffs of smoke near `eye` settle on the
    /// lens.
    pub(super) fn advance(&mut self, seconds: f32, eye: Vec3, particles: &[Particle]) {
        let seconds = seconds.clamp(0.0, 0.25);
        self.warmth_c += (BODY_C - self.warmth_c) * (seconds / WARM_UP_S);
        // Fog grows on a lens below the dew point. Above the dew point it dries at half the rate.
        let cold = (DEW_C - self.warmth_c) / 10.0;
        let rate = if cold > 0.0 { cold } else { 0.5 * cold };
        self.fog = (self.fog + FOG_PER_S * rate * seconds).clamp(0.0, 1.0);
        let near = particles
            .iter()
            .filter(|p| p.kind == Kind::Smoke && p.at_m.distance(eye) < SETTLES_M + p.radius_m());
        let settled = near.count() as f32 * SETTLES_PER_S * seconds;
        self.soot = (self.soot + settled).min(0.7);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(mut lens: Lens, seconds: u32) -> Lens {
        for _ in 0..seconds * 10 {
            lens.advance(0.1, Vec3::ZERO, &[]);
        }
        lens
    }

    #[test]
    fn a_cold_lens_fogs_a_warm_one_does_not_and_fog_goes_as_it_warms() {
        assert!(after(Lens::warm(), 60).fog < 1e-6);
        let fogged = after(Lens::cold(), 10);
        assert!(fogged.fog > 0.5, "{fogged:?}");
        let mut wiped = fogged;
        wiped.wipe();
        assert!(wiped.fog < 1e-6 && after(wiped, 5).fog > 0.1);
        assert!(after(Lens::cold(), 600).fog < 0.05);
    }

    #[test]
    fn smoke_before_the_lens_settles_until_it_is_wiped() {
        let puff = Particle {
            kind: Kind::Smoke,
            at_m: Vec3::new(0.0, 0.0, -0.02),
            velocity_m_s: Vec3::ZERO,
            age_s: 0.5,
            lasts_s: 3.0,
            size_m: 0.003,
            own: 0.5,
        };
        let mut lens = Lens::warm();
        for _ in 0..50 {
            lens.advance(0.1, Vec3::ZERO, &[puff; 4]);
        }
        assert!(lens.soot > 0.1, "{lens:?}");
        let far = lens.soot;
        lens.advance(0.1, Vec3::X, &[puff; 4]);
        assert!((lens.soot - far).abs() < 1e-6);
        lens.wipe();
        assert!(lens.soot < 1e-6);
    }
}
