//! The part of the DHD API that Calot uses.
//!
//! Symbols and numbers are those of `dhdc.h` 3.7; later versions only add some. Every function is a
//! C function. It takes plain numbers and pointers to numbers, and any thread may call it. `bool`
//! is one byte.
#![allow(unsafe_code)] // All calls into Force Dimension's library are here.

use std::ffi::{CStr, c_char, c_int, c_uchar, c_uint, c_ushort};
use std::path::Path;

use libloading::os::unix::{Library, RTLD_LAZY, RTLD_LOCAL};

use crate::HardwareError;
use crate::vendor::{Product, incomplete, refused, symbols};

/// Remedies for a person whose library is refused.
const PRODUCT: Product = Product {
    wrong_version: "Calot needs the Force Dimension SDK 3.7 or newer: install it (forcedimension.com/software/sdk)",
    missing: "Install the Force Dimension SDK (forcedimension.com/software/sdk) and run `sudo ldconfig DIR` on \
              its folder lib/release/…, or name its libdhd.so.3 as `path`",
    broken: "Install the Force Dimension SDK again (forcedimension.com/software/sdk), or name another libdhd.so.3",
    not_a_library: "Name the library itself, e.g. libdhd.so.3 in the SDK's folder lib/release/…",
};

/// Length of the array for the status. The API has 17 entries; newer versions may have more.
const STATUS_MAX: usize = 64;
/// Index of the status entry for a device that waits for its calibration.
const RESET: usize = 3;
/// Index of the status entry for motors that are free.
const IDLE: usize = 4;
/// Index of the status entry for motors that render force.
const FORCE: usize = 5;
/// Index of the status entry for motors that brake.
const BRAKE: usize = 6;
/// Index of the status entry for a wrist that has found its zero.
const WRIST_INIT: usize = 12;
/// Mode in which the library computes velocity from the present position and the position a window
/// ago. The library has no other mode.
const WINDOWING: c_int = 0;

symbols! { Dhd {
    device_count = b"dhdGetDeviceCount\0": fn() -> c_int;
    open = b"dhdOpen\0": fn() -> c_int;
    open_serial = b"dhdOpenSerial\0": fn(c_int) -> c_int;
    close = b"dhdClose\0": fn(c_char) -> c_int;
    stop = b"dhdStop\0": fn(c_char) -> c_int;
    enable_force = b"dhdEnableForce\0": fn(c_uchar, c_char) -> c_int;
    system_type = b"dhdGetSystemType\0": fn(c_char) -> c_int;
    system_name = b"dhdGetSystemName\0": fn(c_char) -> *const c_char;
    serial_number = b"dhdGetSerialNumber\0": fn(*mut c_ushort, c_char) -> c_int;
    status = b"dhdGetStatus\0": fn(*mut c_int, c_char) -> c_int;
    button_mask = b"dhdGetButtonMask\0": fn(c_char) -> c_uint;
    is_left_handed = b"dhdIsLeftHanded\0": fn(c_char) -> c_uchar;
    has_wrist = b"dhdHasWrist\0": fn(c_char) -> c_uchar;
    has_active_wrist = b"dhdHasActiveWrist\0": fn(c_char) -> c_uchar;
    has_gripper = b"dhdHasGripper\0": fn(c_char) -> c_uchar;
    has_active_gripper = b"dhdHasActiveGripper\0": fn(c_char) -> c_uchar;
    position = b"dhdGetPosition\0": fn(*mut f64, *mut f64, *mut f64, c_char) -> c_int;
    pose = b"dhdGetPositionAndOrientationFrame\0": fn(*mut f64, *mut f64, *mut f64, *mut f64, c_char) -> c_int;
    configure_velocity = b"dhdConfigLinearVelocity\0": fn(c_int, c_int, c_char) -> c_int;
    velocity = b"dhdGetLinearVelocity\0": fn(*mut f64, *mut f64, *mut f64, c_char) -> c_int;
    gripper_angle = b"dhdGetGripperAngleDeg\0": fn(*mut f64, c_char) -> c_int;
    set_force = b"dhdSetForceAndTorqueAndGripperForce\0": fn(f64, f64, f64, f64, f64, f64, f64, c_char) -> c_int;
    last_error = b"dhdErrorGetLast\0": fn() -> c_int;
} }

impl Dhd {
    /// Loads the library, which is never unloaded.
    pub(super) fn load(path: &Path) -> Result<&'static Self, HardwareError> {
        let failed = |error: libloading::Error| refused(path, &error.to_string(), &PRODUCT);
        // SAFETY: the vendor's initialisers run; the person who names a library trusts it.
        let library =
            unsafe { Library::open(Some(path), RTLD_LAZY | RTLD_LOCAL) }.map_err(failed)?;
        let table =
            Self::find(&library).map_err(|error| incomplete(path, &error.to_string(), &PRODUCT))?;
        // The library is never closed, because its threads may outlive the driver.
        std::mem::forget(library);
        Ok(Box::leak(Box::new(table)))
    }

    /// Number of devices on this computer, including those in use by other programs.
    pub(super) fn device_count(&self) -> i32 {
        // SAFETY: no arguments.
        unsafe { (self.device_count)() }
    }

    /// Opens the device with this serial number, or the first one that is free. `Err` holds the
    /// library's error code.
    pub(super) fn open(&'static self, serial: Option<u16>) -> Result<Handle, i32> {
        let id = match serial {
            // SAFETY: plain numbers.
            Some(serial) => unsafe { (self.open_serial)(c_int::from(serial)) },
            // SAFETY: no arguments.
            None => unsafe { (self.open)() },
        };
        match i8::try_from(id) {
            Ok(id @ 0..) => Ok(Handle {
                dhd: self,
                id: id as c_char,
            }),
            _ => Err(self.last_error()),
        }
    }

    /// Last error of this thread.
    pub(super) fn last_error(&self) -> i32 {
        // SAFETY: no arguments.
        unsafe { (self.last_error)() }
    }
}

/// An open device. Dropping the handle closes the device.
#[derive(Debug)]
pub(super) struct Handle {
    dhd: &'static Dhd,
    id: c_char,
}

/// State of the device's controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Status {
    /// The device waits for its calibration.
    pub(super) is_reset: bool,
    /// The motors are free or short-circuited, because a button on the device, its own speed limit,
    /// its watchdog or its deadman's switch has removed the force.
    pub(super) is_forceless: bool,
    /// The wrist has found its zero.
    pub(super) is_wrist_ready: bool,
}

/// Parts of the device.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts {
    pub(super) has_wrist: bool,
    pub(super) has_active_wrist: bool,
    pub(super) has_gripper: bool,
    pub(super) has_active_gripper: bool,
    pub(super) is_left_handed: bool,
}

impl Handle {
    /// Number of the model.
    pub(super) fn model(&self) -> i32 {
        // SAFETY: plain numbers.
        unsafe { (self.dhd.system_type)(self.id) }
    }

    /// Name of the model.
    pub(super) fn name(&self) -> String {
        // SAFETY: plain numbers.
        let text = unsafe { (self.dhd.system_name)(self.id) };
        if text.is_null() {
            return "device without a name".to_owned();
        }
        // SAFETY: not null, and the API returns zero-terminated strings that stay valid.
        unsafe { CStr::from_ptr(text) }
            .to_string_lossy()
            .into_owned()
    }

    pub(super) fn serial(&self) -> Option<u16> {
        let mut serial = 0;
        // SAFETY: the library writes one number.
        let code = unsafe { (self.dhd.serial_number)(&raw mut serial, self.id) };
        (code >= 0).then_some(serial)
    }

    pub(super) fn parts(&self) -> Parts {
        // SAFETY: plain numbers.
        let has = |ask: unsafe extern "C" fn(c_char) -> c_uchar| unsafe { ask(self.id) } != 0;
        Parts {
            has_wrist: has(self.dhd.has_wrist),
            has_active_wrist: has(self.dhd.has_active_wrist),
            has_gripper: has(self.dhd.has_gripper),
            has_active_gripper: has(self.dhd.has_active_gripper),
            is_left_handed: has(self.dhd.is_left_handed),
        }
    }

    pub(super) fn status(&self) -> Option<Status> {
        let mut entries = [0; STATUS_MAX];
        // SAFETY: the library writes as many numbers as its status has, 17 in version 3.14.
        let code = unsafe { (self.dhd.status)(entries.as_mut_ptr(), self.id) };
        let is = |entry: usize| entries[entry] != 0;
        (code >= 0).then(|| Status {
            is_reset: is(RESET),
            // The modes reset, idle, force and brake exclude each other. A status without any mode
            // does not count as forceless.
            is_forceless: !is(FORCE) && (is(RESET) || is(IDLE) || is(BRAKE)),
            is_wrist_ready: is(WRIST_INIT),
        })
    }

    pub(super) fn enable_force(&self) -> bool {
        // SAFETY: plain numbers.
        unsafe { (self.dhd.enable_force)(1, self.id) >= 0 }
    }

    /// Takes the force from the motors and brakes them.
    pub(super) fn stop(&self) {
        // SAFETY: plain numbers.
        let _ = unsafe { (self.dhd.stop)(self.id) };
    }

    /// Sets the time over which the library averages the velocity.
    pub(super) fn configure_velocity(&self, window_ms: i32) {
        // SAFETY: plain numbers.
        let _ = unsafe { (self.dhd.configure_velocity)(window_ms, WINDOWING, self.id) };
    }

    /// Position, m, of a device without a wrist.
    pub(super) fn position(&self) -> Option<[f64; 3]> {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        // SAFETY: the library writes one number to each.
        let code = unsafe { (self.dhd.position)(&raw mut x, &raw mut y, &raw mut z, self.id) };
        (code >= 0).then_some([x, y, z])
    }

    /// Position, m, and rotation matrix, row by row, of a device with a wrist.
    pub(super) fn pose(&self) -> Option<([f64; 3], [f64; 9])> {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        let mut rows = [f64::NAN; 9];
        let to = rows.as_mut_ptr();
        // SAFETY: the library writes one number to each, and nine to the matrix.
        let code = unsafe { (self.dhd.pose)(&raw mut x, &raw mut y, &raw mut z, to, self.id) };
        (code >= 0).then_some(([x, y, z], rows))
    }

    /// Velocity, m/s; `None` before the library has two positions.
    pub(super) fn velocity(&self) -> Option<[f64; 3]> {
        let [mut x, mut y, mut z] = [f64::NAN; 3];
        // SAFETY: the library writes one number to each.
        let code = unsafe { (self.dhd.velocity)(&raw mut x, &raw mut y, &raw mut z, self.id) };
        (code >= 0).then_some([x, y, z])
    }

    /// Angle of the gripper, degrees.
    pub(super) fn gripper_deg(&self) -> Option<f64> {
        let mut angle = f64::NAN;
        // SAFETY: the library writes one number.
        let code = unsafe { (self.dhd.gripper_angle)(&raw mut angle, self.id) };
        (code >= 0).then_some(angle)
    }

    /// Buttons pressed, one bit each. `None` if all bits are set, which stands for an error.
    pub(super) fn buttons(&self) -> Option<u32> {
        // SAFETY: plain numbers.
        Some(unsafe { (self.dhd.button_mask)(self.id) }).filter(|mask| *mask != c_uint::MAX)
    }

    /// Sets force, N, torque, N m, and the gripper's force, N. True if the device took these
    /// values, even if its motors cannot render all of them.
    pub(super) fn set_force(&self, force: [f64; 3], torque: [f64; 3], gripper: f64) -> bool {
        let ([fx, fy, fz], [tx, ty, tz]) = (force, torque);
        // SAFETY: plain numbers.
        unsafe { (self.dhd.set_force)(fx, fy, fz, tx, ty, tz, gripper, self.id) >= 0 }
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: plain numbers; nobody has the number of the device after this.
        let _ = unsafe { (self.dhd.close)(self.id) };
    }
}
