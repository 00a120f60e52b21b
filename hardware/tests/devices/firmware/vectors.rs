//! Tests that the firmware in C and C++ sends the frames that `PROTOCOL.md` prints.

use hardware::rig::device::Motion;
use hardware::rig::wire::{Capabilities, Force, Switches};

use super::compiler::Language;
use super::twin::Firmware;

/// Frames of the test vectors in `PROTOCOL.md`, in the order of the document.
fn printed() -> Vec<Vec<u8>> {
    let (_, vectors) = include_str!("../../../PROTOCOL.md")
        .split_once("## Test vectors")
        .expect("a chapter");
    let blocks = vectors.split("```text").skip(1);
    let hexadecimal = blocks.map(|block| block.split("```").next().expect("a block"));
    let bytes = |text: &str| {
        let words = text.split_whitespace();
        words
            .map(|word| u8::from_str_radix(word, 16).expect("a byte"))
            .collect()
    };
    hexadecimal.map(bytes).collect()
}

#[test]
fn the_checksum_is_the_catalogued_crc_32c() {
    let firmware = Firmware::new(Language::C);
    let twin = firmware.device(&Capabilities::touch_class());
    assert_eq!(twin.crc(b"123456789"), 0xE306_9283);
}

fn device_says_the_printed_bytes(language: Language) {
    let [
        hello,
        force,
        stop,
        capabilities,
        state,
        switches,
        opening @ ..,
    ] = <[Vec<u8>; 9]>::try_from(printed()).expect("nine vectors");
    let firmware = Firmware::new(language);
    let mut twin = firmware.device(&Capabilities::touch_class());
    twin.receive(&hello, 0);
    assert_eq!(twin.answer(), capabilities);
    assert!(twin.answer().is_empty(), "one answer for one greeting");

    twin.receive(&force, 0);
    let wanted = Force {
        opening_n: None,
        force_n: [1.0, -2.0, 3.3],
        torque_nm: [0.01, 0.0, 0.0],
    };
    // The force exceeds the peak of 3.3 N, and the device renders no torque.
    let size_n = wanted.force_n.iter().map(|x| x * x).sum::<f32>().sqrt();
    let rendered = twin.force(0);
    for (rendered, wanted) in rendered.force_n.iter().zip(wanted.force_n) {
        assert!(
            (rendered - wanted * 3.3 / size_n).abs() < 1e-5,
            "{rendered}"
        );
    }
    assert!(rendered.torque_nm.iter().all(|part| part.abs() < 1e-9));

    for _ in 2..9 {
        twin.state(&Motion::default(), 0);
    }
    let now_us = 67_438_087;
    twin.receive(Force::default().frame(515).as_bytes(), now_us);
    let motion = Motion {
        position_m: [0.01, -0.02, 0.03],
        velocity_m_s: [0.1, 0.0, -0.1],
        buttons: 1,
        ..Motion::default()
    };
    assert_eq!(twin.state(&motion, now_us), state);
    twin.receive(&stop, now_us);
    assert!(twin.state(&motion, now_us).is_empty(), "after a stop");
    assert_eq!(twin.counters().messages, 4);

    let mut twin = firmware.device(&Capabilities::touch_class_with_opening());
    twin.receive(&hello, 0);
    assert_eq!(twin.answer(), opening[0]);
    for _ in 2..9 {
        twin.state(&Motion::default(), 0);
    }
    let newest = Force {
        opening_n: Some(0.0),
        ..Force::default()
    };
    twin.receive(newest.frame(515).as_bytes(), now_us);
    let half = Motion {
        opening: 0.5,
        ..motion
    };
    assert_eq!(twin.state(&half, now_us), opening[1]);
    twin.receive(&hello, now_us);
    twin.receive(&opening[2], now_us);
    let opening_n = twin.force(now_us).opening_n.expect("it opens");
    assert!((opening_n - 1.5).abs() < 1e-6, "{opening_n}");

    let mut twin = firmware.device(&Capabilities::pedal(100));
    twin.receive(&hello, 0);
    twin.answer();
    twin.switches(Switches::default());
    let coagulate = Switches {
        coagulate: true,
        ..Switches::default()
    };
    assert_eq!(twin.switches(coagulate), switches);
}

#[test]
fn the_device_in_c_sends_the_documented_bytes() {
    device_says_the_printed_bytes(Language::C);
}

#[test]
fn the_device_in_cpp_sends_the_documented_bytes() {
    device_says_the_printed_bytes(Language::Cpp);
}
