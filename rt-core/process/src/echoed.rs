//! Motion-to-force times of the newest ticks. When the device echoes a force, the time of its tick
//! is looked up here.

/// Number of ticks with a fresh sample that are kept. The echo of a force arrives some ticks later.
const KEPT: usize = 64;

/// For each of the newest ticks: arrival of its sample, and time from this arrival until the force
/// was sent, ns.
pub(crate) struct Echoed {
    ticks: [(u64, u32); KEPT],
    next: usize,
}

impl Default for Echoed {
    fn default() -> Self {
        Self {
            ticks: [(0, 0); KEPT],
            next: 0,
        }
    }
}

impl Echoed {
    /// Notes that the force for the sample that arrived at `arrived_ns` was sent `took_ns` later.
    pub(crate) fn note(&mut self, arrived_ns: u64, took_ns: u32) {
        if let Some(place) = self.ticks.get_mut(self.next) {
            *place = (arrived_ns, took_ns);
        }
        self.next = (self.next + 1) % KEPT;
    }

    /// Motion-to-force time of the tick whose sample arrived at `arrived_ns`, ns; 0 if unknown.
    pub(crate) fn of(&self, arrived_ns: u64) -> u32 {
        let mut ticks = self.ticks.iter();
        ticks
            .find(|tick| tick.0 == arrived_ns && arrived_ns > 0)
            .map_or(0, |tick| tick.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_ticks_are_known_by_their_samples_arrival() {
        let mut echoed = Echoed::default();
        assert_eq!(echoed.of(0), 0);
        for tick in 1..=100 {
            echoed.note(1000 * tick, tick as u32);
        }
        assert_eq!((echoed.of(100_000), echoed.of(37_000)), (100, 37));
        assert_eq!(
            (echoed.of(36_000), echoed.of(5)),
            (0, 0),
            "long ago, and never"
        );
    }
}
