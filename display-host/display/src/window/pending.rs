//! Effects that wait for the next picture. Old and excess effects are dropped. Reports of leaks do
//! not grow old, and are dropped only if nothing else waits.

use std::collections::VecDeque;

use crate::effects::Effect;

/// Largest number of pending effects. A minimised window takes none, so a further effect replaces
/// the oldest.
const PENDING_MAX: usize = 48;
/// Age above which an effect is dropped, s.
const STALE_S: f64 = 0.3;

#[derive(Default)]
pub(super) struct Pending {
    waiting: VecDeque<(f64, Effect)>,
}

impl Pending {
    pub(super) fn push(&mut self, now_s: f64, effect: Effect) {
        if self.waiting.len() == PENDING_MAX {
            // If the report of a leak were lost, the leak would never flow, or never stop.
            let passing = self.waiting.iter().position(|(_, it)| !it.is_leak());
            self.waiting.remove(passing.unwrap_or(0));
        }
        self.waiting.push_back((now_s, effect));
    }

    /// Takes the effects for the next picture.
    pub(super) fn take(&mut self, now_s: f64) -> Vec<Effect> {
        let waiting = self.waiting.drain(..);
        let fresh = waiting.filter(|(at_s, it)| it.is_leak() || now_s - at_s <= STALE_S);
        fresh.map(|(_, effect)| effect).collect()
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::effects::Kind;

    #[test]
    fn an_unseen_window_keeps_few_effects_and_no_old_ones() {
        let effect = Effect {
            kind: Kind::Blood,
            at_m: Vec3::ZERO,
            along: Vec3::ZERO,
            strength: 1.0,
            lasts_s: 1.0,
            flow: Default::default(),
        };
        let mut pending = Pending::default();
        for _ in 0..1000 {
            pending.push(10.0, effect);
        }
        assert_eq!(pending.take(10.1).len(), PENDING_MAX);
        assert!(pending.take(10.1).is_empty());
        pending.push(11.0, effect);
        pending.push(11.2, effect);
        assert_eq!(pending.take(11.4).len(), 1);
        pending.push(12.0, effect);
        pending.clear();
        assert!(pending.take(12.0).is_empty());
        // A leak waits for a slow picture, and many passing effects do not push it out.
        let leak = Effect {
            lasts_s: Effect::LEAK_S,
            ..effect
        };
        pending.push(13.0, leak);
        for _ in 0..1000 {
            pending.push(13.0, effect);
        }
        assert_eq!(pending.take(20.0), [leak]);
    }
}
