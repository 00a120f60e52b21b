//! An emulated station in a directory of its own, and a patient loop around a driver.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::emulate::{
    EmulateConfig, HandScript, HapticModel, LineFaults, Lines, run, run_watched,
};
use nalgebra::{Translation3, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use tempfile::TempDir;

/// What happened inside of the devices.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Seen {
    pub(crate) time_s: f32,
    /// What the motors are told now, N.
    pub(crate) force_n: f32,
    /// The most that they were told, N.
    pub(crate) strongest_n: f32,
    /// The most that one was told, as a share of what it may be told.
    pub(crate) strain: f32,
}

/// A running emulator; stops when dropped.
pub(crate) struct Emulator {
    pub(crate) lines: Lines,
    config: EmulateConfig,
    directory: Option<TempDir>,
    stop: Arc<AtomicBool>,
    inside: Arc<Mutex<Seen>>,
    thread: Option<JoinHandle<Result<(), HardwareError>>>,
}

impl Emulator {
    pub(crate) fn start() -> Self {
        Self::with(LineFaults::default())
    }

    pub(crate) fn with(faults: LineFaults) -> Self {
        Self::of(HapticModel::default(), faults)
    }

    pub(crate) fn of(haptic: HapticModel, faults: LineFaults) -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        let config = EmulateConfig {
            directory: directory.path().join("devices"),
            script: room(),
            seed: 1,
            haptic,
            faults,
        };
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = mpsc::channel();
        let inside = Arc::new(Mutex::new(Seen::default()));
        let thread = std::thread::spawn({
            let (config, stop, inside) = (config.clone(), Arc::clone(&stop), Arc::clone(&inside));
            move || {
                let mut ready = |lines: &Lines| {
                    sender.send(lines.clone()).expect("the test waits");
                };
                run_watched(&config, &stop, &mut ready, &mut |now| {
                    let mut seen = inside.lock().unwrap_or_else(PoisonError::into_inner);
                    let force_n = now.force_n.norm();
                    *seen = Seen {
                        time_s: now.time_s,
                        force_n,
                        strongest_n: seen.strongest_n.max(force_n),
                        strain: seen.strain.max(now.strain),
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

    /// What happened inside until now.
    pub(crate) fn seen(&self) -> Seen {
        *self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tries to start a second one in the same directory.
    pub(crate) fn try_another(&self) -> Result<(), HardwareError> {
        run(&self.config, &AtomicBool::new(true), &mut |_| {})
    }

    /// Ends it, and gives its directory.
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

/// What has not happened by then does not happen, however busy the machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Calls `step` with the time every millisecond or so, until it returns false or time is up.
pub(crate) fn poll_for(limit: Duration, mut step: impl FnMut(u64) -> bool) {
    let start = Instant::now();
    while start.elapsed() < limit && step(now_ns()) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Host time.
pub(crate) fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// A room like a prepared scene's: the handle at rest in the device's origin.
pub(crate) fn room() -> HandScript {
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

/// Where the endoscope rests in the tracker's frame.
pub(crate) fn camera_in_tracker() -> Vec3 {
    let room = room();
    (room.world_from_tracker.inverse() * room.world_from_camera)
        .translation
        .vector
}

/// Opens a device on a bad line as a person would: again, a few times.
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
