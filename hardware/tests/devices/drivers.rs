//! The drivers on real ptys, against the emulated station.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::emulate::{Faults, HapticModel, LineFaults};
use hardware::hapi::{HapiHaptic, pantograph::Pantograph};
use hardware::rig::wire::Status;
use hardware::rig::{RigHaptic, RigPedal};
use hardware::woody::WoodyHaptic;
use rt_core::math::Vec3;
use rt_core::port::{Buttons, ForceCommand, HapticDevice, Pedal, Polled, Tracker};

use crate::support::{Emulator, PATIENCE, now_ns, persist, poll_for};

const NO_FORCE: ForceCommand = ForceCommand {
    opening_n: 0.0,
    force_n: Vec3::new(0.0, 0.0, 0.0),
    torque_nm: Vec3::new(0.0, 0.0, 0.0),
};

#[test]
fn the_haptic_device_answers_streams_and_follows_its_script() {
    let emulator = Emulator::start();
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let capabilities = device.capabilities();
    assert!((capabilities.force_max_n - 3.3).abs() < 1e-3);
    assert!((capabilities.rate_hz - 1000.0).abs() < 1.0);

    let mut heights = Vec::new();
    let mut grasped = false;
    let mut moved_m = 0.0f32;
    poll_for(PATIENCE, |now_ns| {
        device.send(NO_FORCE, now_ns);
        if let Polled::Fresh(sample) = device.poll(now_ns) {
            let at = sample.device_from_handle.translation.vector;
            assert!(at.norm() < 0.11);
            grasped |= sample.buttons.contains(Buttons::GRASP);
            heights.push(at);
            moved_m = moved_m.max((at - heights[0]).norm());
        }
        heights.len() <= 1000 || !grasped || moved_m <= 0.03
    });
    assert!(heights.len() > 1000, "{} samples", heights.len());
    assert!(grasped, "the script closes the jaws after 5.3 s");
    assert!(
        moved_m > 0.03,
        "the hand moved the handle by {moved_m} m only"
    );
    let counters = device.counters();
    // On a busy machine a backlog builds up. Only its newest bytes are read, and they begin inside
    // a frame.
    assert!(counters.bad_frames * 50 < counters.frames, "{counters:?}");
}

#[test]
fn a_force_pushes_the_hand_back() {
    let emulator = Emulator::start();
    pushes_back(|| RigHaptic::open(&emulator.lines.haptic));
    let emulator = Emulator::with_model(HapticModel::Woody, LineFaults::default());
    pushes_back(|| WoodyHaptic::open(&emulator.lines.haptic));
    let emulator = Emulator::with_model(HapticModel::Hapi, LineFaults::default());
    pushes_back(|| HapiHaptic::open(&emulator.lines.haptic, Pantograph::GEN3));
}

#[test]
fn the_emulated_woody_answers_wrong_commands_as_the_firmware_does() {
    let emulator = Emulator::with_model(HapticModel::Woody, LineFaults::default());
    let path = &emulator.lines.haptic;
    let mut line = File::options().read(true).write(true).open(path).unwrap();
    let mut answers = BufReader::new(line.try_clone().unwrap());
    for (text, code) in [
        ("[0,0]\n", 512),
        ("0,0,0]\n", 256),
        ("[0,0,0]x\n", 8),
        ("[0,0,zero]\n", 1024),
        // The firmware is fast enough for commands that come in quick succession.
        ("[0,0,0]\n[0,0,0]\n", 0),
    ] {
        line.write_all(text.as_bytes()).unwrap();
        for _ in text.matches(']') {
            let mut answer = String::new();
            answers.read_line(&mut answer).unwrap();
            assert!(
                answer.ends_with(&format!(",{code}]\n")),
                "{text:?}: {answer}"
            );
        }
    }
}

/// Checks that a force moves the handle. The script moves the hand too, and a busy machine lets the
/// force fade. Each round pushes to both sides twice, so that an even drift cancels. A device lost
/// by a busy machine is opened anew.
fn pushes_back<D: HapticDevice>(open: impl Fn() -> Result<D, HardwareError>) {
    let mut device = Some(persist(&open));
    let mut mean_x = |force_n: f32| {
        let mut xs = Vec::new();
        poll_for(Duration::from_millis(250), |now_ns| {
            let Some(open_device) = &mut device else {
                return false;
            };
            open_device.send(
                ForceCommand {
                    force_n: Vec3::new(force_n, 0.0, 0.0),
                    ..NO_FORCE
                },
                now_ns,
            );
            match open_device.poll(now_ns) {
                Polled::Fresh(sample) => xs.push(sample.device_from_handle.translation.vector.x),
                Polled::Nothing => {}
                Polled::Lost => {
                    device = None;
                    device = Some(persist(&open));
                }
            }
            true
        });
        let late = &xs[xs.len() / 2..];
        late.iter().sum::<f32>() / late.len() as f32
    };
    let start = Instant::now();
    loop {
        let [left, right, still_right, still_left] = [-2.0, 2.0, 2.0, -2.0].map(&mut mean_x);
        let apart_m = 0.5 * (right + still_right - left - still_left);
        if apart_m > 4e-3 {
            break;
        }
        assert!(start.elapsed() < PATIENCE, "{apart_m}");
    }
}

#[test]
fn a_silent_controller_loses_the_force_and_may_continue() {
    let emulator = Emulator::start();
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let push = ForceCommand {
        force_n: Vec3::new(1.0, 0.0, 0.0),
        ..NO_FORCE
    };
    let status_is = |device: &mut RigHaptic, wanted: Status, force: Option<ForceCommand>| {
        let mut seen = false;
        poll_for(PATIENCE, |now_ns| {
            if let Some(force) = force {
                device.send(force, now_ns);
            }
            seen = matches!(device.poll(now_ns), Polled::Fresh(_))
                && device.status().status.contains(wanted);
            !seen
        });
        seen
    };
    assert!(status_is(&mut device, Status::FORCE_ON, Some(push)));
    assert!(status_is(&mut device, Status::WATCHDOG, None));
    assert!(status_is(&mut device, Status::FORCE_ON, Some(push)));
}

#[test]
fn the_tracker_streams_the_endoscope() {
    let emulator = Emulator::start();
    let mut tracker = BirdTracker::open(&emulator.lines.tracker, BirdSetup::default()).unwrap();
    let expected = crate::support::camera_in_tracker();
    let mut samples = 0;
    poll_for(PATIENCE, |now_ns| {
        if let Polled::Fresh(sample) = tracker.poll(now_ns) {
            let off = sample.tracker_from_sensor.translation.vector - expected;
            assert!(off.norm() < 0.05, "{off}");
            samples += 1;
        }
        samples < 50
    });
    assert_eq!(samples, 50);
    assert_eq!(tracker.counters().bad_frames, 0);
}

#[test]
fn the_pedal_reports_its_switches_when_the_script_presses_them() {
    let emulator = Emulator::start();
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let mut pedal = RigPedal::open(&emulator.lines.pedal).unwrap();
    let mut pressed = false;
    let mut released_again = false;
    poll_for(PATIENCE, |now_ns| {
        device.poll(now_ns);
        device.send(NO_FORCE, now_ns);
        if let Polled::Fresh(sample) = pedal.poll(now_ns) {
            released_again |= pressed && !sample.coagulate;
            pressed |= sample.coagulate;
        }
        !released_again
    });
    assert!(pressed && released_again);
}

#[test]
fn every_device_can_be_opened_again_after_it_was_closed() {
    let emulator = Emulator::start();
    for _ in 0..3 {
        let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
        let mut tracker = BirdTracker::open(&emulator.lines.tracker, BirdSetup::default()).unwrap();
        let mut pedal = RigPedal::open(&emulator.lines.pedal).unwrap();
        let (mut d, mut t, mut p) = (false, false, false);
        poll_for(PATIENCE, |now_ns| {
            d |= matches!(device.poll(now_ns), Polled::Fresh(_));
            t |= matches!(tracker.poll(now_ns), Polled::Fresh(_));
            p |= matches!(pedal.poll(now_ns), Polled::Fresh(_));
            !(d && t && p)
        });
        assert!(d && t && p);
    }
}

#[test]
fn an_unplugged_line_is_lost_and_a_new_driver_finds_it_again() {
    let hang_up = Faults {
        hang_up_at_s: Some(0.7),
        back_after_s: Some(0.3),
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: hang_up,
        ..LineFaults::default()
    });
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let mut lost = false;
    poll_for(PATIENCE, |now_ns| {
        lost = matches!(device.poll(now_ns), Polled::Lost);
        !lost
    });
    assert!(lost && device.is_lost());
    assert!(
        matches!(device.poll(now_ns()), Polled::Lost),
        "the device stays lost"
    );
    device.send(NO_FORCE, now_ns());

    let mut found = None;
    poll_for(PATIENCE, |_| {
        found = RigHaptic::open(&emulator.lines.haptic).ok();
        found.is_none()
    });
    let mut device = found.expect("plugged in again");
    let mut fresh = false;
    poll_for(PATIENCE, |now_ns| {
        fresh = matches!(device.poll(now_ns), Polled::Fresh(_));
        !fresh
    });
    assert!(fresh);
}

#[test]
fn a_second_controller_is_told_the_process_that_holds_the_line() {
    let emulator = Emulator::start();
    let _first = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let error = RigHaptic::open(&emulator.lines.haptic).unwrap_err();
    assert!(matches!(error, HardwareError::Held { .. }), "{error}");
    let own = format!("(process {})", std::process::id());
    assert!(error.to_string().contains(&own), "{error}");
}

#[test]
fn a_second_emulator_in_the_same_directory_is_refused() {
    let emulator = Emulator::start();
    let error = emulator.try_another().unwrap_err();
    assert!(matches!(error, HardwareError::Busy { .. }), "{error}");
}

#[test]
fn the_wrong_line_is_named() {
    let emulator = Emulator::start();
    let error = RigHaptic::open(&emulator.lines.pedal).unwrap_err();
    assert!(
        matches!(error, HardwareError::WrongDevice { .. }),
        "{error}"
    );
    // A bird sends nothing unasked, or bytes that are no frames.
    let error = RigHaptic::open(&emulator.lines.tracker).unwrap_err();
    let is_no_answer = matches!(
        error,
        HardwareError::Silent { .. } | HardwareError::Garbled { .. }
    );
    assert!(is_no_answer, "{error}");
    let error = BirdTracker::open(&emulator.lines.haptic, BirdSetup::default()).unwrap_err();
    assert!(matches!(error, HardwareError::Silent { .. }), "{error}");
}

#[test]
fn paths_that_are_no_devices_are_refused_as_such() {
    let directory = tempfile::tempdir().unwrap();
    let missing = RigHaptic::open(&directory.path().join("nothing")).unwrap_err();
    assert!(
        matches!(missing, HardwareError::Missing { .. }),
        "{missing}"
    );
    let file = directory.path().join("file");
    std::fs::write(&file, "text").unwrap();
    let error = RigHaptic::open(&file).unwrap_err();
    assert!(matches!(error, HardwareError::NotSerial { .. }), "{error}");
}

#[test]
fn the_links_are_removed_when_the_emulator_ends() {
    let emulator = Emulator::start();
    let lines = emulator.lines.clone();
    assert!(lines.haptic.exists());
    let directory = emulator.stop();
    for line in [lines.haptic, lines.tracker, lines.pedal] {
        assert!(
            std::fs::symlink_metadata(&line).is_err(),
            "{}",
            line.display()
        );
    }
    drop(directory);
}

#[test]
fn a_noisy_line_still_gives_good_samples_and_counts_the_bad_ones() {
    let noisy = Faults {
        lost: 0.001,
        duplicated: 0.001,
        corrupted: 0.001,
        split: 0.2,
        merged: 0.2,
        degenerate: 0.05,
        babble: 0.05,
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: noisy,
        // A bird's answers have no checksum, so its line must be silent between them.
        tracker: Faults {
            babble: 0.0,
            ..noisy
        },
        pedal: noisy,
    });
    let mut device = persist(|| RigHaptic::open(&emulator.lines.haptic));
    let mut tracker = persist(|| BirdTracker::open(&emulator.lines.tracker, BirdSetup::default()));
    let expected = crate::support::camera_in_tracker();
    let (mut good, mut seen) = (0, 0);
    poll_for(PATIENCE, |now_ns| {
        device.send(NO_FORCE, now_ns);
        if let Polled::Fresh(sample) = device.poll(now_ns) {
            good += 1;
            let pose = sample.device_from_handle;
            assert!(pose.translation.vector.norm() < 0.11, "{pose}");
            assert!((pose.rotation.norm() - 1.0).abs() < 1e-3, "{pose}");
        }
        if let Polled::Fresh(sample) = tracker.poll(now_ns) {
            seen += 1;
            let off = sample.tracker_from_sensor.translation.vector - expected;
            assert!(off.norm() < 0.3, "{off}");
        }
        let counters = device.counters();
        let enough = counters.bad_frames > 10 && counters.lost_frames > 10;
        good <= 500 || seen <= 50 || !enough || tracker.counters().bad_frames == 0
    });
    let counters = device.counters();
    assert!(good > 500 && seen > 50, "{good} {seen}");
    assert!(
        counters.bad_frames > 10 && counters.lost_frames > 10,
        "{counters:?}"
    );
    assert!(tracker.counters().bad_frames > 0);
}

#[test]
fn a_stuck_line_gives_no_new_sample() {
    let stuck = Faults {
        stuck_from_s: Some(0.5),
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: stuck,
        ..LineFaults::default()
    });
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    // A stuck line keeps sending, but nothing new.
    let (mut since, mut repeats) = (device.counters().bad_frames, 0);
    poll_for(PATIENCE, |now_ns| {
        if matches!(device.poll(now_ns), Polled::Fresh(_)) {
            since = device.counters().bad_frames;
        }
        repeats = device.counters().bad_frames - since;
        repeats < 300
    });
    assert!(repeats >= 300, "{repeats} in a row without news");
}

#[test]
fn a_pedal_that_falls_silent_reads_as_released() {
    // The line gets stuck while the script presses, so the last report says "pressed" for ever.
    let stuck = Faults {
        stuck_from_s: Some(3.9),
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        pedal: stuck,
        ..LineFaults::default()
    });
    let mut device = RigHaptic::open(&emulator.lines.haptic).unwrap();
    let mut pedal = RigPedal::open(&emulator.lines.pedal).unwrap();
    let (mut pressed, mut released_again) = (false, false);
    poll_for(PATIENCE, |now_ns| {
        device.poll(now_ns);
        device.send(NO_FORCE, now_ns);
        if let Polled::Fresh(sample) = pedal.poll(now_ns) {
            released_again |= pressed && !sample.coagulate;
            pressed |= sample.coagulate;
        }
        !released_again
    });
    assert!(pressed && released_again);
}
