//! Results of one turn of a program that the station is compared with.

use figures::Distribution;

use crate::misses::Missed;

/// Results of a turn.
#[derive(Debug, Clone, Default)]
pub struct Turn {
    /// Wake-up latency: actual minus scheduled wake-up.
    pub wake_latency: Distribution,
    /// Working time of each tick; empty if the program does no work.
    pub burnt: Distribution,
    /// Periods missed; `None` for cyclictest.
    pub missed: Option<Missed>,
    /// True if the program got the realtime properties that it asked for. `None` for cyclictest,
    /// which fails without them.
    pub realtime: Option<bool>,
}

impl Turn {
    /// Counts of missed periods, all zero at first.
    pub(crate) fn missed_mut(&mut self) -> &mut Missed {
        self.missed.get_or_insert_default()
    }
}
