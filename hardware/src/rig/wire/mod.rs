//! Messages of the rig protocol: fixed layouts, little-endian, fixed-point numbers.
//!
//! Every message starts with its kind and a sequence number, and has one length in each version.
//! Numbers are integers with a stated unit, so no bit pattern is a NaN or an infinity. Parsed
//! values are SI.

mod handshake;
mod haptic;
mod pedal;

pub use handshake::{Capabilities, DeviceKind, Hello, Opening};
pub use haptic::{Force, State, Status};
pub use pedal::Switches;

use super::frame::{Frame, MAX_PAYLOAD};

/// Newest version of the protocol in this module. Its messages carry the handle's opening. A device
/// without one speaks version 1.
pub const VERSION: u8 = 2;

/// Offsets of the header's fields.
mod field {
    pub(super) const KIND: usize = 0;
    pub(super) const SEQUENCE: usize = 1;
    /// First byte after the header.
    pub(super) const BODY: usize = 3;
}

/// View of one payload whose length fits its kind.
#[derive(Debug, Clone, Copy)]
pub struct Message<'a> {
    payload: &'a [u8],
    kind: Kind,
    has_opening: bool,
}

/// Kind of a message. Kinds below 0x80 go from host to device, the others from device to host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Host: a greeting, which starts the stream.
    Hello = 0x01,
    /// Host: render this force.
    Force = 0x02,
    /// Host: end of force and stream.
    Stop = 0x03,
    /// Device: the answer to `Hello`.
    Capabilities = 0x81,
    /// Haptic device: one sample.
    State = 0x82,
    /// Pedal: its switches.
    Switches = 0x83,
}

impl Kind {
    /// Bytes of the body in version 1.
    const fn body_bytes(self) -> usize {
        match self {
            Self::Hello => handshake::HELLO_BYTES,
            Self::Force => haptic::FORCE_BYTES,
            Self::Stop => 0,
            Self::Capabilities => handshake::CAPABILITIES_BYTES,
            Self::State => haptic::STATE_BYTES,
            Self::Switches => pedal::SWITCHES_BYTES,
        }
    }

    /// Bytes of a payload of this kind in version 1, and those that version 2 adds for the opening.
    pub(super) const fn payload_bytes(self) -> (usize, usize) {
        let opening = match self {
            Self::Capabilities => handshake::OPENING_BYTES,
            Self::Force | Self::State => haptic::OPENING_BYTES,
            Self::Hello | Self::Stop | Self::Switches => 0,
        };
        (field::BODY + self.body_bytes(), opening)
    }

    /// Name in `PROTOCOL.md`.
    #[cfg(feature = "std")]
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Hello => "HELLO",
            Self::Force => "FORCE",
            Self::Stop => "STOP",
            Self::Capabilities => "CAPABILITIES",
            Self::State => "STATE",
            Self::Switches => "SWITCHES",
        }
    }

    pub(super) const fn from_byte(byte: u8) -> Option<Self> {
        Some(match byte {
            0x01 => Self::Hello,
            0x02 => Self::Force,
            0x03 => Self::Stop,
            0x81 => Self::Capabilities,
            0x82 => Self::State,
            0x83 => Self::Switches,
            _ => return None,
        })
    }
}

/// Reasons for which a payload with a good checksum is not a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WireError {
    /// The kind is unknown, or not the kind to be parsed.
    Kind(u8),
    /// The length does not fit the kind.
    Length,
    /// A field is outside its range.
    Range(Field),
}

/// Field whose value is outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Position of a `STATE`.
    Position,
    /// Velocity of a `STATE`.
    Velocity,
    /// Rotation of a `STATE`: no unit quaternion.
    Rotation,
    /// Any field of another message.
    Other,
}

impl<'a> Message<'a> {
    /// Checks kind and length.
    pub fn new(payload: &'a [u8]) -> Result<Self, WireError> {
        let byte = *payload.get(field::KIND).ok_or(WireError::Length)?;
        let kind = Kind::from_byte(byte).ok_or(WireError::Kind(byte))?;
        let (plain, opening) = kind.payload_bytes();
        let has_opening = opening > 0 && payload.len() == plain + opening;
        if payload.len() != plain && !has_opening {
            return Err(WireError::Length);
        }
        Ok(Self {
            payload,
            kind,
            has_opening,
        })
    }

    /// Kind of the message.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// True for a message of version 2, which carries the handle's opening.
    #[must_use]
    pub const fn has_opening(&self) -> bool {
        self.has_opening
    }

    /// Sequence number: counts the messages of one sender; wraps.
    #[must_use]
    pub fn sequence(&self) -> u16 {
        u16::from_le_bytes(self.bytes(field::SEQUENCE))
    }

    /// `N` bytes at `at` of the payload; zeros beyond its end, which the length check excludes.
    fn bytes<const N: usize>(&self, at: usize) -> [u8; N] {
        self.payload
            .get(at..at + N)
            .and_then(|bytes| bytes.try_into().ok())
            .unwrap_or([0; N])
    }

    fn u8(&self, at: usize) -> u8 {
        u8::from_le_bytes(self.bytes(at))
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.bytes(at))
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.bytes(at))
    }

    /// Three i16 in steps of `unit`.
    fn i16_triple(&self, at: usize, unit: f32) -> [f32; 3] {
        [0, 2, 4].map(|offset| f32::from(i16::from_le_bytes(self.bytes(at + offset))) * unit)
    }

    /// Three i32 in steps of `unit`, all within ±`limit`.
    fn i32_triple(
        &self,
        at: usize,
        unit: f32,
        limit: f32,
        field: Field,
    ) -> Result<[f32; 3], WireError> {
        let values =
            [0, 4, 8].map(|offset| i32::from_le_bytes(self.bytes(at + offset)) as f32 * unit);
        if values.iter().all(|value| value.abs() <= limit) {
            Ok(values)
        } else {
            Err(WireError::Range(field))
        }
    }
}

/// A payload under construction.
struct Writer {
    bytes: [u8; MAX_PAYLOAD],
    len: usize,
}

impl Writer {
    fn new(kind: Kind, sequence: u16) -> Self {
        let mut writer = Self {
            bytes: [0; MAX_PAYLOAD],
            len: 0,
        };
        writer.put(&[kind as u8]);
        writer.put(&sequence.to_le_bytes());
        writer
    }

    fn put(&mut self, bytes: &[u8]) {
        if let Some(slot) = self.bytes.get_mut(self.len..self.len + bytes.len()) {
            slot.copy_from_slice(bytes);
            self.len += bytes.len();
        }
    }

    fn put_i16(&mut self, value: f32, unit: f32) {
        self.put(&(round(value / unit) as i16).to_le_bytes());
    }

    fn put_i32(&mut self, value: f32, unit: f32) {
        self.put(&(round(value / unit) as i32).to_le_bytes());
    }

    /// Appends an unsigned number in steps of `unit`; saturates.
    fn put_u16(&mut self, value: f32, unit: f32) {
        self.put(&(round(value / unit) as u16).to_le_bytes());
    }

    fn frame(&self) -> Frame {
        // `MAX_PAYLOAD` bounds `len`, so framing succeeds; the empty frame is never sent.
        Frame::new(self.bytes.get(..self.len).unwrap_or(&[])).unwrap_or_else(Frame::empty)
    }
}

/// Adds half a unit away from zero. The later `as` then truncates, saturates and turns NaN into
/// zero.
fn round(value: f32) -> f32 {
    if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }
}

/// Message that ends stream and force.
#[must_use]
pub fn stop_frame(sequence: u16) -> Frame {
    Writer::new(Kind::Stop, sequence).frame()
}

const _: () = assert!(
    field::BODY + haptic::STATE_BYTES + haptic::OPENING_BYTES <= MAX_PAYLOAD
        && field::BODY + handshake::CAPABILITIES_BYTES + handshake::OPENING_BYTES <= MAX_PAYLOAD
);

#[cfg(test)]
pub(crate) fn payload(frame: &Frame) -> Vec<u8> {
    let mut reader = super::frame::FrameReader::new();
    for &byte in frame.as_bytes() {
        if let Some(payload) = reader.push(byte) {
            return payload.unwrap().to_vec();
        }
    }
    panic!("a frame that does not end");
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_stop_is_only_a_header() {
        assert_eq!(payload(&stop_frame(0x1234)), [0x03, 0x34, 0x12]);
    }

    #[test]
    fn kind_and_length_are_checked() {
        assert_eq!(Message::new(&[]).unwrap_err(), WireError::Length);
        assert_eq!(
            Message::new(&[0x7F, 0, 0]).unwrap_err(),
            WireError::Kind(0x7F)
        );
        assert_eq!(Message::new(&[0x03, 0]).unwrap_err(), WireError::Length);
        assert_eq!(
            Message::new(&[0x03, 0, 0, 0]).unwrap_err(),
            WireError::Length
        );
    }

    proptest! {
        /// Every value that passes the checks is finite and within the documented range.
        #[test]
        fn arbitrary_payloads_parse_to_values_in_range_or_to_errors(
            kind in prop::sample::select(vec![1u8, 2, 3, 0x81, 0x82, 0x83]),
            body in prop::collection::vec(any::<u8>(), MAX_PAYLOAD),
            opens in any::<bool>(),
        ) {
            let mut bytes = vec![kind];
            bytes.extend_from_slice(&body);
            let (plain, opening) = Kind::from_byte(kind).unwrap().payload_bytes();
            bytes.truncate(plain + if opens { opening } else { 0 });
            let message = Message::new(&bytes).unwrap();
            if let Ok(state) = State::parse(&message) {
                prop_assert!(state.position_m.iter().all(|x| x.abs() <= State::POSITION_LIMIT_M));
                prop_assert!(state.velocity_m_s.iter().all(|v| v.abs() <= State::SPEED_LIMIT_M_S));
                let norm: f32 = state.rotation_xyzw.iter().map(|x| x * x).sum();
                prop_assert!((norm - 1.0).abs() < 1e-4, "{norm}");
                prop_assert!(state.opening.is_none_or(|it| (0.0..=1.0).contains(&it)));
            }
            if let Ok(force) = Force::parse(&message) {
                prop_assert!(force.force_n.iter().all(|f| f.abs() <= 32.768));
                prop_assert!(force.opening_n.is_none_or(|f| f.abs() <= 32.768));
            }
            if let Ok(capabilities) = Capabilities::parse(&message) {
                prop_assert!(capabilities.force_max_n.is_finite());
            }
        }
    }
}
