//! Messages of the service.
//!
//! ```json
//! {"session_id":7,"inverse3":[{"device_id":"049D",
//!   "state":{"cursor_position":{"x":0,"y":-0.12,"z":0.15},"cursor_velocity":{"x":0,"y":0,"z":0}},
//!   "status":{"calibrated":true}}],
//!  "wireless_verse_grip":[{"state":{"orientation":{"w":1,"x":0,"y":0,"z":0},
//!   "buttons":{"a":false,"b":false,"c":false}}}]}
//! {"inverse3":[{"device_id":"049D",
//!   "commands":{"set_cursor_force":{"vector":{"x":0,"y":0,"z":1.5}}}}]}
//! ```
//!
//! The service's frame is x right, y away from the user, z up, in metres, from the device's base.
//! Our frame is x right, y up, z to the user, from the centre of the workspace.

use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::Vec3;
use serde::Deserialize;

/// Centre of the workspace in the service's frame, m.
const MIDDLE_M: [f64; 3] = [0.0, -0.12, 0.15];
/// Longest device number, characters; real ones have four.
pub const ID_MAX: usize = 64;

/// The used part of a message from the service. Every field may be missing.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct Message {
    session_id: Option<i64>,
    inverse3: Vec<Device>,
    wireless_verse_grip: Vec<Grip>,
    verse_grip: Vec<Grip>,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct Device {
    device_id: String,
    state: State,
    status: Status,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct State {
    cursor_position: Option<Vector>,
    cursor_velocity: Option<Vector>,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct Status {
    calibrated: Option<bool>,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct Grip {
    state: GripState,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct GripState {
    orientation: Option<Orientation>,
    buttons: GripButtons,
    button: bool,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
struct GripButtons {
    a: bool,
    b: bool,
    c: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
struct Vector {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
struct Orientation {
    w: f64,
    x: f64,
    y: f64,
    z: f64,
}

/// Sample of one device and its grip, in our frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Handle position from the centre of the workspace, m.
    pub position_m: Vec3,
    /// Velocity of the handle, m/s.
    pub velocity_m_s: Vec3,
    /// Rotation of the grip; the identity without a grip.
    pub rotation: UnitQuaternion<f32>,
    /// Buttons a, b and c as bits 0, 1 and 2; the one button of a wired grip is bit 0.
    pub buttons: u8,
}

impl Message {
    /// Parses a message; `None` if it is invalid.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// Number of the device `wanted`, or of the first.
    #[must_use]
    pub fn device_id(&self, wanted: Option<&str>) -> Option<&str> {
        let ids = self.inverse3.iter().map(|device| device.device_id.as_str());
        ids.filter(|id| is_id(id))
            .find(|&id| wanted.is_none_or(|wanted| wanted == id))
    }

    /// True if the service reports that this device needs calibration.
    #[must_use]
    pub fn is_uncalibrated(&self, id: &str) -> bool {
        self.device(id)
            .is_some_and(|device| device.status.calibrated == Some(false))
    }

    /// Name of the force in this service's commands.
    #[must_use]
    pub fn force_key(&self) -> ForceKey {
        if self.session_id.is_some() {
            ForceKey::Vector
        } else {
            ForceKey::Values
        }
    }

    /// Sample of this device; `None` without a position, with a value that is not finite, or with
    /// an impossible rotation.
    #[must_use]
    pub fn sample(&self, id: &str) -> Option<Sample> {
        let state = &self.device(id)?.state;
        let position = state.cursor_position?;
        let [x, y, z] = MIDDLE_M;
        let position_m = ours(position.x - x, position.y - y, position.z - z);
        let velocity_m_s = state
            .cursor_velocity
            .map_or(Vec3::zeros(), |v| ours(v.x, v.y, v.z));
        let grip = self.wireless_verse_grip.first().or(self.verse_grip.first());
        let rotation = match grip.and_then(|grip| grip.state.orientation) {
            Some(q) => rotation(q)?,
            None => UnitQuaternion::identity(),
        };
        let buttons = grip.map_or(0, |grip| {
            let GripButtons { a, b, c } = grip.state.buttons;
            u8::from(a || grip.state.button) | u8::from(b) << 1 | u8::from(c) << 2
        });
        let finite = position_m
            .iter()
            .chain(&velocity_m_s)
            .all(|x| x.is_finite());
        finite.then_some(Sample {
            position_m,
            velocity_m_s,
            rotation,
            buttons,
        })
    }

    fn device(&self, id: &str) -> Option<&Device> {
        self.inverse3.iter().find(|device| device.device_id == id)
    }
}

/// True for a device number that needs no quoting in JSON.
fn is_id(id: &str) -> bool {
    (1..=ID_MAX).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

fn ours(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3::new(x as f32, z as f32, -y as f32)
}

/// Converts a rotation from the service's frame to ours.
fn rotation(q: Orientation) -> Option<UnitQuaternion<f32>> {
    let turned = Quaternion::new(q.w, q.x, q.z, -q.y);
    let norm = turned.norm();
    if !(0.9..=1.1).contains(&norm) {
        return None;
    }
    Some(UnitQuaternion::new_normalize((turned / norm).cast()))
}

/// Name of the force in a command: version 3.5 of the service documents `vector`, earlier ones
/// `values`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceKey {
    /// Version 3.5, which starts with a `session_id`.
    Vector,
    /// Earlier versions.
    Values,
}

/// Command for `force_n` in our frame.
#[must_use]
pub fn command(id: &str, key: ForceKey, force_n: Vec3) -> String {
    let key = match key {
        ForceKey::Vector => "vector",
        ForceKey::Values => "values",
    };
    let [x, y, z] =
        [force_n.x, -force_n.z, force_n.y].map(|part| if part.is_finite() { part } else { 0.0 });
    format!(
        "{{\"inverse3\":[{{\"device_id\":\"{id}\",\"commands\":{{\"set_cursor_force\":\
         {{\"{key}\":{{\"x\":{x:.4},\"y\":{y:.4},\"z\":{z:.4}}}}}}}}}]}}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str = r#"{"session_id":7,"inverse3":[{"device_id":"049D","config":{"type":"inverse3"},
        "state":{"cursor_position":{"x":0.01,"y":-0.14,"z":0.18},"cursor_velocity":{"x":0.1,"y":0.2,"z":0.3},
        "control_mode":"idle"},"status":{"calibrated":true}}],
        "wireless_verse_grip":[{"device_id":"61573","state":{"orientation":{"w":0.7071068,"x":0,"y":0,"z":0.7071068},
        "buttons":{"a":true,"b":false,"c":true}}}]}"#;

    #[test]
    fn a_message_of_the_documentation_is_read() {
        let message = Message::parse(TEXT).unwrap();
        assert_eq!(message.device_id(None), Some("049D"));
        assert_eq!(message.device_id(Some("1234")), None);
        assert_eq!(message.force_key(), ForceKey::Vector);
        let sample = message.sample("049D").unwrap();
        assert!((sample.position_m - Vec3::new(0.01, 0.03, 0.02)).norm() < 1e-6);
        assert!((sample.velocity_m_s - Vec3::new(0.1, 0.3, -0.2)).norm() < 1e-6);
        // A quarter turn about the service's z (up) is one about our y.
        assert!((sample.rotation * Vec3::x() + Vec3::z()).norm() < 1e-5);
        assert_eq!(sample.buttons, 0b101);
        assert_eq!(message.sample("other"), None);
    }

    #[test]
    fn the_command_is_json_with_the_force_in_the_services_frame() {
        for (key, name) in [(ForceKey::Vector, "vector"), (ForceKey::Values, "values")] {
            let text = command("049D", key, Vec3::new(1.0, 2.0, -3.0));
            let json: serde_json::Value = serde_json::from_str(&text).unwrap();
            let force = &json["inverse3"][0]["commands"]["set_cursor_force"][name];
            let [x, y, z] = ["x", "y", "z"].map(|axis| force[axis].as_f64().unwrap());
            assert!(
                (x - 1.0).abs() + (y - 3.0).abs() + (z - 2.0).abs() < 1e-6,
                "{text}"
            );
        }
        assert!(command("A", ForceKey::Vector, Vec3::new(f32::NAN, 0.0, 0.0)).contains("0.0000"));
    }

    #[test]
    fn state_with_missing_values_or_without_numbers_is_no_sample() {
        for (right, wrong) in [
            ("cursor_position", "position"),
            ("\"x\":0.01", "\"x\":1e60"),
            ("\"x\":0.01", "\"x\":\"left\""),
            ("0.7071068", "0.2"),
            ("049D\",", "04\\\"9D\","),
        ] {
            let text = TEXT.replace(right, wrong);
            let sample = Message::parse(&text).and_then(|message| message.sample("049D"));
            assert_eq!(sample, None, "{wrong}");
        }
        let uncalibrated = TEXT.replace("\"calibrated\":true", "\"calibrated\":false");
        assert!(
            Message::parse(&uncalibrated)
                .unwrap()
                .is_uncalibrated("049D")
        );
        let hostile = TEXT.replace("049D", "04\\\"9D");
        assert_eq!(Message::parse(&hostile).unwrap().device_id(None), None);
    }

    proptest! {
        #[test]
        fn arbitrary_text_is_harmless(text in ".{0,400}") {
            let _ = Message::parse(&text).and_then(|message| message.sample("049D"));
        }

        #[test]
        fn a_message_with_a_changed_part_gives_a_sample_in_range_or_none(
            at in 0usize..560,
            with in "[0-9eE\\-+.,:{}\\[\\]\"a-z]{0,6}",
        ) {
            let end = (at + with.len()).min(TEXT.len());
            let Some(head) = TEXT.get(..at.min(end)) else { return Ok(()) };
            let text = [head, &with, TEXT.get(end..).unwrap_or("")].concat();
            if let Some(sample) = Message::parse(&text).and_then(|message| message.sample("049D")) {
                prop_assert!(sample.position_m.iter().all(|x| x.is_finite()));
                prop_assert!(sample.velocity_m_s.iter().all(|x| x.is_finite()));
                prop_assert!((sample.rotation.norm() - 1.0).abs() < 1e-4);
            }
        }
    }
}
