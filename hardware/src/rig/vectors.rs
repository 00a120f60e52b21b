//! Checks that the test vectors in `PROTOCOL.md` are the bytes that the code encodes.

use super::wire::{Capabilities, Force, Hello, State, Status, Switches, stop_frame};

fn vectors() -> String {
    let state = State {
        opening: None,
        status: Status::FORCE_ON,
        buttons: 1,
        applied_force: 515,
        device_time_us: 67_438_087,
        position_m: [0.01, -0.02, 0.03],
        velocity_m_s: [0.1, 0.0, -0.1],
        rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
    };
    let force = Force {
        opening_n: None,
        force_n: [1.0, -2.0, 3.3],
        torque_nm: [0.01, 0.0, 0.0],
    };
    let switches = Switches {
        coagulate: true,
        ..Switches::default()
    };
    let rows = [
        ("HELLO, number 7", Hello { version: 2 }.frame(7)),
        (
            "FORCE 1, −2, 3.3 N, torque 10 mN m about x, number 5",
            force.frame(5),
        ),
        ("STOP, number 4660", stop_frame(4660)),
        (
            "CAPABILITIES of the emulated device, number 1",
            Capabilities::touch_class().frame(1),
        ),
        (
            "STATE: force on (515), button 0, 67438087 µs, at 10, −20, 30 mm, \
             moving 100, 0, −100 mm/s, not turned, number 9",
            state.frame(9),
        ),
        ("SWITCHES: coagulate, number 3", switches.frame(3)),
        (
            "CAPABILITIES of the emulated handle that opens by 30 mm with 5 N, number 1",
            Capabilities::touch_class_with_opening().frame(1),
        ),
        (
            "STATE as above, half open, number 9",
            State {
                opening: Some(0.5),
                ..state
            }
            .frame(9),
        ),
        (
            "FORCE as above, opening the handle with 1.5 N, number 5",
            Force {
                opening_n: Some(1.5),
                ..force
            }
            .frame(5),
        ),
    ];
    let mut text = String::new();
    for (name, frame) in rows {
        let bytes: Vec<String> = frame
            .as_bytes()
            .iter()
            .map(|b| format!("{b:02X}"))
            .collect();
        let lines: Vec<String> = bytes.chunks(24).map(|line| line.join(" ")).collect();
        text.push_str(&format!(
            "{name}:\n\n```text\n{}\n```\n\n",
            lines.join("\n")
        ));
    }
    text.trim_end().to_owned()
}

#[test]
fn the_protocol_document_has_the_frames_that_the_code_makes() {
    let document = include_str!("../../PROTOCOL.md");
    let vectors = vectors();
    assert!(
        document.trim_end().ends_with(&vectors),
        "PROTOCOL.md should end with:\n{vectors}"
    );
}
