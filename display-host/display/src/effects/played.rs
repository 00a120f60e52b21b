//! Effects that events and the electrode cause, and their order in time between two pictures.

use std::time::Instant;

use glam::Vec3;
use shared_mem::message::{EventMsg, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::words::EventKind;

use super::Effect;
use crate::render::Renderer;

/// Interval at which the electrode is sampled between two pictures, s. It is also the longest time
/// step in which effects are played.
const LOOK_S: f32 = 1.0 / 30.0;
/// Longest time between two pictures that is played, s. Of a longer time only the end is played,
/// because no particle lives longer.
const STRETCH_MAX_S: f32 = 20.0;
/// Largest number of effects that are kept between two pictures.
const EFFECTS_MAX: usize = 4096;

/// Data of a scene that turn an event or a sample into effects: the kinds of its organs, and the
/// radii of its spheres, m.
#[derive(Debug)]
pub(crate) struct Causes {
    organ_kinds: Vec<Option<OrganKind>>,
    radii_m: Vec<f32>,
}

impl Causes {
    pub(crate) fn of(scene: &SceneFile) -> Self {
        let kinds = scene.organs().iter().map(|it| OrganKind::from_u32(it.kind));
        Self {
            organ_kinds: kinds.collect(),
            radii_m: scene.spheres().iter().map(|it| it.radius_m).collect(),
        }
    }

    /// Effect of an event.
    pub(crate) fn event(&self, event: &EventMsg) -> Option<Effect> {
        let kind = self.organ_kinds.get(event.organ as usize).copied();
        Effect::of_event(event, kind.flatten())
    }

    /// Effects of the electrode during `seconds`.
    pub(crate) fn electrode(
        &self,
        state: &StateFrame,
        tools: &ToolFrame,
        seconds: f32,
    ) -> Vec<Effect> {
        let touched = state.spheres().unwrap_or(&[]).iter().zip(&self.radii_m);
        let touched = touched
            .filter(|(sphere, _)| sphere.bits & SphereState::CONTACT != 0)
            .map(|(sphere, radius_m)| (Vec3::from(sphere.center_m), *radius_m));
        Effect::of_electrode(tools, touched, seconds)
    }
}

/// Collects the effects since the last picture, in a run without a window.
pub(crate) struct EffectCollector {
    causes: Causes,
    /// New effects, and the time of each since the last picture, s.
    began: Vec<(f32, Effect)>,
    /// Time of the last picture.
    since: Instant,
    /// Time from the last picture to the last sample of the electrode, s.
    looked_s: f32,
    cleared: bool,
}

/// Effects between two pictures.
pub(crate) struct Stretch {
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
            since: Instant::now(),
            looked_s: 0.0,
            cleared: false,
        }
    }

    fn now_s(&self) -> f32 {
        self.since.elapsed().as_secs_f32()
    }

    fn begin(&mut self, effect: Effect) {
        if self.began.len() < EFFECTS_MAX {
            self.began.push((self.now_s(), effect));
        }
    }

    pub(crate) fn event(&mut self, event: &EventMsg) {
        if event.is(EventKind::Reset) {
            self.clear();
        }
        if let Some(effect) = self.causes.event(event) {
            self.begin(effect);
        }
    }

    /// Samples the electrode if the last sample is at least [`LOOK_S`] old.
    pub(crate) fn look(&mut self, state: &StateFrame, tools: &ToolFrame) {
        let now_s = self.now_s();
        if now_s - self.looked_s >= LOOK_S {
            self.looked_s = now_s;
            for effect in self.causes.electrode(state, tools, LOOK_S) {
                self.begin(effect);
            }
        }
    }

    /// Drops all effects, because the organs were reset.
    pub(crate) fn clear(&mut self) {
        self.began.clear();
        self.cleared = true;
    }

    /// Takes the effects since the last picture.
    pub(crate) fn take(&mut self) -> Stretch {
        let seconds = self.now_s();
        (self.since, self.looked_s) = (Instant::now(), 0.0);
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
