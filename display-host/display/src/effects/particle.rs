//! Flying particles: puffs, drops and sparks.

use glam::Vec3;

use super::Kind;

/// Largest number of particles.
pub const PARTICLES: usize = 480;

const GRAVITY_M_S2: f32 = 9.81;

/// A puff, a drop or a spark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// Kind of the effect that emitted the particle.
    pub kind: Kind,
    /// Centre in the world frame, m.
    pub at_m: Vec3,
    /// Velocity, m/s.
    pub velocity_m_s: Vec3,
    /// Age, s.
    pub age_s: f32,
    /// Lifetime, s.
    pub lasts_s: f32,
    /// Initial radius, m.
    pub size_m: f32,
    /// The particle's own random number, from 0 to 1. It makes particles look different.
    pub own: f32,
}

impl Particle {
    pub(super) fn is_alive(&self) -> bool {
        self.age_s < self.lasts_s && self.at_m.is_finite()
    }

    /// Share of its lifetime that has passed, from 0 to 1.
    #[must_use]
    pub fn life(&self) -> f32 {
        (self.age_s / self.lasts_s).clamp(0.0, 1.0)
    }

    /// Present radius, m. Smoke and steam spread with age.
    #[must_use]
    pub fn radius_m(&self) -> f32 {
        match self.kind {
            Kind::Smoke => self.size_m * (1.0 + 7.0 * self.life().sqrt()),
            Kind::Steam => self.size_m * (1.0 + 4.0 * self.life().sqrt()),
            _ => self.size_m,
        }
    }

    /// Moves the particle by one time step. The draught (m/s) moves only smoke and steam.
    pub(super) fn step(&mut self, step_s: f32, up: Vec3, draught_m_s: Vec3) {
        self.age_s += step_s;
        match self.kind {
            Kind::Smoke | Kind::Steam => {
                // The gas slows the puff; heat lifts it, and eddies move it about.
                let rise = up * (0.035 * (1.0 - 0.7 * self.life()));
                let wind = rise + eddies(self.at_m, self.age_s, self.own) * 0.016 + draught_m_s;
                self.velocity_m_s += (wind - self.velocity_m_s) * (4.0 * step_s);
            }
            Kind::Sparks => {
                self.velocity_m_s -= up * (GRAVITY_M_S2 * step_s);
                self.velocity_m_s *= 1.0 - 3.0 * step_s;
            }
            Kind::Blood | Kind::Bile | Kind::Char | Kind::Water | Kind::Suction => {
                self.velocity_m_s -= up * (GRAVITY_M_S2 * step_s);
            }
        }
        self.at_m += self.velocity_m_s * step_s;
    }
}

/// Velocity of a swirling flow, about 1 in size; `own` tells particles apart. The flow has no
/// divergence, because no component depends on its own coordinate.
fn eddies(at_m: Vec3, age_s: f32, own: f32) -> Vec3 {
    let p = at_m * 60.0 + Vec3::splat(own * 9.0);
    let t = age_s * 0.9;
    Vec3::new(
        (p.y + t).sin() + 0.5 * (2.3 * p.z - t).cos(),
        (p.z + 1.1 * t).sin() + 0.5 * (2.1 * p.x + t).cos(),
        (p.x - 0.8 * t).sin() + 0.5 * (2.6 * p.y + t).cos(),
    )
}
