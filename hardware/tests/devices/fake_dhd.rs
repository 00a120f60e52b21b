//! Controls the fake `libdhd.so.3` from a test.
#![allow(unsafe_code)] // the fake library's own symbols

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use hardware::HardwareError;
use hardware::dhd::DhdHaptic;
use libloading::Library;

use crate::support::{PATIENCE, build_library};

/// Indices of the device's state in the fake library.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Entry {
    Position = 0,
    Velocity = 3,
    Angle = 6,
    Buttons = 7,
    Count = 8,
    OpenError = 9,
    Hangs = 10,
    Exits = 11,
    Model = 12,
    Parts = 13,
    Reset = 14,
    ForceMode = 15,
    WristReady = 16,
    ReadError = 17,
    Noisy = 18,
    NoVelocity = 19,
    Turned = 20,
    Force = 21,
    Stops = 28,
    Closes = 29,
    ForceError = 30,
    /// Largest change of a force from one command to the next since this entry was last set, N or N
    /// m.
    Step = 32,
}

/// Bit of `Entry::Parts`: the device is for the left hand.
pub(crate) const LEFT: u32 = 1;
/// Bit of `Entry::Parts`: the device has a wrist.
pub(crate) const WRIST: u32 = 2;
/// Bit of `Entry::Parts`: the wrist has motors.
pub(crate) const ACTIVE_WRIST: u32 = 4;
/// Bit of `Entry::Parts`: the device has a gripper.
pub(crate) const GRIPPER: u32 = 8;
/// Bit of `Entry::Parts`: the gripper has a motor.
pub(crate) const ACTIVE_GRIPPER: u32 = 16;

/// A Falcon: number of the model, and its parts.
pub(crate) const FALCON: (u32, u32) = (60, 0);
/// An omega.7: number of the model, and its parts.
pub(crate) const OMEGA_7: (u32, u32) = (35, WRIST | GRIPPER | ACTIVE_GRIPPER);
/// A sigma.7: number of the model, and its parts.
pub(crate) const SIGMA_7: (u32, u32) = (104, OMEGA_7.1 | ACTIVE_WRIST);

/// The fake library. It has one device, so only one test may use it at a time.
pub(crate) struct Fake {
    pub(crate) path: PathBuf,
    set: extern "C" fn(u32, f64),
    get: extern "C" fn(u32) -> f64,
    _library: Library,
    _alone: MutexGuard<'static, ()>,
}

/// Environment variable with the path of the fake library. It is set only in the process that the
/// library ends.
pub(crate) const DOOMED: &str = "CALOT_TEST_DOOMED_DHD";

impl Fake {
    /// A healthy device of this model, at rest in the middle.
    pub(crate) fn new((model, parts): (u32, u32)) -> Self {
        static ALONE: Mutex<()> = Mutex::new(());
        static BUILT: OnceLock<PathBuf> = OnceLock::new();
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let path = BUILT
            .get_or_init(|| match std::env::var_os(DOOMED) {
                Some(built) => built.into(),
                None => build_library("dhd", "fake_dhd/libdhd.rs", &[]),
            })
            .clone();
        // SAFETY: our own library.
        let library = unsafe { Library::new(&path) }.expect("the fake library loads");
        // SAFETY: the fake's own symbols, of these types; the library lives as long as they.
        let (set, get) = unsafe {
            let set = library.get::<extern "C" fn(u32, f64)>(b"fake_set");
            let get = library.get::<extern "C" fn(u32) -> f64>(b"fake_get");
            (*set.expect("a symbol"), *get.expect("a symbol"))
        };
        let fake = Self {
            path,
            set,
            get,
            _library: library,
            _alone: alone,
        };
        (0..40).for_each(|number| (fake.set)(number, 0.0));
        fake.set(Entry::Model, f64::from(model));
        fake.set(Entry::Parts, f64::from(parts));
        fake.set(Entry::Count, 1.0);
        fake.set(Entry::WristReady, 1.0);
        fake.set(Entry::Angle, 30.0);
        fake
    }

    pub(crate) fn open(&self) -> Result<DhdHaptic, HardwareError> {
        DhdHaptic::open(&self.path, None)
    }

    pub(crate) fn set(&self, what: Entry, value: f64) {
        (self.set)(what as u32, value);
    }

    /// Sets three numbers: x, y and z in the library's axes.
    pub(crate) fn set3(&self, what: Entry, values: [f64; 3]) {
        for (at, value) in (what as u32..).zip(values) {
            (self.set)(at, value);
        }
    }

    pub(crate) fn get(&self, what: Entry) -> f64 {
        (self.get)(what as u32)
    }

    /// Force, torque and the gripper's force at the motors, in the library's axes.
    pub(crate) fn rendered(&self) -> [f64; 7] {
        let mut at = Entry::Force as u32..;
        [(); 7].map(|()| (self.get)(at.next().expect("endless")))
    }

    pub(crate) fn force_n(&self) -> f64 {
        let [x, y, z, ..] = self.rendered();
        (x * x + y * y + z * z).sqrt()
    }

    /// Opens the device as soon as the library is free again.
    pub(crate) fn open_once_free(&self) -> DhdHaptic {
        let start = Instant::now();
        loop {
            match self.open() {
                Ok(device) => return device,
                Err(error) => assert!(start.elapsed() < PATIENCE, "{error}"),
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }
}
