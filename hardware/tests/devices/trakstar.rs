//! Tests the tracker's driver over USB packets with emulated birds.

use std::path::Path;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::bird::device::Bird;
use hardware::bird::wire::{Hemisphere, Record, Scale, command, parameter};
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::conformance::{CheckOutcome, Options, tracker_by};
use hardware::emulate::EmulatedBulk;
use nalgebra::UnitQuaternion;
use rt_core::math::Vec3;
use rt_core::port::{Polled, Tracker, TrackerSample};

use crate::support::poll_for;

fn at(x: f32) -> Record {
    Record {
        position_m: [x, 0.1, -0.2],
        rotation: UnitQuaternion::from_scaled_axis(Vec3::new(0.0, x, 0.0)),
    }
}

fn open(
    poses: &[Record],
    setup: BirdSetup,
) -> (Result<BirdTracker, HardwareError>, Arc<AtomicBool>) {
    let (pipe, plug) = EmulatedBulk::new(poses);
    let opened = BirdTracker::open_bulk(Path::new("emulated"), Box::new(pipe), setup);
    (opened, plug)
}

fn samples(tracker: &mut BirdTracker, wanted: usize) -> Vec<TrackerSample> {
    let mut samples = Vec::new();
    poll_for(Duration::from_secs(20), |now_ns| {
        if let Polled::Fresh(sample) = tracker.poll(now_ns) {
            samples.push(sample);
        }
        samples.len() < wanted
    });
    samples
}

#[test]
fn records_are_asked_for_and_arrive() {
    let start = Instant::now();
    let (tracker, plug) = open(&[at(0.3)], BirdSetup::default());
    let mut tracker = tracker.unwrap();
    let samples = samples(&mut tracker, 20);
    assert_eq!(samples.len(), 20);
    for sample in &samples {
        let pose = sample.tracker_from_sensor;
        assert!((pose.translation.vector - Vec3::new(0.3, 0.1, -0.2)).norm() < 3e-4);
        assert!((pose.rotation.angle() - 0.3).abs() < 1e-3);
    }
    assert!(samples.windows(2).all(|pair| pair[1].at_ns > pair[0].at_ns));
    // A stall of a second or more leaves a backlog, which is cut off inside a record.
    let cut = 2 * start.elapsed().as_secs();
    assert!(tracker.counters().bad_frames <= cut);

    plug.store(true, Ordering::Relaxed);
    let mut lost = false;
    poll_for(Duration::from_secs(20), |now_ns| {
        lost = matches!(tracker.poll(now_ns), Polled::Lost);
        !lost
    });
    assert!(lost && tracker.is_lost());
}

#[test]
fn endoscope_takes_one_bird_of_a_group() {
    let setup = BirdSetup {
        birds: 3,
        bird: 2,
        ..BirdSetup::default()
    };
    let (tracker, _plug) = open(&[at(0.1), at(0.2), at(0.3)], setup);
    let mut tracker = tracker.unwrap();
    let samples = samples(&mut tracker, 10);
    assert_eq!(samples.len(), 10);
    for sample in samples {
        let x = sample.tracker_from_sensor.translation.x;
        assert!((x - 0.2).abs() < 3e-4, "{x}");
    }
}

#[test]
fn a_single_bird_leaves_the_group_that_an_earlier_host_made() {
    let mut bird = Bird::flock(&[at(0.3)]);
    bird.receive(&[command::CHANGE, parameter::AUTO_CONFIGURE, 1], |_| {});
    bird.receive(&[command::CHANGE, parameter::GROUP_MODE, 1], |_| {});
    let start = Instant::now();
    let (pipe, _plug) = EmulatedBulk::of(bird);
    let name = Path::new("emulated");
    let mut tracker = BirdTracker::open_bulk(name, Box::new(pipe), BirdSetup::default()).unwrap();
    assert_eq!(samples(&mut tracker, 20).len(), 20);
    // If records carried an address, each would be followed by a stray byte.
    assert!(tracker.counters().bad_frames <= 2 * start.elapsed().as_secs());
}

#[test]
fn an_extended_range_controller_is_refused() {
    let bird = Bird::flock(&[at(0.3)]).with_model(*b"6DERC     ");
    let (pipe, _plug) = EmulatedBulk::of(bird);
    let name = Path::new("emulated");
    let error = BirdTracker::open_bulk(name, Box::new(pipe), BirdSetup::default()).unwrap_err();
    assert!(error.to_string().contains("144 in"), "{error}");
}

#[test]
fn the_larger_scale_has_a_larger_range() {
    let setup = BirdSetup {
        scale: Scale::Inches72,
        hemisphere: Hemisphere::Forward,
        ..BirdSetup::default()
    };
    let (tracker, _plug) = open(&[at(1.5)], setup);
    let mut tracker = tracker.unwrap();
    for sample in samples(&mut tracker, 5) {
        let x = sample.tracker_from_sensor.translation.x;
        assert!((x - 1.5).abs() < 3e-4, "{x}");
    }
}

#[test]
fn the_suite_passes_on_packets_too() {
    let plug = Mutex::new(Arc::new(AtomicBool::new(false)));
    let attempt = || {
        let (tracker, pulled) = open(&[at(0.3)], BirdSetup::default());
        *plug.lock().expect("nobody panics with it") = pulled;
        tracker
    };
    let mut pull = || {
        plug.lock()
            .expect("nobody panics with it")
            .store(true, Ordering::Relaxed);
    };
    // A busy machine may spoil the rate for a while.
    let start = Instant::now();
    let mut report = tracker_by(&attempt, &mut options(&mut pull));
    while !report.passed() && start.elapsed() < Duration::from_secs(120) {
        report = tracker_by(&attempt, &mut options(&mut pull));
    }
    print!("{report}");
    assert!(report.passed(), "{report}");
    let unplug = report.check("unplug").map(|check| check.outcome);
    assert_eq!(unplug, Some(CheckOutcome::Pass));
}

fn options<'a>(pull: &'a mut dyn FnMut()) -> Options<'a> {
    Options {
        watch: Duration::from_secs(1),
        unplug: Some(pull),
    }
}

#[test]
fn a_missing_unit_is_reported() {
    let error = BirdTracker::open_usb(Path::new("no-such-unit"), BirdSetup::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("trakSTAR") || text.contains("USB"), "{text}");
}
