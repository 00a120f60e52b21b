//! What happens beside the tissue's motion: smoke, steam, sparks, blood, bile, char. Fed by a plain
//! list of [`Effect`]s, whoever makes it; nothing of it goes back to the controller.
//!
//! ```text
//! events, tools ─► Effect ─► sources ─► particles (billboards)
//!                    │          └─────► stains (on the skin at rest, so that they stick to it)
//!                    └────────────────► haze (smoke that has spread, until it is drawn off)
//! ```

mod haze;
mod particle;
mod played;
mod source;
mod stain;

pub(crate) use played::{Causes, Course, Stretch};

use glam::Vec3;
use shared_mem::message::{EventMsg, ToolFrame};
use shared_mem::scene::OrganKind;

use self::haze::{DRAUGHT_M_S, Haze, MOUTH_M};
pub use self::particle::{PARTICLES, Particle};
use self::source::Source;
pub use self::stain::{STAINS, Skin, Stain};

/// Sources at most; a new one takes the oldest one's place.
const SOURCES: usize = 48;
/// Step of the little physics, s: the same pictures at any frame rate.
const STEP_S: f32 = 1.0 / 120.0;
/// A current works where tissue is touched within this of its electrode's tip, m.
const TIP_M: f32 = 0.003;
/// Coagulation dries what bleeds within this, m.
const DRIED_M: f32 = 0.004;
/// A leak goes on until it is told that it has changed, s: longer than a session.
const LEAK_S: f32 = 36_000.0;
/// Leaks nearer than this to each other are the same, m: one leak is always told of at one place.
const SAME_LEAK_M: f32 = 0.000_1;
/// A frame that took longer than this is not made up for, s.
const CATCH_UP_S: f32 = 0.25;

/// What an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Burnt tissue: smoke that drifts and gathers.
    Smoke,
    /// Water boiled off: white, gone in a second.
    Steam,
    /// Sparks of a cutting current.
    Sparks,
    /// Blood under pressure: pulses, drips, runs down, pools.
    Blood,
    /// Bile from a hole: seeps, runs down, pools.
    Bile,
    /// The surface turns black.
    Char,
}

/// Something that begins. Lengths in m, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// What.
    pub kind: Kind,
    /// Where.
    pub at_m: Vec3,
    /// Which way it leaves; need not be of unit length. Zero: off the skin there, or up.
    pub along: Vec3,
    /// How much of it: 1 is a cystic artery cut through, or a hook's full current.
    pub strength: f32,
    /// How long its source lasts, s. Char is there at once: as wide as so long a current makes it.
    pub lasts_s: f32,
}

impl Effect {
    /// What an event of the controller shows, if anything, on an organ of this kind: ducts leak,
    /// fat and connective tissue neither leak nor bleed.
    #[must_use]
    pub fn of_event(event: &EventMsg, organ: Option<OrganKind>) -> Option<Self> {
        use OrganKind as Organ;
        let (kind, much) = match organ? {
            Organ::CysticDuct | Organ::BileDuct => (Kind::Bile, 1.0),
            Organ::CysticArtery | Organ::Vessel => (Kind::Blood, 1.0),
            Organ::Fat | Organ::ConnectiveTissue => return None,
            Organ::Gallbladder if matches!(event.kind, EventMsg::LEAK | EventMsg::PERFORATION) => {
                (Kind::Bile, 1.0)
            }
            // Only tubes and bands part: of the gallbladder it is its bed, which bleeds a little.
            _ => (Kind::Blood, 0.5),
        };
        let is_tube = matches!(
            organ?,
            Organ::CysticDuct | Organ::BileDuct | Organ::CysticArtery | Organ::Vessel
        );
        let (strength, lasts_s) = match event.kind {
            // What was in a tube; whether it goes on leaking is told apart.
            EventMsg::TEAR | EventMsg::CUT if is_tube => (0.5 * much, 1.5),
            EventMsg::TEAR => (0.5 * much, 6.0),
            EventMsg::CUT => (much, 10.0),
            EventMsg::PERFORATION => (0.5 * much, 1.5),
            EventMsg::LEAK => (event.value * much, LEAK_S),
            _ => return None,
        };
        Some(Self {
            kind,
            at_m: Vec3::from(event.at_m),
            along: Vec3::ZERO,
            strength,
            lasts_s,
        })
    }

    /// What an electrode that touches tissue does in a moment of `seconds`: cutting (switch 1)
    /// sparks and smokes a little, coagulating (2) smokes, steams and chars. `touched` are the spheres
    /// that some tool touches, centre and radius in m: a shaft that leans on tissue burns nothing.
    #[must_use]
    pub fn of_electrode(
        tools: &ToolFrame,
        mut touched: impl Iterator<Item = (Vec3, f32)>,
        seconds: f32,
    ) -> Vec<Self> {
        const HOOK: u32 = 1;
        let current = tools.switches & 3;
        // Both at once: the controller lets neither through.
        if tools.instrument != HOOK || !matches!(current, 1 | 2) {
            return Vec::new();
        }
        let Some(tip) = tools
            .capsules()
            .and_then(|c| c.iter().find(|c| c.role != 0))
        else {
            return Vec::new();
        };
        let at_m = Vec3::from(tip.b_m);
        if !touched.any(|(center, radius_m)| center.distance(at_m) < radius_m + TIP_M) {
            return Vec::new();
        }
        let along = (Vec3::from(tip.a_m) - at_m).normalize_or(Vec3::Y);
        let effect = |kind, strength| Self {
            kind,
            at_m,
            along,
            strength,
            // The others go on while the electrode is on: to the next picture and a little longer.
            lasts_s: if kind == Kind::Char {
                seconds
            } else {
                seconds + 0.05
            },
        };
        if current == 1 {
            vec![
                effect(Kind::Sparks, 1.0),
                effect(Kind::Smoke, 0.5),
                effect(Kind::Char, 0.4),
            ]
        } else {
            vec![
                effect(Kind::Smoke, 1.0),
                effect(Kind::Steam, 0.6),
                effect(Kind::Char, 1.0),
            ]
        }
    }
}

/// All that goes on.
#[derive(Debug, Clone)]
pub struct Effects {
    sources: Vec<Source>,
    particles: Vec<Particle>,
    stains: Vec<Stain>,
    haze: Haze,
    /// Where smoke is drawn off, while it is, world frame, m.
    suction_m: Option<Vec3>,
    /// Up, against gravity.
    up: Vec3,
    left_s: f32,
    /// Counts what was thrown: the same effects give the same pictures.
    thrown: u32,
}

impl Effects {
    /// Nothing yet; `up` is against gravity.
    #[must_use]
    pub fn new(up: Vec3) -> Self {
        Self {
            sources: Vec::new(),
            particles: Vec::new(),
            stains: Vec::new(),
            haze: Haze::default(),
            suction_m: None,
            up: up.normalize_or(Vec3::Y),
            left_s: 0.0,
            thrown: 0,
        }
    }

    /// Begins an effect. What is not finite, or no effect at all, is left out. A leak takes the place of
    /// what was told of it before; one without strength is stopped.
    pub fn begin(&mut self, effect: &Effect, skin: &Skin<'_>) {
        let sane = effect.at_m.is_finite() && effect.along.is_finite();
        if sane && effect.lasts_s >= LEAK_S {
            self.sources.retain(|source| {
                let leaks = source.effect.lasts_s >= LEAK_S && source.effect.kind == effect.kind;
                !(leaks && source.effect.at_m.distance(effect.at_m) < SAME_LEAK_M)
            });
        }
        let flows = effect.strength > 0.0 && effect.lasts_s > 0.0;
        if !(sane && flows) {
            return;
        }
        if effect.kind == Kind::Char {
            if let Some(vertex) = skin.nearest(effect.at_m) {
                let current_s = effect.strength * effect.lasts_s;
                stain::char(&mut self.stains, skin, vertex, current_s);
            }
            return;
        }
        // Only coagulation steams.
        if effect.kind == Kind::Steam {
            self.dry(effect.at_m);
        }
        let wets = matches!(effect.kind, Kind::Blood | Kind::Bile);
        let vertex = wets.then(|| skin.nearest(effect.at_m)).flatten();
        let mut effect = *effect;
        if effect.along == Vec3::ZERO {
            effect.along = vertex.map_or(self.up, |v| skin.normal(v));
        }
        // A current is one source, however often it is told of; two ends of a tube are two.
        let same = |s: &&mut Source| {
            s.effect.kind == effect.kind
                && s.effect.lasts_s < LEAK_S
                && effect.lasts_s < LEAK_S
                && s.effect.at_m.distance(effect.at_m) < 0.002
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

    /// Goes on by `seconds`.
    pub fn advance(&mut self, seconds: f32, skin: &Skin<'_>) {
        self.left_s = (self.left_s + seconds.max(0.0)).min(CATCH_UP_S);
        while self.left_s >= STEP_S {
            self.left_s -= STEP_S;
            self.step(skin);
        }
    }

    fn step(&mut self, skin: &Skin<'_>) {
        let Self {
            sources,
            particles,
            stains,
            haze,
            suction_m,
            up,
            thrown,
            ..
        } = self;
        for source in sources.iter_mut() {
            source.step(STEP_S, skin, *up, particles, stains, thrown);
        }
        sources.retain(Source::is_on);
        haze.step(STEP_S, suction_m.is_some());
        particles.retain_mut(|particle| {
            let draught_m_s = suction_m.map_or(Vec3::ZERO, |port_m| {
                (port_m - particle.at_m).normalize_or_zero() * DRAUGHT_M_S
            });
            let hit = particle.step(STEP_S, *up, draught_m_s, skin);
            if let Some((vertex, kind)) = hit {
                stain::splash(stains, skin, vertex, kind);
            }
            let has_left = suction_m.is_some_and(|port_m| port_m.distance(particle.at_m) < MOUTH_M);
            let is_alive = particle.is_alive();
            if !is_alive && !has_left {
                haze.take(particle);
            }
            hit.is_none() && is_alive && !has_left
        });
    }

    /// Draws smoke off through a trocar there (world frame, m), or no longer.
    pub fn draw_off(&mut self, port_m: Option<Vec3>) {
        self.suction_m = port_m.filter(|it| it.is_finite());
    }

    /// Whether smoke is being drawn off.
    #[must_use]
    pub fn is_drawn_off(&self) -> bool {
        self.suction_m.is_some()
    }

    /// How much light the smoke that has spread takes from a beam, 1/m.
    #[must_use]
    pub fn haze_per_m(&self) -> f32 {
        self.haze.per_m
    }

    /// What flies.
    #[must_use]
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// What lies on the skin.
    #[must_use]
    pub fn stains(&self) -> &[Stain] {
        &self.stains
    }

    /// Stops what oozes near a place; what leaks goes on until the controller says that it is closed.
    fn dry(&mut self, at_m: Vec3) {
        self.sources.retain(|s| {
            s.effect.kind != Kind::Blood
                || s.effect.lasts_s >= LEAK_S
                || s.effect.at_m.distance(at_m) > DRIED_M
        });
    }

    /// Everything as it was before.
    pub fn clear(&mut self) {
        self.sources.clear();
        self.particles.clear();
        self.stains.clear();
        self.haze = Haze::default();
    }
}

/// Adds a particle, in the place of the oldest if there are too many.
fn throw(particles: &mut Vec<Particle>, particle: Particle) {
    if particles.len() == PARTICLES {
        particles.remove(0);
    }
    particles.push(particle);
}

/// Three numbers from −1 to 1 that follow from a count.
fn chance(count: u32) -> Vec3 {
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
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::skinning::SkinMesh;

    fn effect(kind: Kind) -> Effect {
        Effect {
            kind,
            at_m: Vec3::new(0.0, 0.1, 0.0),
            along: Vec3::Y,
            strength: 1.0,
            lasts_s: 1.0,
        }
    }

    fn run(kind: Kind, frame_s: f32, seconds: f32) -> Effects {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let mut effects = Effects::new(Vec3::Y);
        effects.begin(&effect(kind), &skin);
        for _ in 0..(seconds / frame_s).round() as u32 {
            effects.advance(frame_s, &skin);
        }
        effects
    }

    #[test]
    fn smoke_gathers_and_goes_only_when_it_is_drawn_off() {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let burnt = run(Kind::Smoke, 0.05, 8.0);
        let gathered = burnt.haze_per_m();
        assert!(gathered > 0.1, "{gathered}");
        assert!(run(Kind::Steam, 0.05, 8.0).haze_per_m() <= 0.0);
        let after = |suction: Option<Vec3>, seconds: u32| {
            let mut effects = burnt.clone();
            effects.draw_off(suction);
            for _ in 0..seconds * 20 {
                effects.advance(0.05, &skin);
            }
            effects.haze_per_m()
        };
        let port = Some(Vec3::new(0.0, 0.3, 0.0));
        assert!(after(None, 10) > 0.7 * gathered);
        assert!(after(port, 10) < 0.1 * gathered);
        assert!(after(Some(Vec3::NAN), 10) > 0.7 * gathered, "no place");
    }

    #[test]
    fn puffs_leave_through_the_trocar_that_draws_them_off() {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let height = |suction: Option<Vec3>| {
            let mut effects = run(Kind::Smoke, 0.05, 1.0);
            effects.draw_off(suction);
            for _ in 0..30 {
                effects.advance(0.05, &skin);
            }
            let puffs = effects.particles();
            puffs.iter().map(|p| p.at_m.y).sum::<f32>() / puffs.len() as f32
        };
        let below = Some(Vec3::new(0.0, -0.2, 0.0));
        assert!(height(below) < height(None) - 0.03);
        let mut beside = run(Kind::Smoke, 0.05, 1.0);
        let mouth = beside.particles()[0].at_m;
        beside.draw_off(Some(mouth));
        let before = beside.particles().len();
        beside.advance(0.05, &skin);
        assert!(beside.particles().len() < before && beside.haze_per_m() <= 0.0);
    }

    #[test]
    fn smoke_rises_and_blood_falls_and_both_end() {
        let height = |kind| {
            let effects = run(kind, 0.02, 0.5);
            assert!(effects.particles().len() > 3, "{kind:?}");
            let sum: f32 = effects.particles().iter().map(|p| p.at_m.y).sum();
            sum / effects.particles().len() as f32
        };
        assert!(height(Kind::Smoke) > 0.105 && height(Kind::Blood) < 0.1);
        for kind in [
            Kind::Smoke,
            Kind::Steam,
            Kind::Sparks,
            Kind::Blood,
            Kind::Bile,
        ] {
            assert!(run(kind, 0.05, 30.0).particles().is_empty(), "{kind:?}");
        }
    }

    #[test]
    fn the_frame_rate_does_not_matter() {
        let [slow, fast] = [0.05, 0.008_333_334].map(|frame| run(Kind::Smoke, frame, 1.0));
        assert!(slow.particles().len().abs_diff(fast.particles().len()) <= 1);
        let (a, b) = (slow.particles()[2], fast.particles()[2]);
        assert!(a.at_m.distance(b.at_m) < 2e-3, "{a:?} {b:?}");
    }

    #[test]
    fn a_cut_vessel_bleeds_in_pulses_until_coagulation_dries_it() {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let mut effects = Effects::new(Vec3::Y);
        effects.begin(
            &Effect {
                lasts_s: 20.0,
                ..effect(Kind::Blood)
            },
            &skin,
        );
        let mut thrown = Vec::new();
        let mut before = 0;
        for _ in 0..60 {
            effects.advance(0.05, &skin);
            thrown.push(effects.thrown - before);
            before = effects.thrown;
        }
        let (most, least) = (thrown.iter().max(), thrown.iter().min());
        assert!(most > least.map(|l| l + 1).as_ref(), "{thrown:?}");
        effects.begin(&effect(Kind::Bile), &skin);
        effects.begin(
            &Effect {
                at_m: Vec3::new(0.0, 0.101, 0.0),
                ..effect(Kind::Steam)
            },
            &skin,
        );
        let kinds: Vec<Kind> = effects.sources.iter().map(|s| s.effect.kind).collect();
        assert_eq!(kinds, [Kind::Bile, Kind::Steam]);
    }

    #[test]
    fn a_leak_goes_on_until_it_is_told_to_be_closed() {
        let mesh = SkinMesh::default();
        let skin = Skin::new(&mesh, &[], &[], &[]);
        let mut effects = Effects::new(Vec3::Y);
        let leak = |value, x| {
            let event = EventMsg {
                kind: EventMsg::LEAK,
                at_m: [x, 0.0, 0.0],
                value,
                ..bytemuck::Zeroable::zeroed()
            };
            Effect::of_event(&event, Some(OrganKind::CysticDuct)).expect("bile")
        };
        for (value, x) in [(1.0, 0.0), (0.5, 0.0), (1.0, 0.001)] {
            effects.begin(&leak(value, x), &skin);
        }
        for _ in 0..600 {
            effects.advance(0.1, &skin);
        }
        let strengths: Vec<f32> = effects.sources.iter().map(|s| s.effect.strength).collect();
        assert_eq!(strengths, [0.5, 1.0], "a minute later");
        effects.begin(&leak(0.0, 0.0), &skin);
        assert_eq!(effects.sources.len(), 1);
    }

    #[test]
    fn events_and_currents_show_what_they_do() {
        let event = |kind| EventMsg {
            kind,
            ..bytemuck::Zeroable::zeroed()
        };
        let shown = |kind, organ| Effect::of_event(&event(kind), organ).map(|e| e.kind);
        use OrganKind as Organ;
        for (organ, kind) in [
            (Organ::CysticArtery, Some(Kind::Blood)),
            (Organ::Liver, Some(Kind::Blood)),
            (Organ::CysticDuct, Some(Kind::Bile)),
            (Organ::Fat, None),
        ] {
            assert_eq!(shown(EventMsg::CUT, Some(organ)), kind, "{organ:?}");
            assert_eq!(shown(EventMsg::CONTACT, Some(organ)), None);
        }
        assert_eq!(shown(EventMsg::CUT, None), None);
        for (organ, kind) in [
            (Organ::CysticArtery, Kind::Blood),
            (Organ::CysticDuct, Kind::Bile),
            (Organ::Gallbladder, Kind::Bile),
        ] {
            assert_eq!(shown(EventMsg::LEAK, Some(organ)), Some(kind));
        }
        let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
        tools.world_from_handle.orientation[3] = 1.0;
        tools.world_from_instrument = tools.world_from_handle;
        tools.world_from_camera = tools.world_from_handle;
        (tools.instrument, tools.contact_count, tools.capsule_count) = (1, 1, 1);
        tools.capsules[0].role = 3;
        let mut kinds = |switches, far_m| {
            tools.switches = switches;
            let touched = [(Vec3::new(far_m, 0.0, 0.0), 0.004)];
            Effect::of_electrode(&tools, touched.into_iter(), 0.1)
                .iter()
                .map(|e| e.kind)
                .collect::<Vec<_>>()
        };
        assert!(kinds(1, 0.005).contains(&Kind::Sparks) && kinds(2, 0.005).contains(&Kind::Steam));
        assert!(kinds(0, 0.005).is_empty() && kinds(3, 0.005).is_empty());
        // Only its shaft touches.
        assert!(kinds(1, 0.02).is_empty());
    }

    #[test]
    fn on_skin_char_is_of_the_current_s_time_and_blood_leaves_it_at_right_angles() {
        use bytemuck::Zeroable;
        use shared_mem::message::SphereState;
        use shared_mem::scene::SphereRecord;
        let mesh = SkinMesh {
            vertices: vec![crate::skinning::RestVertex {
                normal: [1.0, 0.0, 0.0],
                ..Zeroable::zeroed()
            }],
            skinned: 1,
            ..SkinMesh::default()
        };
        let (rest, now) = ([SphereRecord::zeroed()], [SphereState::zeroed()]);
        let skin = Skin::new(&mesh, &rest, &now, &[]);
        let burnt = |frames: u32, seconds: f32| {
            let mut effects = Effects::new(Vec3::Y);
            for _ in 0..frames {
                let moment = Effect {
                    at_m: Vec3::ZERO,
                    lasts_s: seconds / frames as f32,
                    ..effect(Kind::Char)
                };
                effects.begin(&moment, &skin);
            }
            effects.stains()[0].radius_m
        };
        assert!((burnt(10, 0.5) - burnt(60, 0.5)).abs() < 1e-6);
        assert!((burnt(10, 0.5) - burnt(10, 0.25) - 0.25 * 0.003).abs() < 1e-6);
        let mut effects = Effects::new(Vec3::Y);
        let bleeds = Effect {
            at_m: Vec3::ZERO,
            along: Vec3::ZERO,
            ..effect(Kind::Blood)
        };
        effects.begin(&bleeds, &skin);
        assert_eq!(effects.sources[0].effect.along, Vec3::X);
    }

    proptest! {
        #[test]
        fn nothing_breaks_it(
            at in any::<[f32; 3]>(), along in any::<[f32; 3]>(), strength in any::<f32>(),
            lasts_s in any::<f32>(), seconds in any::<f32>(), times in 0u32..80,
        ) {
            let mesh = SkinMesh::default();
            let skin = Skin::new(&mesh, &[], &[], &[]);
            let mut effects = Effects::new(Vec3::ZERO);
            for kind in [Kind::Smoke, Kind::Blood, Kind::Sparks, Kind::Char] {
                let effect = Effect {
                    kind, at_m: at.into(), along: along.into(), strength, lasts_s,
                };
                effects.begin(&effect, &skin);
            }
            for _ in 0..times {
                effects.advance(seconds, &skin);
            }
            prop_assert!(effects.particles().len() <= PARTICLES);
            prop_assert!(effects.stains().len() <= STAINS);
            prop_assert!(effects.particles().iter().all(|p| p.at_m.is_finite()));
        }
    }
}
