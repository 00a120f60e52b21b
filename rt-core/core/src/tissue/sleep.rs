//! Sleep: an organ at rest is not simulated, so that only organs that move cost time.

use crate::capacity::MAX_ORGANS;

/// Speed below which an organ is at rest, m/s. Freezing an organ at this speed costs an error of
/// 0.06 mm. A higher threshold lets organs fall asleep earlier, with a larger error.
const STILL_M_S: f32 = 0.001;
/// Ticks at rest after which an organ falls asleep.
const DROWSY_TICKS: u16 = 50;

/// Number of ticks for which each organ has been at rest.
#[derive(Debug, Clone)]
pub(crate) struct Sleep {
    still_ticks: [u16; MAX_ORGANS],
}

impl Sleep {
    /// Every organ is awake.
    pub(crate) const AWAKE: Self = Self {
        still_ticks: [0; MAX_ORGANS],
    };

    /// True while the organ sleeps.
    pub(crate) fn is_asleep(&self, organ: usize) -> bool {
        self.still_ticks
            .get(organ)
            .is_some_and(|&ticks| ticks >= DROWSY_TICKS)
    }

    /// Wakes an organ. Resets its rest counter.
    pub(crate) fn wake(&mut self, organ: usize) {
        if let Some(ticks) = self.still_ticks.get_mut(organ) {
            *ticks = 0;
        }
    }

    /// Records the speed of an organ after a tick in which it was simulated, m/s: the low-passed
    /// speed of its fastest sphere (`Bodies::pace_m_s`). Returns true if the organ is now asleep.
    pub(crate) fn note_speed(&mut self, organ: usize, speed_m_s: f32) -> bool {
        if let Some(ticks) = self.still_ticks.get_mut(organ) {
            let still = speed_m_s < STILL_M_S;
            *ticks = if still { ticks.saturating_add(1) } else { 0 };
        }
        self.is_asleep(organ)
    }

    /// True if the organ moved in its last tick, or was just woken: it then wakes organs next to
    /// it.
    pub(crate) fn is_stirring(&self, organ: usize) -> bool {
        self.still_ticks.get(organ) == Some(&0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeps_after_standing_still_and_wakes_at_once() {
        let mut sleep = Sleep::AWAKE;
        for _ in 1..DROWSY_TICKS {
            sleep.note_speed(3, 0.0005);
        }
        assert!(!sleep.is_asleep(3));
        sleep.note_speed(3, 0.0005);
        assert!(sleep.is_asleep(3) && !sleep.is_stirring(3));
        assert!(!sleep.is_asleep(2) && sleep.is_stirring(2));
        sleep.wake(3);
        assert!(!sleep.is_asleep(3));
        sleep.note_speed(3, 0.002);
        assert!(sleep.is_stirring(3));
        assert!(!sleep.is_asleep(MAX_ORGANS), "there is none");
    }
}
