//! Effects for the next picture.

use super::Session;
use crate::effects::Effect;

impl Session {
    /// Effects since the last picture. Since then `seconds` have been played.
    pub(in crate::window) fn take_effects(&mut self, seconds: f32) -> Vec<Effect> {
        let mut effects = self.pending.take(self.start.elapsed().as_secs_f64());
        // While the controller is silent or paused, the electrode burns nothing, whatever the last
        // frame says.
        let works = self.is_live() && !self.ui.is_paused();
        if let Some((state, tools)) = self.moment().filter(|_| works) {
            effects.extend(self.causes.electrode(state, tools, seconds.min(0.2)));
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

    /// True if the next picture must clear all bleeding and stains.
    pub(in crate::window) fn take_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_reset)
    }
}
