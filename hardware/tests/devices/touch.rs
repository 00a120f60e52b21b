//! The Touch's driver against a fake `libHD.so` that the test builds.
#![allow(unsafe_code)] // the fake library's own symbols

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::conformance::{CheckOutcome, Options};
use hardware::touch::TouchHaptic;
use libloading::Library;
use rt_core::fault::Fault;
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Polled};

use crate::support::{PATIENCE, build_library, now_ns, poll_for};

/// The fake library. It has one device, so only one test may use it at a time.
struct Fake {
    path: PathBuf,
    library: Library,
    _alone: MutexGuard<'static, ()>,
}

impl Fake {
    fn new() -> Self {
        static ALONE: Mutex<()> = Mutex::new(());
        static BUILT: OnceLock<PathBuf> = OnceLock::new();
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let path = BUILT.get_or_init(build).clone();
        // SAFETY: our own library.
        let library = unsafe { Library::new(&path) }.expect("the fake library loads");
        let fake = Self {
            path,
            library,
            _alone: alone,
        };
        fake.tell("fake_calibration", 0x5000);
        fake.tell("fake_raise", 0);
        fake
    }

    fn open(&self) -> Result<TouchHaptic, HardwareError> {
        TouchHaptic::open(&self.path, Some("right"))
    }

    fn tell(&self, symbol: &str, value: u32) {
        // SAFETY: the fake's own symbol, of this type.
        unsafe {
            let call = self.library.get::<extern "C" fn(u32)>(symbol.as_bytes());
            call.expect("a symbol of the fake")(value);
        }
    }

    fn fail_init(&self, times: u32, code: u32) {
        // SAFETY: the fake's own symbol, of this type.
        unsafe {
            let call = self
                .library
                .get::<extern "C" fn(u32, u32)>(b"fake_fail_init");
            call.expect("a symbol of the fake")(times, code);
        }
    }

    /// Size of the force that the motors render, N.
    fn force_n(&self) -> f64 {
        let mut force = [0.0; 3];
        // SAFETY: the fake's own symbol, of this type; it writes three numbers.
        unsafe {
            let call = self.library.get::<extern "C" fn(*mut f64)>(b"fake_force");
            call.expect("a symbol of the fake")(force.as_mut_ptr());
        }
        force.iter().map(|part| part * part).sum::<f64>().sqrt()
    }
}

/// Builds the fake with the compiler in use.
fn build() -> PathBuf {
    if let Some(built) = std::env::var_os(DOOMED) {
        return built.into();
    }
    build_library("HD", "fake_hd/libhd.rs", &[])
}

fn push(newtons: f32) -> ForceCommand {
    ForceCommand {
        opening_n: 0.0,
        force_n: Vec3::new(newtons, 0.0, 0.0),
        torque_nm: Vec3::zeros(),
    }
}

#[test]
fn poses_arrive_in_metres_and_forces_are_rendered_and_limited() {
    let fake = Fake::new();
    let mut device = fake.open().unwrap();
    assert_eq!(device.identity().name, "Fake Touch 12345");
    let capabilities = device.capabilities();
    assert!((capabilities.force_max_n - 3.3).abs() < 1e-6);
    assert!((capabilities.stiffness_max_n_m - 700.0).abs() < 1e-3);
    assert!((capabilities.damping_max_n_s_m - 5.0).abs() < 1e-3);
    assert!((capabilities.workspace_radius_m - 0.08).abs() < 1e-6);
    assert!(!capabilities.renders_torque());

    let (mut samples, mut strongest, mut rendered) = (0, 0.0f64, false);
    poll_for(PATIENCE, |now_ns| {
        device.send(push(100.0), now_ns);
        if let Polled::Fresh(sample) = device.poll(now_ns) {
            samples += 1;
            let pose = sample.device_from_handle;
            let at = pose.translation.vector;
            assert!(
                (at.xy().norm() - 0.05).abs() < 1e-5 && (at.z + 0.01).abs() < 1e-6,
                "{at}"
            );
            // The fake handle is turned by 90° about z.
            assert!((pose.rotation * Vec3::x() - Vec3::y()).norm() < 1e-5);
            // The handle circles at 50 mm/s. The driver gives the larger of two velocities: the one
            // that the handle reports, and the one from its positions, which varies with the times
            // of the polls.
            let along = Vec3::z().cross(&at).normalize();
            let speed_m_s = sample.velocity_m_s.unwrap().dot(&along);
            assert!(speed_m_s > 0.049, "{speed_m_s}");
            assert_eq!(sample.buttons.0, 1);
        }
        strongest = strongest.max(fake.force_n());
        rendered |= fake.force_n() > 3.29;
        samples < 100 || !rendered
    });
    assert!(samples >= 100 && rendered, "{samples}");
    assert!(strongest <= 3.3001, "{strongest}");
}

#[test]
fn a_hanging_host_loses_the_force_and_closing_ends_it_at_once() {
    let fake = Fake::new();
    let mut device = fake.open().unwrap();
    let becomes = |wanted: bool, device: &mut TouchHaptic, send: bool| {
        let mut seen = false;
        poll_for(PATIENCE, |now_ns| {
            if send {
                device.send(push(1.0), now_ns);
            }
            seen = (fake.force_n() > 0.9) == wanted;
            !seen
        });
        seen
    };
    assert!(becomes(true, &mut device, true));
    assert!(becomes(false, &mut device, false), "nobody sends any more");
    assert!(becomes(true, &mut device, true));
    drop(device);
    assert!(fake.force_n() < 1e-9);
}

#[test]
fn a_force_that_is_not_a_number_is_rendered_as_zero() {
    let fake = Fake::new();
    let mut device = fake.open().unwrap();
    poll_for(Duration::from_millis(100), |now_ns| {
        device.send(push(f32::NAN), now_ns);
        let force_n = fake.force_n();
        assert!(force_n < 1e-9, "{force_n}");
        true
    });
}

#[test]
fn a_pose_that_is_no_number_is_no_sample() {
    let fake = Fake::new();
    fake.tell("fake_break_pose", 1);
    let mut device = fake.open().unwrap();
    poll_for(Duration::from_millis(100), |now_ns| {
        assert_eq!(device.poll(now_ns), Polled::Nothing);
        true
    });
    fake.tell("fake_break_pose", 0);
    let mut fresh = false;
    poll_for(PATIENCE, |now_ns| {
        fresh = matches!(device.poll(now_ns), Polled::Fresh(_));
        !fresh
    });
    assert!(fresh);
}

#[test]
fn warnings_of_warm_motors_are_counted_and_a_broken_line_is_lost() {
    let fake = Fake::new();
    let mut device = fake.open().unwrap();
    fake.tell("fake_raise", 0x0200);
    let mut is_limited = false;
    poll_for(PATIENCE, |now_ns| {
        device.poll(now_ns);
        is_limited = device.findings().faults.contains(Fault::DeviceLimited);
        !is_limited
    });
    assert!(is_limited);
    assert_eq!(device.counters().bad_frames, 0, "a limit is no bad frame");
    fake.tell("fake_raise", 0x0302);
    let mut lost = false;
    poll_for(PATIENCE, |now_ns| {
        lost = device.poll(now_ns) == Polled::Lost;
        !lost
    });
    assert!(lost);
    assert_eq!(device.failure(), Some(0x0302));
    drop(device);
    let mut again = fake.open().unwrap();
    assert_ne!(again.poll(now_ns()), Polled::Lost);
}

#[test]
fn opening_waits_for_a_device_that_the_last_program_left_in_use() {
    let fake = Fake::new();
    fake.fail_init(3, 0x0301);
    assert!(fake.open().is_ok());
    fake.fail_init(1, 0x0600);
    let error = fake.open().unwrap_err().to_string();
    assert!(
        error.contains("failed with error 0600") && error.contains("licence"),
        "{error}"
    );
}

#[test]
fn the_calibration_is_updated_or_requested() {
    let fake = Fake::new();
    fake.tell("fake_calibration", 0x5001);
    assert!(fake.open().is_ok(), "the library updates it");
    fake.tell("fake_calibration", 0x5002);
    for (styles, remedy) in [
        (4, "inkwell"),
        (1, "reset position"),
        (7, "through its whole range"),
    ] {
        fake.tell("fake_calibration_styles", styles);
        let error = fake.open().unwrap_err().to_string();
        assert!(error.contains(remedy), "{styles}: {error}");
    }
}

#[test]
fn one_driver_at_a_time_and_a_missing_library_is_named() {
    let fake = Fake::new();
    let device = fake.open().unwrap();
    assert!(matches!(fake.open(), Err(HardwareError::Busy { .. })));
    drop(device);
    let error = TouchHaptic::open("/there/is/no/libHD.so".as_ref(), None).unwrap_err();
    assert!(matches!(error, HardwareError::Library { .. }), "{error}");
    assert!(
        fake.open().is_ok(),
        "a failed opening leaves the device free"
    );
}

#[test]
fn a_device_that_reports_no_force_is_refused() {
    let fake = Fake::new();
    fake.tell("fake_forceless", 1);
    let error = fake.open().unwrap_err();
    fake.tell("fake_forceless", 0);
    let HardwareError::Capability { what, value, .. } = error else {
        panic!("{error}");
    };
    assert_eq!((what, value), ("force_max_n", 0.0));
    assert!(fake.open().is_ok(), "a refused device is free again");
}

#[test]
fn a_library_that_hangs_is_named_and_used_again_once_it_returns() {
    let fake = Fake::new();
    fake.tell("fake_hang", 1);
    for _ in 0..2 {
        let error = fake.open().unwrap_err();
        assert!(matches!(error, HardwareError::Hangs { .. }), "{error}");
        assert!(error.to_string().contains("libHD.so"), "{error}");
    }
    fake.tell("fake_hang", 0);
    let start = Instant::now();
    while let Err(error) = fake.open() {
        assert!(start.elapsed() < Duration::from_secs(60), "{error}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Environment variable with the path of the fake library. It is set only in the process that the
/// library ends.
const DOOMED: &str = "CALOT_TEST_DOOMED";

#[test]
fn a_library_that_ends_the_program_is_named_and_its_exit_code_is_replaced() {
    if std::env::var_os(DOOMED).is_some() {
        let fake = Fake::new();
        fake.tell("fake_exit", 1);
        let _ = fake.open();
        unreachable!("the library ended the process");
    }
    let path = Fake::new().path.display().to_string();
    let name = "touch::a_library_that_ends_the_program_is_named_and_its_exit_code_is_replaced";
    let ended = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", name, "--nocapture"])
        .env(DOOMED, &path)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(
        said.contains(&path) && said.contains("ended the program"),
        "{said}"
    );
}

#[test]
fn the_suite_does_not_pass_without_samples() {
    let fake = Fake::new();
    fake.tell("fake_break_pose", 1);
    let mut options = Options {
        watch: Duration::from_millis(300),
        unplug: None,
    };
    let report = hardware::conformance::touch(&fake.path, Some("right"), &mut options);
    fake.tell("fake_break_pose", 0);
    // If this computer itself was late, the lack of samples is not judged.
    let intervals = report.check("intervals").map(|check| check.outcome);
    assert!(
        report.has(CheckOutcome::Fail) || intervals == Some(CheckOutcome::NotJudged),
        "{report}"
    );
    let bad = report.check("bad frames").map(|check| check.detail.clone());
    let bad = bad.unwrap_or_default();
    assert!(
        bad.contains("a value that is no number (NaN or infinite)"),
        "{report}"
    );
    for name in ["rate", "intervals", "gaps"] {
        let said = report.check(name).map(|check| check.detail.clone());
        assert!(!said.unwrap_or_default().contains("NaN"), "{report}");
    }
    for name in ["finite", "workspace", "speed"] {
        let outcome = report.check(name).map(|check| check.outcome);
        assert_eq!(outcome, Some(CheckOutcome::NotJudged), "{report}");
    }
}

#[test]
fn the_suite_passes_and_notices_a_broken_line() {
    let fake = Fake::new();
    let start = Instant::now();
    loop {
        let mut unplug = || fake.tell("fake_raise", 0x0302);
        let mut options = Options {
            watch: Duration::from_secs(1),
            unplug: Some(&mut unplug),
        };
        let report = hardware::conformance::touch(&fake.path, Some("right"), &mut options);
        fake.tell("fake_raise", 0);
        if report.passed() {
            let unplug = report.check("unplug").map(|check| check.outcome);
            assert_eq!(unplug, Some(CheckOutcome::Pass), "{report}");
            return;
        }
        // A busy machine may spoil the rate for a while.
        assert!(start.elapsed() < Duration::from_secs(120), "{report}");
    }
}
