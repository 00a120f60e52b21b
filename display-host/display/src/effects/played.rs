//! Effects that events and the electrode cause, and their order in time between two pictures.

use assess::Rules;
use glam::Vec3;
use shared_mem::message::{EventMsg, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::words::EventKind;

use super::Effect;
use crate::render::Renderer;

/// Interval at which the electrode is sampled between two pictures, s. It is also the longest time
/// step in which effects are played.
const LOOK_S: f32 = 1.0 / 30.0;
/// Number of ticks in [`LOOK_S`], rounded down.
const LOOK_TICKS: u64 = 33;
/// Period of the tick, s. Effects follow the time that the ticks count, so that a replay of any
/// speed shows as much blood as the run did.
pub(crate) const TICK_S: f32 = 0.001;
/// Longest time between two pictures that is played, s. Of a longer time only the end is played. No
/// particle lives longer than that.
const STRETCH_MAX_S: f32 = 20.0;
/// Largest number of effects that are kept between two pictures.
const EFFECTS_MAX: usize = 4096;

/// Data from which an event or a sample of the electrode becomes effects: the kinds of a scene's
/// organs, the radii of its spheres (m), and the rules.
#[derive(Debug)]
pub(crate) struct Causes {
    organ_kinds: Vec<Option<OrganKind>>,
    radii_m: Vec<f32>,
    /// Unit vector against gravity.
    up: Vec3,
    /// Rules of the assessment. They give the flow of each kind of organ.
    rules: Rules,
}

impl Causes {
    pub(crate) fn of(scene: &SceneFile) -> Self {
        let kinds = scene.organs().iter().map(|it| OrganKind::from_u32(it.kind));
        Self {
            organ_kinds: kinds.collect(),
            radii_m: scene.spheres().iter().map(|it| it.radius_m).collect(),
            up: (-Vec3::from(scene.room().gravity_m_s2)).normalize_or(Vec3::Y),
            rules: Rules::default(),
        }
    }

    /// Effect of an event.
    pub(crate) fn event(&self, event: &EventMsg) -> Option<Effect> {
        let kind = self.organ_kinds.get(event.organ as usize).copied();
        Effect::of_event(event, kind.flatten(), &self.rules)
    }

    /// Effects of the instrument during `seconds`, and of boiling tissue.
    pub(crate) fn work(&self, state: &StateFrame, tools: &ToolFrame, seconds: f32) -> Vec<Effect> {
        let touched = state.spheres().unwrap_or(&[]).iter().zip(&self.radii_m);
        let touched = touched
            .filter(|(sphere, _)| sphere.bits & SphereState::CONTACT != 0)
            .map(|(sphere, radius_m)| (Vec3::from(sphere.center_m), *radius_m));
        let mut effects = Effect::of_electrode(tools, touched, seconds);
        effects.extend(Effect::of_irrigator(tools, seconds));
        let spheres = state.spheres().unwrap_or(&[]).iter();
        effects.extend(Effect::of_heat(
            spheres.zip(self.radii_m.iter().copied()),
            self.up,
        ));
        effects
    }
}

/// Collects the effects since the last picture, in a run without a window.
pub(crate) struct EffectCollector {
    causes: Causes,
    /// New effects, and the time of each since the last picture, s.
    began: Vec<(f32, Effect)>,
    /// Tick of the last picture; `None` before the first tick.
    since: Option<u64>,
    /// Tick of the last sample of the electrode.
    looked: u64,
    /// True if earlier effects were dropped since the last picture.
    cleared: bool,
}

/// Time between two pictures, and the effects that begin in it.
pub(crate) struct Stretch {
    /// Length of the stretch.
    seconds: f32,
    /// New effects, and the time of each since the start of the stretch, s.
    began: Vec<(f32, Effect)>,
    /// True if the organs were reset. All earlier effects are then gone.
    cleared: bool,
}

impl EffectCollector {
    pub(crate) fn new(scene: &SceneFile) -> Self {
        Self {
            causes: Causes::of(scene),
            began: Vec::new(),
            since: None,
            looked: 0,
            cleared: false,
        }
    }

    /// Time from the last picture to this tick, s.
    fn at_s(&mut self, tick: u64) -> f32 {
        let since = *self.since.get_or_insert(tick);
        tick.saturating_sub(since) as f32 * TICK_S
    }

    fn begin(&mut self, tick: u64, effect: Effect) {
        let at_s = self.at_s(tick);
        if self.began.len() < EFFECTS_MAX {
            self.began.push((at_s, effect));
        }
    }

    pub(crate) fn event(&mut self, event: &EventMsg) {
        if event.is(EventKind::Reset) {
            self.clear();
        }
        if let Some(effect) = self.causes.event(event) {
            self.begin(event.tick, effect);
        }
    }

    /// Samples the electrode if the last sample is at least [`LOOK_S`] old.
    pub(crate) fn look(&mut self, state: &StateFrame, tools: &ToolFrame) {
        if state.tick.saturating_sub(self.looked) >= LOOK_TICKS {
            self.looked = state.tick;
            for effect in self.causes.work(state, tools, LOOK_S) {
                self.begin(state.tick, effect);
            }
        }
    }

    /// Drops all effects, because the organs were reset or another controller counts its own ticks.
    pub(crate) fn clear(&mut self) {
        self.began.clear();
        (self.since, self.looked) = (None, 0);
        self.cleared = true;
    }

    /// Takes the effects from the last picture to the picture of this tick.
    pub(crate) fn take(&mut self, tick: u64) -> Stretch {
        let seconds = self.at_s(tick);
        self.since = Some(tick);
        Stretch {
            seconds,
            began: std::mem::take(&mut self.began),
            cleared: std::mem::take(&mut self.cleared),
        }
    }
}

impl Stretch {
    /// Plays the effects in time steps of at most [`LOOK_S`].
    pub(crate) fn play(&self, renderer: &mut Renderer, spheres: &[SphereState]) {
        if self.cleared {
            renderer.effects_mut().clear();
        }
        let from_s = (self.seconds - STRETCH_MAX_S).max(0.0);
        let steps = ((self.seconds - from_s) / LOOK_S).ceil().max(1.0) as u32;
        let step_s = (self.seconds - from_s) / steps as f32;
        let mut waiting = self.began.iter().peekable();
        for step in 1..=steps {
            let until_s = from_s + step as f32 * step_s;
            let mut due = Vec::new();
            while let Some((_, effect)) = waiting.next_if(|(at_s, _)| *at_s <= until_s) {
                due.push(*effect);
            }
            if step == steps {
                due.extend(waiting.by_ref().map(|(_, effect)| *effect));
            }
            renderer.play(spheres, &due, step_s);
        }
    }
}
