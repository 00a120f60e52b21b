//! Driver of a foot pedal that speaks the rig protocol.

use std::path::Path;

use rt_core::port::{LineCounters, Pedal, PedalSample, Polled};
use rt_core::time::TimeNs;

use super::host::{BadReason, Host};
use super::wire::{DeviceKind, Switches, WireError};
use crate::HardwareError;

/// Missed reports after which a pedal counts as released.
const MISSED_REPORTS: u64 = 10;

/// A foot pedal that has answered the greeting. It reports all the time. When it falls silent, its
/// switches count as released.
#[derive(Debug)]
pub struct RigPedal {
    host: Host,
    silence_ns: u64,
    last_heard_ns: Option<TimeNs>,
    electrodes: Electrodes,
    camera_lock: bool,
}

/// Switches that turn the current on: cut and coagulate.
#[derive(Debug, Default)]
struct Electrodes {
    /// Switches pressed in the last report.
    pressed: [bool; 2],
    /// Switches that were pressed when the pedal fell silent. Such a switch counts again only after
    /// it was released.
    held: [bool; 2],
}

impl Electrodes {
    /// Takes a report. Returns the switches that count as pressed.
    fn update(&mut self, pressed: [bool; 2]) -> [bool; 2] {
        self.pressed = pressed;
        self.held = [0, 1].map(|i| self.held[i] && pressed[i]);
        [0, 1].map(|i| pressed[i] && !self.held[i])
    }

    /// Releases all switches. Returns true if one was pressed.
    fn release_all(&mut self) -> bool {
        let pressed = core::mem::take(&mut self.pressed);
        self.held = [0, 1].map(|i| self.held[i] || pressed[i]);
        pressed != [false; 2]
    }
}

impl RigPedal {
    /// Opens the line, greets the pedal and checks its capabilities. Waits up to 5 s for the
    /// answer, so the tick must not call it.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        let (host, identity) = Host::open(path, DeviceKind::Pedal)?;
        let silence_ns = MISSED_REPORTS * 1_000_000_000 / u64::from(identity.rate_hz);
        Ok(Self {
            host,
            silence_ns,
            last_heard_ns: None,
            electrodes: Electrodes::default(),
            camera_lock: false,
        })
    }

    /// Path of the line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.host.path()
    }

    /// True if the line is lost; see [`super::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.host.is_lost()
    }
}

impl Pedal for RigPedal {
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample> {
        let mut newest = None;
        let mut rejected = [0; BadReason::COUNT];
        let mut reject = |why: BadReason| {
            if let Some(count) = rejected.get_mut(why as usize) {
                *count += 1;
            }
        };
        let read = self
            .host
            .receive(|message, at_ns| match Switches::parse(message) {
                Ok(switches) => newest = Some((switches, at_ns)),
                Err(WireError::Range(_)) => reject(BadReason::Range),
                Err(_) => reject(BadReason::Message),
            });
        self.host.reject(&rejected);
        if let Some((switches, at_ns)) = newest {
            let Switches {
                cut,
                coagulate,
                camera_lock,
            } = switches;
            self.last_heard_ns = Some(at_ns);
            self.camera_lock = camera_lock;
            let [cut, coagulate] = self.electrodes.update([cut, coagulate]);
            return Polled::Fresh(PedalSample {
                cut,
                coagulate,
                camera_lock,
                at_ns,
            });
        }
        let silent = self
            .last_heard_ns
            .is_some_and(|heard| now_ns.saturating_sub(heard) > self.silence_ns);
        if read.is_none() {
            Polled::Lost
        } else if silent && (self.electrodes.release_all() | core::mem::take(&mut self.camera_lock))
        {
            Polled::Fresh(PedalSample {
                at_ns: now_ns,
                ..PedalSample::default()
            })
        } else {
            Polled::Nothing
        }
    }

    fn counters(&self) -> LineCounters {
        self.host.counters()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pedal_held_during_a_silence_gives_no_current_until_it_is_released() {
        let mut electrodes = Electrodes::default();
        assert_eq!(electrodes.update([false, true]), [false, true]);
        assert!(electrodes.release_all());
        assert!(!electrodes.release_all(), "reported once");
        assert_eq!(
            electrodes.update([false, true]),
            [false, false],
            "still held"
        );
        assert_eq!(electrodes.update([true, true]), [true, false]);
        assert_eq!(electrodes.update([false, false]), [false, false]);
        assert_eq!(electrodes.update([false, true]), [false, true]);
    }
}
