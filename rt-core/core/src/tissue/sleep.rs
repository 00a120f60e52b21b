//! Sleep: an organ at rest is not simulated, so that only organs that move cost time.

use crate::capacity::MAX_ORGANS;

/// Speed below which an organ is at rest, m/s. Freezing an organ at this speed costs an error of
/// 0.06 mm. A higher threshold lets organs fall asleep earlier, with a larger error.
const REST_SPEED_M_S: f32 = 0.001;
/// Ticks at rest after which an organ falls asleep.
const SLEEP_AFTER_TICKS: u16 = 50;

/// Number of ticks for which each organ has been at rest.
#[derive(Debug, Clone)]
pub(crate) struct Sleep {
    rest_ticks: [u16; MAX_ORGANS],
}

impl Sleep {
    /// Every organ is awake.
    pub(crate) const AWAKE: Self = Self {
        rest_ticks: [0; MAX_ORGANS],
    };

    /// True while the organ sleeps.
    pub(crate) fn is_asleep(&self, organ: usize) -> bool {
        self.rest_ticks
            .get(organ)
            .is_some_and(|&ticks| ticks >= SLEEP_AFTER_TICKS)
    }

    /// Wakes an organ. Resets its rest counter.
    pub(crate) fn wake(&mut self, organ: usize) {
        if let Some(ticks) = self.rest_ticks.get_mut(organ) {
            *ticks = 0;
        }
    }

    /// Records the speed of an organ after a tick in which it was simulated, m/s: the net speed of
    /// its fastest sphere (`Bodies::net_speed_m_s`). Returns true if the organ is now asleep.
    pub(crate) fn record_speed(&mut self, organ: usize, speed_m_s: f32) -> bool {
        if let Some(ticks) = self.rest_ticks.get_mut(organ) {
            let is_at_rest = speed_m_s < REST_SPEED_M_S;
            *ticks = if is_at_rest {
                ticks.saturating_add(1)
            } else {
                0
            };
        }
        self.is_asleep(organ)
    }

    /// True if the organ moved in its last tick or was just woken. Such an organ wakes organs next
    /// to it.
    pub(crate) fn wakes_neighbours(&self, organ: usize) -> bool {
        self.rest_ticks.get(organ) == Some(&0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeps_after_rest_and_wakes_at_once() {
        let mut sleep = Sleep::AWAKE;
        for _ in 1..SLEEP_AFTER_TICKS {
            sleep.record_speed(3, 0.0005);
        }
        assert!(!sleep.is_asleep(3));
        sleep.record_speed(3, 0.0005);
        assert!(sleep.is_asleep(3) && !sleep.wakes_neighbours(3));
        assert!(!sleep.is_asleep(2) && sleep.wakes_neighbours(2));
        sleep.wake(3);
        assert!(!sleep.is_asleep(3));
        sleep.record_speed(3, 0.002);
        assert!(sleep.wakes_neighbours(3));
        assert!(!sleep.is_asleep(MAX_ORGANS), "there is none");
    }
}
