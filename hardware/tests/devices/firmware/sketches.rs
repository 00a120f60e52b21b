//! The Arduino sketches, compiled and run against a stand-in of `Arduino.h`.

use std::io::Write;
use std::process::{Command, Stdio};

use hardware::rig::frame::FrameReader;
use hardware::rig::wire::{Capabilities, DeviceKind, Force, Hello, Kind, Message, State, Status};

use super::compiler::{Language, compile, path};

/// Bytes that a sketch sends in half a second while a host speaks.
fn said(sketch: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let arduino = path("tests/devices/firmware/arduino");
    let include = format!("-I{}", arduino.display());
    let made = compile(Language::Cpp, &path(sketch), &[&include], &folder);
    let mut program = Command::new(made)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the sketch runs");
    let mut host = program.stdin.take().expect("a pipe");
    for frame in [
        Hello { version: 1 }.frame(1),
        Force::default().frame(2),
        Force::default().frame(2),
    ] {
        host.write_all(frame.as_bytes()).expect("the sketch reads");
    }
    drop(host);
    let out = program.wait_with_output().expect("the sketch ends");
    assert!(out.status.success(), "{sketch}: {}", out.status);
    out.stdout
}

fn is_a_haptic_device(sketch: &str) {
    let mut reader = FrameReader::new();
    let (mut description, mut statuses, mut clock_us) = (None, Vec::new(), Vec::new());
    for byte in said(sketch) {
        let Some(payload) = reader.push(byte) else {
            continue;
        };
        let message = Message::new(payload.expect("a good frame")).expect("a message");
        match message.kind() {
            Kind::Capabilities => {
                description = Some(Capabilities::parse(&message).expect("a description"));
            }
            Kind::State => {
                let state = State::parse(&message).expect("a sample");
                statuses.push(state.status);
                clock_us.push(state.device_time_us);
            }
            kind => panic!("{sketch} says {kind:?}"),
        }
    }
    let can = description.expect("the sketch answers");
    assert_eq!((can.kind, can.rate_hz), (DeviceKind::Haptic, 1000));
    // The sketch runs for 5000 rounds of 0.1 ms.
    assert!((499..=501).contains(&statuses.len()), "{}", statuses.len());
    assert_eq!(statuses[2], Status::FORCE_ON);
    assert_eq!(statuses.last(), Some(&Status::WATCHDOG));
    // The first sample may come at once.
    let steps = clock_us[1..]
        .windows(2)
        .map(|two| two[1].wrapping_sub(two[0]));
    assert!(steps.clone().all(|us| us == 1000), "{:?}", steps.max());
}

#[test]
fn the_teensys_sketch_is_a_haptic_device() {
    is_a_haptic_device("firmware/teensy/teensy.ino");
}

#[test]
fn the_rp2040s_sketch_is_a_haptic_device() {
    is_a_haptic_device("firmware/rp2040/rp2040.ino");
}
