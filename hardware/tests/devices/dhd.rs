//! The driver of Force Dimension's devices against a fake `libdhd.so.3` that the test builds.

use std::process::Command;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::conformance::{CheckOutcome, Options};
use hardware::dhd::DhdHaptic;
use hardware::station::StationFile;
use rt_core::fault::Fault;
use rt_core::math::Vec3;
use rt_core::port::{Buttons, DeviceSample, ForceCommand, HapticDevice, Polled};

use crate::fake_dhd::{ACTIVE_GRIPPER, DOOMED, Entry, FALCON, Fake, LEFT, OMEGA_7, SIGMA_7};
use crate::support::{PATIENCE, build_library, poll_for};

fn opens(opening_n: f32) -> ForceCommand {
    ForceCommand {
        opening_n,
        ..ForceCommand::default()
    }
}

fn push(force_n: Vec3) -> ForceCommand {
    ForceCommand {
        opening_n: 0.0,
        force_n,
        torque_nm: Vec3::zeros(),
    }
}

/// Polls until `is_seen`, and sends `command` meanwhile, if there is one.
fn until(
    device: &mut DhdHaptic,
    command: Option<ForceCommand>,
    mut is_seen: impl FnMut(&DhdHaptic, Polled<DeviceSample>) -> bool,
) {
    let mut seen = false;
    poll_for(PATIENCE, |now_ns| {
        if let Some(command) = command {
            device.send(command, now_ns);
        }
        let polled = device.poll(now_ns);
        seen = is_seen(device, polled);
        !seen
    });
    assert!(seen, "no such sample in {} s", PATIENCE.as_secs());
}

/// A fresh sample that fulfils `wanted`.
fn sample(device: &mut DhdHaptic, wanted: impl Fn(&DeviceSample) -> bool) -> DeviceSample {
    let mut found = None;
    until(device, None, |_, polled| {
        if let Polled::Fresh(sample) = polled {
            found = Some(sample).filter(&wanted);
        }
        found.is_some()
    });
    found.expect("found")
}

fn is_close(a: [f64; 7], b: [f64; 7]) -> bool {
    a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn positions_and_forces_to_the_right_are_converted_both_ways() {
    let fake = Fake::new(OMEGA_7);
    // The library: x to the user, y right, z up.
    for (theirs, ours) in [
        ([0.0, 1.0, 0.0], Vec3::x()),
        ([0.0, 0.0, 1.0], Vec3::y()),
        ([1.0, 0.0, 0.0], Vec3::z()),
    ] {
        fake.set3(Entry::Position, theirs.map(|x| x * 0.05));
        fake.set3(Entry::Velocity, theirs.map(|x| x * 0.3));
        let mut device = fake.open().unwrap();
        let seen = sample(&mut device, |_| true);
        let at = seen.device_from_handle.translation.vector;
        assert!((at - ours * 0.05).norm() < 1e-6, "{at}");
        let velocity = seen.velocity_m_s.unwrap();
        assert!((velocity - ours * 0.3).norm() < 1e-6, "{velocity}");
        let [x, y, z] = theirs;
        let wanted = [x * 2.0, y * 2.0, z * 2.0, 0.0, 0.0, 0.0, 0.0];
        until(&mut device, Some(push(ours * 2.0)), |_, _| {
            is_close(fake.rendered(), wanted)
        });
    }
}

#[test]
fn a_rotation_about_the_librarys_vertical_is_one_about_calots() {
    let fake = Fake::new(OMEGA_7);
    fake.set(Entry::Turned, 1.0);
    let mut device = fake.open().unwrap();
    let rotation = sample(&mut device, |_| true).device_from_handle.rotation;
    assert!((rotation * Vec3::y() - Vec3::y()).norm() < 1e-5);
    // The axis that points to the user turns to the right.
    assert!((rotation * Vec3::z() - Vec3::x()).norm() < 1e-5);
    assert_eq!(device.freedom().measured, 6);
}

#[test]
fn only_a_wrist_with_motors_gets_a_torque_and_it_is_limited() {
    for (model, is_rendered) in [(SIGMA_7, true), (OMEGA_7, false)] {
        let fake = Fake::new(model);
        let mut device = fake.open().unwrap();
        assert_eq!(device.capabilities().renders_torque(), is_rendered);
        assert_eq!(device.freedom().rendered, if is_rendered { 6 } else { 3 });
        let command = ForceCommand {
            opening_n: 0.0,
            force_n: Vec3::new(100.0, 0.0, 0.0),
            torque_nm: Vec3::new(0.0, -9.0, 0.0),
        };
        let most = device.capabilities();
        let torque = -f64::from(most.torque_max_nm);
        let force = f64::from(most.force_max_n);
        let wanted = [0.0, force, 0.0, 0.0, 0.0, torque, 0.0];
        until(&mut device, Some(command), |_, _| {
            is_close(fake.rendered(), wanted)
        });
    }
}

#[test]
fn a_gripper_is_read_gets_a_force_and_counts_as_a_button() {
    let fake = Fake::new(OMEGA_7);
    let mut device = fake.open().unwrap();
    let opening = device.capabilities().opening;
    assert!(opening.is_rendered() && (opening.force_max_n - 8.0).abs() < 1e-6);
    sample(&mut device, |sample| sample.opening == Some(1.0));
    let grasps = |sample: &DeviceSample| sample.buttons.contains(Buttons::GRASP);
    assert!(!grasps(&sample(&mut device, |_| true)));
    fake.set(Entry::Angle, 3.0);
    let opening = sample(&mut device, grasps).opening.unwrap();
    assert!((opening - 0.1).abs() < 1e-6, "{opening}");
    // Between the two limits the button stays as it is.
    fake.set(Entry::Angle, 9.0);
    sample(&mut device, |sample| sample.opening > Some(0.2));
    assert!(grasps(&sample(&mut device, |_| true)));
    fake.set(Entry::Angle, 15.0);
    sample(&mut device, |sample| !grasps(sample));
    // The gripper opens against the fingers, and never with more force than its motor has.
    for (opening_n, rendered) in [(2.5, 2.5), (-99.0, -8.0), (f32::NAN, 0.0)] {
        until(&mut device, Some(opens(opening_n)), |_, _| {
            (fake.rendered()[6] - rendered).abs() < 1e-9
        });
    }
    fake.set(Entry::Angle, f64::NAN);
    sample(&mut device, |sample| sample.opening.is_none());
}

#[test]
fn a_left_hand_s_gripper_opens_the_other_way() {
    let (model, parts) = OMEGA_7;
    let fake = Fake::new((model, parts | LEFT));
    fake.set(Entry::Angle, -15.0);
    let mut device = fake.open().unwrap();
    sample(&mut device, |sample| sample.opening == Some(0.5));
    until(&mut device, Some(opens(1.0)), |_, _| {
        (fake.rendered()[6] + 1.0).abs() < 1e-9
    });
}

#[test]
fn a_gripper_without_a_motor_gets_no_force() {
    let (model, parts) = OMEGA_7;
    let fake = Fake::new((model, parts & !ACTIVE_GRIPPER));
    let mut device = fake.open().unwrap();
    let opening = device.capabilities().opening;
    assert!(opening.is_measured() && !opening.is_rendered());
    let command = ForceCommand {
        force_n: Vec3::x(),
        ..opens(5.0)
    };
    until(&mut device, Some(command), |_, _| fake.force_n() > 0.9);
    assert!(fake.rendered()[6].abs() < 1e-9);
}

#[test]
fn a_falcon_has_three_directions_and_four_buttons() {
    let fake = Fake::new(FALCON);
    let mut device = fake.open().unwrap();
    let freedom = device.freedom();
    assert_eq!((freedom.measured, freedom.rendered), (3, 3));
    fake.set(Entry::Buttons, 10.0);
    let seen = sample(&mut device, |sample| sample.buttons != Buttons(0));
    assert_eq!(seen.buttons, Buttons(10));
    assert!(seen.device_from_handle.rotation.angle() < 1e-6);
    assert_eq!(seen.opening, None);
    assert!(!device.capabilities().opening.is_measured());
    assert_eq!(device.identity().name, "fake.7 10432");
    // The library reports an error instead of the buttons.
    fake.set(Entry::Buttons, f64::from(u32::MAX));
    sample(&mut device, |sample| sample.buttons == Buttons(0));
}

#[test]
fn each_model_has_its_figures_and_an_unknown_model_has_low_ones() {
    for (number, force_max_n) in [(33, 12.0), (60, 8.0), (63, 20.0), (104, 20.0), (109, 12.0)] {
        let fake = Fake::new((number, 0));
        let found = fake.open().unwrap().capabilities();
        assert!((found.force_max_n - force_max_n).abs() < 1e-6, "{number}");
        assert!(!found.renders_torque(), "{number}: no motors in its wrist");
    }
    let fake = Fake::new((91, SIGMA_7.1));
    let found = fake.open().unwrap().capabilities();
    assert!(found.force_max_n <= 3.0 && !found.renders_torque());
}

#[test]
fn a_hanging_host_loses_the_force_and_closing_ends_it_at_once() {
    let fake = Fake::new(SIGMA_7);
    let mut device = fake.open().unwrap();
    let strong = push(Vec3::x());
    until(&mut device, Some(strong), |_, _| fake.force_n() > 0.9);
    until(&mut device, None, |_, _| fake.force_n() < 1e-9);
    until(&mut device, Some(strong), |_, _| fake.force_n() > 0.9);
    drop(device);
    assert!(fake.rendered().iter().all(|part| part.abs() < 1e-9));
    assert!(fake.get(Entry::Stops) > 0.0, "the motors brake");
    assert!(fake.get(Entry::Closes) > 0.0, "the device is closed");
}

#[test]
fn values_that_are_not_numbers_are_neither_rendered_nor_sampled() {
    let fake = Fake::new(SIGMA_7);
    let mut device = fake.open().unwrap();
    poll_for(Duration::from_millis(100), |now_ns| {
        device.send(push(Vec3::new(f32::NAN, 0.0, 0.0)), now_ns);
        let force_n = fake.force_n();
        assert!(force_n < 1e-9, "{force_n}");
        true
    });
    fake.set3(Entry::Position, [f64::NAN; 3]);
    until(&mut device, None, |device, _| {
        device.counters().bad_frames > 20
    });
    // The last good sample may still wait.
    device.poll(0);
    poll_for(Duration::from_millis(50), |now_ns| {
        assert_eq!(device.poll(now_ns), Polled::Nothing);
        true
    });
    fake.set3(Entry::Position, [0.0; 3]);
    sample(&mut device, |_| true);
}

#[test]
fn a_velocity_that_the_library_lacks_is_left_to_the_tick() {
    let fake = Fake::new(FALCON);
    fake.set(Entry::NoVelocity, 1.0);
    let mut device = fake.open().unwrap();
    assert_eq!(sample(&mut device, |_| true).velocity_m_s, None);
    fake.set(Entry::NoVelocity, 0.0);
    sample(&mut device, |sample| sample.velocity_m_s.is_some());
}

#[test]
fn a_jump_is_dropped_and_a_lasting_one_is_accepted_and_reported() {
    let fake = Fake::new(OMEGA_7);
    let mut device = fake.open().unwrap();
    let first = sample(&mut device, |_| true);
    assert!(first.device_from_handle.translation.vector.norm() < 1e-6);
    assert!(!device.findings().faults.contains(Fault::DeviceLeap));
    // A thread that a busy machine held up for long admits a jump at once. Then the position jumps
    // again.
    let start = Instant::now();
    for right_m in [0.08, 0.0].into_iter().cycle() {
        fake.set3(Entry::Position, [0.0, right_m, 0.0]);
        let (mut is_told, mut leapt) = (false, false);
        until(&mut device, None, |device, polled| {
            let findings = device.findings();
            is_told |= findings.faults.contains(Fault::DeviceLeap);
            leapt |= findings.leapt;
            let Polled::Fresh(sample) = polled else {
                return false;
            };
            let at = sample.device_from_handle.translation.x;
            (f64::from(at) - right_m).abs() < 0.01
        });
        if is_told && leapt {
            break;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "told: {is_told}, leapt: {leapt}"
        );
    }
    assert!(device.counters().bad_frames >= 7);
}

#[test]
fn a_device_whose_own_button_ended_the_force_is_reported_and_gets_it_back_slowly() {
    let fake = Fake::new(OMEGA_7);
    let mut device = fake.open().unwrap();
    let strong = push(Vec3::new(4.0, 0.0, 0.0));
    let is_deaf = |device: &DhdHaptic| device.findings().faults.contains(Fault::DeafDevice);
    until(&mut device, Some(strong), |_, _| fake.force_n() > 3.9);
    // A busy machine that holds this thread up also causes a step, because the force becomes too
    // old.
    let start = Instant::now();
    loop {
        fake.set(Entry::ForceMode, 0.0);
        until(&mut device, Some(strong), |device, _| {
            is_deaf(device) && fake.force_n() < 1e-9
        });
        fake.set(Entry::Step, 0.0);
        fake.set(Entry::ForceMode, 1.0);
        until(&mut device, Some(strong), |_, _| fake.force_n() > 3.9);
        assert!(!is_deaf(&device));
        let step_n = fake.get(Entry::Step);
        if step_n < 0.1 {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{step_n}");
    }
}

#[test]
fn an_unplugged_device_is_lost_and_opens_again() {
    let fake = Fake::new(SIGMA_7);
    let mut device = fake.open().unwrap();
    sample(&mut device, |_| true);
    fake.set(Entry::ReadError, 2.0);
    until(&mut device, Some(push(Vec3::x())), |_, polled| {
        polled == Polled::Lost
    });
    assert!(device.is_lost() && device.counters().bad_frames > 1);
    until(&mut device, None, |_, polled| polled == Polled::Lost);
    assert!(fake.force_n() < 1e-9);
    fake.set(Entry::ReadError, 0.0);
    // The old driver may live on while the new one opens.
    let mut again = fake.open_once_free();
    drop(device);
    sample(&mut again, |_| true);
    assert!(matches!(fake.open(), Err(HardwareError::Busy { .. })));
}

#[test]
fn a_force_that_the_library_refuses_is_counted() {
    let fake = Fake::new(OMEGA_7);
    let mut device = fake.open().unwrap();
    assert_eq!(device.counters().dropped_writes, 0);
    fake.set(Entry::ForceError, 2.0);
    until(&mut device, Some(push(Vec3::x())), |device, _| {
        device.counters().dropped_writes > 3
    });
    drop(device);
    let error = fake.open().unwrap_err().to_string();
    assert!(
        error.contains("enabling the force failed with error 0002"),
        "{error}"
    );
}

#[test]
fn a_device_that_cannot_be_opened_says_why() {
    let fake = Fake::new(OMEGA_7);
    fake.set(Entry::Count, 0.0);
    let error = fake.open().unwrap_err();
    assert!(matches!(error, HardwareError::NoForceDevice { .. }));
    let words = error.to_string();
    assert!(words.contains("ATTR{idVendor}==\"1451\""), "{words}");
    fake.set(Entry::Count, 2.0);
    for (code, words) in [
        (
            20,
            "failed with error 0014: another program uses the device",
        ),
        (2, "check its cable and power"),
        (12, "calibrate it"),
        (1, "dhdc.h"),
    ] {
        fake.set(Entry::OpenError, f64::from(code));
        let error = fake.open().unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    fake.set(Entry::OpenError, 0.0);
    let error = DhdHaptic::open(&fake.path, Some(7))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("Force Dimension 7") && error.contains("correct `device`"),
        "{error}"
    );
    assert!(DhdHaptic::open(&fake.path, Some(10432)).is_ok());
}

#[test]
fn a_device_that_is_not_calibrated_is_refused_with_what_to_do() {
    let fake = Fake::new(SIGMA_7);
    for (what, value, words) in [
        (Entry::Reset, 1.0, "end stops"),
        (Entry::WristReady, 0.0, "HapticInit"),
    ] {
        let before = fake.get(what);
        fake.set(what, value);
        let error = fake.open().unwrap_err();
        assert!(
            matches!(error, HardwareError::Calibration { .. }),
            "{error}"
        );
        assert!(error.to_string().contains(words), "{error}");
        fake.set(what, before);
        assert!(fake.get(Entry::Closes) > 0.0, "a refused device is closed");
    }
    assert!(fake.open().is_ok());
    // A wrist without motors needs no initialisation.
    drop(fake);
    let fake = Fake::new(OMEGA_7);
    fake.set(Entry::WristReady, 0.0);
    assert!(fake.open().is_ok());
}

#[test]
fn a_missing_or_old_library_is_named_with_the_sdk() {
    let fake = Fake::new(OMEGA_7);
    let error = DhdHaptic::open("/there/is/no/libdhd.so.3".as_ref(), None).unwrap_err();
    assert!(matches!(error, HardwareError::Library { .. }), "{error}");
    let words = error.to_string();
    assert!(
        words.contains("no such library") && words.contains("forcedimension.com"),
        "{words}"
    );
    let old = build_library("old_dhd", "fake_dhd/libdhd.rs", &["--cfg=old"]);
    let words = DhdHaptic::open(&old, None).unwrap_err().to_string();
    assert!(
        words.contains("lacks `dhdHasActiveGripper`") && words.contains("3.7"),
        "{words}"
    );
    assert!(
        fake.open().is_ok(),
        "a failed opening leaves the device free"
    );
}

#[test]
fn a_library_that_hangs_is_named_and_used_again_once_it_returns() {
    let fake = Fake::new(OMEGA_7);
    fake.set(Entry::Hangs, 1.0);
    for _ in 0..2 {
        let error = fake.open().unwrap_err();
        assert!(matches!(error, HardwareError::Hangs { .. }), "{error}");
        assert!(error.to_string().contains("libdhd.so"), "{error}");
    }
    fake.set(Entry::Hangs, 0.0);
    fake.open_once_free();
}

#[test]
fn a_library_that_hangs_later_delays_neither_the_tick_nor_the_end() {
    let fake = Fake::new(OMEGA_7);
    let mut device = fake.open().unwrap();
    sample(&mut device, |_| true);
    fake.set(Entry::Hangs, 1.0);
    let start = Instant::now();
    poll_for(Duration::from_millis(100), |now_ns| {
        device.send(push(Vec3::x()), now_ns);
        device.poll(now_ns);
        true
    });
    drop(device);
    assert!(start.elapsed() < PATIENCE);
    let error = fake.open().unwrap_err();
    assert!(matches!(error, HardwareError::Hangs { .. }), "{error}");
    fake.set(Entry::Hangs, 0.0);
    fake.open_once_free();
}

#[test]
fn a_library_that_ends_the_program_is_named() {
    if std::env::var_os(DOOMED).is_some() {
        let fake = Fake::new(OMEGA_7);
        fake.set(Entry::Exits, 1.0);
        let _ = fake.open();
        unreachable!("the library ended the process");
    }
    let path = Fake::new(OMEGA_7).path.display().to_string();
    let ended = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "dhd::a_library_that_ends_the_program_is_named",
            "--nocapture",
        ])
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
fn a_station_file_opens_it_with_its_limits() {
    let fake = Fake::new(SIGMA_7);
    fake.set(Entry::Noisy, 1.0);
    let text = format!(
        "[haptic]\ndriver = \"force-dimension\"\npath = {:?}\ndevice = \"10432\"\nforce_max_n = 1.5\n",
        fake.path
    );
    let station = StationFile::parse(&text, "station.toml".as_ref()).unwrap();
    let mut device = station.haptic.unwrap().open().unwrap();
    let capabilities = device.capabilities();
    assert!((capabilities.force_max_n - 1.5).abs() < 1e-6);
    assert!(capabilities.renders_torque());
    let mut strongest = 0.0f64;
    poll_for(PATIENCE, |now_ns| {
        device.send(push(Vec3::new(0.0, 50.0, 0.0)), now_ns);
        strongest = strongest.max(fake.force_n());
        strongest < 1.49
    });
    assert!((1.49..1.501).contains(&strongest), "{strongest}");
}

#[test]
fn the_suite_passes_and_notices_a_broken_line() {
    let fake = Fake::new(OMEGA_7);
    let start = Instant::now();
    loop {
        let mut unplug = || fake.set(Entry::ReadError, 2.0);
        let mut options = Options {
            watch: Duration::from_secs(1),
            unplug: Some(&mut unplug),
        };
        let report = hardware::conformance::force_dimension(&fake.path, None, &mut options);
        fake.set(Entry::ReadError, 0.0);
        if report.passed() {
            for name in ["unplug", "opening", "consistent"] {
                let outcome = report.check(name).map(|check| check.outcome);
                assert_eq!(outcome, Some(CheckOutcome::Pass), "{report}");
            }
            return;
        }
        // A busy machine may spoil the rate for a while.
        assert!(start.elapsed() < Duration::from_secs(120), "{report}");
    }
}
