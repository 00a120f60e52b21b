//! Frames on standard output: a letter, the length of the body (u32, little endian), the body.
//! `display-host/centre/src/frame.rs` reads them.

use std::io::Write;
use std::sync::{Mutex, PoisonError};

/// The state as JSON.
pub(super) const STATE: u8 = b's';
/// A small picture, JPEG.
pub(super) const TILE: u8 = b't';
/// A large picture, JPEG.
pub(super) const VIEW: u8 = b'v';
/// The station's answer to an act, as JSON.
pub(super) const ANSWER: u8 = b'a';

/// Writes frames, each whole, from any thread.
pub(super) struct Frames<W>(Mutex<W>);

impl<W: Write> Frames<W> {
    pub(super) fn new(to: W) -> Self {
        Self(Mutex::new(to))
    }

    /// Writes one frame.
    pub(super) fn write(&self, kind: u8, body: &[u8]) -> std::io::Result<()> {
        let length = u32::try_from(body.len()).map_err(std::io::Error::other)?;
        let mut to = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        to.write_all(&[kind])?;
        to.write_all(&length.to_le_bytes())?;
        to.write_all(body)?;
        to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_has_its_kind_its_length_and_its_body() {
        let frames = Frames::new(Vec::new());
        frames.write(STATE, b"{}").unwrap();
        frames.write(TILE, b"").unwrap();
        assert_eq!(frames.0.into_inner().unwrap(), b"s\x02\0\0\0{}t\0\0\0\0");
    }
}
