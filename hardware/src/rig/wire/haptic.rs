//! `STATE`, a sample of a haptic device, and `FORCE`, the command for its motors.

use super::{Field, Frame, Kind, Message, WireError, Writer, field};

/// Offsets of the fields of `STATE` in the payload.
mod state {
    pub(super) const STATUS: usize = 3;
    pub(super) const BUTTONS: usize = 4;
    pub(super) const APPLIED: usize = 5;
    pub(super) const TIME: usize = 7;
    pub(super) const POSITION: usize = 11;
    pub(super) const VELOCITY: usize = 23;
    pub(super) const ROTATION: usize = 35;
    pub(super) const END: usize = 43;
    /// Version 2.
    pub(super) const OPENING: usize = 43;
}

/// Offsets of the fields of `FORCE` in the payload.
mod force {
    pub(super) const FORCE: usize = 3;
    pub(super) const TORQUE: usize = 9;
    pub(super) const END: usize = 15;
    /// Version 2.
    pub(super) const OPENING: usize = 15;
}

pub(super) const STATE_BYTES: usize = state::END - field::BODY;
pub(super) const FORCE_BYTES: usize = force::END - field::BODY;
/// A version 2 message of either kind has an additional 16-bit field for the opening.
pub(super) const OPENING_BYTES: usize = 2;

const POSITION_UNIT_M: f32 = 1e-7;
const SPEED_UNIT_M_S: f32 = 1e-6;
const ROTATION_UNIT: f32 = 1.0 / 32767.0;
const OPENING_UNIT: f32 = 1.0 / 65535.0;
const FORCE_UNIT_N: f32 = 1e-3;
const TORQUE_UNIT_NM: f32 = 1e-4;

/// Bits of the device's status.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status(pub u8);

impl Status {
    /// A `FORCE` is in effect, even one that asks for zero.
    pub const FORCE_ON: Self = Self(1);
    /// The watchdog dropped the force; the next `FORCE` restores it.
    pub const WATCHDOG: Self = Self(2);
    /// The device limits the force (heat, current).
    pub const LIMITED: Self = Self(4);
    /// A fault that a person must repair. No force is in effect.
    pub const FAULT: Self = Self(8);

    /// True if every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One sample of a haptic device, SI, in the device's base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Status of the device.
    pub status: Status,
    /// Buttons pressed, one bit each.
    pub buttons: u8,
    /// Sequence number of the `FORCE` that the device renders.
    pub applied_force: u16,
    /// The device's clock at the sample, µs; wraps.
    pub device_time_us: u32,
    /// Position of the handle, m; in steps of 0.1 µm.
    pub position_m: [f32; 3],
    /// Velocity, m/s; in steps of 1 µm/s. Zero if it is not measured.
    pub velocity_m_s: [f32; 3],
    /// Unit quaternion x y z w; in steps of 1/32767.
    pub rotation_xyzw: [f32; 4],
    /// Opening of the handle, 0 shut to 1 wide open; in steps of 1/65535. A message with this field
    /// has version 2.
    pub opening: Option<f32>,
}

impl State {
    /// Largest coordinate of a position; no table-top device reaches farther from its base.
    pub const POSITION_LIMIT_M: f32 = 1.6;
    /// Largest component of a velocity; no hand is faster.
    pub const SPEED_LIMIT_M_S: f32 = 20.0;

    /// Parses a message of kind `STATE` and normalises the rotation. A position or velocity beyond
    /// these limits is out of range, and so is a rotation whose squared length differs from 1 by
    /// more than 10 %.
    pub fn parse(message: &Message<'_>) -> Result<Self, WireError> {
        use state as at;
        if message.kind() != Kind::State {
            return Err(WireError::Kind(message.kind() as u8));
        }
        Ok(Self {
            status: Status(message.u8(at::STATUS)),
            buttons: message.u8(at::BUTTONS),
            applied_force: message.u16(at::APPLIED),
            device_time_us: message.u32(at::TIME),
            position_m: message.i32_triple(
                at::POSITION,
                POSITION_UNIT_M,
                Self::POSITION_LIMIT_M,
                Field::Position,
            )?,
            velocity_m_s: message.i32_triple(
                at::VELOCITY,
                SPEED_UNIT_M_S,
                Self::SPEED_LIMIT_M_S,
                Field::Velocity,
            )?,
            rotation_xyzw: unit_quaternion([0, 2, 4, 6].map(|offset| {
                f32::from(i16::from_le_bytes(message.bytes(at::ROTATION + offset))) * ROTATION_UNIT
            }))?,
            opening: message
                .has_opening()
                .then(|| (f32::from(message.u16(at::OPENING)) * OPENING_UNIT).min(1.0)),
        })
    }

    /// The framed message. Values saturate at the range of their fields.
    #[must_use]
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut writer = Writer::new(Kind::State, sequence);
        writer.put(&[self.status.0, self.buttons]);
        writer.put(&self.applied_force.to_le_bytes());
        writer.put(&self.device_time_us.to_le_bytes());
        for position in self.position_m {
            writer.put_i32(position, POSITION_UNIT_M);
        }
        for speed in self.velocity_m_s {
            writer.put_i32(speed, SPEED_UNIT_M_S);
        }
        for part in self.rotation_xyzw {
            writer.put_i16(part, ROTATION_UNIT);
        }
        if let Some(opening) = self.opening {
            writer.put_u16(opening, OPENING_UNIT);
        }
        writer.frame()
    }
}

/// Normalises a quaternion whose squared length is within 10 % of 1.
fn unit_quaternion(q: [f32; 4]) -> Result<[f32; 4], WireError> {
    let squared: f32 = q.iter().map(|part| part * part).sum();
    if !(0.9..=1.1).contains(&squared) {
        return Err(WireError::Range(Field::Rotation));
    }
    // Newton's steps for 1/√s from 1, because `core` has no square root. At 10 % off, three steps
    // leave less than one part in 10⁶.
    let mut scale = 1.0;
    for _ in 0..3 {
        scale *= 1.5 - 0.5 * squared * scale * scale;
    }
    Ok(q.map(|part| part * scale))
}

/// Command for a haptic device, SI, in its base frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Force {
    /// Force at the handle, N; in steps of 1 mN, up to ±32.767 N.
    pub force_n: [f32; 3],
    /// Torque, N m; in steps of 0.1 mN m. A device without torque ignores it.
    pub torque_nm: [f32; 3],
    /// Force that opens the handle, N; in steps of 1 mN. A message with this field has version 2.
    pub opening_n: Option<f32>,
}

impl Force {
    /// Parses a message of kind `FORCE`.
    pub fn parse(message: &Message<'_>) -> Result<Self, WireError> {
        if message.kind() != Kind::Force {
            return Err(WireError::Kind(message.kind() as u8));
        }
        Ok(Self {
            force_n: message.i16_triple(force::FORCE, FORCE_UNIT_N),
            torque_nm: message.i16_triple(force::TORQUE, TORQUE_UNIT_NM),
            opening_n: message.has_opening().then(|| {
                f32::from(i16::from_le_bytes(message.bytes(force::OPENING))) * FORCE_UNIT_N
            }),
        })
    }

    /// The framed message. Values saturate at the range of their fields; NaN becomes zero.
    #[must_use]
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut writer = Writer::new(Kind::Force, sequence);
        for force in self.force_n {
            writer.put_i16(force, FORCE_UNIT_N);
        }
        for torque in self.torque_nm {
            writer.put_i16(torque, TORQUE_UNIT_NM);
        }
        if let Some(opening_n) = self.opening_n {
            writer.put_i16(opening_n, FORCE_UNIT_N);
        }
        writer.frame()
    }
}

#[cfg(test)]
mod tests {
    use super::super::payload;
    use super::*;
    use proptest::prelude::*;

    fn sample() -> State {
        State {
            status: Status::FORCE_ON,
            buttons: 1,
            applied_force: 0x0203,
            device_time_us: 0x0405_0607,
            position_m: [0.01, -0.02, 0.03],
            velocity_m_s: [0.1, 0.0, -0.1],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            opening: None,
        }
    }

    #[test]
    fn state_has_its_documented_bytes() {
        let mut expected = vec![0x82, 0x09, 0x00, 0x01, 0x01, 0x03, 0x02, 7, 6, 5, 4];
        for tenth_um in [100_000i32, -200_000, 300_000] {
            expected.extend_from_slice(&tenth_um.to_le_bytes());
        }
        for um_s in [100_000i32, 0, -100_000] {
            expected.extend_from_slice(&um_s.to_le_bytes());
        }
        expected.extend_from_slice(&[0, 0, 0, 0, 0, 0, 0xFF, 0x7F]);
        assert_eq!(payload(&sample().frame(9)), expected);
    }

    #[test]
    fn the_opening_is_the_last_field() {
        let state = State {
            opening: Some(0.4),
            ..sample()
        };
        let bytes = payload(&state.frame(9));
        assert_eq!(bytes.get(..43), payload(&sample().frame(9)).get(..));
        assert_eq!(bytes.get(43..), Some(&26214u16.to_le_bytes()[..]));
        let force = Force {
            opening_n: Some(-1.5),
            ..Force::default()
        };
        let bytes = payload(&force.frame(5));
        assert_eq!(bytes.get(15..), Some(&(-1500i16).to_le_bytes()[..]));
        let read = Force::parse(&Message::new(&bytes).unwrap()).unwrap();
        assert!((read.opening_n.unwrap() + 1.5).abs() < 1e-6, "{read:?}");
    }

    #[test]
    fn a_rotation_of_length_zero_is_refused() {
        let frame = State {
            rotation_xyzw: [0.0; 4],
            ..sample()
        }
        .frame(0);
        let bytes = payload(&frame);
        assert_eq!(
            State::parse(&Message::new(&bytes).unwrap()),
            Err(WireError::Range(Field::Rotation))
        );
    }

    #[test]
    fn force_has_its_documented_bytes() {
        let force = Force {
            force_n: [1.0, -2.0, 3.3],
            torque_nm: [0.01, 0.0, 0.0],
            opening_n: None,
        };
        let expected = [
            0x02, 5, 0, 0xE8, 0x03, 0x30, 0xF8, 0xE4, 0x0C, 100, 0, 0, 0, 0, 0,
        ];
        assert_eq!(payload(&force.frame(5)), expected);
    }

    #[test]
    fn a_force_that_is_not_a_number_is_sent_as_zero() {
        let force = Force {
            force_n: [f32::NAN; 3],
            torque_nm: [f32::NAN; 3],
            opening_n: None,
        };
        assert_eq!(force.frame(0), Force::default().frame(0));
    }

    proptest! {
        #[test]
        fn forces_are_read_as_sent_within_half_a_step(force_n in prop::array::uniform3(-32.7..32.7f32)) {
            let bytes = payload(&Force { force_n, ..Force::default() }.frame(0));
            let read = Force::parse(&Message::new(&bytes).unwrap()).unwrap();
            for (read, sent) in read.force_n.iter().zip(force_n) {
                prop_assert!((read - sent).abs() <= 0.51e-3);
            }
        }

        #[test]
        fn states_are_read_as_sent_within_half_a_step(
            position_m in prop::array::uniform3(-0.5..0.5f32),
            axis in prop::array::uniform4(-1.0..1.0f32),
        ) {
            let norm = axis.iter().map(|x| x * x).sum::<f32>().sqrt();
            prop_assume!(norm > 0.01);
            let sent = State { position_m, rotation_xyzw: axis.map(|x| x / norm), ..sample() };
            let bytes = payload(&sent.frame(0));
            let read = State::parse(&Message::new(&bytes).unwrap()).unwrap();
            for (read, sent) in read.position_m.iter().zip(sent.position_m) {
                prop_assert!((read - sent).abs() <= 0.1e-6, "{} {}", read, sent);
            }
            for (read, sent) in read.rotation_xyzw.iter().zip(sent.rotation_xyzw) {
                prop_assert!((read - sent).abs() <= 1e-4);
            }
        }
    }
}
