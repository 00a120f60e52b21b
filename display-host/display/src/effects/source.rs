//! Sources, which emit particles and wet the skin around them.

use glam::Vec3;

use super::particle::Particle;
use super::stain::{self, Skin, Stain};
use super::{Effect, Kind, chance, throw};

/// Period of the heartbeat, s.
const BEAT_S: f32 = 0.86;
/// Speed of blood that spurts at a pressure of 1, m/s. Bile seeps.
const SPURT_M_S: f32 = 0.55;
/// Interval between the marks of blood or bile that runs down, at a pressure of 1, s.
const RUN_S: f32 = 0.12;

/// A running source.
#[derive(Debug, Clone)]
pub(super) struct Source {
    pub(super) effect: Effect,
    age_s: f32,
    /// Accumulated fraction of the next particle.
    due: f32,
    /// Vertex of the skin at the source.
    mouth: Option<usize>,
    /// Vertex of the skin that the blood or bile running down has reached.
    front: Option<usize>,
    run_s: f32,
}

impl Source {
    pub(super) fn new(effect: Effect, mouth: Option<usize>) -> Self {
        Self {
            effect,
            age_s: 0.0,
            due: 0.0,
            mouth,
            front: mouth,
            run_s: 0.0,
        }
    }

    /// Renews the effect: its duration counts from now.
    pub(super) fn go_on(&mut self, effect: &Effect) {
        self.effect = *effect;
        self.age_s = 0.0;
    }

    pub(super) fn is_on(&self) -> bool {
        self.age_s < self.effect.lasts_s
    }

    /// Pressure, 0 to 1. The pressure of blood pulses with the heart. The pressures of blood and
    /// bile fall to 0 during the source's duration.
    fn pressure(&self) -> f32 {
        let left = 1.0 - self.age_s / self.effect.lasts_s;
        match self.effect.kind {
            Kind::Blood => {
                let phase = (self.age_s / BEAT_S).fract();
                left * (0.15 + 0.85 * (-(phase / 0.22).powi(2)).exp())
            }
            Kind::Bile => 0.5 * left,
            _ => 1.0,
        }
    }

    pub(super) fn step(
        &mut self,
        step_s: f32,
        skin: &Skin<'_>,
        up: Vec3,
        particles: &mut Vec<Particle>,
        stains: &mut Vec<Stain>,
        thrown: &mut u32,
    ) {
        self.age_s += step_s;
        let pressure = self.pressure() * self.effect.strength.min(2.0);
        let per_second = match self.effect.kind {
            Kind::Smoke => 48.0,
            Kind::Steam => 30.0,
            Kind::Sparks => 70.0,
            Kind::Blood => 46.0,
            Kind::Bile => 5.0,
            Kind::Char => 0.0,
        };
        self.due += per_second * pressure * step_s;
        while self.due >= 1.0 {
            self.due -= 1.0;
            *thrown = thrown.wrapping_add(1);
            throw(particles, self.particle(pressure, *thrown));
        }
        if matches!(self.effect.kind, Kind::Blood | Kind::Bile) {
            self.wet(step_s, pressure, skin, up, stains);
        }
    }

    fn particle(&self, pressure: f32, count: u32) -> Particle {
        let any = chance(count);
        let own = chance(count.wrapping_add(7919)).x * 0.5 + 0.5;
        let along = self.effect.along.normalize_or(Vec3::Y);
        let (speed, spread, size_m, lasts_s) = match self.effect.kind {
            Kind::Smoke => (0.07, 0.5, 0.0026, 3.2 + 1.6 * own),
            Kind::Steam => (0.10, 0.6, 0.0018, 0.5 + 0.5 * own),
            Kind::Sparks => (0.5 + 0.6 * own, 1.2, 0.000_12, 0.06 + 0.14 * own),
            Kind::Blood => (
                SPURT_M_S * pressure.sqrt(),
                0.16,
                0.000_5 + 0.000_6 * own,
                1.5,
            ),
            Kind::Bile | Kind::Char => (0.03, 0.4, 0.000_9, 1.5),
        };
        Particle {
            kind: self.effect.kind,
            at_m: self.effect.at_m + any * (0.5 * size_m),
            velocity_m_s: (along + any * spread) * speed,
            age_s: 0.0,
            lasts_s,
            size_m,
            own,
        }
    }

    /// Grows the pool at the source, and marks the skin down which the liquid runs. Both are slower
    /// at a low pressure.
    fn wet(
        &mut self,
        step_s: f32,
        pressure: f32,
        skin: &Skin<'_>,
        up: Vec3,
        stains: &mut Vec<Stain>,
    ) {
        let kind = self.effect.kind;
        if let Some(mouth) = self.mouth {
            stain::pool(stains, skin, mouth, kind, 0.0025 * pressure * step_s, 0.006);
        }
        self.run_s += step_s * pressure.max(0.1);
        if self.run_s < RUN_S {
            return;
        }
        self.run_s = 0.0;
        let Some(front) = self.front else { return };
        match skin.downhill(front, up) {
            Some(next) => {
                stain::run(stains, skin, next, kind);
                self.front = Some(next);
            }
            // The liquid gathers at the lowest place.
            None => stain::pool(stains, skin, front, kind, 0.0006 * pressure, 0.009),
        }
    }
}
