//! Sources. They emit particles, pour blood and bile on the skin, and rinse and suck.

use glam::Vec3;

use super::fluid::{Fluids, Gush, WATER_M3};
use super::particle::Particle;
use super::stain::Skin;
use super::{Effect, Kind, chance, throw};

/// Period of the heartbeat, s.
const BEAT_S: f32 = 0.86;
/// Pressure of an artery between the beats, as a share of its peak.
const RESTING: f32 = 0.15;
/// Width of a beat's bell of pressure, as a share of the period: the added pressure is `exp(−(phase
/// / BEAT)²)`.
const BEAT: f32 = 0.22;
/// Mean of an artery's pressure over a period, as a share of its peak. The area under the bell is
/// half of √π times its width; the pressure between the beats is added.
const MEAN: f32 = RESTING + (1.0 - RESTING) * 0.886_227 * BEAT;
/// Speed of blood that spurts at an artery's peak, m/s.
const SPURT_M_S: f32 = 0.42;
/// Share of an artery's blood that spurts while the pressure is above [`SPURTS`]. The rest runs
/// down.
const SPURTING: f32 = 0.45;
/// Pressure above which blood spurts, as a share of the peak.
const SPURTS: f32 = 0.4;
/// Volume of a drop that spurts, m³.
const SPURT_M3: f64 = 3e-9;

/// Largest flow of a source, ml/min: many times that of any vessel of the scenes.
const ML_MIN_MAX: f64 = 1000.0;

/// A running source.
#[derive(Debug, Clone)]
pub(super) struct Source {
    pub(super) effect: Effect,
    age_s: f32,
    /// Part of the next particle that is already due, from 0 to 1.
    due: f32,
    /// Volume of blood, bile or water that has become due and has not left yet, m³.
    due_m3: f64,
    /// Vertex of the skin at the source.
    mouth: Option<usize>,
}

impl Source {
    pub(super) fn new(effect: Effect, mouth: Option<usize>) -> Self {
        Self {
            effect,
            age_s: 0.0,
            due: 0.0,
            due_m3: 0.0,
            mouth,
        }
    }

    /// Replaces the effect by a new one, whose duration counts from now.
    pub(super) fn go_on(&mut self, effect: &Effect) {
        self.effect = *effect;
        self.age_s = 0.0;
    }

    /// True for a source that changes volumes of fluid.
    pub(super) fn is_fluid(&self) -> bool {
        use Kind::{Bile, Blood, Suction, Water};
        matches!(self.effect.kind, Blood | Bile | Water | Suction)
    }

    pub(super) fn is_on(&self) -> bool {
        self.age_s < self.effect.lasts_s
    }

    /// Present pressure of an artery, as a share of its peak.
    fn beat(&self) -> f32 {
        let phase = (self.age_s / BEAT_S).fract();
        RESTING + (1.0 - RESTING) * (-(phase / BEAT).powi(2)).exp()
    }

    /// Flow as a share of the mean flow. A leak flows until it is closed. A tube that empties
    /// itself flows less and less.
    fn share(&self) -> f32 {
        let left = match self.effect.is_leak() {
            true => 1.0,
            false => (1.0 - self.age_s / self.effect.lasts_s).max(0.0),
        };
        let pulse = if self.effect.flow.pulses {
            self.beat() / MEAN
        } else {
            1.0
        };
        left * pulse
    }

    pub(super) fn step(
        &mut self,
        step_s: f32,
        skin: &Skin<'_>,
        particles: &mut Vec<Particle>,
        fluids: &mut Fluids,
        thrown: &mut u32,
    ) {
        self.age_s += step_s;
        match self.effect.kind {
            Kind::Blood | Kind::Bile => return self.pour(step_s, skin, fluids, thrown),
            Kind::Water => return self.rinse(step_s, skin, fluids),
            Kind::Suction => return fluids.suck(self.effect.at_m, step_s, skin),
            Kind::Smoke | Kind::Steam | Kind::Sparks | Kind::Char => {}
        }
        let per_second = match self.effect.kind {
            Kind::Smoke => 48.0,
            Kind::Steam => 30.0,
            Kind::Sparks => 70.0,
            _ => 0.0,
        };
        self.due += per_second * self.effect.strength.min(2.0) * step_s;
        while self.due >= 1.0 {
            self.due -= 1.0;
            *thrown = thrown.wrapping_add(1);
            throw(particles, self.particle(*thrown));
        }
    }

    /// The mouth's present place and outward normal. A cut may hide the skin at the mouth. Then
    /// the mouth is at the nearest vertex whose skin is whole.
    fn mouth(&mut self, skin: &Skin<'_>) -> (Vec3, Vec3) {
        let is_hidden = |vertex: &usize| skin.place_at(*vertex).is_none();
        if let Some(vertex) = self.mouth.filter(is_hidden) {
            self.mouth = skin.nearest_whole(vertex);
        }
        let given = self.effect.along.normalize_or(Vec3::Y);
        match self.mouth {
            Some(vertex) => {
                let normal = skin.present_normal(vertex).normalize_or(given);
                (skin.place(vertex), normal)
            }
            None => (self.effect.at_m, given),
        }
    }

    /// Pours the blood or bile that flows in a step.
    fn pour(&mut self, step_s: f32, skin: &Skin<'_>, fluids: &mut Fluids, thrown: &mut u32) {
        // The flow is limited, because an absurd flow would need absurdly many parcels. If the flow
        // is NaN, nothing flows.
        let ml_min = f64::from(self.effect.flow.ml_min * self.effect.strength.min(2.0));
        let mean_m3_s = ml_min.clamp(0.0, ML_MIN_MAX) * 1e-6 / 60.0;
        self.due_m3 += mean_m3_s * f64::from(self.share() * step_s);
        let beat = self.beat();
        let spurts = self.effect.flow.pulses && beat > SPURTS;
        let parcel_m3 = match spurts {
            true => SPURT_M3.max(fluids.parcel_m3(mean_m3_s)),
            false => fluids.parcel_m3(mean_m3_s),
        };
        if !(self.due_m3 >= parcel_m3 && parcel_m3 > 0.0) {
            return;
        }
        let (at_m, normal) = self.mouth(skin);
        while self.due_m3 >= parcel_m3 {
            self.due_m3 -= parcel_m3;
            *thrown = thrown.wrapping_add(1);
            let along = normal + chance(*thrown) * 0.12;
            let speed = SPURT_M_S * beat.sqrt() * self.effect.strength.clamp(0.0, 1.0).sqrt();
            fluids.pour(
                &Gush {
                    kind: self.effect.kind,
                    at_m,
                    mouth: self.mouth,
                    volume_m3: parcel_m3,
                    spurts: (along * speed, if spurts { SPURTING } else { 0.0 }),
                    is_leak: self.effect.is_leak(),
                },
                skin,
            );
        }
    }

    /// Rinses with the water that flows in a step.
    fn rinse(&mut self, step_s: f32, skin: &Skin<'_>, fluids: &mut Fluids) {
        let ml_min = f64::from(self.effect.flow.ml_min).clamp(0.0, ML_MIN_MAX);
        self.due_m3 += ml_min * 1e-6 / 60.0 * f64::from(step_s);
        let jet = (
            self.effect.at_m,
            self.effect.along.normalize_or(Vec3::NEG_Y),
        );
        while self.due_m3 >= WATER_M3 {
            self.due_m3 -= WATER_M3;
            fluids.rinse(jet, WATER_M3, step_s, skin);
        }
    }

    fn particle(&self, count: u32) -> Particle {
        let any = chance(count);
        let own = chance(count.wrapping_add(7919)).x * 0.5 + 0.5;
        let along = self.effect.along.normalize_or(Vec3::Y);
        let (speed, spread, size_m, lasts_s) = match self.effect.kind {
            Kind::Smoke => (0.07, 0.5, 0.0026, 3.2 + 1.6 * own),
            Kind::Steam => (0.10, 0.6, 0.0018, 0.5 + 0.5 * own),
            Kind::Sparks => (0.5 + 0.6 * own, 1.2, 0.000_12, 0.06 + 0.14 * own),
            _ => (0.03, 0.4, 0.000_9, 1.5),
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
}
