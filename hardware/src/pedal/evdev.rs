//! A USB pedal, which the kernel treats as a keyboard. The driver grabs the pedal, so that no other
//! program gets its keys, and reads it without blocking.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::path::{Path, PathBuf};

use rt_core::port::{LineCounters, Pedal, PedalSample, Polled};
use rt_core::time::TimeNs;
use rustix::fs::OFlags;
use rustix::io::Errno;

use crate::HardwareError;

/// Offsets of the kernel's `input_event` on a 64-bit machine.
mod field {
    pub(super) const KIND: usize = 16;
    pub(super) const CODE: usize = 18;
    pub(super) const VALUE: usize = 20;
    pub(super) const END: usize = 24;
}

const EV_SYN: u16 = 0;
const EV_KEY: u16 = 1;
/// Code of the event that reports an overflow of the kernel's buffer. After it the pressed keys are
/// unknown.
const SYN_DROPPED: u16 = 3;
/// Largest number of events that one poll reads.
const EVENTS_PER_POLL: usize = 32;

/// A parsed event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// A key went down or up.
    Key { code: u16, down: bool },
    /// Events were lost.
    Dropped,
    /// Any other event, for example a key repetition or a marker.
    Other,
}

impl Event {
    fn parse(bytes: &[u8; field::END]) -> Self {
        let word = |at: usize| u16::from_ne_bytes([bytes[at], bytes[at + 1]]);
        let value = i32::from_ne_bytes([
            bytes[field::VALUE],
            bytes[field::VALUE + 1],
            bytes[field::VALUE + 2],
            bytes[field::VALUE + 3],
        ]);
        match (word(field::KIND), word(field::CODE), value) {
            (EV_KEY, code, 0) => Self::Key { code, down: false },
            (EV_KEY, code, 1) => Self::Key { code, down: true },
            (EV_SYN, SYN_DROPPED, _) => Self::Dropped,
            _ => Self::Other,
        }
    }
}

/// Roles of a pedal's keys, by the kernel's key codes. A role may be empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Roles {
    /// Electrosurgery: cut.
    pub cut: Option<u16>,
    /// Electrosurgery: coagulate.
    pub coagulate: Option<u16>,
    /// Holds the camera.
    pub camera_lock: Option<u16>,
}

impl Default for Roles {
    /// A three-switch pedal with the keys 0, 1 and 2 (VEC Infinity): left cuts, right coagulates,
    /// the middle holds the camera.
    fn default() -> Self {
        Self {
            cut: Some(256),
            camera_lock: Some(257),
            coagulate: Some(258),
        }
    }
}

/// A USB pedal.
#[derive(Debug)]
pub struct EvdevPedal {
    /// `None` after the pedal was unplugged.
    events: Option<OwnedFd>,
    path: PathBuf,
    roles: Roles,
    pressed: PedalSample,
    counters: LineCounters,
}

impl EvdevPedal {
    /// Opens and grabs the input device at `path` (`/dev/input/by-id/…-event-kbd`). May wait, so
    /// the tick must not call it.
    pub fn open(path: &Path, roles: Roles) -> Result<Self, HardwareError> {
        let mut device =
            evdev::raw_stream::RawDevice::open(path).map_err(|error| open_error(path, &error))?;
        let keys = [roles.cut, roles.coagulate, roles.camera_lock];
        let known = device.supported_keys();
        for key in keys.into_iter().flatten() {
            if !known.is_some_and(|known| known.contains(evdev::KeyCode::new(key))) {
                return Err(HardwareError::WrongDevice {
                    path: path.to_path_buf(),
                    expected: "pedal with the keys that the station names",
                    found: format!("{}, without key {key}", device.name().unwrap_or("a device")),
                });
            }
        }
        device.grab().map_err(|_| HardwareError::Busy {
            path: path.to_path_buf(),
        })?;
        // The second descriptor refers to the same open file. The grab belongs to the file, so it
        // remains when `device` is dropped.
        let events = device
            .as_fd()
            .try_clone_to_owned()
            .map_err(|error| open_error(path, &error))?;
        Self::on(events, path, roles)
    }

    /// A pedal that reads its events from `events`, which may be any descriptor.
    fn on(events: OwnedFd, path: &Path, roles: Roles) -> Result<Self, HardwareError> {
        rustix::fs::fcntl_setfl(&events, OFlags::NONBLOCK)
            .map_err(|errno| open_error(path, &errno.into()))?;
        Ok(Self {
            events: Some(events),
            path: path.to_path_buf(),
            roles,
            pressed: PedalSample::default(),
            counters: LineCounters::default(),
        })
    }

    /// Path of the input device.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True if the pedal was unplugged; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.events.is_none()
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Key { code, down } => {
                self.counters.frames += 1;
                let code = Some(code);
                if code == self.roles.cut {
                    self.pressed.cut = down;
                }
                if code == self.roles.coagulate {
                    self.pressed.coagulate = down;
                }
                if code == self.roles.camera_lock {
                    self.pressed.camera_lock = down;
                }
            }
            Event::Dropped => {
                self.counters.lost_frames += 1;
                self.pressed = PedalSample::default();
            }
            Event::Other => {}
        }
    }
}

impl Pedal for EvdevPedal {
    /// Returns a fresh sample at every poll while the pedal is connected, because the kernel
    /// reports every change.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample> {
        let mut bytes = [0; EVENTS_PER_POLL * field::END];
        let Some(events) = &self.events else {
            return Polled::Lost;
        };
        match rustix::io::read(events, &mut bytes) {
            Ok(count) if count > 0 => {
                let (whole, rest) = bytes.get(..count).unwrap_or(&[]).as_chunks();
                for event in whole {
                    self.take(Event::parse(event));
                }
                if !rest.is_empty() {
                    // The kernel never sends a partial event. If one comes nevertheless, all keys
                    // count as released.
                    self.counters.bad_frames += 1;
                    self.take(Event::Dropped);
                }
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            Ok(_) | Err(_) => {
                self.events = None;
                self.pressed = PedalSample::default();
                return Polled::Lost;
            }
        }
        self.pressed.at_ns = now_ns;
        Polled::Fresh(self.pressed)
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}

/// Path and name of all input devices whose name contains `name`, ignoring case.
#[must_use]
pub fn find(name: &str) -> Vec<(PathBuf, String)> {
    let wanted = name.to_lowercase();
    evdev::raw_stream::enumerate()
        .filter_map(|(path, device)| Some((path, device.name()?.to_owned())))
        .filter(|(_, name)| name.to_lowercase().contains(&wanted))
        .collect()
}

fn open_error(path: &Path, error: &io::Error) -> HardwareError {
    let path = path.to_path_buf();
    match error.kind() {
        io::ErrorKind::NotFound => HardwareError::Missing { path },
        io::ErrorKind::PermissionDenied => HardwareError::Permission { path },
        _ => HardwareError::Line {
            path,
            doing: "opening the pedal",
            what: error.to_string(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn event(kind: u16, code: u16, value: i32) -> Vec<u8> {
        let mut bytes = vec![0; field::KIND];
        bytes.extend_from_slice(&kind.to_ne_bytes());
        bytes.extend_from_slice(&code.to_ne_bytes());
        bytes.extend_from_slice(&value.to_ne_bytes());
        bytes
    }

    /// A pedal that reads a pipe, and the pipe's other end.
    fn piped() -> (EvdevPedal, OwnedFd) {
        let (read, write) = rustix::pipe::pipe().unwrap();
        (
            EvdevPedal::on(read, "pedal".as_ref(), Roles::default()).unwrap(),
            write,
        )
    }

    fn poll_after(pedal: &mut EvdevPedal, write: &OwnedFd, bytes: &[u8]) -> PedalSample {
        rustix::io::write(write, bytes).unwrap();
        match pedal.poll(7) {
            Polled::Fresh(sample) => sample,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_event_has_the_kernels_length() {
        assert_eq!(size_of::<evdev::InputEvent>(), field::END);
    }

    #[test]
    fn keys_press_and_release_and_autorepeat_does_nothing() {
        let (mut pedal, write) = piped();
        let idle = PedalSample {
            at_ns: 7,
            ..PedalSample::default()
        };
        assert_eq!(pedal.poll(7), Polled::Fresh(idle));
        let cut = PedalSample { cut: true, ..idle };
        assert_eq!(poll_after(&mut pedal, &write, &event(EV_KEY, 256, 1)), cut);
        assert_eq!(poll_after(&mut pedal, &write, &event(EV_KEY, 256, 2)), cut);
        assert_eq!(poll_after(&mut pedal, &write, &event(EV_KEY, 30, 1)), cut);
        assert_eq!(poll_after(&mut pedal, &write, &event(EV_KEY, 256, 0)), idle);
        let coagulate = poll_after(&mut pedal, &write, &event(EV_KEY, 258, 1));
        assert_eq!(
            coagulate,
            PedalSample {
                coagulate: true,
                ..idle
            }
        );
    }

    #[test]
    fn lost_events_and_an_unplugged_pedal_read_as_released() {
        let (mut pedal, write) = piped();
        assert!(poll_after(&mut pedal, &write, &event(EV_KEY, 256, 1)).cut);
        assert!(!poll_after(&mut pedal, &write, &event(EV_SYN, SYN_DROPPED, 0)).cut);
        assert!(poll_after(&mut pedal, &write, &event(EV_KEY, 256, 1)).cut);
        drop(write);
        assert_eq!(pedal.poll(8), Polled::Lost);
        assert_eq!(pedal.poll(9), Polled::Lost);
    }

    #[test]
    fn the_suite_passes_on_piped_events_and_notices_a_press_and_an_unplugged_pedal() {
        use crate::conformance::{CheckOutcome, Options, pedal_by};
        use std::cell::RefCell;
        let plug = RefCell::new(None);
        let pressed = std::cell::Cell::new(false);
        let attempt = || {
            let (pedal, write) = piped();
            if pressed.get() {
                rustix::io::write(&write, &event(EV_KEY, 256, 1)).unwrap();
            }
            *plug.borrow_mut() = Some(write);
            Ok(pedal)
        };
        let suite = || {
            let mut unplug = || drop(plug.borrow_mut().take());
            let mut options = Options {
                watch: std::time::Duration::from_millis(200),
                unplug: Some(&mut unplug),
            };
            pedal_by(&attempt, &mut options)
        };
        let report = suite();
        assert!(report.passed(), "{report}");
        let outcome = |report: &crate::conformance::Report, name| {
            report.check(name).map(|check| check.outcome)
        };
        assert_eq!(
            outcome(&report, "unplug"),
            Some(CheckOutcome::Pass),
            "{report}"
        );
        pressed.set(true);
        assert_eq!(outcome(&suite(), "released"), Some(CheckOutcome::Fail));
    }

    #[test]
    fn a_file_that_is_no_input_device_is_refused() {
        let missing = EvdevPedal::open("/dev/input/none".as_ref(), Roles::default());
        assert!(
            matches!(missing, Err(HardwareError::Missing { .. })),
            "{missing:?}"
        );
        assert!(EvdevPedal::open("/dev/null".as_ref(), Roles::default()).is_err());
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_are_harmless(bytes in prop::collection::vec(any::<u8>(), 1..2000)) {
            let (mut pedal, write) = piped();
            rustix::io::write(&write, &bytes).unwrap();
            for _ in 0..4 {
                prop_assert!(matches!(pedal.poll(1), Polled::Fresh(_)));
            }
        }
    }
}
