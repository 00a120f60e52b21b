//! An emulated station in a directory of its own, and a patient polling loop.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::emulate::{
    EmulateConfig, HandScript, HapticModel, Holding, LineFaults, Lines, Mistake, run, run_watched,
};
use nalgebra::{Translation3, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use tempfile::TempDir;

/// State of the emulated devices.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DeviceStates {
    pub(crate) time_s: f32,
    /// Force commanded to the motors now, N.
    pub(crate) force_n: f32,
    /// Largest force commanded so far, N.
    pub(crate) strongest_n: f32,
    /// Largest motor command so far, as a share of the largest permitted command.
    pub(crate) motor_load: f32,
}

/// A running emulator; stops when dropped.
pub(crate) struct Emulator {
    pub(crate) lines: Lines,
    config: EmulateConfig,
    directory: Option<TempDir>,
    stop: Arc<AtomicBool>,
    inside: Arc<Mutex<DeviceStates>>,
    thread: Option<JoinHandle<Result<(), HardwareError>>>,
}

impl Emulator {
    pub(crate) fn start() -> Self {
        Self::with_faults(LineFaults::default())
    }

    pub(crate) fn with_faults(faults: LineFaults) -> Self {
        Self::with_model(HapticModel::default(), faults)
    }

    /// An emulated rig whose firmware has a mistake.
    pub(crate) fn with_mistake(mistake: Mistake) -> Self {
        Self::start_with(HapticModel::default(), Some(mistake), LineFaults::default())
    }

    pub(crate) fn with_model(haptic: HapticModel, faults: LineFaults) -> Self {
        Self::start_with(haptic, None, faults)
    }

    fn start_with(haptic: HapticModel, mistake: Option<Mistake>, faults: LineFaults) -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        let config = EmulateConfig {
            directory: directory.path().join("devices"),
            script: workplace(),
            seed: 1,
            haptic,
            mistake,
            holding: Holding::default(),
            faults,
        };
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = mpsc::channel();
        let inside = Arc::new(Mutex::new(DeviceStates::default()));
        let thread = std::thread::spawn({
            let (config, stop, inside) = (config.clone(), Arc::clone(&stop), Arc::clone(&inside));
            move || {
                let mut ready = |lines: &Lines| {
                    sender.send(lines.clone()).expect("the test waits");
                };
                run_watched(&config, &stop, &mut ready, &mut |now| {
                    let mut seen = inside.lock().unwrap_or_else(PoisonError::into_inner);
                    let force_n = now.force_n.norm();
                    *seen = DeviceStates {
                        time_s: now.time_s,
                        force_n,
                        strongest_n: seen.strongest_n.max(force_n),
                        motor_load: seen.motor_load.max(now.motor_load),
                    };
                })
            }
        });
        let lines = receiver.recv().expect("the emulator starts");
        Self {
            lines,
            config,
            directory: Some(directory),
            stop,
            inside,
            thread: Some(thread),
        }
    }

    /// State inside the devices so far.
    pub(crate) fn seen(&self) -> DeviceStates {
        *self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tries to start a second emulator in the same directory.
    pub(crate) fn try_another(&self) -> Result<(), HardwareError> {
        run(&self.config, &AtomicBool::new(true), &mut |_| {})
    }

    /// Stops the emulator and returns its directory.
    pub(crate) fn stop(mut self) -> TempDir {
        self.end();
        self.directory.take().expect("only stopped once")
    }

    fn end(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread
                .join()
                .expect("the emulator does not panic")
                .expect("nor fail");
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.end();
        }
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Builds a fake library with the compiler in use; returns its path. `source` lies in `tests`.
pub(crate) fn build_library(name: &str, source: &str, options: &[&str]) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("lib{name}.so"));
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let built = Command::new(rustc)
        .args(["--edition=2024", "--crate-type=cdylib", "--crate-name"])
        .arg(name)
        .args(options)
        .arg("-o")
        .arg(&path)
        .arg(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("tests")
                .join(source),
        )
        .status();
    assert!(
        built.is_ok_and(|status| status.success()),
        "the fake library does not build"
    );
    path
}

/// Longest wait, even on a busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Calls `step` with the time about every millisecond, until it returns false or time is up.
pub(crate) fn poll_for(limit: Duration, mut step: impl FnMut(u64) -> bool) {
    let start = Instant::now();
    while start.elapsed() < limit && step(now_ns()) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// `CLOCK_MONOTONIC`, ns.
pub(crate) fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// A workplace like that of a prepared scene, with the handle at rest in the device's origin.
pub(crate) fn workplace() -> HandScript {
    let port = Vec3::zeros();
    let target = Vec3::new(0.02, -0.01, -0.2);
    let length = 0.33;
    let handle = port - target.normalize() * (length - target.norm());
    let camera = Vec3::new(0.05, 0.05, -0.1);
    HandScript {
        instrument_port_m: port,
        instrument_length_m: length,
        world_from_device: Pose::from_parts(handle.into(), UnitQuaternion::identity()),
        world_from_tracker: Translation3::new(0.05, 0.05, 0.1).into(),
        world_from_camera: Pose::from_parts(camera.into(), UnitQuaternion::identity()),
        endoscope_port_m: Vec3::new(0.05, 0.05, 0.05),
        target_m: target,
        target_normal: Vec3::new(0.0, 0.6, 0.8),
    }
}

/// Rest position of the endoscope in the tracker's frame.
pub(crate) fn camera_in_tracker() -> Vec3 {
    let workplace = workplace();
    (workplace.world_from_tracker.inverse() * workplace.world_from_camera)
        .translation
        .vector
}

/// Opens a device on a bad line as a person would: with a few retries.
pub(crate) fn persist<T>(open: impl Fn() -> Result<T, HardwareError>) -> T {
    let mut last = None;
    for _ in 0..8 {
        match open() {
            Ok(driver) => return driver,
            Err(error) => last = Some(error),
        }
    }
    panic!("eight times in a row: {last:?}");
}
