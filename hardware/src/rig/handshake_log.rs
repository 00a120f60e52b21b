//! Describes the bytes that came while a greeting found no answer.

use super::frame::{CRC, FrameError, MAX_FRAME};
use super::wire::{Capabilities, Kind, Message, WireError};

/// Bytes heard since the line was opened.
#[derive(Debug, Default)]
pub(super) struct HandshakeLog {
    bytes: u64,
    zeros: u64,
    /// Bytes since the last zero, at most one more than [`MAX_FRAME`].
    frame: Vec<u8>,
    valid: Vec<(Kind, u64)>,
    too_long: u64,
    too_short: u64,
    stuffing: u64,
    checksum: u64,
    /// A sentence about the first frame with a wrong checksum, after a space.
    example: Option<String>,
    /// The first payload that is no valid message, in words.
    first_invalid: Option<String>,
}

impl HandshakeLog {
    /// Number of bytes.
    pub(super) const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Takes a byte. `read` is the result of the frame that this byte ends.
    pub(super) fn take(&mut self, byte: u8, read: Option<Result<&[u8], FrameError>>) {
        self.bytes += 1;
        if byte != 0 {
            if self.frame.len() <= MAX_FRAME {
                self.frame.push(byte);
            }
            return;
        }
        self.zeros += 1;
        let mut frame = std::mem::take(&mut self.frame);
        match read {
            None => {}
            Some(Ok(payload)) => self.message(payload),
            Some(Err(FrameError::TooLong)) => self.too_long += 1,
            Some(Err(FrameError::TooShort)) => self.too_short += 1,
            Some(Err(FrameError::Stuffing)) => self.stuffing += 1,
            Some(Err(FrameError::Checksum)) => {
                self.checksum += 1;
                if self.example.is_none() {
                    self.example = wrong_checksum(&mut frame);
                }
            }
        }
    }

    fn message(&mut self, payload: &[u8]) {
        let invalid = match Message::new(payload) {
            Ok(message) if is_refused(&message) => format!(
                "a CAPABILITIES of {} bytes with kind {} and version {}, where the kind must be 1 (haptic device) \
                 or 2 (pedal), and the length 45 bytes in version 1 or 51 bytes in version 2",
                payload.len(),
                payload.get(4).unwrap_or(&0),
                payload.get(3).unwrap_or(&0)
            ),
            Ok(message) => {
                let kind = message.kind();
                match self.valid.iter_mut().find(|(known, _)| *known == kind) {
                    Some((_, count)) => *count += 1,
                    None => self.valid.push((kind, 1)),
                }
                return;
            }
            Err(WireError::Kind(byte)) => format!("a message of the unknown kind {byte:02X}"),
            Err(_) => match payload.first().copied().and_then(Kind::from_byte) {
                Some(kind) => {
                    let (plain, opening) = kind.payload_bytes();
                    let wanted = match opening {
                        0 => plain.to_string(),
                        more => format!("{plain} ({} with an opening)", plain + more),
                    };
                    format!(
                        "a {} of {} bytes instead of {wanted}",
                        kind.name(),
                        payload.len()
                    )
                }
                None => "a message without a kind".to_owned(),
            },
        };
        self.first_invalid.get_or_insert(invalid);
    }

    /// Sentences about the bytes that came, the likely mistake and its remedy, without the last
    /// full stop.
    pub(super) fn in_words(&self) -> String {
        if self.zeros == 0 {
            return format!(
                "{} bytes came, none of which is 00, the end of a frame. Is the line's rate 1 000 000 \
                 baud? Or does the device speak another protocol (`--driver woody`, `bird` or `hapi-gen3`)?",
                self.bytes
            );
        }
        let mut parts = Vec::new();
        for (kind, count) in &self.valid {
            parts.push(format!("{count} good {}", kind.name()));
        }
        parts.extend(self.first_invalid.clone());
        let counted = [
            (self.checksum, "with a wrong checksum"),
            (
                self.stuffing,
                "with stuffing (COBS) that contradicts the length",
            ),
            (self.too_long, "without a 00 within 66 bytes"),
            (self.too_short, "too short for a kind and a checksum"),
        ];
        for (count, what) in counted.into_iter().filter(|(count, _)| *count > 0) {
            let frames = if count == 1 { "frame" } else { "frames" };
            parts.push(format!("{count} {frames} {what}"));
        }
        if parts.is_empty() {
            parts.push("no whole frame".to_owned());
        }
        let example = self.example.as_deref().unwrap_or_default();
        let answered = self
            .valid
            .iter()
            .any(|(kind, _)| *kind == Kind::Capabilities);
        let remedy = if self.first_invalid.is_some() {
            "Correct the wrong message: hardware/PROTOCOL.md has its bytes"
        } else if answered {
            // The host drops a good answer only as a repetition.
            "CAPABILITIES had the sequence number of the message before it, so the host dropped it: count up by one \
             per message"
        } else if !self.valid.is_empty() {
            "The firmware must answer HELLO with CAPABILITIES"
        } else {
            "Compare the frames with the test vectors of hardware/PROTOCOL.md, and the rate of the line \
             with 1 000 000 baud"
        };
        format!("Received: {}.{example} {remedy}", parts.join("; "))
    }
}

/// True for CAPABILITIES with an unknown kind of device, or with a length that does not fit their
/// version.
fn is_refused(message: &Message<'_>) -> bool {
    message.kind() == Kind::Capabilities && Capabilities::parse(message).is_err()
}

/// A sentence, after a space, about a frame with a wrong checksum: both checksums.
fn wrong_checksum(stuffed: &mut [u8]) -> Option<String> {
    let plain = cobs::decode_in_place(stuffed).ok()?;
    let (payload, is) = stuffed.get(..plain)?.split_last_chunk::<4>()?;
    let right = CRC.checksum(payload).to_le_bytes();
    let hex = |bytes: &[u8]| {
        let words: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        words.join(" ")
    };
    let begins = payload.get(..3).unwrap_or(payload);
    Some(format!(
        " After the payload {} … came the checksum {}; it must be {}.",
        hex(begins),
        hex(is),
        hex(&right)
    ))
}

#[cfg(test)]
mod tests {
    use super::super::frame::{Frame, FrameReader};
    use super::super::wire::Switches;
    use super::*;

    fn said(bytes: &[u8]) -> String {
        let mut heard = HandshakeLog::default();
        let mut reader = FrameReader::new();
        for &byte in bytes {
            let read = reader.push(byte);
            heard.take(byte, read);
        }
        heard.in_words()
    }

    #[test]
    fn each_mistake_of_a_new_firmware_has_its_message() {
        let good = Capabilities::touch_class().frame(1);
        let mut plain = good.as_bytes().to_vec();
        plain.pop();
        let length = cobs::decode_in_place(&mut plain).unwrap();
        let payload = &plain[..length - 4];
        let short = Frame::new(&payload[..44]).unwrap();
        assert!(
            said(short.as_bytes()).contains("a CAPABILITIES of 44 bytes instead of 45"),
            "{}",
            said(short.as_bytes())
        );
        let mut kind = payload.to_vec();
        kind[0] = 3;
        kind[0] |= 0x40;
        let kind = Frame::new(&kind).unwrap();
        assert!(said(kind.as_bytes()).contains("the unknown kind 43"));
        let mut third = payload.to_vec();
        third[4] = 3;
        let words = said(Frame::new(&third).unwrap().as_bytes());
        assert!(
            words.contains("45 bytes with kind 3 and version 1, where the kind must be 1"),
            "{words}"
        );
        let mut spoilt = payload.to_vec();
        let crc = CRC.checksum(payload).to_be_bytes();
        spoilt.extend(crc);
        let mut framed = vec![0; 80];
        let length = cobs::encode(&spoilt, &mut framed);
        framed.truncate(length);
        framed.push(0);
        let words = said(&framed);
        assert!(
            words.contains("1 frame with a wrong checksum. After"),
            "{words}"
        );
        assert!(words.contains("the payload 81 01 00 … came the"), "{words}");
        let words = said(&[0x55; 500]);
        assert!(words.contains("none of which is 00"), "{words}");
        let words = said(Switches::default().frame(1).as_bytes());
        assert!(
            words.contains("Received: 1 good SWITCHES. The firmware must"),
            "{words}"
        );
    }
}
