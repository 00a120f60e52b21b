//! Effects for the next picture.

use super::Session;
use crate::effects::Effect;

/// Largest speed that the panel of a replay offers.
const OBSERVED_SPEED: f32 = 2.0;

impl Session {
    /// Effects since the last picture, with their ticks. Since then `seconds` have been played.
    pub(in crate::window) fn take_effects(&mut self, seconds: f32) -> Vec<(u64, Effect)> {
        // During a seek, the reports of the target's leaks arrive. They stay pending until the seek
        // is over.
        if self.is_seeking() {
            return Vec::new();
        }
        let mut effects = self.pending.take(self.start.elapsed().as_secs_f64());
        // While the controller is silent or paused, the electrode burns nothing, whatever the last
        // frame says.
        let works = self.is_live() && !self.ui.is_paused();
        if let Some((state, tools)) = self.moment().filter(|_| works) {
            let burnt = self.causes.work(state, tools, seconds.min(0.2));
            effects.extend(burnt.into_iter().map(|it| (state.tick, it)));
        }
        effects
    }

    /// Makes the next picture clear all bleeding and stains: after a reset, a start, a seek or a
    /// restart of the controller.
    pub(super) fn forget_effects(&mut self) {
        self.pending.clear();
        self.newest_clip = None;
        self.was_reset = true;
    }

    /// True while a replay runs to another moment.
    fn is_seeking(&self) -> bool {
        (self.ui.replay).is_some_and(|view| view.seeks_s.is_some())
    }

    /// True if the next picture must clear all bleeding and stains. Each picture during a seek
    /// must, and so must the first after it.
    pub(in crate::window) fn take_reset(&mut self) -> bool {
        match self.is_seeking() {
            true => {
                self.was_reset = true;
                true
            }
            false => std::mem::take(&mut self.was_reset),
        }
    }

    /// Largest speed at which the shown ticks pass. An observer's display does not know a replay's
    /// speed, so it assumes the largest.
    pub(in crate::window) fn most_speed(&self) -> f32 {
        (self.ui.replay).map_or(OBSERVED_SPEED, |view| view.speed as f32)
    }
}
