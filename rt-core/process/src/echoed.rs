//! Times from motion to force of the last ticks, until the device echoes their forces.

/// Ticks kept. An echo comes some ticks later.
const KEPT: usize = 64;

/// The last ticks: arrival of the sample, and time from there to the force, ns.
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
    /// Notes a tick.
    pub(crate) fn note(&mut self, arrived_ns: u64, took_ns: u32) {
        if let Some(place) = self.ticks.get_mut(self.next) {
            *place = (arrived_ns, took_ns);
        }
        self.next = (self.next + 1) % KEPT;
    }

    /// Time of the tick whose sample arrived then, ns; 0 if it is no longer known.
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
