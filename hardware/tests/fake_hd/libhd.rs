//! A stand-in for the vendor's `libHD.so`, which the test builds with `rustc`. It has the same
//! symbols, a thread that calls back a thousand times a second, and a handle that moves on a
//! circle. Extra symbols let the test make it fail and read the motors.
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_ushort, c_void};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::SeqCst};
use std::time::{Duration, Instant};

type Callback = unsafe extern "C" fn(*mut c_void) -> c_uint;

#[repr(C)]
pub struct ErrorInfo {
    code: u32,
    internal: c_int,
    device: c_uint,
}

#[derive(Clone, Copy)]
struct Job {
    call: Callback,
    data: usize,
    handle: u64,
}

static ERROR: AtomicU32 = AtomicU32::new(0);
static INIT_FAILURES: AtomicU32 = AtomicU32::new(0);
static INIT_ERROR: AtomicU32 = AtomicU32::new(0);
static HANGING: AtomicBool = AtomicBool::new(false);
static EXITING: AtomicBool = AtomicBool::new(false);
static FORCELESS: AtomicBool = AtomicBool::new(false);
static CALIBRATION: AtomicU32 = AtomicU32::new(0x5000);
/// Ways in which the device can be calibrated, a bit each. 4: in the inkwell.
static CALIBRATION_STYLES: AtomicU32 = AtomicU32::new(4);
static BROKEN_POSE: AtomicBool = AtomicBool::new(false);
static FORCE: Mutex<[f64; 3]> = Mutex::new([0.0; 3]);
static FORCE_ENABLED: AtomicBool = AtomicBool::new(false);
static JOB: Mutex<Option<Job>> = Mutex::new(None);
static SCHEDULING: AtomicBool = AtomicBool::new(false);
static STARTS: AtomicU32 = AtomicU32::new(0);
static TICKS: AtomicU64 = AtomicU64::new(0);
static FRAME: AtomicBool = AtomicBool::new(false);

#[unsafe(no_mangle)]
pub extern "C" fn hdInitDevice(_name: *const c_char) -> c_uint {
    while HANGING.load(SeqCst) {
        std::thread::sleep(Duration::from_millis(1));
    }
    if EXITING.load(SeqCst) {
        std::process::exit(3);
    }
    if INIT_FAILURES.load(SeqCst) > 0 {
        INIT_FAILURES.fetch_sub(1, SeqCst);
        ERROR.store(INIT_ERROR.load(SeqCst), SeqCst);
        return 0xDEAD; // garbage, as the real one does
    }
    7
}
#[unsafe(no_mangle)]
pub extern "C" fn hdMakeCurrentDevice(_device: c_uint) {}
#[unsafe(no_mangle)]
pub extern "C" fn hdDisableDevice(_device: c_uint) {
    FORCE_ENABLED.store(false, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn hdBeginFrame(_device: c_uint) {
    FRAME.store(true, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn hdEndFrame(_device: c_uint) {
    FRAME.store(false, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn hdEnable(what: c_uint) {
    FORCE_ENABLED.store(what == 0x4000, SeqCst);
}
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hdGetIntegerv(what: c_uint, out: *mut c_int) {
    let value = match what {
        0x2000 => 1, // buttons
        0x2554 => 3, // degrees of freedom out
        0x2555 => CALIBRATION_STYLES.load(SeqCst) as c_int,
        _ => 0,
    };
    unsafe { out.write(value) };
}
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hdGetDoublev(what: c_uint, out: *mut f64) {
    let angle = TICKS.load(SeqCst) as f64 * 0.001;
    let values: Vec<f64> = match what {
        0x2051 => vec![-50.0 * angle.sin(), 50.0 * angle.cos(), 0.0],
        0x2052 if BROKEN_POSE.load(SeqCst) => vec![f64::NAN; 16],
        0x2052 => {
            // Turned 90° about z; column-major.
            let mut m = vec![
                0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.,
            ];
            m[12] = 50.0 * angle.cos();
            m[13] = 50.0 * angle.sin();
            m[14] = -10.0;
            m
        }
        0x2551 => vec![-80.0, -60.0, -35.0, 80.0, 60.0, 35.0],
        0x2602 => vec![0.7],
        0x2603 | 0x2604 if FORCELESS.load(SeqCst) => vec![0.0],
        0x2603 => vec![3.3],
        0x2604 => vec![0.88],
        0x2608 => vec![0.005],
        _ => vec![0.0],
    };
    for (at, value) in values.iter().enumerate() {
        unsafe { out.add(at).write(*value) };
    }
}
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hdSetDoublev(what: c_uint, values: *const f64) {
    assert!(
        what == 0x2700 && FRAME.load(SeqCst),
        "a force belongs into a frame"
    );
    *FORCE.lock().unwrap() = unsafe { [*values, *values.add(1), *values.add(2)] };
}
#[unsafe(no_mangle)]
pub extern "C" fn hdGetString(what: c_uint) -> *const c_char {
    let text: &[u8] = if what == 0x2501 {
        b"Fake Touch\0"
    } else {
        b"12345\0"
    };
    text.as_ptr().cast()
}
#[unsafe(no_mangle)]
pub extern "C" fn hdGetError() -> ErrorInfo {
    ErrorInfo {
        code: ERROR.swap(0, SeqCst),
        internal: -1,
        device: 7,
    }
}
#[unsafe(no_mangle)]
pub extern "C" fn hdCheckCalibration() -> c_uint {
    CALIBRATION.load(SeqCst)
}
#[unsafe(no_mangle)]
pub extern "C" fn hdUpdateCalibration(_style: c_uint) {
    CALIBRATION.store(0x5000, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn hdStartScheduler() {
    if SCHEDULING.swap(true, SeqCst) {
        return;
    }
    // A thread that slept through a stop and a start must not run next to the new one.
    let own = STARTS.fetch_add(1, SeqCst) + 1;
    std::thread::spawn(move || {
        let mut due = Instant::now();
        while SCHEDULING.load(SeqCst) && STARTS.load(SeqCst) == own {
            TICKS.fetch_add(1, SeqCst);
            let mut job = JOB.lock().unwrap();
            if let Some(now) = *job {
                if unsafe { (now.call)(now.data as *mut c_void) } == 0 {
                    *job = None;
                }
            }
            drop(job);
            // Like the real scheduler, this one keeps its mean rate. It catches up after delays of
            // up to 5 ms.
            due = (due + Duration::from_millis(1)).max(Instant::now() - Duration::from_millis(5));
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    });
}
#[unsafe(no_mangle)]
pub extern "C" fn hdStopScheduler() {
    SCHEDULING.store(false, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn hdScheduleAsynchronous(
    call: Callback,
    data: *mut c_void,
    _priority: c_ushort,
) -> u64 {
    *JOB.lock().unwrap() = Some(Job {
        call,
        data: data as usize,
        handle: 42,
    });
    42
}
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hdScheduleSynchronous(
    call: Callback,
    data: *mut c_void,
    _priority: c_ushort,
) {
    let _alone = JOB.lock().unwrap();
    while unsafe { call(data) } == 1 {}
}
#[unsafe(no_mangle)]
pub extern "C" fn hdUnschedule(handle: u64) {
    let mut job = JOB.lock().unwrap();
    if job.is_some_and(|job| job.handle == handle) {
        *job = None;
    }
}

// Controls for the test.

#[unsafe(no_mangle)]
pub extern "C" fn fake_fail_init(times: u32, code: u32) {
    INIT_ERROR.store(code, SeqCst);
    INIT_FAILURES.store(times, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_raise(code: u32) {
    ERROR.store(code, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_calibration(state: u32) {
    CALIBRATION.store(state, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_calibration_styles(styles: u32) {
    CALIBRATION_STYLES.store(styles, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_break_pose(broken: u32) {
    BROKEN_POSE.store(broken != 0, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_hang(hanging: u32) {
    HANGING.store(hanging != 0, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_exit(exiting: u32) {
    EXITING.store(exiting != 0, SeqCst);
}
#[unsafe(no_mangle)]
pub extern "C" fn fake_forceless(forceless: u32) {
    FORCELESS.store(forceless != 0, SeqCst);
}
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fake_force(out: *mut f64) {
    let force = *FORCE.lock().unwrap();
    for (at, value) in force.iter().enumerate() {
        unsafe { out.add(at).write(*value) };
    }
}
