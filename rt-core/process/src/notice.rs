//! Sentences about faults of devices, for a person who can mend these.

use core::sync::atomic::Ordering::Relaxed;
use std::path::{Path, PathBuf};

use rt_core::fault::Fault;

use crate::shared::Shared;

/// Describes a fault of the haptic device at `haptic`, or of the pedal, with the remedy if one is
/// known. `None` for other faults. `bundle_ms` is the length of bundles, 0 if unknown.
#[must_use]
pub fn sentence(fault: &str, haptic: Option<&Path>, bundle_ms: u32) -> Option<String> {
    let device = haptic.map_or("the haptic device".to_owned(), |path| {
        format!("the haptic device {}", path.display())
    });
    Some(match fault {
        "speed_trip" => format!(
            "{device} moved faster than 1.2 m/s: the force is off until it is enabled again (key \
             F). If nobody threw the handle, its positions are noisy"
        ),
        "stale_device" => format!(
            "samples of {device} came late, or this computer stood still: the force was held down \
             meanwhile"
        ),
        "lost_device" => format!("the line to {device} was lost for a while: no force meanwhile"),
        "silent_device" => format!(
            "{device} is open and sends no valid sample: no force. Look at its firmware, or run \
             `calot devices conformance`"
        ),
        "frozen_device" => format!(
            "{device} repeats one position although it says that it moves: no force meanwhile"
        ),
        "device_clock" => format!(
            "the clock of {device} runs backwards, stands still or does not count microseconds: no \
             force meanwhile"
        ),
        "device_leap" => format!(
            "positions of {device} leapt farther than a hand moves: these samples were dropped"
        ),
        "device_bundles" => bundles(&device, haptic, bundle_ms),
        "deaf_device" => format!("{device} confirms no force that it is sent: no force meanwhile"),
        "lost_pedal" => {
            "the foot pedal was lost, or sent nothing, for a while: it counted as released"
                .to_owned()
        }
        _ => return None,
    })
}

fn bundles(device: &str, haptic: Option<&Path>, bundle_ms: u32) -> String {
    // A name from /dev/serial/by-id leads to the tty.
    let tty = haptic.and_then(|path| path.canonicalize().ok());
    let tty = tty.as_deref().and_then(Path::file_name);
    let tty = tty.map_or("ttyUSB0".into(), |name| name.to_string_lossy());
    let length = match bundle_ms {
        0 => String::new(),
        ms => format!(" of {ms} ms"),
    };
    format!(
        "samples come in bundles{length} from {device}: no force. An FTDI adapter's latency timer \
         does that; as root: echo 1 > /sys/bus/usb-serial/devices/{tty}/latency_timer"
    )
}

/// Tells each kind of fault once on standard error.
#[derive(Debug, Default)]
pub(crate) struct Notices {
    haptic: Option<PathBuf>,
    told: u32,
}

impl Notices {
    /// Notices about the haptic device at `haptic`.
    pub(crate) const fn new(haptic: Option<PathBuf>) -> Self {
        Self { haptic, told: 0 }
    }

    /// Tells the faults that were not told before.
    pub(crate) fn look(&mut self, shared: &Shared) {
        for (fault, count) in Fault::ALL.into_iter().zip(&shared.faults) {
            let bit = 1 << fault.code();
            if count.load(Relaxed) == 0 || self.told & bit != 0 {
                continue;
            }
            self.told |= bit;
            let bundle_ms = shared.bundle_ms.load(Relaxed);
            if let Some(text) = sentence(fault.name(), self.haptic.as_deref(), bundle_ms) {
                crate::say!("calot rt: {text}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundles_name_the_setting_that_mends_them() {
        let path = Path::new("/dev/null");
        let text = sentence("device_bundles", Some(path), 16).unwrap();
        assert!(text.contains("bundles of 16 ms"), "{text}");
        let setting = "/sys/bus/usb-serial/devices/null/latency_timer";
        assert!(text.contains(setting), "{text}");
    }

    #[test]
    fn every_fault_of_a_device_has_a_sentence() {
        let from = usize::from(Fault::SilentDevice.code());
        for fault in Fault::ALL.into_iter().skip(from).take(7) {
            assert!(
                sentence(fault.name(), None, 0).is_some(),
                "{}",
                fault.name()
            );
        }
        assert!(sentence(Fault::Clamped.name(), None, 0).is_none());
    }
}
