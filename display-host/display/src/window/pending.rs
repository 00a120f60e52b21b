//! Effects that wait for the next picture, and the time that passes in them until then. Old and
//! excess effects are dropped. Reports of leaks do not grow old, and are dropped only if nothing
//! else waits.

use std::collections::VecDeque;

use crate::effects::{Effect, TICK_S};

/// Largest number of pending effects. A minimised window takes none, so a further effect replaces
/// the oldest.
const PENDING_MAX: usize = 48;
/// Age above which an effect is dropped, s.
const STALE_S: f64 = 0.3;
/// Time that a state may be late or early, s.
const SLACK_S: f32 = 0.5;
/// Number of parts into which a long time between two pictures is split. A leak begins or changes
/// at the start of a part. After a window was hidden for 20 s, each leak is right to 1.25 s.
const TIMES: u32 = 16;
/// Time between two pictures up to which it is not split, s: all leaks begin at its start.
const SHORT_S: f32 = 0.1;

#[derive(Default)]
pub(super) struct Pending {
    waiting: VecDeque<Waiting>,
}

struct Waiting {
    /// Time of its arrival, s.
    since_s: f64,
    /// Tick of its event.
    tick: u64,
    effect: Effect,
}

/// Time that passes in the effects from the picture of tick `before` to that of `tick`, s. `wall_s`
/// is the real time between the pictures, and `speed` the largest speed of a replay. If more ticks
/// passed than that time allows, the replay has jumped. Then nothing flows: the result is 0.
pub(super) fn played_s(before: u64, tick: u64, wall_s: f32, speed: f32) -> f32 {
    let passed_s = tick.saturating_sub(before) as f32 * TICK_S;
    match passed_s > SLACK_S + 2.0 * speed * wall_s {
        true => 0.0,
        false => passed_s,
    }
}

/// A part of the time between two pictures: the effects that begin at its start, and its length, s.
pub(super) type Part = (Vec<Effect>, f32);

/// Parts of the `seconds` since the picture of tick `before`. Each leak begins in the part of its
/// tick; all else begins in the last part.
pub(super) fn parts(begun: &[(u64, Effect)], before: u64, seconds: f32) -> Vec<Part> {
    let count = if seconds > SHORT_S { TIMES } else { 1 };
    let each_s = seconds / count as f32;
    let part_of = |(tick, effect): &(u64, Effect)| {
        let at_s = tick.saturating_sub(before) as f32 * TICK_S;
        match effect.is_leak() && each_s > 0.0 {
            true => ((at_s / each_s) as u32).min(count - 1),
            false => count - 1,
        }
    };
    let mut parts: Vec<Part> = Vec::new();
    for number in 0..count {
        let own = begun.iter().filter(|it| part_of(it) == number);
        let own: Vec<Effect> = own.map(|(_, effect)| *effect).collect();
        match parts.last_mut().filter(|_| own.is_empty()) {
            Some((_, length_s)) => *length_s += each_s,
            None => parts.push((own, each_s)),
        }
    }
    parts
}

impl Pending {
    pub(super) fn push(&mut self, now_s: f64, tick: u64, effect: Effect) {
        if self.waiting.len() == PENDING_MAX {
            // An effect that is no leak is dropped first: without its report, a leak would never
            // flow, or never stop.
            let passing = self.waiting.iter().position(|it| !it.effect.is_leak());
            self.waiting.remove(passing.unwrap_or(0));
        }
        self.waiting.push_back(Waiting {
            since_s: now_s,
            tick,
            effect,
        });
    }

    /// Takes the effects for the next picture, with the ticks of their events.
    pub(super) fn take(&mut self, now_s: f64) -> Vec<(u64, Effect)> {
        let waiting = self.waiting.drain(..);
        let fresh = waiting.filter(|it| it.effect.is_leak() || now_s - it.since_s <= STALE_S);
        fresh.map(|it| (it.tick, it.effect)).collect()
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
            pending.push(10.0, 7, effect);
        }
        assert_eq!(pending.take(10.1).len(), PENDING_MAX);
        assert!(pending.take(10.1).is_empty());
        pending.push(11.0, 7, effect);
        pending.push(11.2, 7, effect);
        assert_eq!(pending.take(11.4).len(), 1);
        pending.push(12.0, 7, effect);
        pending.clear();
        assert!(pending.take(12.0).is_empty());
        // A leak waits for a slow picture, and many passing effects do not push it out.
        let leak = Effect {
            lasts_s: Effect::LEAK_S,
            ..effect
        };
        pending.push(13.0, 7, leak);
        for _ in 0..1000 {
            pending.push(13.0, 7, effect);
        }
        assert_eq!(pending.take(20.0), [(7, leak)]);
    }

    #[test]
    fn a_seek_plays_no_time_and_a_late_picture_plays_all() {
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-3, "{a} is not {b}");
        near(played_s(1000, 1033, 0.033, 1.0), 0.033);
        // A hidden window of a replay at double speed.
        near(played_s(1000, 21_000, 10.0, 2.0), 20.0);
        // Seeks forward and back.
        near(played_s(1000, 61_000, 0.033, 2.0), 0.0);
        near(played_s(61_000, 1000, 0.033, 2.0), 0.0);
    }

    #[test]
    fn a_leak_flows_from_its_own_tick_after_a_hidden_window() {
        let leak = |at: f32| Effect {
            kind: Kind::Blood,
            at_m: Vec3::splat(at),
            along: Vec3::ZERO,
            strength: 1.0,
            lasts_s: Effect::LEAK_S,
            flow: Default::default(),
        };
        let passing = Effect {
            lasts_s: 1.0,
            ..leak(3.0)
        };
        // Of 16 s since tick 1000: one leak after 4 s, one after 15.9 s, and a report from before.
        let begun = [
            (900, leak(0.0)),
            (5000, leak(1.0)),
            (16_900, leak(2.0)),
            (5000, passing),
        ];
        let parts = parts(&begun, 1000, 16.0);
        let began: Vec<_> = parts.iter().map(|it| it.0.clone()).collect();
        assert_eq!(began[0], [leak(0.0)]);
        assert_eq!(began[1], [leak(1.0)]);
        assert_eq!(began[2], [leak(2.0), passing]);
        let lengths: Vec<f32> = parts.iter().map(|it| it.1).collect();
        for (length, right) in lengths.iter().zip([4.0, 11.0, 1.0]) {
            assert!((length - right).abs() < 1e-3, "{lengths:?}");
        }
        assert_eq!(super::parts(&begun, 1000, 0.033).len(), 1);
        assert_eq!(super::parts(&begun, 1000, 0.0)[0].0.len(), 4);
    }
}
