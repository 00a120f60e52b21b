//! Every driver under every fault of a line. Nothing panics, every sample is plausible, the motors
//! get no more than the clamp, no force remains when the driver is dropped, and a line that
//! recovers is used again.

use std::path::Path;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::bird::wire::Scale;
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::emulate::{Faults, HapticModel, LineFaults};
use hardware::hapi::{HapiHaptic, pantograph::Pantograph};
use hardware::rig::{RigHaptic, RigPedal};
use hardware::woody::WoodyHaptic;
use rt_core::math::Vec3;
use rt_core::port::{DeviceSample, ForceCommand, HapticDevice, Pedal, Polled, Tracker};

use crate::support::{Emulator, now_ns};

/// Long enough for a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
/// Start of the faults on the emulator's clock.
const FROM_S: f32 = 0.3;
/// End of the faults on the emulator's clock.
const UNTIL_S: f32 = 0.8;

/// Every fault of a real line, at least as strong as on a bad one.
fn faults() -> Vec<(&'static str, Faults)> {
    let ill = Faults {
        from_s: FROM_S,
        until_s: Some(UNTIL_S),
        ..Faults::default()
    };
    vec![
        ("lost", Faults { lost: 0.02, ..ill }),
        ("merged", Faults { merged: 0.5, ..ill }),
        ("split", Faults { split: 0.5, ..ill }),
        (
            "duplicated",
            Faults {
                duplicated: 0.02,
                ..ill
            },
        ),
        (
            "corrupted",
            Faults {
                corrupted: 0.02,
                ..ill
            },
        ),
        (
            "stuck",
            Faults {
                stuck_from_s: Some(FROM_S),
                ..ill
            },
        ),
        (
            "hang-up",
            Faults {
                hang_up_at_s: Some(FROM_S),
                back_after_s: Some(UNTIL_S - FROM_S),
                ..Faults::default()
            },
        ),
        (
            "16 ms batches",
            Faults {
                batch_ms: 16,
                ..ill
            },
        ),
        (
            "slow reader",
            Faults {
                slow_reader_ms: 20,
                ..ill
            },
        ),
        (
            "no number",
            Faults {
                degenerate: 0.3,
                ..ill
            },
        ),
        ("noise", Faults { babble: 0.5, ..ill }),
        (
            "all at once",
            Faults {
                lost: 0.01,
                merged: 0.3,
                split: 0.3,
                duplicated: 0.01,
                corrupted: 0.01,
                batch_ms: 16,
                degenerate: 0.1,
                babble: 0.1,
                ..ill
            },
        ),
    ]
}

/// Opens a device as a person would: again and again.
fn opened<D>(open: impl Fn() -> Result<D, HardwareError>) -> D {
    unless_uncalibrated(open).expect("it needs no calibration")
}

/// Opens a device; `None` if it needs a person's calibration.
fn unless_uncalibrated<D>(open: impl Fn() -> Result<D, HardwareError>) -> Option<D> {
    let start = Instant::now();
    loop {
        match open() {
            Ok(device) => return Some(device),
            Err(HardwareError::Calibration { .. }) => return None,
            Err(error) => assert!(start.elapsed() < PATIENCE, "{error}"),
        }
    }
}

fn is_sane(sample: &DeviceSample, reach_m: f32) -> bool {
    let pose = sample.device_from_handle;
    let velocity = sample.velocity_m_s.unwrap_or_default();
    pose.translation.vector.norm() <= reach_m
        && (pose.rotation.norm() - 1.0).abs() < 1e-3
        && velocity.iter().all(|part| part.is_finite())
}

/// One haptic driver under every fault.
fn under_every_fault<D: HapticDevice>(
    model: HapticModel,
    reach_m: f32,
    open: impl Fn(&Path) -> Result<D, HardwareError>,
) {
    // This force is too large on purpose. The driver itself must limit it to the device's peak.
    let push = ForceCommand {
        opening_n: 0.0,
        force_n: Vec3::new(-60.0, 80.0, 40.0),
        torque_nm: Vec3::zeros(),
    };
    for (name, faults) in faults() {
        let emulator = Emulator::with_model(
            model,
            LineFaults {
                haptic: faults,
                ..LineFaults::default()
            },
        );
        let line = &emulator.lines.haptic;
        let mut opened = Some(opened(|| open(line)));
        let start = Instant::now();
        let mut recovered = 0;
        while let Some(device) = opened.as_mut().filter(|_| recovered < 20) {
            assert!(start.elapsed() < PATIENCE, "{name}: no samples again");
            let now_ns = now_ns();
            device.send(push, now_ns);
            match device.poll(now_ns) {
                Polled::Fresh(sample) => {
                    assert!(is_sane(&sample, reach_m), "{name}: {sample:?}");
                    recovered += u32::from(emulator.seen().time_s > UNTIL_S);
                }
                Polled::Nothing => {}
                Polled::Lost => {
                    drop(opened.take());
                    opened = unless_uncalibrated(|| open(line));
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        // A hAPI board that received nothing for long, perhaps because of a busy machine, has lost
        // its angles and says so.
        let is_refused = model == HapticModel::Hapi && opened.is_none();
        assert!(opened.is_some() || is_refused, "{name}: not calibrated");
        // This checks the motors, not the force at the hand. The driver computes a torque for the
        // last known position of the handle, which is slightly wrong while samples are missing or
        // damage looks like a movement.
        let seen = emulator.seen();
        assert!(
            seen.motor_load <= 1.001,
            "{name}: {} of the most",
            seen.motor_load
        );
        assert!(
            seen.strongest_n > 0.1 || is_refused,
            "{name}: the force does arrive"
        );
        drop(opened);
        let ended = Instant::now();
        while emulator.seen().force_n > 1e-3 {
            assert!(ended.elapsed() < PATIENCE, "{name}: a force is left");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn the_rig_survives_every_fault() {
    under_every_fault(HapticModel::TouchRig, 0.2001, RigHaptic::open);
}

#[test]
fn the_rig_survives_damage_on_the_way_to_the_device() {
    // These frames have a checksum, so damage on the way to the device makes no force.
    let faults = Faults {
        corrupted_to_device: 0.02,
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: faults,
        ..LineFaults::default()
    });
    let mut device = opened(|| RigHaptic::open(&emulator.lines.haptic));
    let start = Instant::now();
    let mut samples = 0;
    while samples < 500 {
        assert!(start.elapsed() < PATIENCE);
        let now_ns = now_ns();
        device.send(
            ForceCommand {
                opening_n: 0.0,
                force_n: Vec3::new(0.5, 0.0, 0.0),
                torque_nm: Vec3::zeros(),
            },
            now_ns,
        );
        samples += u32::from(matches!(device.poll(now_ns), Polled::Fresh(_)));
        std::thread::sleep(Duration::from_millis(1));
    }
    let strongest_n = emulator.seen().strongest_n;
    assert!((0.49..0.51).contains(&strongest_n), "{strongest_n} N");
}

#[test]
fn woody() {
    under_every_fault(HapticModel::Woody, 0.3001, WoodyHaptic::open);
}

#[test]
fn hapi() {
    under_every_fault(HapticModel::Hapi, 0.1501, |path| {
        HapiHaptic::open(path, Pantograph::GEN3)
    });
}

#[test]
fn the_tracker() {
    for (name, faults) in faults() {
        let emulator = Emulator::with_faults(LineFaults {
            tracker: faults,
            ..LineFaults::default()
        });
        let line = &emulator.lines.tracker;
        let open = || BirdTracker::open(line, BirdSetup::default());
        let mut tracker = opened(open);
        let start = Instant::now();
        let mut recovered = 0;
        while recovered < 5 {
            assert!(start.elapsed() < PATIENCE, "{name}: no samples again");
            match tracker.poll(now_ns()) {
                Polled::Fresh(sample) => {
                    let pose = sample.tracker_from_sensor;
                    let most = pose.translation.vector.amax();
                    assert!(most <= Scale::Inches36.full_m(), "{name}: {pose}");
                    assert!((pose.rotation.norm() - 1.0).abs() < 1e-3, "{name}: {pose}");
                    recovered += u32::from(emulator.seen().time_s > UNTIL_S);
                }
                Polled::Nothing => {}
                Polled::Lost => {
                    drop(tracker);
                    tracker = opened(open);
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn the_pedal() {
    for (name, faults) in faults() {
        let emulator = Emulator::with_faults(LineFaults {
            pedal: faults,
            ..LineFaults::default()
        });
        let line = &emulator.lines.pedal;
        let mut pedal = opened(|| RigPedal::open(line));
        let start = Instant::now();
        let mut recovered = 0;
        while recovered < 5 {
            assert!(start.elapsed() < PATIENCE, "{name}: no samples again");
            match pedal.poll(now_ns()) {
                Polled::Fresh(sample) => {
                    // No controller renders a force, so the script presses nothing.
                    assert!(!sample.cut && !sample.coagulate, "{name}: {sample:?}");
                    recovered += u32::from(emulator.seen().time_s > UNTIL_S);
                }
                Polled::Nothing => {}
                Polled::Lost => {
                    drop(pedal);
                    pedal = opened(|| RigPedal::open(line));
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn the_wrong_device_is_refused_and_gets_no_force() {
    let models = [HapticModel::TouchRig, HapticModel::Woody, HapticModel::Hapi];
    std::thread::scope(|scope| {
        for model in models {
            scope.spawn(move || {
                let emulator = Emulator::with_model(model, LineFaults::default());
                let line = &emulator.lines.haptic;
                if model != HapticModel::TouchRig {
                    assert!(RigHaptic::open(line).is_err(), "{model:?}");
                }
                if model != HapticModel::Woody {
                    assert!(WoodyHaptic::open(line).is_err(), "{model:?}");
                }
                if model != HapticModel::Hapi {
                    assert!(
                        HapiHaptic::open(line, Pantograph::GEN3).is_err(),
                        "{model:?}"
                    );
                }
                assert!(
                    BirdTracker::open(line, BirdSetup::default()).is_err(),
                    "{model:?}"
                );
                assert!(emulator.seen().strongest_n < 1e-6, "{model:?}");
            });
        }
    });
}
