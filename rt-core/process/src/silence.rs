//! Detects a haptic device that is open but sends no valid sample. This works with every driver.

use rt_core::fault::Fault;
use rt_core::port::{DeviceSample, Findings, Polled};
use rt_core::time::TimeNs;

/// Time without a sample after which a device counts as silent, ns. A busy computer delays an
/// emulated device by less. A person still gets the message within a second.
const SILENT_NS: u64 = 400_000_000;
/// Longest time between two polls that counts in full as silence, ns. Of a longer gap only this
/// much counts, because this process stood still and could not have read a sample.
const POLL_NS: u64 = 2_000_000;

/// Measures the time for which the tick has polled without a sample.
#[derive(Debug, Default)]
pub(crate) struct Silence {
    polled_ns: TimeNs,
    silent_ns: u64,
}

impl Silence {
    /// Notes the result of a poll.
    pub(crate) fn note(&mut self, polled: &Polled<DeviceSample>, now_ns: TimeNs) {
        let passed_ns = now_ns.saturating_sub(self.polled_ns).min(POLL_NS);
        self.polled_ns = now_ns;
        self.silent_ns = match polled {
            Polled::Nothing => self.silent_ns + passed_ns,
            Polled::Fresh(_) | Polled::Lost => 0,
        };
    }

    /// Adds the silence to the driver's findings, unless these hold a fault already.
    pub(crate) fn complete(&self, mut findings: Findings) -> Findings {
        let is_silent = self.silent_ns > SILENT_NS && findings.faults.is_empty();
        findings.faults.raise_if(is_silent, Fault::SilentDevice);
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn is_silent(silence: &Silence) -> bool {
        let faults = silence.complete(Findings::default()).faults;
        faults.contains(Fault::SilentDevice)
    }

    #[test]
    fn a_device_is_silent_after_many_polls_but_not_after_a_pause_of_the_host() {
        let mut silence = Silence::default();
        silence.note(&Polled::Nothing, 10 * MS);
        silence.note(&Polled::Nothing, 60_000 * MS);
        assert!(!is_silent(&silence));
        for ms in 0..500 {
            silence.note(&Polled::Nothing, (60_000 + ms) * MS);
        }
        assert!(is_silent(&silence));
        let mut explained = Findings::default();
        explained.faults.raise(Fault::FrozenDevice);
        assert_eq!(silence.complete(explained), explained);
        silence.note(&Polled::Lost, 61_000 * MS);
        assert!(!is_silent(&silence));
    }
}
