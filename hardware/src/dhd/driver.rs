//! Driver of a device behind `libdhd`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rt_core::fault::{Fault, FaultSet};
use rt_core::math::Pose;
use rt_core::port::{
    DeviceCapabilities, DeviceSample, Findings, ForceCommand, Freedom, HapticDevice, Identity,
    LineCounters, Polled,
};
use rt_core::time::TimeNs;

use super::library::{Dhd, Handle, Parts};
use super::model;
use super::servo::Servo;
use super::shared::{Command, Shared};
use crate::HardwareError;
use crate::motion::faster;
use crate::trail::Trail;
use crate::vendor::LibraryAccess;

/// Lets one driver at a time use the library.
static ACCESS: LibraryAccess = LibraryAccess::new("calot-dhd");
/// Time over which the library averages the velocity, ms. The library's default of 20 ms would
/// delay the velocity by 10 ms.
const VELOCITY_WINDOW_MS: i32 = 5;
/// `drop` waits this long for the thread to send zero force and to end.
const STOP_TIMEOUT: Duration = Duration::from_millis(500);

/// A Force Dimension device or a Falcon, served by a thread of its own.
#[derive(Debug)]
pub struct DhdHaptic {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    parts: Parts,
    capabilities: DeviceCapabilities,
    identity: String,
    last_version: u32,
    counters: LineCounters,
    /// Value of `Shared::leaps` at the last poll.
    refused_jumps: u32,
    trail: Trail,
    /// Number of jumps accepted as the new place, at the last poll.
    accepted_jumps: u32,
    findings: Findings,
}

/// Lets the next driver use the library when the thread has ended, even by a panic.
struct Release;

impl Drop for Release {
    fn drop(&mut self) {
        ACCESS.release();
    }
}

impl DhdHaptic {
    /// Opens the device with this serial number (`None`: the first that is free) through `library`
    /// (usually [`super::LIBRARY`]). Never call it from the tick: it takes up to 10 s if the
    /// library hangs.
    pub fn open(library: &Path, serial: Option<u16>) -> Result<Self, HardwareError> {
        let path = PathBuf::from(match serial {
            Some(serial) => format!("Force Dimension {serial}"),
            None => "first Force Dimension device".to_owned(),
        });
        let (own_library, own_path) = (library.to_path_buf(), path.clone());
        ACCESS.open(&path, library, move || {
            Self::open_directly(&own_library, serial, &own_path)
        })
    }

    fn open_directly(
        library: &Path,
        serial: Option<u16>,
        path: &Path,
    ) -> Result<Self, HardwareError> {
        let dhd = Dhd::load(library)?;
        if dhd.device_count() <= 0 {
            return Err(HardwareError::NoForceDevice {
                path: path.to_path_buf(),
            });
        }
        let handle = dhd
            .open(serial)
            .map_err(|code| library_error(path, "opening the device", code))?;
        let parts = handle.parts();
        require_calibration(dhd, &handle, parts, path)?;
        let number = handle
            .serial()
            .map_or_else(|| "without a serial number".to_owned(), |it| it.to_string());
        let identity = format!("{} {number}", handle.name());
        let capabilities = model::capabilities(handle.model(), parts);
        handle.configure_velocity(VELOCITY_WINDOW_MS);
        // With the first force, even a zero force, the library begins to compensate the weight of
        // the arms.
        let nothing = [0.0; 3];
        if !handle.set_force(nothing, nothing, 0.0) || !handle.enable_force() {
            return Err(library_error(path, "enabling the force", dhd.last_error()));
        }
        let shared = Arc::new(Shared::new());
        let servo = Servo::new(handle, parts, capabilities, Arc::clone(&shared));
        let thread = thread::Builder::new()
            .name("calot-dhd-servo".to_owned())
            .spawn(move || {
                // `serve` closes the device. `_release` is dropped after that.
                let _release = Release;
                servo.serve();
            })
            .map_err(|error| HardwareError::Line {
                path: path.to_path_buf(),
                doing: "starting a thread",
                what: error.to_string(),
            })?;
        Ok(Self {
            shared,
            thread: Some(thread),
            parts,
            capabilities,
            identity,
            last_version: 0,
            counters: LineCounters::default(),
            refused_jumps: 0,
            trail: Trail::default(),
            accepted_jumps: 0,
            findings: Findings::default(),
        })
    }

    /// True if the device is lost; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.shared.is_lost.load(Ordering::Acquire)
    }
}

/// The library's error code (`dhdc.h`) as an error with a remedy.
fn library_error(path: &Path, doing: &'static str, code: i32) -> HardwareError {
    let remedy = match code {
        2 => {
            "the device does not answer; check its cable and power, and that your user may open the USB device"
        }
        3 | 20 => "another program uses the device; end it, then try again",
        5 | 15 => {
            "no device has this serial number; correct `device` in the station file, or leave it out"
        }
        6 | 7 => "the device is not ready; switch it off and on, then try again",
        12 => "the device is not ready; switch it on and calibrate it",
        14 | 18 => "the device found a fault in itself; switch it off and on, then ask its maker",
        _ => "see the SDK's list of errors (dhdc.h), or run its own HapticDesk",
    };
    HardwareError::Vendor {
        path: path.to_path_buf(),
        doing,
        code: code as u16,
        remedy,
    }
}

/// Refuses a device that is not calibrated. Such a device does not know where its handle is.
fn require_calibration(
    dhd: &Dhd,
    handle: &Handle,
    parts: Parts,
    path: &Path,
) -> Result<(), HardwareError> {
    let Some(status) = handle.status() else {
        return Err(library_error(path, "reading the status", dhd.last_error()));
    };
    let remedy = if status.is_reset {
        "Move the handle slowly to all its end stops, or put it into its calibration pit. Its light then stops \
         blinking. With a sigma or lambda, let go of the handle and run the SDK's HapticInit"
    } else if parts.has_active_wrist && !status.is_wrist_ready {
        "Let go of the handle and run the SDK's HapticInit, which turns its wrist"
    } else {
        return Ok(());
    };
    Err(HardwareError::Calibration {
        path: path.to_path_buf(),
        remedy,
    })
}

impl HapticDevice for DhdHaptic {
    fn identity(&self) -> Identity {
        Identity::new(self.identity.as_bytes(), 0)
    }

    fn capabilities(&self) -> DeviceCapabilities {
        self.capabilities
    }

    fn freedom(&self) -> Freedom {
        let of = |has_rotation: bool| if has_rotation { 6 } else { 3 };
        Freedom {
            measured: of(self.parts.has_wrist),
            rendered: of(self.capabilities.renders_torque()),
        }
    }

    fn poll(&mut self, _now_ns: TimeNs) -> Polled<DeviceSample> {
        self.findings = Findings::default();
        if self.is_lost() {
            return Polled::Lost;
        }
        let leaps = self.shared.leaps.load(Ordering::Relaxed);
        let mut faults = FaultSet::NONE;
        faults.raise_if(leaps != self.refused_jumps, Fault::DeviceLeap);
        let is_forceless = self.shared.is_forceless.load(Ordering::Acquire);
        faults.raise_if(is_forceless, Fault::DeafDevice);
        self.refused_jumps = leaps;
        self.findings.faults = faults;
        let Some((version, sample)) = self.shared.sample() else {
            return Polled::Nothing;
        };
        if version == self.last_version {
            return Polled::Nothing;
        }
        // A sample that a newer one replaced before this poll does not count as lost on the line.
        self.last_version = version;
        self.counters.frames += 1;
        self.findings.leapt = sample.jumps != self.accepted_jumps;
        self.accepted_jumps = sample.jumps;
        if self.findings.leapt {
            self.trail.clear();
        }
        let at_us = (sample.at_ns / 1000) as u32;
        let trail_m_s = self.trail.add(at_us, &sample.position_m);
        let velocity_m_s = sample.velocity_m_s;
        let has_velocity = velocity_m_s.iter().all(|part| part.is_finite());
        Polled::Fresh(DeviceSample {
            opening: Some(sample.opening).filter(|opening| opening.is_finite()),
            device_from_handle: Pose::from_parts(sample.position_m.into(), sample.rotation),
            velocity_m_s: has_velocity.then(|| faster(velocity_m_s, trail_m_s)),
            buttons: sample.buttons,
            sequence: sample.count as u16,
            at_ns: sample.at_ns,
        })
    }

    fn findings(&self) -> Findings {
        self.findings
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        self.shared.send_command(&Command {
            force_n: command.force_n,
            torque_nm: command.torque_nm,
            opening_n: command.opening_n,
            at_ns: now_ns,
        });
    }

    fn counters(&self) -> LineCounters {
        let [bad, leaps, refusals] = [
            &self.shared.bad_samples,
            &self.shared.leaps,
            &self.shared.refusals,
        ]
        .map(|count| u64::from(count.load(Ordering::Relaxed)));
        LineCounters {
            bad_frames: bad + leaps,
            dropped_writes: refusals,
            ..self.counters
        }
    }
}

impl Drop for DhdHaptic {
    /// Ends the thread. Its last acts are to send zero force and to brake the motors. If the
    /// library hangs, this call gives up after `STOP_TIMEOUT` and leaves the thread behind.
    fn drop(&mut self) {
        self.shared.running.store(false, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let start = Instant::now();
            while !thread.is_finished() && start.elapsed() < STOP_TIMEOUT {
                thread::sleep(Duration::from_millis(1));
            }
            match thread.is_finished() {
                true => drop(thread.join()),
                false => ACCESS.mark_hung(),
            }
        }
    }
}
