//! Driver of a 3D Systems Touch, through the vendor's library.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rt_core::fault::Fault;
use rt_core::math::{Pose, Quat, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, Findings, ForceCommand, HapticDevice, Identity,
    LineCounters, Opening, Polled,
};
use rt_core::time::TimeNs;

use super::hd::{Hd, Servo, name};
use crate::HardwareError;
use crate::line::now_ns;
use crate::motion::Motion;
use crate::slot::Slot;
use crate::vendor::{FORCE_AGE_NS, LibraryAccess};

/// The library has one scheduler, so only one driver may exist.
static ACCESS: LibraryAccess = LibraryAccess::new("touch");
/// Largest valid device handle. The library returns a larger one when it fails.
const HANDLE_MAX: u32 = 1024;
/// Attempts to open a device. A device that another program has just used becomes free after a
/// moment.
const INIT_TRIES: u32 = 10;
/// Wait between two attempts.
const INIT_INTERVAL: Duration = Duration::from_millis(100);
/// Error code: another program uses the device.
const ALREADY_INITIATED: u16 = 0x0301;
/// Error codes after which the callback goes on, because the library itself reduces the force: warm
/// motors; too much force, impulse or speed; a force error.
const LIMITS: std::ops::RangeInclusive<u16> = 0x0200..=0x0204;
/// Callbacks after such an error for which the force counts as limited: 0.1 s. The library reports
/// the error only once, and the tick may poll later.
const LIMITED_CALLBACKS: u32 = 100;
/// Largest workspace radius that is accepted, m: the reach of the vendor's largest device plus a
/// margin. Rigs have the same limit.
const WORKSPACE_MAX_M: f32 = 1.5;
/// Rate of the library's scheduler.
const RATE_HZ: f32 = 1000.0;

/// An open Touch. The library's scheduler calls `Shared::call` 1000 times a second.
#[derive(Debug)]
pub struct TouchHaptic {
    hd: &'static Hd,
    shared: &'static Shared,
    device: u32,
    schedule: u64,
    capabilities: DeviceCapabilities,
    identity: String,
    last_version: u32,
    motion: Motion,
    counters: LineCounters,
}

/// State shared by the vendor's thread and the tick.
#[derive(Debug)]
struct Shared {
    hd: &'static Hd,
    device: u32,
    running: AtomicBool,
    /// Code of the error that ended the callback; 0: none.
    failed: AtomicU16,
    /// Callbacks for which the force still counts as limited by the library.
    limited_callbacks: AtomicU32,
    /// Number of refused samples by reason, in the order of [`BadSample::NAMES`].
    bad_samples: [AtomicU32; 2],
    force_max_n: f32,
    /// Ten f32 as bits (position 3, quaternion x y z w, velocity 3), the buttons, and the count of
    /// samples.
    sample: Slot<12>,
    /// Three f32 as bits (force), and the time in ns as two words.
    force: Slot<5>,
}

impl TouchHaptic {
    /// Opens a device through `library` (usually `libHD.so`). `device` is its name in the vendor's
    /// set-up; `None` is the default device. Never call it from the tick: it takes about 1 s, and
    /// 10 s if the library hangs.
    pub fn open(library: &Path, device: Option<&str>) -> Result<Self, HardwareError> {
        let path = PathBuf::from(device.unwrap_or("default Touch"));
        let (own_library, name) = (library.to_path_buf(), device.map(str::to_owned));
        let own_path = path.clone();
        ACCESS.open(&path, library, move || {
            Self::open_directly(&own_library, name.as_deref(), &own_path)
        })
    }

    fn open_directly(
        library: &Path,
        device: Option<&str>,
        path: &Path,
    ) -> Result<Self, HardwareError> {
        let hd = Hd::load(library)?;
        let handle = init(hd, device, path)?;
        hd.make_current(handle);
        let capabilities = capabilities(hd);
        if let Err(error) = check_limits(&capabilities, path) {
            hd.disable_device(handle);
            return Err(error);
        }
        let shared: &'static Shared = Box::leak(Box::new(Shared {
            hd,
            device: handle,
            running: AtomicBool::new(true),
            failed: AtomicU16::new(0),
            limited_callbacks: AtomicU32::new(0),
            bad_samples: [AtomicU32::new(0), AtomicU32::new(0)],
            force_max_n: capabilities.force_max_n,
            sample: Slot::new(),
            force: Slot::new(),
        }));
        let identity = format!("{} {}", hd.string(name::MODEL), hd.string(name::SERIAL));
        hd.enable_force();
        hd.start_scheduler();
        if let code @ 1.. = hd.error() {
            hd.stop_scheduler();
            hd.disable_device(handle);
            return Err(vendor_error(path, "starting the scheduler", code));
        }
        if let Err(error) = calibrate(hd, handle, path) {
            hd.stop_scheduler();
            hd.disable_device(handle);
            return Err(error);
        }
        let schedule = hd.schedule(shared);
        Ok(Self {
            hd,
            shared,
            device: handle,
            schedule,
            capabilities,
            identity,
            last_version: 0,
            motion: Motion::default(),
            counters: LineCounters::default(),
        })
    }

    /// Code of the library's error that ended the callback, if any.
    #[must_use]
    pub fn failure(&self) -> Option<u16> {
        match self.shared.failed.load(Ordering::Acquire) {
            0 => None,
            code => Some(code),
        }
    }

    /// Number of refused samples so far by reason.
    pub fn bad_frames(&self) -> impl Iterator<Item = (&'static str, u64)> + use<> {
        let counts = self.shared.bad_samples.each_ref();
        let counts = counts.map(|count| u64::from(count.load(Ordering::Relaxed)));
        BadSample::NAMES.into_iter().zip(counts)
    }

    /// True if the device is lost; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.failure().is_some()
    }
}

fn init(hd: &Hd, device: Option<&str>, path: &Path) -> Result<u32, HardwareError> {
    let name = device
        .map(CString::new)
        .transpose()
        .map_err(|_| HardwareError::Vendor {
            path: path.to_path_buf(),
            doing: "naming the device",
            code: 0,
            remedy: "the name must not contain a zero byte",
        })?;
    for _ in 0..INIT_TRIES {
        let handle = hd.init_device(name.as_ref());
        let code = hd.error();
        if code == 0 && handle <= HANDLE_MAX {
            return Ok(handle);
        }
        // A failed call can return a handle that looks good, so the error is read as well.
        if code != ALREADY_INITIATED {
            return Err(vendor_error(path, "opening the device", code));
        }
        thread::sleep(INIT_INTERVAL);
    }
    Err(vendor_error(path, "opening the device", ALREADY_INITIATED))
}

fn vendor_error(path: &Path, doing: &'static str, code: u16) -> HardwareError {
    let remedy = match code {
        0x0301 => {
            "another program uses the device: close that program, or unplug the device and plug it in again"
        }
        0x0302 => "the device does not answer; check its cable, power and pairing",
        0x0304 => "the library's timer failed; check the kernel's and the user's realtime limits",
        0x0600 => "the vendor's licence is missing or over; renew it",
        _ => "see the vendor's manual for the code",
    };
    HardwareError::Vendor {
        path: path.to_path_buf(),
        doing,
        code,
        remedy,
    }
}

/// Limits and workspace as the device reports them. Damping, delay and rate are constants of this
/// driver. The library uses mm.
fn capabilities(hd: &Hd) -> DeviceCapabilities {
    let one = |parameter| hd.doubles::<1>(parameter)[0] as f32;
    let [x0, y0, z0, x1, y1, z1] = hd.doubles::<6>(name::USABLE_WORKSPACE);
    // The radius is the largest coordinate of the usable box, not the radius of a sphere inside it.
    let farthest_mm = [x0, y0, z0, x1, y1, z1]
        .iter()
        .fold(0.0f64, |most, mm| most.max(mm.abs()));
    DeviceCapabilities {
        opening: Opening::NONE,
        force_max_n: one(name::MAX_FORCE),
        force_continuous_n: one(name::MAX_CONTINUOUS_FORCE),
        stiffness_max_n_m: one(name::MAX_STIFFNESS) * 1e3,
        damping_max_n_s_m: one(name::MAX_DAMPING) * 1e3,
        workspace_radius_m: farthest_mm as f32 * 1e-3,
        torque_max_nm: 0.0, // this driver sends none
        damping_n_s_m: super::DAMPING_N_S_M,
        delay_s: super::DELAY_S,
        rate_hz: RATE_HZ,
    }
}

/// Refuses limits that no Touch has. Otherwise a device that renders no force would be accepted.
fn check_limits(found: &DeviceCapabilities, path: &Path) -> Result<(), HardwareError> {
    let more = "more than 0";
    let checks = [
        ("force_max_n", found.force_max_n, f32::MAX, more),
        (
            "force_continuous_n",
            found.force_continuous_n,
            found.force_max_n,
            "more than 0, at most force_max_n",
        ),
        ("stiffness_max_n_m", found.stiffness_max_n_m, f32::MAX, more),
        (
            "workspace_radius_m",
            found.workspace_radius_m,
            WORKSPACE_MAX_M,
            "more than 0, at most 1.5",
        ),
    ];
    for (what, value, most, allowed) in checks {
        // The comparison is written so that NaN is refused too.
        if !(value > 0.0 && value <= most) {
            return Err(HardwareError::Capability {
                path: path.to_path_buf(),
                what,
                value,
                allowed,
            });
        }
    }
    Ok(())
}

/// The style to use, of those that the device offers (one bit each): the easiest for the person.
fn calibration_style(offered: u32) -> u32 {
    [
        name::CALIBRATION_AUTO,
        name::CALIBRATION_INKWELL,
        name::CALIBRATION_ENCODER_RESET,
    ]
    .into_iter()
    .find(|style| offered & style != 0)
    .unwrap_or(offered)
}

fn calibrate(hd: &Hd, device: u32, path: &Path) -> Result<(), HardwareError> {
    let style = calibration_style(hd.integer(name::CALIBRATION_STYLE) as u32);
    let mut state = 0;
    let mut code = 0;
    hd.in_servo(|| {
        hd.begin_frame(device);
        state = hd.check_calibration();
        if state == name::CALIBRATION_UPDATE {
            hd.update_calibration(style);
            state = hd.check_calibration();
        }
        hd.end_frame(device);
        code = hd.error();
    });
    if code != 0 && !LIMITS.contains(&code) {
        return Err(vendor_error(path, "calibrating", code));
    }
    if state == name::CALIBRATION_OK {
        return Ok(());
    }
    let remedy = match style {
        name::CALIBRATION_ENCODER_RESET => "Hold the stylus in its reset position",
        name::CALIBRATION_INKWELL => "Put the stylus into the inkwell",
        _ => "Move the stylus through its whole range, then rest it",
    };
    Err(HardwareError::Calibration {
        path: path.to_path_buf(),
        remedy,
    })
}

impl Servo for Shared {
    /// One callback on the vendor's thread: reads a sample and sets the force. Returns true to be
    /// called again.
    fn call(&self) -> bool {
        let hd = self.hd;
        let running = self.running.load(Ordering::Acquire);
        hd.begin_frame(self.device);
        let transform = hd.doubles::<16>(name::TRANSFORM);
        let velocity_mm_s = hd.doubles::<3>(name::VELOCITY);
        let buttons = hd.integer(name::BUTTONS);
        let force_n = if running {
            self.wanted_force_n()
        } else {
            [0.0; 3]
        };
        hd.set_force(&force_n);
        hd.end_frame(self.device);

        match sample_words(&transform, &velocity_mm_s, buttons) {
            Ok(mut words) => {
                let count = self.sample.read().map_or(0, |(_, words)| words[11]);
                words[11] = count.wrapping_add(1);
                self.sample.write(words);
            }
            Err(why) => {
                let [not_finite, not_rigid] = &self.bad_samples;
                let count = match why {
                    BadSample::NotFinite => not_finite,
                    BadSample::NotRigid => not_rigid,
                };
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
        match hd.error() {
            0 => {
                let callbacks = self.limited_callbacks.load(Ordering::Relaxed);
                let left = callbacks.saturating_sub(1);
                self.limited_callbacks.store(left, Ordering::Relaxed);
                running
            }
            code if LIMITS.contains(&code) => {
                self.limited_callbacks
                    .store(LIMITED_CALLBACKS, Ordering::Relaxed);
                running
            }
            code => {
                self.failed.store(code, Ordering::Release);
                false
            }
        }
    }
}

impl Shared {
    /// Newest force, clamped to the device's peak. Zero if there is none, if it is not finite, or
    /// if it is older than [`FORCE_AGE_NS`].
    fn wanted_force_n(&self) -> [f64; 3] {
        let Some((_, [x, y, z, low, high])) = self.force.read() else {
            return [0.0; 3];
        };
        let sent_ns = u64::from(low) | u64::from(high) << 32;
        if now_ns().saturating_sub(sent_ns) > FORCE_AGE_NS {
            return [0.0; 3];
        }
        let mut force_n = Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
        let norm = force_n.norm();
        if !norm.is_finite() {
            return [0.0; 3];
        }
        if norm > self.force_max_n {
            force_n *= self.force_max_n / norm;
        }
        [force_n.x, force_n.y, force_n.z].map(f64::from)
    }
}

/// Reasons to refuse a sample of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BadSample {
    /// A value is not finite.
    NotFinite,
    /// The pose is not rigid.
    NotRigid,
}

impl BadSample {
    /// Text for each reason, in the order of the variants. It follows a number.
    const NAMES: [&str; 2] = [
        "in which the library gave a value that is no number (NaN or infinite)",
        "whose pose is not rigid: its axes are not at right angles, or not of length 1",
    ];
}

/// A sample as words, or the reason to refuse it.
fn sample_words(
    transform: &[f64; 16],
    velocity_mm_s: &[f64; 3],
    buttons: i32,
) -> Result<[u32; 12], BadSample> {
    // Column-major, translation last, mm.
    let [a, b, c, _, d, e, f, _, g, h, i, _, x, y, z, _] = *transform;
    let rotation = Matrix3::new(a, d, g, b, e, h, c, f, i);
    let finite = transform
        .iter()
        .chain(velocity_mm_s)
        .all(|part| part.is_finite());
    if !finite {
        return Err(BadSample::NotFinite);
    }
    let off = (rotation * rotation.transpose() - Matrix3::identity()).norm();
    if off > 0.05 || rotation.determinant() < 0.0 {
        return Err(BadSample::NotRigid);
    }
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let [vx, vy, vz] = *velocity_mm_s;
    let metres = |mm: f64| (mm * 1e-3) as f32;
    let parts = [metres(x), metres(y), metres(z)]
        .into_iter()
        .chain([q.i, q.j, q.k, q.w].map(|part| part as f32))
        .chain([metres(vx), metres(vy), metres(vz)]);
    let mut words = [0; 12];
    for (word, part) in words.iter_mut().zip(parts) {
        *word = part.to_bits();
    }
    words[10] = buttons as u32;
    Ok(words)
}

impl HapticDevice for TouchHaptic {
    fn capabilities(&self) -> DeviceCapabilities {
        self.capabilities
    }

    fn identity(&self) -> Identity {
        Identity::new(self.identity.as_bytes(), 0)
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        self.motion.begin();
        if self.is_lost() {
            return Polled::Lost;
        }
        let Some((version, words)) = self.shared.sample.read() else {
            return Polled::Nothing;
        };
        if version == self.last_version {
            return Polled::Nothing;
        }
        // A sample that a newer one replaced before this poll does not count as lost on the line.
        self.last_version = version;
        self.counters.frames += 1;
        let [x, y, z, qx, qy, qz, qw, vx, vy, vz, ..] = words.map(f32::from_bits);
        let (at_m, reported_m_s) = (Vec3::new(x, y, z), Vec3::new(vx, vy, vz));
        let Some(velocity_m_s) = self.motion.take(at_m, reported_m_s, now_ns) else {
            return Polled::Nothing;
        };
        let rotation = Quat::new_unchecked(nalgebra::Quaternion::new(qw, qx, qy, qz));
        Polled::Fresh(DeviceSample {
            opening: None,
            device_from_handle: Pose::from_parts(at_m.into(), rotation),
            velocity_m_s: Some(velocity_m_s),
            buttons: Buttons(words[10] as u8),
            sequence: words[11] as u16,
            at_ns: now_ns,
        })
    }

    fn findings(&self) -> Findings {
        let mut findings = self.motion.findings();
        let is_limited = self.shared.limited_callbacks.load(Ordering::Relaxed) > 0;
        findings.faults.raise_if(is_limited, Fault::DeviceLimited);
        findings
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        let [x, y, z] = <[f32; 3]>::from(command.force_n).map(f32::to_bits);
        self.shared
            .force
            .write([x, y, z, now_ns as u32, (now_ns >> 32) as u32]);
    }

    fn counters(&self) -> LineCounters {
        let bad: u64 = self.bad_frames().map(|(_, count)| count).sum();
        LineCounters {
            bad_frames: bad + self.motion.leaps(),
            ..self.counters
        }
    }
}

impl Drop for TouchHaptic {
    /// Ends the service with a frame of zero force. The library stays loaded.
    fn drop(&mut self) {
        self.shared.running.store(false, Ordering::Release);
        self.hd.unschedule(self.schedule);
        // Zero force again, in case the callback was removed before it saw that `running` is false.
        let (hd, device) = (self.hd, self.device);
        hd.in_servo(|| {
            hd.begin_frame(device);
            hd.set_force(&[0.0; 3]);
            hd.end_frame(device);
        });
        hd.stop_scheduler();
        hd.disable_device(device);
        ACCESS.release();
    }
}
