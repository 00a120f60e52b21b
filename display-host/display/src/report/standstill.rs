//! Standstills of the controller in a run, from the timing of its ticks.

use shared_mem::message::TickRecord;

/// Shortest standstill that counts, ns. After this time a device's own watchdog drops the force.
const LEAST_NS: u64 = 100_000_000;

/// Standstills of a run.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Standstills {
    last: Option<TickRecord>,
    count: u64,
    longest_ns: u64,
    sum_ns: u64,
}

impl Standstills {
    /// Takes the next record. If a tick made the controller miss periods, the next tick is
    /// scheduled later by these periods. A gap of lost records is no standstill.
    pub(super) fn take(&mut self, record: &TickRecord) {
        let Some(last) = self.last.replace(*record) else {
            return;
        };
        let stood_ns = record.scheduled_ns.saturating_sub(last.scheduled_ns);
        if record.tick == last.tick + 1 && last.missed > 0 && stood_ns >= LEAST_NS {
            self.count += 1;
            self.longest_ns = self.longest_ns.max(stood_ns);
            self.sum_ns += stood_ns;
        }
    }

    /// The standstills as one of the run's warnings, if there were any.
    pub(super) fn warning(&self) -> Option<String> {
        let seconds = |ns: u64| ns as f64 / 1e9;
        let longest_s = seconds(self.longest_ns);
        let times = match self.count {
            0 => return None,
            1 => format!("for {longest_s:.2} s"),
            n => format!(
                "{n} times, for {longest_s:.2} s at the longest and {:.2} s in all",
                seconds(self.sum_ns)
            ),
        };
        Some(format!(
            "the controller stood still {times}, without force: it was stopped (SIGSTOP, a debugger, \
             sleep), or others took its core"
        ))
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    /// Warning of a run whose ticks missed these periods of 1 ms.
    fn warning(missed: &[u32]) -> Option<String> {
        let mut found = Standstills::default();
        let mut scheduled_ns = 7_000_000;
        for (tick, &missed) in missed.iter().enumerate() {
            found.take(&TickRecord {
                tick: tick as u64,
                scheduled_ns,
                missed,
                ..TickRecord::zeroed()
            });
            scheduled_ns += (u64::from(missed) + 1) * 1_000_000;
        }
        found.warning()
    }

    #[test]
    fn a_standstill_is_reported_with_its_length() {
        assert_eq!(warning(&[0, 0, 20, 0, 0]), None);
        let once = warning(&[0, 0, 5012, 0, 0]).unwrap();
        assert!(once.contains("stood still for 5.01 s,"), "{once}");
        let more = warning(&[0, 519, 0, 0, 249, 0]).unwrap();
        let words = "2 times, for 0.52 s at the longest and 0.77 s in all";
        assert!(more.contains(words), "{more}");
    }

    #[test]
    fn lost_records_and_a_new_controller_are_no_standstill() {
        let mut found = Standstills::default();
        for (tick, scheduled_ns) in [(0, 0), (5000, 5_000_000_000), (0, 9_000_000_000)] {
            let missed = 1;
            found.take(&TickRecord {
                tick,
                scheduled_ns,
                missed,
                ..TickRecord::zeroed()
            });
        }
        assert_eq!(found.warning(), None);
    }
}
