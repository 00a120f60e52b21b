//! Effects in addition to the tissue's motion: smoke, steam, sparks, blood, bile, water, char. The
//! input is a plain list of [`Effect`]s from any source; nothing returns to the controller.
//!
//! ```text
//! events, tools ─► Effect ─► sources ─► particles (billboards)
//!                    │          └─────► fluid (blood and bile on the skin, and in drops)
//!                    ├────────────────► stains (char, on the skin at rest: it moves with it)
//!                    ├────────────────► haze (spread smoke, which settles or is evacuated)
//!                    └────────────────► wear (residues on the instrument)
//! ```

mod cause;
pub mod fluid;
mod haze;
mod particle;
mod played;
mod source;
mod stain;
mod wear;

pub(crate) use played::{Causes, EffectCollector, Stretch, TICK_S};

use glam::Vec3;
use shared_mem::message::ToolFrame;

pub use self::cause::{Effect, Flow, Kind};
use self::fluid::Fluids;
use self::haze::{DRAUGHT_M_S, Haze, MOUTH_M};
pub use self::particle::{PARTICLES, Particle};
use self::source::Source;
pub use self::stain::{STAINS, Skin, Stain};
pub use self::wear::Wear;

/// Largest number of sources. A further source replaces the oldest.
const SOURCES: usize = 48;
/// Time step of the effects, s. It is fixed, so that the pictures do not depend on the frame rate.
const STEP_S: f32 = 1.0 / 120.0;
/// Coagulation stops bleeding within this distance, m.
const DRIED_M: f32 = 0.004;
/// Reports of one kind of leak, nearer to each other than this, belong to one leak, m. All events
/// of a leak have the same position.
const SAME_LEAK_M: f32 = 0.000_1;
/// Largest number of steps in one frame that move particles. In a longer frame only the last steps
/// move them.
const CATCH_UP: u32 = 30;
/// Number of steps of the effects for one step of blood and bile.
const FLUID_EVERY: u32 = 4;
/// Largest number of steps of blood and bile in one frame. In a longer frame their steps are
/// longer.
const FLUID_STEPS_MAX: u32 = 45;
/// Longest time that the effects advance in one frame, s. The rest of a longer frame is skipped.
const FLOWS_MAX_S: f32 = 20.0;

/// All running effects.
#[derive(Debug, Clone)]
pub struct Effects {
    sources: Vec<Source>,
    particles: Vec<Particle>,
    stains: Vec<Stain>,
    fluids: Fluids,
    haze: Haze,
    wear: Wear,
    /// Position of the trocar through which smoke is evacuated, world frame, m. `None` if its valve
    /// is closed.
    suction_m: Option<Vec3>,
    /// Unit vector against gravity.
    up: Vec3,
    /// Time that is too short for a step and is left for the next frame, s.
    left_s: f32,
    /// Steps of the effects since the last step of blood and bile.
    waited: u32,
    /// Count of emitted particles. It seeds their randomness, so the same effects give the same
    /// pictures.
    thrown: u32,
}

impl Effects {
    /// No effects yet; `up` points against gravity.
    #[must_use]
    pub fn new(up: Vec3) -> Self {
        let up = up.normalize_or(Vec3::Y);
        Self {
            sources: Vec::new(),
            particles: Vec::new(),
            stains: Vec::new(),
            fluids: Fluids::new(up),
            haze: Haze::default(),
            wear: Wear::default(),
            suction_m: None,
            up,
            left_s: 0.0,
            waited: 0,
            thrown: 0,
        }
    }

    /// Starts an effect. An effect without a finite position and direction is ignored. A new report
    /// of a leak replaces the earlier one, and a report of strength 0 stops the leak.
    pub fn begin(&mut self, effect: &Effect, skin: &Skin<'_>) {
        let sane = effect.at_m.is_finite() && effect.along.is_finite();
        let flows = effect.strength > 0.0 && effect.lasts_s > 0.0;
        if sane && effect.is_leak() {
            let is_same = |source: &Source| {
                let leaks = source.effect.is_leak() && source.effect.kind == effect.kind;
                leaks && source.effect.at_m.distance(effect.at_m) < SAME_LEAK_M
            };
            if flows && let Some(source) = self.sources.iter_mut().find(|it| is_same(it)) {
                source.effect.strength = effect.strength;
                return;
            }
            self.sources.retain(|it| !is_same(it));
        }
        if !(sane && flows) {
            return;
        }
        self.wear.begin(effect);
        if effect.kind == Kind::Char {
            if let Some(vertex) = skin.nearest(effect.at_m) {
                let current_s = effect.strength * effect.lasts_s;
                stain::char(&mut self.stains, skin, vertex, current_s);
            }
            return;
        }
        // Only coagulation steams, and coagulation stops bleeding.
        if effect.kind == Kind::Steam {
            self.dry(effect.at_m);
        }
        let wets = matches!(effect.kind, Kind::Blood | Kind::Bile);
        let vertex = wets.then(|| skin.nearest(effect.at_m)).flatten();
        let mut effect = *effect;
        if effect.along == Vec3::ZERO {
            effect.along = vertex.map_or(self.up, |v| skin.normal(v));
        }
        // A new effect of the same kind within 2 mm renews the source, as during a long current.
        // A leak renews none: the two ends of a cut tube are two sources.
        // There is one irrigator: it has one jet and one mouth.
        let is_irrigator = matches!(effect.kind, Kind::Water | Kind::Suction);
        let same = |s: &&mut Source| {
            s.effect.kind == effect.kind
                && !s.effect.is_leak()
                && !effect.is_leak()
                && (is_irrigator || s.effect.at_m.distance(effect.at_m) < 0.002)
        };
        if let Some(source) = self.sources.iter_mut().find(same) {
            source.go_on(&effect);
            return;
        }
        if self.sources.len() == SOURCES {
            self.sources.remove(0);
        }
        self.sources.push(Source::new(effect, vertex));
    }

    /// Advances the effects by `seconds`, of which at most `FLOWS_MAX_S` count. Blood and bile flow
    /// all this time. All else advances only in the last `CATCH_UP` steps.
    pub fn advance(&mut self, seconds: f32, skin: &Skin<'_>) {
        let seconds = if seconds.is_finite() { seconds } else { 0.0 };
        self.left_s += seconds.clamp(0.0, FLOWS_MAX_S);
        let steps = (self.left_s / STEP_S) as u32;
        self.left_s = (self.left_s - steps as f32 * STEP_S).max(0.0);
        // In a long time, each step of the fluid is longer.
        let stride = FLUID_EVERY * steps.div_ceil(FLUID_EVERY * FLUID_STEPS_MAX).max(1);
        self.fluids.begin_moment(skin);
        for step in 0..steps {
            let is_played = step + CATCH_UP >= steps;
            self.step(is_played, skin);
            self.waited += 1;
            if self.waited >= stride {
                self.fluids.step(self.waited as f32 * STEP_S, skin);
                self.waited = 0;
            }
        }
    }

    /// Makes one step of the effects. A step that is not played advances only the sources of blood
    /// and bile.
    fn step(&mut self, is_played: bool, skin: &Skin<'_>) {
        let Self {
            sources,
            particles,
            fluids,
            haze,
            wear,
            suction_m,
            up,
            thrown,
            ..
        } = self;
        for source in sources.iter_mut() {
            if is_played || source.is_fluid() {
                source.step(STEP_S, skin, particles, fluids, thrown);
            }
        }
        sources.retain(Source::is_on);
        if !is_played {
            return;
        }
        haze.step(STEP_S, suction_m.is_some());
        wear.step(STEP_S, sources, fluids);
        particles.retain_mut(|particle| {
            let draught_m_s = suction_m.map_or(Vec3::ZERO, |port_m| {
                (port_m - particle.at_m).normalize_or_zero() * DRAUGHT_M_S
            });
            particle.step(STEP_S, *up, draught_m_s);
            let has_left = suction_m.is_some_and(|port_m| port_m.distance(particle.at_m) < MOUTH_M);
            let is_alive = particle.is_alive();
            if !is_alive && !has_left {
                haze.take(particle);
            }
            is_alive && !has_left
        });
    }

    /// Evacuates smoke through a trocar at this position (world frame, m). `None` stops the
    /// evacuation.
    pub fn draw_off(&mut self, port_m: Option<Vec3>) {
        self.suction_m = port_m.filter(|it| it.is_finite());
    }

    /// True while smoke is evacuated.
    #[must_use]
    pub fn is_drawn_off(&self) -> bool {
        self.suction_m.is_some()
    }

    /// Attenuation of light by the spread smoke, 1/m.
    #[must_use]
    pub fn haze_per_m(&self) -> f32 {
        self.haze.per_m
    }

    /// Residues on the instrument in the hand.
    #[must_use]
    pub fn wear(&self) -> &Wear {
        &self.wear
    }

    /// Sets the instrument in the hand and its position, for the residues on it.
    pub fn hold(&mut self, tools: &ToolFrame) {
        self.wear.hold(tools);
    }

    /// The flying particles.
    #[must_use]
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// The stains on the skin.
    #[must_use]
    pub fn stains(&self) -> &[Stain] {
        &self.stains
    }

    /// Blood and bile outside of vessels.
    #[must_use]
    pub fn fluids(&self) -> &Fluids {
        &self.fluids
    }

    /// Prepares for a skin whose triangles have changed.
    pub(crate) fn skin_changed(&mut self) {
        self.fluids.skin_changed();
    }

    /// Stops bleeding near a place. A leak continues until the controller reports it closed.
    fn dry(&mut self, at_m: Vec3) {
        self.sources.retain(|s| {
            s.effect.kind != Kind::Blood
                || s.effect.is_leak()
                || s.effect.at_m.distance(at_m) > DRIED_M
        });
    }

    /// Removes all effects.
    pub fn clear(&mut self) {
        self.sources.clear();
        self.particles.clear();
        self.stains.clear();
        self.fluids = Fluids::new(self.up);
        self.haze = Haze::default();
        self.wear = Wear::default();
        (self.left_s, self.waited, self.thrown) = (0.0, 0, 0);
    }

    /// No effects, under the same gravity.
    pub(crate) fn none(&self) -> Self {
        Self::new(self.up)
    }
}

/// Adds a particle, replacing the oldest if there are too many.
fn throw(particles: &mut Vec<Particle>, particle: Particle) {
    if particles.len() == PARTICLES {
        particles.remove(0);
    }
    particles.push(particle);
}

/// Three pseudo-random numbers from −1 to 1. Equal counts give equal numbers.
pub(crate) fn chance(count: u32) -> Vec3 {
    let one = |k: u32| {
        let mut h = (count.wrapping_mul(3).wrapping_add(k)).wrapping_mul(0x9e37_79b9);
        h ^= h >> 15;
        h = h.wrapping_mul(0x2c1b_3c6d);
        h ^= h >> 12;
        h = h.wrapping_mul(0x297a_2d39);
        h ^= h >> 15;
        (h >> 8) as f32 / 8_388_608.0 - 1.0
    };
    Vec3::new(one(0), one(1), one(2))
}

#[cfg(test)]
mod tests;
