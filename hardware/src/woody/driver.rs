//! Driver of a WoodenHaptics device.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Quat, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Freedom, HapticDevice, LineCounters,
    Opening, Polled,
};
use rt_core::time::TimeNs;

use super::mechanism::Mechanism;
use super::wire::{Currents, Encoders, ListReader, Model};
use crate::HardwareError;
use crate::gate::Gate;
use crate::line::{Line, Read, Written};

/// Bit rate of the line. The Teensy's USB ignores it.
const BAUD: u32 = 115_200;
const NAME: &str = "WoodenHaptics device";
const HANDSHAKE: Duration = Duration::from_secs(2);
const ASK_INTERVAL: Duration = Duration::from_millis(50);
/// Largest number of bytes that one poll reads: 15 of the longest lines.
const BYTES_PER_POLL: usize = 1024;
/// Farthest plausible position from the middle, in workspace radii.
const REACH: f32 = 3.0;
/// Fastest plausible movement of the handle, m/s.
const SPEED_LIMIT_M_S: f32 = 5.0;
/// Noise of a position, m, allowed on top of that movement.
const NOISE_M: f32 = 0.002;
/// Time after which the firmware drops the currents when no command comes, ms.
const WATCHDOG_MS: u16 = 100;
/// First error code for a command that was not understood. Lower codes concern a joint's sensor.
const COMMAND_ERROR: i32 = 8;

/// A WoodenHaptics device. It only answers commands: without [`HapticDevice::send`] there are no
/// samples.
#[derive(Debug)]
pub struct WoodyHaptic {
    line: Line,
    mechanism: Mechanism,
    reader: ListReader,
    counters: LineCounters,
    sequence: u16,
    angles_rad: [f64; 3],
    gate: Gate<3>,
    /// True at the start, and after a write that broke off. The next write then needs a newline in
    /// front.
    torn: bool,
}

impl WoodyHaptic {
    /// Opens the line with the published mechanism. The device must have been zeroed in its home
    /// position. Waits up to 2 s for an answer, so the tick must not call it.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        Self::open_as(path, Mechanism::WOODY)
    }

    /// Opens a device with another mechanism.
    pub fn open_as(path: &Path, mechanism: Mechanism) -> Result<Self, HardwareError> {
        Self::on(Line::open(path, BAUD)?, mechanism)
    }

    /// Opens the device on an open line.
    pub(crate) fn on(line: Line, mechanism: Mechanism) -> Result<Self, HardwareError> {
        let path = line.path().to_path_buf();
        let mut woody = Self {
            line,
            mechanism,
            reader: ListReader::default(),
            counters: LineCounters::default(),
            sequence: 0,
            angles_rad: mechanism.home_rad,
            gate: Gate::new(SPEED_LIMIT_M_S, NOISE_M),
            torn: true,
        };
        let found = woody.greet()?;
        if found.model != Model::Woody {
            return Err(HardwareError::WrongDevice {
                path,
                expected: NAME,
                found: format!(
                    "a {:?}, whose linkage this driver does not know",
                    found.model
                ),
            });
        }
        woody.counters = LineCounters::default();
        Ok(woody)
    }

    /// Path of the line.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.line.path()
    }

    /// True if the line is lost; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.line.is_lost()
    }

    /// Sends zero currents until the device answers.
    fn greet(&mut self) -> Result<Encoders, HardwareError> {
        let path = self.path().to_path_buf();
        let start = Instant::now();
        let mut next = start;
        let mut heard = 0;
        while start.elapsed() < HANDSHAKE {
            if Instant::now() >= next {
                self.write(Currents::default());
                next += ASK_INTERVAL;
            }
            let mut bytes = [0; BYTES_PER_POLL];
            match self.line.read(&mut bytes) {
                Read::Bytes(count, _) => {
                    heard += count as u64;
                    let mut found = None;
                    for &byte in bytes.iter().take(count) {
                        if let Some(Ok(text)) = self.reader.push(byte) {
                            found = Encoders::parse(text).or(found);
                        }
                    }
                    if let Some(found) = found {
                        return Ok(found);
                    }
                }
                Read::Empty => thread::sleep(Duration::from_millis(1)),
                Read::Lost => return Err(HardwareError::Missing { path }),
            }
        }
        let waited_ms = HANDSHAKE.as_millis() as u64;
        Err(HardwareError::Silent {
            path,
            expected: NAME,
            waited_ms,
            heard,
        })
    }

    fn write(&mut self, currents: Currents) {
        if self.torn {
            // Ends an incomplete command; the firmware answers with an error at most.
            match self.line.write(b"\n") {
                Written::All => self.torn = false,
                Written::Part(_) | Written::Nothing => {
                    self.counters.dropped_writes += 1;
                    return;
                }
            }
        }
        let written = self.line.write(currents.line().as_bytes());
        if written != Written::All {
            self.torn = matches!(written, Written::Part(_));
            self.counters.dropped_writes += 1;
        }
    }
}

impl Drop for WoodyHaptic {
    /// Sets the currents to zero now instead of leaving that to the watchdog.
    fn drop(&mut self) {
        self.write(Currents::default());
    }
}

impl HapticDevice for WoodyHaptic {
    fn capabilities(&self) -> DeviceCapabilities {
        DeviceCapabilities {
            opening: Opening::NONE,
            force_max_n: self.mechanism.force_max_n as f32,
            force_continuous_n: self.mechanism.force_continuous_n as f32,
            stiffness_max_n_m: self.mechanism.stiffness_max_n_m as f32,
            damping_max_n_s_m: self.mechanism.damping_max_n_s_m as f32,
            workspace_radius_m: self.mechanism.radius_m as f32,
            torque_max_nm: 0.0,
            damping_n_s_m: self.mechanism.damping_n_s_m as f32,
            delay_s: self.mechanism.delay_s as f32,
            // The device answers as often as it is asked.
            rate_hz: 1000.0,
        }
    }

    /// Measures the position of the handle, not its rotation.
    fn freedom(&self) -> Freedom {
        Freedom {
            measured: 3,
            rendered: 3,
        }
    }

    fn watchdog_ms(&self) -> Option<u16> {
        Some(WATCHDOG_MS)
    }

    fn poll(&mut self, _now_ns: TimeNs) -> Polled<DeviceSample> {
        let mut bytes = [0; BYTES_PER_POLL];
        let (count, at_ns) = match self.line.read(&mut bytes) {
            Read::Bytes(count, at_ns) => (count, at_ns),
            Read::Empty => return Polled::Nothing,
            Read::Lost => return Polled::Lost,
        };
        let reach_m = self.mechanism.radius_m as f32 * REACH;
        let mut newest = None;
        for &byte in bytes.iter().take(count) {
            let Some(read) = self.reader.push(byte) else {
                continue;
            };
            let sample = read.ok().and_then(Encoders::parse).and_then(|encoders| {
                let [a, b, c, ..] = encoders.counts;
                let angles_rad = self.mechanism.angles_rad([a, b, c]);
                let position_m = self.mechanism.position_m(angles_rad);
                let good = encoders.model == Model::Woody
                    && encoders.error < COMMAND_ERROR
                    && position_m.norm() <= reach_m;
                good.then_some((angles_rad, position_m))
            });
            // The line has no checksum. A number that lost a digit can be recognised only as a
            // jump.
            let sample = sample
                .filter(|(_, position_m)| self.gate.admit(<[f32; 3]>::from(*position_m), at_ns));
            match sample {
                Some((angles_rad, position_m)) => {
                    self.counters.frames += 1;
                    self.sequence = self.sequence.wrapping_add(1);
                    self.angles_rad = angles_rad;
                    newest = Some(position_m);
                }
                None => self.counters.bad_frames += 1,
            }
        }
        newest.map_or(Polled::Nothing, |position_m| {
            Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: Pose::from_parts(position_m.into(), Quat::identity()),
                velocity_m_s: None,
                buttons: Buttons::default(),
                sequence: self.sequence,
                at_ns,
            })
        })
    }

    fn send(&mut self, command: ForceCommand, _now_ns: TimeNs) {
        let mut force_n = command.force_n;
        let norm = force_n.norm();
        let max_n = self.mechanism.force_max_n as f32;
        if !norm.is_finite() {
            force_n = Vec3::zeros();
        } else if norm > max_n {
            force_n *= max_n / norm;
        }
        self.write(Currents(
            self.mechanism.currents_ma(self.angles_rad, force_n),
        ));
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}
