//! `SWITCHES`, the state of a foot pedal.

use super::{Field, Frame, Kind, Message, WireError, Writer, field};

/// Offset of the field in the payload.
mod switches {
    pub(super) const BITS: usize = 3;
    pub(super) const END: usize = 4;
}

pub(super) const SWITCHES_BYTES: usize = switches::END - field::BODY;

/// Switches of a foot pedal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Switches {
    /// Bit 0: cut (yellow).
    pub cut: bool,
    /// Bit 1: coagulate (blue).
    pub coagulate: bool,
    /// Bit 2: hold the camera.
    pub camera_lock: bool,
}

impl Switches {
    /// Parses a message of kind `SWITCHES`. A message in which an unused bit is set is out of
    /// range.
    pub fn parse(message: &Message<'_>) -> Result<Self, WireError> {
        if message.kind() != Kind::Switches {
            return Err(WireError::Kind(message.kind() as u8));
        }
        let bits = message.u8(switches::BITS);
        if bits & !7 != 0 {
            return Err(WireError::Range(Field::Other));
        }
        Ok(Self {
            cut: bits & 1 != 0,
            coagulate: bits & 2 != 0,
            camera_lock: bits & 4 != 0,
        })
    }

    /// The framed message.
    #[must_use]
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut writer = Writer::new(Kind::Switches, sequence);
        let bits =
            u8::from(self.cut) | u8::from(self.coagulate) << 1 | u8::from(self.camera_lock) << 2;
        writer.put(&[bits]);
        writer.frame()
    }
}

#[cfg(test)]
mod tests {
    use super::super::payload;
    use super::*;

    #[test]
    fn every_combination_is_read_as_sent() {
        for bits in 0..8u8 {
            let sent = Switches {
                cut: bits & 1 != 0,
                coagulate: bits & 2 != 0,
                camera_lock: bits & 4 != 0,
            };
            let bytes = payload(&sent.frame(3));
            assert_eq!(bytes, [0x83, 3, 0, bits]);
            assert_eq!(Switches::parse(&Message::new(&bytes).unwrap()), Ok(sent));
        }
    }

    #[test]
    fn undefined_bits_are_refused() {
        let message = [0x83, 0, 0, 8];
        assert_eq!(
            Switches::parse(&Message::new(&message).unwrap()),
            Err(WireError::Range(Field::Other))
        );
    }
}
