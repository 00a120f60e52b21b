//! Measures, by the device's own clock, how long a force stays in effect after its last command.
//! Every sample counts, even one that the host reads late.

use super::wire::{State, Status};

/// Drops of the force by the device's watchdog.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WatchdogDrops {
    /// Number of drops so far. A drop counts only if a sample showed the force in effect before.
    pub count: u32,
    /// Duration of the last dropped force, µs: from the first sample with the force in effect to
    /// the first sample that reports the drop.
    pub held_us: u32,
}

/// The force in effect, and the drops.
#[derive(Debug, Default)]
pub(super) struct Watchdog {
    /// Number of the force in effect, and the device's time of the first sample with it, µs.
    in_effect: Option<(u16, u32)>,
    drops: WatchdogDrops,
}

impl Watchdog {
    pub(super) fn take(&mut self, state: &State) {
        let now_us = state.device_time_us;
        if state.status.contains(Status::FORCE_ON) {
            let number = state.applied_force;
            if self.in_effect.is_none_or(|(known, _)| known != number) {
                self.in_effect = Some((number, now_us));
            }
            return;
        }
        let Some((_, since_us)) = self.in_effect.take() else {
            return;
        };
        if state.status.contains(Status::WATCHDOG) {
            self.drops = WatchdogDrops {
                count: self.drops.count.wrapping_add(1),
                held_us: now_us.wrapping_sub(since_us),
            };
        }
    }

    pub(super) const fn drops(&self) -> WatchdogDrops {
        self.drops
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(ms: u32, status: Status, applied_force: u16) -> State {
        State {
            status,
            buttons: 0,
            applied_force,
            device_time_us: ms * 1000,
            position_m: [0.0; 3],
            velocity_m_s: [0.0; 3],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            opening: None,
        }
    }

    #[test]
    fn samples_after_the_drop_do_not_lengthen_the_measured_time() {
        let mut watchdog = Watchdog::default();
        for ms in 0..123 {
            let now = match ms {
                0..10 => state(ms, Status::FORCE_ON, 7),
                10..60 => state(ms, Status::FORCE_ON, 8),
                _ => state(ms, Status::WATCHDOG, 0),
            };
            watchdog.take(&now);
        }
        let WatchdogDrops { count, held_us } = watchdog.drops();
        assert_eq!((count, held_us), (1, 50_000));
    }

    #[test]
    fn a_force_that_ends_for_another_reason_is_no_drop() {
        let mut watchdog = Watchdog::default();
        watchdog.take(&state(0, Status::FORCE_ON, 7));
        watchdog.take(&state(1, Status::FAULT, 0));
        watchdog.take(&state(2, Status::WATCHDOG, 0));
        assert_eq!(watchdog.drops(), WatchdogDrops::default());
    }
}
