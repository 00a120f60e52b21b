//! Sentences about faults of devices, for a person who can mend the device.

use core::sync::atomic::Ordering::Relaxed;
use std::path::{Path, PathBuf};

use rt_core::fault::Fault;

use crate::shared::Shared;

/// Describes a fault of the haptic device at `haptic`, or of the pedal, with the remedy if one is
/// known. `None` for other faults. `bundle_ms` is the length of the bundles in which samples come,
/// ms; 0: unknown.
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
            "samples of {device} came late, or this computer stood still: the force was lowered \
             meanwhile"
        ),
        "lost_device" => format!("the line to {device} was lost for a while: no force meanwhile"),
        "silent_device" => format!(
            "{device} is open and sends no valid sample: no force. Look at its firmware, or run \
             `calot devices conformance`"
        ),
        "frozen_device" => format!(
            "{device} repeats one sample, or repeats one position while it reports a velocity: no \
             force meanwhile"
        ),
        "device_clock" => format!(
            "the clock of {device} runs backwards, stands still or does not count microseconds: no \
             force meanwhile"
        ),
        "device_leap" => format!(
            "positions of {device} leapt farther than a hand moves: these samples were dropped"
        ),
        "device_bundles" => bundles(&device, haptic, bundle_ms),
        "deaf_device" => {
            format!("{device} does not confirm the forces sent to it: no force meanwhile")
        }
        "device_fault" => format!(
            "{device} reports a fault of its own: no force. Find the cause by its lamp and the \
             maker's manual, and remove it"
        ),
        "device_watchdog" => format!(
            "the watchdog of {device} dropped the force, since no command came in time: this \
             computer was late, or the line loses bytes"
        ),
        "device_limited" => format!(
            "{device} says that it limits its force (heat or current): contact felt softer than \
             computed. Let it cool down, or lower force_max_n"
        ),
        "noisy_device" => format!(
            "positions of {device} are noisy by more than 0.1 mm, and so its force steps. Mend its \
             sensor or cable; `calot devices conformance` measures the noise"
        ),
        "held_pedal" => {
            "a pedal has been held down since the start, or since its line returned: it counts as \
             released until you release it once"
                .to_owned()
        }
        "lost_pedal" => {
            "the foot pedal was lost, or sent nothing, for a while: it counted as released"
                .to_owned()
        }
        _ => return None,
    })
}

fn bundles(device: &str, haptic: Option<&Path>, bundle_ms: u32) -> String {
    // A name from /dev/serial/by-id is a link to the tty.
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

/// Amount of contact in a run in which one fault held the force back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Held {
    /// Name of the fault that is the reason.
    pub fault: String,
    /// Ticks of contact in which less or none of the force was rendered.
    pub ticks: u64,
    /// Number of times that the fault began to hold the force back.
    pub times: u64,
}

/// Line of a haptic device, with its counters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Path of the line.
    pub path: PathBuf,
    /// Rejected frames.
    pub bad_frames: u64,
    /// Frames that are missing in the sequence numbers.
    pub lost_frames: u64,
    /// Commands that the line refused.
    pub dropped_writes: u64,
    /// Bytes that this computer did not read in time.
    pub unread_bytes: u64,
}

impl Line {
    fn in_words(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        format!(
            " ({}: {} bad, {} lost, {} refused, {} bytes unread)",
            name.display(),
            self.bad_frames,
            self.lost_frames,
            self.dropped_writes,
            self.unread_bytes
        )
    }
}

/// Describes the force that was held back in `contact_ticks` of contact, with the counters of the
/// haptic device's `line`. `None` if little force was held back.
#[must_use]
pub fn held_back(contact_ticks: u64, held: &[Held], line: Option<&Line>) -> Option<String> {
    let ticks: u64 = held.iter().map(|it| it.ticks).sum();
    let percent = 100.0 * ticks as f64 / contact_ticks.max(1) as f64;
    if ticks < HELD_TICKS_MIN || percent < HELD_PERCENT_MIN {
        return None;
    }
    let reasons: Vec<String> = held.iter().map(reason).collect();
    Some(format!(
        "force was held back in {percent:.0} % of contact: {}{}",
        reasons.join("; "),
        line.map(Line::in_words).unwrap_or_default()
    ))
}

/// Least time for which a hand notices that force is missing, ticks.
const HELD_TICKS_MIN: u64 = 50;
/// Least share of contact that is reported, %.
const HELD_PERCENT_MIN: f64 = 1.0;

fn reason(held: &Held) -> String {
    let why = match held.fault.as_str() {
        "device_fault" => "the device reported a fault",
        "lost_device" => "the device's line was lost",
        "frozen_device" => "the device repeated one position",
        "device_clock" => "the device's clock was wrong",
        "deaf_device" => "the device confirmed no force",
        "device_bundles" => "samples came in bundles",
        "silent_device" => "no valid sample came",
        "device_leap" => "positions leapt",
        "bad_force" => "the force was not finite",
        "speed_trip" => "the handle was too fast, and nobody enabled the force again",
        "not_enabled" => "nobody had enabled the force (key F)",
        _ => "samples came late",
    };
    let times = match held.times {
        0 | 1 => "once".to_owned(),
        times => format!("{times} times"),
    };
    format!("{why} {times} ({:.1} s)", held.ticks as f64 * 1.0e-3)
}

/// Prints each kind of fault once on standard error.
#[derive(Debug, Default)]
pub(crate) struct Notices {
    haptic: Option<PathBuf>,
    printed: u32,
}

impl Notices {
    /// Notices about the haptic device at `haptic`.
    pub(crate) const fn new(haptic: Option<PathBuf>) -> Self {
        Self { haptic, printed: 0 }
    }

    /// Prints the faults that were not printed before.
    pub(crate) fn look(&mut self, shared: &Shared) {
        for (fault, count) in Fault::ALL.into_iter().zip(&shared.faults) {
            let bit = 1 << fault.code();
            if count.load(Relaxed) == 0 || self.printed & bit != 0 {
                continue;
            }
            self.printed |= bit;
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
    fn notice_of_bundles_names_the_setting_that_removes_them() {
        let path = Path::new("/dev/null");
        let text = sentence("device_bundles", Some(path), 16).unwrap();
        assert!(text.contains("bundles of 16 ms"), "{text}");
        let setting = "/sys/bus/usb-serial/devices/null/latency_timer";
        assert!(text.contains(setting), "{text}");
    }

    #[test]
    fn every_fault_of_a_device_has_a_sentence() {
        let from = usize::from(Fault::SilentDevice.code());
        for fault in Fault::ALL.into_iter().skip(from).filter(|it| it.is_alarm()) {
            assert!(
                sentence(fault.name(), None, 0).is_some(),
                "{}",
                fault.name()
            );
        }
        assert!(sentence(Fault::Clamped.name(), None, 0).is_none());
        let limited = sentence(Fault::DeviceLimited.name(), None, 0).unwrap();
        assert!(limited.contains("limits its force"), "{limited}");
    }

    #[test]
    fn report_of_held_back_force_has_share_reason_and_number() {
        let held = |fault: Fault, ticks, times| Held {
            fault: fault.name().to_owned(),
            ticks,
            times,
        };
        let late = held(Fault::StaleDevice, 8600, 53);
        assert_eq!(
            held_back(10_000, std::slice::from_ref(&late), None).unwrap(),
            "force was held back in 86 % of contact: samples came late 53 times (8.6 s)"
        );
        let line = Line {
            path: PathBuf::from("/dev/ttyACM0"),
            bad_frames: 4,
            lost_frames: 31,
            dropped_writes: 2,
            unread_bytes: 80,
        };
        assert_eq!(
            held_back(10_000, &[late], Some(&line)).unwrap(),
            "force was held back in 86 % of contact: samples came late 53 times (8.6 s) (ttyACM0: 4 \
             bad, 31 lost, 2 refused, 80 bytes unread)"
        );
        let little = held(Fault::StaleDevice, 60, 1);
        assert_eq!(held_back(10_000, &[little], Some(&line)), None);
        assert_eq!(held_back(0, &[], None), None);
    }
}
