//! Time budget of each stage, and the work that a late tick drops.
//!
//! A tick must end before the next one starts. The force is sent in every tick, after stage
//! `force`. If a tick has too little time for its remaining stages, it drops optional work in this
//! order:
//!
//! 1. contact between organs, and of an organ with itself, before stage `contact`;
//! 2. far organs, before stage `solve`: awake organs that no tool is near and that no jaws hold;
//! 3. the frame for the display. After [`DROPPED_MAX`] dropped frames in a row, the next one is
//!    published even if the tick is late. Events and timing records are never dropped.
//!
//! The tick drops the work if the needed time is more than the time left until the deadline (the
//! start of the next period). For 1 and 2, the needed time is the time of all stages from the named
//! one to `force` in the slowest tick that admission measured. Without a measurement, it is the sum
//! of the stages' budgets. For 3, the needed time is the budget of stage `publish`. Each drop is
//! counted and noted in the tick's record.

use rt_core::sim::Stage;
use shared_mem::message::STAGES;

/// Share of the period for each stage, ‰: sample, tool, contact, solve, force, procedure, publish.
/// The remaining 140 ‰ are for late wake-ups. The shares come from measured ticks (`stage_ns` in a
/// run's `summary.json`): solving took two thirds of the time, reading and writing serial lines a
/// tenth.
pub const STAGE_PER_MILLE: [u64; STAGES] = [80, 20, 200, 400, 50, 30, 80];

const _: () = {
    let mut sum = 0;
    let mut i = 0;
    while i < STAGES {
        sum += STAGE_PER_MILLE[i];
        i += 1;
    }
    assert!(
        sum <= 900,
        "the budgets must leave a tenth of the period for late wake-ups"
    );
};

/// Largest number of frames that may be dropped in a row. At 1 kHz and a frame every fourth tick,
/// the display waits at most 100 ms.
pub const DROPPED_MAX: u32 = 25;

/// Budget of the stage with this number in a period, ns; 0 if there is no such stage.
#[must_use]
pub fn stage_ns(stage: usize, period_ns: u64) -> u64 {
    STAGE_PER_MILLE
        .get(stage)
        .map_or(0, |share| share * period_ns / 1000)
}

/// Time that the stages from `first` to `force` need together, both included, ns; 0 if `first`
/// comes after `force`. `needs_ns` holds the time that each stage needs.
pub(crate) fn until_force_ns(needs_ns: &[u64; STAGES], first: Stage) -> u64 {
    let upto_force = needs_ns.iter().take(Stage::Force as usize + 1);
    upto_force.skip(first as usize).sum()
}

/// Budgets of all stages in a period, ns.
pub(crate) fn all_ns(period_ns: u64) -> [u64; STAGES] {
    STAGE_PER_MILLE.map(|share| share * period_ns / 1000)
}

/// Decides whether the tick publishes a due frame. Counts the frames that were dropped in a row.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PublishGate {
    dropped: u32,
}

impl PublishGate {
    /// Returns true if there is time for the frame before `deadline_ns`, or if the last
    /// [`DROPPED_MAX`] frames were dropped.
    pub(crate) fn may_publish(&mut self, now_ns: u64, deadline_ns: u64, period_ns: u64) -> bool {
        let publish_ns = stage_ns(STAGES - 1, period_ns);
        let in_time = now_ns + publish_ns <= deadline_ns;
        if in_time || self.dropped >= DROPPED_MAX {
            self.dropped = 0;
            return true;
        }
        self.dropped += 1;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_needed_until_the_force_shrinks_from_stage_to_stage() {
        let needs = [1, 2, 4, 8, 16, 32, 64];
        assert_eq!(until_force_ns(&needs, Stage::Contact), 4 + 8 + 16);
        assert_eq!(until_force_ns(&needs, Stage::Solve), 8 + 16);
        assert_eq!(until_force_ns(&needs, Stage::Publish), 0);
        assert_eq!(all_ns(1_000_000)[3], 400_000);
    }

    #[test]
    fn a_late_tick_drops_its_frame_and_the_display_still_goes_on() {
        let mut gate = PublishGate::default();
        let period = 1_000_000;
        assert!(gate.may_publish(500_000, 1_000_000, period));
        assert!(!gate.may_publish(950_000, 1_000_000, period));
        assert!(gate.may_publish(900_000, 1_000_000, period));
        let always_late = (0..260).map(|_| gate.may_publish(1_200_000, 1_000_000, period));
        assert_eq!(always_late.filter(|&shown| shown).count(), 10);
    }
}
