//! A stand-in for Force Dimension's `libdhd.so.3`, which the test builds with `rustc`. It has the
//! same symbols and one device, whose state is a row of numbers. Extra symbols let the test write
//! and read these numbers.
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uchar, c_uint, c_ushort};
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};
use std::time::Duration;

// Indices of the numbers of the device's state, as in `tests/devices/fake_dhd.rs`.
const POSITION: usize = 0; // 3
const VELOCITY: usize = 3; // 3
const ANGLE: usize = 6;
const BUTTONS: usize = 7;
const COUNT: usize = 8;
const OPEN_ERROR: usize = 9;
const HANGS: usize = 10;
const EXITS: usize = 11;
const MODEL: usize = 12;
const PARTS: usize = 13;
const RESET: usize = 14;
const FORCE_MODE: usize = 15;
const WRIST_READY: usize = 16;
const READ_ERROR: usize = 17;
const NOISY: usize = 18;
const NO_VELOCITY: usize = 19;
const TURNED: usize = 20;
const FORCE: usize = 21; // 7
const STOPS: usize = 28;
const CLOSES: usize = 29;
const FORCE_ERROR: usize = 30;
const WINDOW_MS: usize = 31;
const STEP: usize = 32;

static STATE: [AtomicU64; 40] = [const { AtomicU64::new(0) }; 40];
static LAST_ERROR: AtomicU64 = AtomicU64::new(0);

const ID: c_int = 3;
const SERIAL: c_int = 10432;

fn get(what: usize) -> f64 {
    f64::from_bits(STATE[what].load(SeqCst))
}

fn set(what: usize, value: f64) {
    STATE[what].store(value.to_bits(), SeqCst);
}

fn is(what: usize) -> bool {
    get(what) != 0.0
}

fn answer(error: f64) -> c_int {
    while is(HANGS) {
        std::thread::sleep(Duration::from_millis(1));
    }
    if error == 0.0 {
        return 0;
    }
    LAST_ERROR.store(error as u64, SeqCst);
    -1
}

fn part(bit: u32) -> c_uchar {
    u8::from(get(PARTS) as u32 >> bit & 1 != 0)
}

#[unsafe(no_mangle)]
pub extern "C" fn fake_set(what: u32, value: f64) {
    set(what as usize, value);
}

#[unsafe(no_mangle)]
pub extern "C" fn fake_get(what: u32) -> f64 {
    get(what as usize)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdGetDeviceCount() -> c_int {
    if is(EXITS) {
        std::process::exit(3);
    }
    get(COUNT) as c_int
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdOpen() -> c_int {
    match answer(get(OPEN_ERROR)) {
        0 => ID,
        failed => failed,
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdOpenSerial(serial: c_int) -> c_int {
    let error = if serial == SERIAL { get(OPEN_ERROR) } else { 5.0 };
    match answer(error) {
        0 => ID,
        failed => failed,
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdClose(id: c_char) -> c_int {
    assert_eq!(c_int::from(id), ID);
    set(CLOSES, get(CLOSES) + 1.0);
    set(FORCE_MODE, 0.0);
    answer(0.0)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdStop(_id: c_char) -> c_int {
    set(STOPS, get(STOPS) + 1.0);
    set(FORCE_MODE, 0.0);
    answer(0.0)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdEnableForce(on: c_uchar, _id: c_char) -> c_int {
    set(FORCE_MODE, f64::from(on));
    answer(get(FORCE_ERROR))
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdGetSystemType(_id: c_char) -> c_int {
    get(MODEL) as c_int
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdGetSystemName(_id: c_char) -> *const c_char {
    b"fake.7\0".as_ptr().cast()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetSerialNumber(serial: *mut c_ushort, _id: c_char) -> c_int {
    unsafe { serial.write(SERIAL as c_ushort) };
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetStatus(status: *mut c_int, _id: c_char) -> c_int {
    let mut entries = [0; 17];
    entries[0] = 1; // power
    if is(NOISY) {
        println!("DHD: noise");
        eprintln!("DHD: noise");
    }
    entries[3] = c_int::from(is(RESET));
    entries[5] = c_int::from(is(FORCE_MODE) && !is(RESET));
    entries[6] = c_int::from(!is(FORCE_MODE) && !is(RESET));
    entries[12] = c_int::from(is(WRIST_READY));
    for (at, entry) in entries.iter().enumerate() {
        unsafe { status.add(at).write(*entry) };
    }
    answer(0.0)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdGetButtonMask(_id: c_char) -> c_uint {
    get(BUTTONS) as c_uint
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdIsLeftHanded(_id: c_char) -> c_uchar {
    part(0)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdHasWrist(_id: c_char) -> c_uchar {
    part(1)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdHasActiveWrist(_id: c_char) -> c_uchar {
    part(2)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdHasGripper(_id: c_char) -> c_uchar {
    part(3)
}

#[cfg(not(old))]
#[unsafe(no_mangle)]
pub extern "C" fn dhdHasActiveGripper(_id: c_char) -> c_uchar {
    part(4)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetPosition(
    x: *mut f64,
    y: *mut f64,
    z: *mut f64,
    _id: c_char,
) -> c_int {
    unsafe {
        x.write(get(POSITION));
        y.write(get(POSITION + 1));
        z.write(get(POSITION + 2));
    }
    answer(get(READ_ERROR))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetPositionAndOrientationFrame(
    x: *mut f64,
    y: *mut f64,
    z: *mut f64,
    matrix: *mut f64,
    id: c_char,
) -> c_int {
    let rows = match is(TURNED) {
        // A quarter turn about the library's z, up: its x becomes its y.
        true => [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        false => [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    };
    for (at, value) in rows.iter().enumerate() {
        unsafe { matrix.add(at).write(*value) };
    }
    unsafe { dhdGetPosition(x, y, z, id) }
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdConfigLinearVelocity(ms: c_int, _mode: c_int, _id: c_char) -> c_int {
    set(WINDOW_MS, f64::from(ms));
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetLinearVelocity(
    x: *mut f64,
    y: *mut f64,
    z: *mut f64,
    _id: c_char,
) -> c_int {
    unsafe {
        x.write(get(VELOCITY));
        y.write(get(VELOCITY + 1));
        z.write(get(VELOCITY + 2));
    }
    answer(if is(NO_VELOCITY) { 7.0 } else { 0.0 })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn dhdGetGripperAngleDeg(angle: *mut f64, _id: c_char) -> c_int {
    unsafe { angle.write(get(ANGLE)) };
    answer(0.0)
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdSetForceAndTorqueAndGripperForce(
    fx: f64,
    fy: f64,
    fz: f64,
    tx: f64,
    ty: f64,
    tz: f64,
    gripper: f64,
    _id: c_char,
) -> c_int {
    for (at, value) in [fx, fy, fz, tx, ty, tz, gripper].into_iter().enumerate() {
        set(STEP, get(STEP).max((value - get(FORCE + at)).abs()));
        set(FORCE + at, value);
    }
    match answer(get(FORCE_ERROR)) {
        0 => 2, // motors saturated: no error
        failed => failed,
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn dhdErrorGetLast() -> c_int {
    LAST_ERROR.load(SeqCst) as c_int
}
