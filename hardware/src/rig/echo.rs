//! Measures the time from hand to force by the device's own clock. The time begins with the STATE
//! from which the host computes a force. It ends with the first STATE that names this force as the
//! one in effect.

use rt_core::port::Echo;
use rt_core::time::TimeNs;

use super::wire::{State, Status};

/// Largest number of forces whose echo is awaited. A line would need more than 64 ticks to exceed
/// it.
const SENT: usize = 64;
/// Longest time that counts, µs. A longer time means that the device's clock or its sequence
/// numbers have restarted.
const LONGEST_US: u32 = 1_000_000;

/// A force that was sent, and the sample from which it came.
#[derive(Debug, Clone, Copy)]
struct SentForce {
    sequence: u16,
    device_time_us: u32,
    sample_at_ns: TimeNs,
}

/// Forces that were sent and not yet confirmed, and the newest echo.
#[derive(Debug)]
pub(super) struct Echoes {
    sent: [Option<SentForce>; SENT],
    /// The sample of this poll: the device's clock and the arrival.
    fresh: Option<(u32, TimeNs)>,
    in_effect: Option<u16>,
    found: Option<Echo>,
}

impl Default for Echoes {
    fn default() -> Self {
        Self {
            sent: [None; SENT],
            fresh: None,
            in_effect: None,
            found: None,
        }
    }
}

impl Echoes {
    /// Begins a poll.
    pub(super) fn begin(&mut self) {
        self.fresh = None;
        self.found = None;
    }

    /// Takes a sample that the tick may use. The tick uses the last one of a poll.
    pub(super) fn use_sample(&mut self, state: &State, at_ns: TimeNs) {
        self.fresh = Some((state.device_time_us, at_ns));
    }

    /// Takes any sample, as the device reported it.
    pub(super) fn take(&mut self, state: &State) {
        if !state.status.contains(Status::FORCE_ON) {
            self.in_effect = None;
            return;
        }
        let sequence = state.applied_force;
        if self.in_effect.replace(sequence) == Some(sequence) {
            return;
        }
        let slot = self.sent.get(usize::from(sequence) % SENT).copied();
        let Some(sent) = slot.flatten().filter(|sent| sent.sequence == sequence) else {
            return;
        };
        let took_us = state.device_time_us.wrapping_sub(sent.device_time_us);
        if took_us < LONGEST_US {
            self.found = Some(Echo {
                sample_at_ns: sent.sample_at_ns,
                took_us,
            });
        }
    }

    /// Notes the force that is sent now. Only the first force after a sample counts as computed
    /// from that sample.
    pub(super) fn sent(&mut self, sequence: u16) {
        let fresh = self.fresh.take();
        if let Some(slot) = self.sent.get_mut(usize::from(sequence) % SENT) {
            *slot = fresh.map(|(device_time_us, sample_at_ns)| SentForce {
                sequence,
                device_time_us,
                sample_at_ns,
            });
        }
    }

    /// The newest echo of this poll.
    pub(super) const fn found(&self) -> Option<Echo> {
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(device_time_us: u32, applied: Option<u16>) -> State {
        State {
            status: applied.map_or(Status::default(), |_| Status::FORCE_ON),
            buttons: 0,
            applied_force: applied.unwrap_or(0),
            device_time_us,
            position_m: [0.0; 3],
            velocity_m_s: [0.0; 3],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            opening: None,
        }
    }

    /// A poll with one sample at this time of the device, and the force that answers it.
    fn tick(echoes: &mut Echoes, us: u32, applied: Option<u16>, sequence: u16) -> Option<Echo> {
        let state = state(us, applied);
        echoes.begin();
        echoes.take(&state);
        echoes.use_sample(&state, u64::from(us) * 1000 + 7);
        echoes.sent(sequence);
        echoes.found()
    }

    #[test]
    fn the_first_sample_with_a_force_ends_the_measurement_of_its_delay() {
        let mut echoes = Echoes::default();
        let start = u32::MAX - 500; // the device's clock wraps on the way
        assert_eq!(tick(&mut echoes, start, None, 1), None);
        assert_eq!(tick(&mut echoes, start.wrapping_add(1000), None, 2), None);
        let echo = tick(&mut echoes, start.wrapping_add(2000), Some(1), 3);
        let expected = Echo {
            sample_at_ns: u64::from(start) * 1000 + 7,
            took_us: 2000,
        };
        assert_eq!(echo, Some(expected));
        let same = tick(&mut echoes, start.wrapping_add(3000), Some(1), 4);
        assert_eq!(same, None, "reported once");
        let later = tick(&mut echoes, start.wrapping_add(4000), Some(3), 5);
        assert_eq!(
            later.map(|it| it.took_us),
            Some(2000),
            "the second was passed over"
        );
    }

    #[test]
    fn forces_without_a_new_sample_and_unknown_numbers_have_no_echo() {
        let mut echoes = Echoes::default();
        tick(&mut echoes, 0, None, 1);
        echoes.begin();
        echoes.sent(2); // no sample came
        assert_eq!(tick(&mut echoes, 2000, Some(2), 3), None);
        assert_eq!(tick(&mut echoes, 3000, Some(500), 4), None);
        // A device that dropped the force and takes the same one up again.
        assert_eq!(tick(&mut echoes, 4000, None, 5), None);
        let again = tick(&mut echoes, 5000, Some(3), 6);
        assert_eq!(again.map(|it| it.took_us), Some(3000));
        // A clock that began anew.
        assert_eq!(tick(&mut echoes, 100, Some(6), 7), None);
    }
}
