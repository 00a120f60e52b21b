//! Tests a device that answers the greeting and then sends any bytes.

use std::cell::RefCell;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::PathBuf;

use hardware::rig::RigHaptic;
use hardware::rig::device::{Device, Motion};
use hardware::rig::frame::Frame;
use hardware::rig::wire::Capabilities;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use rt_core::port::{HapticDevice, Polled};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::support::{PATIENCE, now_ns, poll_for};

/// The device's end of a line, which the test operates.
struct EmulatedRig {
    line: File,
    device: Device,
}

/// A pty, its path and its master.
pub(crate) fn pty() -> (PathBuf, OwnedFd) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pty");
    grantpt(&master).expect("a pty");
    unlockpt(&master).expect("a pty");
    let name = ptsname(&master, Vec::new()).expect("its name");
    (PathBuf::from(name.to_str().expect("ASCII")), master)
}

/// Opens a driver on a rig that the test emulates.
fn open_emulated() -> (RigHaptic, EmulatedRig) {
    let (path, master) = pty();
    let thread = std::thread::spawn(move || {
        let mut line = File::from(master);
        let mut device = Device::new(Capabilities::touch_class());
        let mut bytes = [0; 256];
        loop {
            // Reading fails until the driver opens the line.
            let count = line.read(&mut bytes).unwrap_or(0);
            device.receive(&bytes[..count], 0);
            if let Some(answer) = device.answer() {
                line.write_all(answer.as_bytes()).expect("an open line");
                return EmulatedRig { line, device };
            }
        }
    });
    let driver = RigHaptic::open(&path).expect("a open_emulated device");
    (driver, thread.join().expect("it answers"))
}

/// Bytes that a hostile device may send.
fn anything() -> impl Strategy<Value = Vec<u8>> {
    let noise = prop::collection::vec(any::<u8>(), 0..300);
    // Valid frames with any content.
    let framed = (
        prop::sample::select(vec![0x81u8, 0x82, 0x82, 0x82, 0x83, 0x01, 0x7F]),
        prop::collection::vec(any::<u8>(), 0..59),
    )
        .prop_map(|(kind, mut body)| {
            body.insert(0, kind);
            if kind == 0x82 {
                body.resize(43, 0);
            }
            Frame::new(&body).expect("short").as_bytes().to_vec()
        });
    prop_oneof![noise, framed]
}

#[test]
fn samples_are_in_range_on_any_bytes_and_the_next_good_one_is_found() {
    let line = RefCell::new(open_emulated());
    let clock_us = std::cell::Cell::new(0);
    let mut runner = TestRunner::new(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    runner
        .run(&prop::collection::vec(anything(), 0..8), |chunks| {
            let (driver, rig) = &mut *line.borrow_mut();
            for chunk in chunks {
                rig.line.write_all(&chunk).unwrap();
                let mut polls = 0;
                loop {
                    match driver.poll(now_ns()) {
                        Polled::Fresh(sample) => {
                            let pose = sample.device_from_handle;
                            prop_assert!(pose.translation.vector.norm() <= 0.2001);
                            prop_assert!((pose.rotation.norm() - 1.0).abs() < 1e-3);
                            let speed = sample.velocity_m_s.unwrap().norm();
                            prop_assert!(speed.is_finite() && speed < 40.0);
                        }
                        Polled::Nothing => {}
                        Polled::Lost => prop_assert!(false, "noise is no hang-up"),
                    }
                    polls += 1;
                    if polls > 3 {
                        break;
                    }
                }
            }
            // A zero ends any incomplete frame. Then good samples follow, as many as the driver
            // needs to trust clock and position again after hostile samples.
            rig.line.write_all(&[0]).unwrap();
            for ms in 0..40 {
                let good = rig.device.state(&Motion::default(), ms * 1000).unwrap();
                rig.line.write_all(good.as_bytes()).unwrap();
            }
            let mut found = false;
            poll_for(PATIENCE, |now_ns| {
                clock_us.set(clock_us.get() + 1000);
                let motion = Motion::default();
                let good = rig.device.state(&motion, clock_us.get()).unwrap();
                rig.line.write_all(good.as_bytes()).unwrap();
                found = matches!(driver.poll(now_ns), Polled::Fresh(_));
                !found
            });
            prop_assert!(found);
            Ok(())
        })
        .unwrap();
}

#[test]
fn next_good_sample_after_a_flood_is_found() {
    let (mut driver, mut rig) = open_emulated();
    let before = driver.counters();
    // This is more than the reading thread keeps, and more than one poll reads.
    for _ in 0..50 {
        rig.line.write_all(&[0x55; 4000]).unwrap();
        driver.poll(now_ns());
    }
    let mut clock_us = 0;
    let mut is_found = false;
    poll_for(PATIENCE, |now_ns| {
        // A frame written during the backlog may be discarded with it.
        clock_us += 1_000_000;
        let good = rig.device.state(&Motion::default(), clock_us).unwrap();
        rig.line.write_all(&[0]).unwrap();
        rig.line.write_all(good.as_bytes()).unwrap();
        is_found = matches!(driver.poll(now_ns), Polled::Fresh(_));
        !is_found
    });
    assert!(is_found, "{:?}", driver.counters());
    assert_ne!(driver.counters(), before, "the flood is counted");
}
