//! The part of the HD API that Calot uses: symbols, numbers, and the two callbacks.
//!
//! Symbols and numbers are those of OpenHaptics 3.4. Every function is a C function. It takes and
//! returns plain numbers and pointers to arrays of a stated length, and any thread may call it.
//! Frames may be used only in the scheduler's callbacks.
#![allow(unsafe_code)] // All calls into the vendor's library are here.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_ushort, c_void};
use std::path::Path;

use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_LAZY};

use crate::HardwareError;
use crate::vendor::{Product, incomplete, refused, symbols};

/// Remedies for a person whose library is refused.
const PRODUCT: Product = Product {
    wrong_version: "Calot needs OpenHaptics 3.4: install that version (`ldd -r` on the library lists what it lacks)",
    missing: "Install the vendor's driver, or name its library in the station file",
    broken: "Install the vendor's driver again, or name its library in the station file",
    not_a_library: "Name the library itself, e.g. libHD.so.3.4 beside it",
};

/// Numbers of parameters, capabilities and answers.
pub(super) mod name {
    pub(in crate::touch) const BUTTONS: u32 = 0x2000;
    pub(in crate::touch) const VELOCITY: u32 = 0x2051;
    pub(in crate::touch) const TRANSFORM: u32 = 0x2052;
    pub(in crate::touch) const MODEL: u32 = 0x2501;
    pub(in crate::touch) const SERIAL: u32 = 0x2504;
    pub(in crate::touch) const USABLE_WORKSPACE: u32 = 0x2551;
    pub(in crate::touch) const CALIBRATION_STYLE: u32 = 0x2555;
    pub(in crate::touch) const MAX_STIFFNESS: u32 = 0x2602;
    pub(in crate::touch) const MAX_FORCE: u32 = 0x2603;
    pub(in crate::touch) const MAX_CONTINUOUS_FORCE: u32 = 0x2604;
    pub(in crate::touch) const MAX_DAMPING: u32 = 0x2608;
    pub(in crate::touch) const FORCE: u32 = 0x2700;
    pub(in crate::touch) const FORCE_OUTPUT: u32 = 0x4000;
    pub(in crate::touch) const CALIBRATION_ENCODER_RESET: u32 = 1;
    pub(in crate::touch) const CALIBRATION_AUTO: u32 = 2;
    pub(in crate::touch) const CALIBRATION_INKWELL: u32 = 4;
    pub(in crate::touch) const CALIBRATION_OK: u32 = 0x5000;
    pub(in crate::touch) const CALIBRATION_UPDATE: u32 = 0x5001;
}

/// Return value of a callback that must be called again.
pub(super) const CONTINUE: u32 = 1;
/// Return value of a callback that is done.
pub(super) const DONE: u32 = 0;
/// Highest priority of the scheduler.
const PRIORITY: c_ushort = 0xFFFF;

/// Last error of the library. `errorCode` is 16 or 32 bits wide, depending on the header; the lower
/// 16 bits agree, and no code needs more.
#[repr(C)]
#[derive(Clone, Copy)]
struct ErrorInfo {
    code: u16,
    _padding: u16,
    _internal: c_int,
    _device: c_uint,
}

type Callback = unsafe extern "C" fn(*mut c_void) -> c_uint;

symbols! { Hd {
    init_device = b"hdInitDevice\0": fn(*const c_char) -> c_uint;
    make_current = b"hdMakeCurrentDevice\0": fn(c_uint);
    disable_device = b"hdDisableDevice\0": fn(c_uint);
    begin_frame = b"hdBeginFrame\0": fn(c_uint);
    end_frame = b"hdEndFrame\0": fn(c_uint);
    enable = b"hdEnable\0": fn(c_uint);
    get_integers = b"hdGetIntegerv\0": fn(c_uint, *mut c_int);
    get_doubles = b"hdGetDoublev\0": fn(c_uint, *mut f64);
    set_doubles = b"hdSetDoublev\0": fn(c_uint, *const f64);
    get_string = b"hdGetString\0": fn(c_uint) -> *const c_char;
    get_error = b"hdGetError\0": fn() -> ErrorInfo;
    check_calibration = b"hdCheckCalibration\0": fn() -> c_uint;
    update_calibration = b"hdUpdateCalibration\0": fn(c_uint);
    start_scheduler = b"hdStartScheduler\0": fn();
    stop_scheduler = b"hdStopScheduler\0": fn();
    schedule_asynchronous = b"hdScheduleAsynchronous\0": fn(Callback, *mut c_void, c_ushort) -> u64;
    schedule_synchronous = b"hdScheduleSynchronous\0": fn(Callback, *mut c_void, c_ushort);
    unschedule = b"hdUnschedule\0": fn(u64);
} }

/// Callback of the scheduler's thread. `call` returns true to be called again.
pub(super) trait Servo: Sync {
    /// One frame.
    fn call(&self) -> bool;
}

unsafe extern "C" fn servo<S: Servo>(data: *mut c_void) -> c_uint {
    // SAFETY: `data` is the `&'static S` that `schedule` was given; it is shared, never unique.
    let servo = unsafe { &*data.cast::<S>() };
    if servo.call() { CONTINUE } else { DONE }
}

unsafe extern "C" fn once<F: FnMut()>(data: *mut c_void) -> c_uint {
    // SAFETY: `data` is the `&mut F` of `in_servo`, which waits until this has returned.
    let work = unsafe { &mut *data.cast::<F>() };
    work();
    DONE
}

impl Hd {
    /// Loads the library, which is never unloaded. A second call finds the library loaded.
    pub(super) fn load(path: &Path) -> Result<&'static Self, HardwareError> {
        let failed = |error: libloading::Error| refused(path, &error.to_string(), &PRODUCT);
        // SAFETY: the vendor's initialisers run; the person who names a library trusts it.
        let library =
            unsafe { Library::open(Some(path), RTLD_LAZY | RTLD_GLOBAL) }.map_err(failed)?;
        let table =
            Self::find(&library).map_err(|error| incomplete(path, &error.to_string(), &PRODUCT))?;
        // The library is never closed, because the vendor's driver fails when it is loaded again.
        std::mem::forget(library);
        Ok(Box::leak(Box::new(table)))
    }

    /// Opens a device; without a name the vendor's default one.
    pub(super) fn init_device(&self, device: Option<&CString>) -> u32 {
        let name = device.map_or(std::ptr::null(), |name| name.as_ptr());
        // SAFETY: the name is a string or null, which the API allows.
        unsafe { (self.init_device)(name) }
    }

    pub(super) fn make_current(&self, device: u32) {
        // SAFETY: plain numbers.
        unsafe { (self.make_current)(device) }
    }

    pub(super) fn disable_device(&self, device: u32) {
        // SAFETY: plain numbers.
        unsafe { (self.disable_device)(device) }
    }

    pub(super) fn begin_frame(&self, device: u32) {
        // SAFETY: plain numbers.
        unsafe { (self.begin_frame)(device) }
    }

    pub(super) fn end_frame(&self, device: u32) {
        // SAFETY: plain numbers.
        unsafe { (self.end_frame)(device) }
    }

    pub(super) fn enable_force(&self) {
        // SAFETY: plain numbers.
        unsafe { (self.enable)(name::FORCE_OUTPUT) }
    }

    /// A parameter of one integer.
    pub(super) fn integer(&self, parameter: u32) -> i32 {
        // Longer than any parameter, in case one has more numbers than the manual states.
        let mut values = [0; 32];
        // SAFETY: the library writes as many numbers as the parameter has, at most 16.
        unsafe { (self.get_integers)(parameter, values.as_mut_ptr()) };
        values[0]
    }

    /// A parameter of up to sixteen numbers.
    pub(super) fn doubles<const N: usize>(&self, parameter: u32) -> [f64; N] {
        let mut values = [0.0; 32];
        // SAFETY: the library writes as many numbers as the parameter has, at most 16.
        unsafe { (self.get_doubles)(parameter, values.as_mut_ptr()) };
        std::array::from_fn(|at| values.get(at).copied().unwrap_or(0.0))
    }

    /// Sets the force of the present frame, N.
    pub(super) fn set_force(&self, force_n: &[f64; 3]) {
        // SAFETY: the force has three numbers.
        unsafe { (self.set_doubles)(name::FORCE, force_n.as_ptr()) }
    }

    /// A parameter of text.
    pub(super) fn string(&self, parameter: u32) -> String {
        // SAFETY: plain numbers.
        let text = unsafe { (self.get_string)(parameter) };
        if text.is_null() {
            return String::new();
        }
        // SAFETY: not null, and the API returns zero-terminated strings that stay valid.
        unsafe { CStr::from_ptr(text) }
            .to_string_lossy()
            .into_owned()
    }

    /// Takes the newest error off the library's stack; 0 if there is none.
    pub(super) fn error(&self) -> u16 {
        // SAFETY: no arguments.
        unsafe { (self.get_error)() }.code
    }

    pub(super) fn check_calibration(&self) -> u32 {
        // SAFETY: no arguments.
        unsafe { (self.check_calibration)() }
    }

    pub(super) fn update_calibration(&self, style: u32) {
        // SAFETY: plain numbers.
        unsafe { (self.update_calibration)(style) }
    }

    pub(super) fn start_scheduler(&self) {
        // SAFETY: no arguments.
        unsafe { (self.start_scheduler)() }
    }

    pub(super) fn stop_scheduler(&self) {
        // SAFETY: no arguments.
        unsafe { (self.stop_scheduler)() }
    }

    /// Calls `work` on the scheduler's thread, a thousand times a second, until `call` returns
    /// false.
    pub(super) fn schedule<S: Servo>(&self, work: &'static S) -> u64 {
        let data = std::ptr::from_ref(work).cast_mut().cast();
        // SAFETY: `servo::<S>` takes exactly this pointer, which lives for ever.
        unsafe { (self.schedule_asynchronous)(servo::<S>, data, PRIORITY) }
    }

    /// Runs `work` once on the scheduler's thread and waits for it.
    pub(super) fn in_servo<F: FnMut() + Send>(&self, mut work: F) {
        let data = std::ptr::from_mut(&mut work).cast();
        // SAFETY: `once::<F>` takes exactly this pointer, and the call returns after it.
        unsafe { (self.schedule_synchronous)(once::<F>, data, PRIORITY) }
    }

    /// Waits for the callback to end and removes it.
    pub(super) fn unschedule(&self, handle: u64) {
        // SAFETY: plain numbers.
        unsafe { (self.unschedule)(handle) }
    }
}
