//! A replay with random access: it keeps checkpoints and repeats the ticks from the nearest one.

use rt_core::sim::{Checkpoint, Sim};
use shared_mem::inputs::InputRecord;

use super::{Recorded, Replayed};

/// Largest number of checkpoints, of 3.6 MB each. In a session of one hour, at most about half a
/// minute of ticks lies between a moment and the checkpoint before it.
const KEPT_MAX: usize = 128;
/// Number of ticks between two checkpoints at first. It is doubled whenever there are too many
/// checkpoints.
const EVERY_FIRST: u64 = 500;
/// Longest time that counts between two ticks, ns. A damaged session may claim hundreds of years.
const STEP_MAX_NS: u64 = 1_000_000_000;

/// Time that has passed in a session.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SessionTime {
    newest_ns: Option<u64>,
    pub(super) passed_ns: u64,
}

impl SessionTime {
    /// Advances to a tick's time. Returns the time passed since the first tick, ns.
    pub(super) fn pass(&mut self, now_ns: u64) -> u64 {
        let before_ns = self.newest_ns.replace(now_ns).unwrap_or(now_ns);
        let step_ns = now_ns.saturating_sub(before_ns).min(STEP_MAX_NS);
        self.passed_ns = self.passed_ns.saturating_add(step_ns);
        self.passed_ns
    }
}

/// Time from the first tick to the last, as a show counts it, ns.
pub fn length_ns(ticks: impl IntoIterator<Item = InputRecord>) -> u64 {
    let mut time = SessionTime::default();
    for tick in ticks {
        time.pass(tick.now_ns);
    }
    time.passed_ns
}

/// A checkpoint.
struct Kept<T> {
    /// Number of ticks run before the checkpoint.
    ran: u64,
    time: SessionTime,
    state: T,
}

/// The checkpoints of a session. Their number is bounded for any length of the session.
struct Keeper<T> {
    kept: Vec<Kept<T>>,
    every: u64,
}

impl<T> Keeper<T> {
    fn new() -> Self {
        Self {
            kept: Vec::new(),
            every: EVERY_FIRST,
        }
    }

    /// Keeps a checkpoint if one is due.
    fn offer(&mut self, ran: u64, time: SessionTime, make: impl FnOnce() -> T) {
        let is_new = self.kept.last().is_none_or(|last| ran > last.ran);
        if !is_new || !ran.is_multiple_of(self.every) {
            return;
        }
        if self.kept.len() >= KEPT_MAX {
            self.every *= 2;
            let every = self.every;
            self.kept.retain(|it| it.ran.is_multiple_of(every));
            if !ran.is_multiple_of(every) {
                return;
            }
        }
        let state = make();
        self.kept.push(Kept { ran, time, state });
    }

    /// Last checkpoint before a moment. The first checkpoint is the start of the session.
    fn before(&self, at_ns: u64) -> Option<&Kept<T>> {
        let after = self.kept.partition_point(|it| it.time.passed_ns < at_ns);
        self.kept.get(after.saturating_sub(1))
    }
}

/// A simulation, its place in the session, and its checkpoints.
pub(super) struct Player<'a> {
    sim: Sim<'a>,
    keeper: Keeper<Box<Checkpoint>>,
    ran: u64,
    furthest: u64,
    time: SessionTime,
}

impl<'a> Player<'a> {
    /// A player at the start of the session.
    pub(super) fn new(sim: Sim<'a>) -> Self {
        Self {
            sim,
            keeper: Keeper::new(),
            ran: 0,
            furthest: 0,
            time: SessionTime::default(),
        }
    }

    /// Time that has passed in the session, ns.
    pub(super) fn passed_ns(&self) -> u64 {
        self.time.passed_ns
    }

    /// Runs a tick. `each` receives the tick, the time passed, and true if the tick was never run
    /// before.
    pub(super) fn tick(
        &mut self,
        record: &InputRecord,
        each: impl FnOnce(&Replayed<'_>, u64, bool),
    ) {
        let sim = &self.sim;
        self.keeper
            .offer(self.ran, self.time, || Box::new(sim.checkpoint()));
        let passed_ns = self.time.pass(record.now_ns);
        let is_new = self.ran >= self.furthest;
        self.ran += 1;
        self.furthest = self.furthest.max(self.ran);
        let mut each = Some(each);
        self.sim.tick(&mut Recorded {
            record,
            each: |replayed: &Replayed<'_>| {
                if let Some(each) = each.take() {
                    each(replayed, passed_ns, is_new);
                }
            },
        });
    }

    /// Goes to a state before a moment of the session. If the moment is ahead and no checkpoint
    /// lies between here and the moment, the state stays as it is. Otherwise the last checkpoint
    /// before the moment is restored, and the number of ticks before that checkpoint is returned.
    pub(super) fn go_before(&mut self, at_ns: u64) -> Option<u64> {
        let kept = self.keeper.before(at_ns)?;
        let is_ahead = self.time.passed_ns < at_ns || self.ran == 0;
        if is_ahead && kept.ran <= self.ran {
            return None;
        }
        self.sim.go_back(&kept.state);
        (self.ran, self.time) = (kept.ran, kept.time);
        Some(self.ran)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn time_goes_on_by_a_second_at_most_and_never_back() {
        let mut time = SessionTime::default();
        let at = [u64::MAX - 5, 7, 9, u64::MAX, 3, 4].map(|now_ns| time.pass(now_ns));
        let second = STEP_MAX_NS;
        assert_eq!(at, [0, 0, 2, second + 2, second + 2, second + 3]);
    }

    proptest! {
        /// Every moment has a checkpoint before it, at most two intervals of checkpoints away.
        #[test]
        fn every_moment_has_a_near_checkpoint_and_checkpoints_are_few(length in 1u64..4_000_000, share in 0.0f64..1.0) {
            let (mut keeper, mut time) = (Keeper::new(), SessionTime::default());
            for ran in (0..length).step_by(EVERY_FIRST as usize) {
                time.passed_ns = ran * 1_000_000;
                keeper.offer(ran, time, || ran);
                keeper.offer(ran, time, || panic!("the same twice"));
            }
            prop_assert!(keeper.kept.len() <= KEPT_MAX);
            let asked = (length as f64 * share) as u64;
            let kept = keeper.before(asked * 1_000_000).expect("the start is kept");
            prop_assert_eq!(kept.ran, kept.state);
            prop_assert!(kept.ran <= asked && asked - kept.ran <= 2 * keeper.every, "{} for {}", kept.ran, asked);
            prop_assert!(keeper.every <= EVERY_FIRST.max(4 * length / KEPT_MAX as u64));
        }
    }
}
