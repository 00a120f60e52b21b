//! Frames: a payload and its CRC-32C (little-endian), COBS-stuffed, ended by one zero byte.
//!
//! The closing zero is the only zero of a frame, so a receiver that lost bytes resumes at the next
//! zero. Device and host use this file, which allocates nothing.

use crc::{CRC_32_ISCSI, Crc};

/// Longest payload, bytes.
pub const MAX_PAYLOAD: usize = 60;
/// Bytes of the checksum.
const CRC_BYTES: usize = 4;
/// Longest frame on the wire with its closing zero, bytes.
pub const MAX_FRAME: usize = cobs::max_encoding_length(MAX_PAYLOAD + CRC_BYTES) + 1;

pub(super) const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// A frame ready for the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    bytes: [u8; MAX_FRAME],
    len: usize,
}

impl Frame {
    /// Frames `payload`; `None` when it is longer than [`MAX_PAYLOAD`].
    #[must_use]
    pub fn new(payload: &[u8]) -> Option<Self> {
        let mut plain = [0; MAX_PAYLOAD + CRC_BYTES];
        plain
            .get_mut(..payload.len())
            .filter(|_| payload.len() <= MAX_PAYLOAD)?;
        let (body, rest) = plain.split_at_mut(payload.len());
        body.copy_from_slice(payload);
        rest.get_mut(..CRC_BYTES)?
            .copy_from_slice(&CRC.checksum(payload).to_le_bytes());

        let mut bytes = [0; MAX_FRAME];
        let stuffed = plain.get(..payload.len() + CRC_BYTES)?;
        let len = cobs::try_encode(stuffed, &mut bytes).ok()? + 1;
        Some(Self { bytes, len })
    }

    /// An empty frame.
    pub(super) fn empty() -> Self {
        Self {
            bytes: [0; MAX_FRAME],
            len: 0,
        }
    }

    /// Bytes to send.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// Reasons for which bytes between two zeros are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// More than [`MAX_FRAME`] bytes without a zero.
    TooLong,
    /// Too few bytes for a kind and a checksum.
    TooShort,
    /// The stuffing contradicts the length.
    Stuffing,
    /// The checksum does not match.
    Checksum,
}

/// Finds frames in a stream of bytes. The stream may start anywhere, lose bytes and hold wrong
/// ones.
#[derive(Debug, Clone)]
pub struct FrameReader {
    bytes: [u8; MAX_FRAME],
    len: usize,
    overrun: bool,
    /// True while the bytes up to the next zero belong to a frame whose beginning is lost.
    midway: bool,
}

impl Default for FrameReader {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameReader {
    /// A reader that expects the first byte of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; MAX_FRAME],
            len: 0,
            overrun: false,
            midway: false,
        }
    }

    /// A reader that starts inside a frame and drops bytes up to the next zero.
    #[must_use]
    pub const fn midway() -> Self {
        Self {
            midway: true,
            ..Self::new()
        }
    }

    /// Takes one byte. Returns `Some` at the end of a frame: its payload, or the reason for its
    /// rejection.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if byte != 0 {
            match self.bytes.get_mut(self.len) {
                Some(slot) => {
                    *slot = byte;
                    self.len += 1;
                }
                None => self.overrun = true,
            }
            return None;
        }
        let len = core::mem::take(&mut self.len);
        if core::mem::take(&mut self.midway) {
            self.overrun = false;
            return None;
        }
        if core::mem::take(&mut self.overrun) {
            return Some(Err(FrameError::TooLong));
        }
        if len == 0 {
            return None; // Idle zeros between frames are allowed.
        }
        Some(self.unpack(len))
    }

    fn unpack(&mut self, len: usize) -> Result<&[u8], FrameError> {
        let stuffed = self.bytes.get_mut(..len).ok_or(FrameError::TooLong)?;
        let plain = cobs::decode_in_place(stuffed).map_err(|_| FrameError::Stuffing)?;
        let end = plain.checked_sub(CRC_BYTES).filter(|&end| end > 0);
        let end = end.ok_or(FrameError::TooShort)?;
        let (payload, rest) = self
            .bytes
            .get(..plain)
            .ok_or(FrameError::Stuffing)?
            .split_at(end);
        if rest == CRC.checksum(payload).to_le_bytes() {
            Ok(payload)
        } else {
            Err(FrameError::Checksum)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Payloads that a reader finds in `bytes`, and the number of frames that it rejects.
    fn read(bytes: &[u8]) -> (Vec<Vec<u8>>, usize) {
        let mut reader = FrameReader::new();
        let mut good = Vec::new();
        let mut bad = 0;
        for &byte in bytes {
            match reader.push(byte) {
                Some(Ok(payload)) => good.push(payload.to_vec()),
                Some(Err(_)) => bad += 1,
                None => {}
            }
        }
        (good, bad)
    }

    #[test]
    fn the_checksum_is_the_catalogued_crc_32c() {
        assert_eq!(CRC.checksum(b"123456789"), 0xE306_9283);
    }

    #[test]
    fn a_payload_longer_than_the_limit_is_refused() {
        assert!(Frame::new(&[1; MAX_PAYLOAD]).is_some());
        assert!(Frame::new(&[1; MAX_PAYLOAD + 1]).is_none());
    }

    #[test]
    fn a_reader_that_starts_in_the_middle_finds_the_next_frame() {
        let frame = Frame::new(b"payload").unwrap();
        let mut bytes = frame.as_bytes()[3..].to_vec();
        bytes.extend_from_slice(frame.as_bytes());
        assert_eq!(read(&bytes), (vec![b"payload".to_vec()], 1));
    }

    #[test]
    fn a_stream_without_zeros_is_one_bad_frame() {
        let mut bytes = vec![0x55; 10_000];
        bytes.push(0);
        assert_eq!(read(&bytes), (vec![], 1));
    }

    proptest! {
        #[test]
        fn frames_are_read_as_sent(payloads in prop::collection::vec(
            prop::collection::vec(any::<u8>(), 1..=MAX_PAYLOAD), 0..8)) {
            let mut bytes = Vec::new();
            for payload in &payloads {
                bytes.extend_from_slice(Frame::new(payload).unwrap().as_bytes());
            }
            prop_assert_eq!(read(&bytes), (payloads, 0));
        }

        #[test]
        fn arbitrary_bytes_are_harmless(bytes in prop::collection::vec(any::<u8>(), 0..2048)) {
            let (good, bad) = read(&bytes);
            prop_assert!(good.len() + bad <= bytes.iter().filter(|&&byte| byte == 0).count());
        }

        /// CRC-32C finds every burst of up to 32 bits. A damaged byte is a burst of 8, but it may
        /// become or destroy a stuffing code. So this test looks at the payload that arrives.
        #[test]
        fn one_damaged_byte_never_changes_a_payload(
            payload in prop::collection::vec(any::<u8>(), 1..=MAX_PAYLOAD),
            at in any::<prop::sample::Index>(),
            flip in 1..=255u8,
        ) {
            let mut bytes = Frame::new(&payload).unwrap().as_bytes().to_vec();
            let at = at.index(bytes.len());
            bytes[at] ^= flip;
            bytes.push(0);
            let (good, _) = read(&bytes);
            prop_assert!(good.is_empty(), "{good:?}");
        }
    }
}
