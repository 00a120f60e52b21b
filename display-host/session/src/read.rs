//! Reads a session from its beginning, a chunk at a time. The session may be complete, cut off by a
//! kill, or damaged.

use std::io::Read;
use std::path::Path;

use shared_mem::inputs::{InputRecord, RunSetup};

use crate::error::ReadError;
use crate::info::{Finish, Info};
use crate::opened::{self, Opened};
use crate::records::{End, Part};

/// A session being read.
pub struct Session {
    opened: Opened,
    /// The session's description of itself.
    pub info: Info,
    /// Setup of the run.
    pub setup: RunSetup,
    /// The compiled scene, if the file holds it.
    pub scene: Option<Vec<u8>>,
    inputs: std::vec::IntoIter<InputRecord>,
}

impl core::fmt::Debug for Session {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Session")
            .field("path", &self.opened.path)
            .field("info", &self.info)
            .finish_non_exhaustive()
    }
}

impl Session {
    /// Opens a session and reads up to its first tick.
    ///
    /// # Errors
    /// See [`ReadError`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (bytes, source) = opened::source(path)?;
        Self::read(path, bytes, source)
    }

    /// As [`Session::open`], from a `source` of `bytes` bytes. `path` is only a name: for messages
    /// and [`Session::path`].
    ///
    /// # Errors
    /// See [`ReadError`].
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let without = "it has no ticks";
        let (opened, head, first) = Opened::read(path, (bytes, source), without, Part::inputs)?;
        let setup = head
            .setup
            .ok_or_else(|| opened::not_a_session(path, "its first tick precedes its setup"))?;
        Ok(Self {
            opened,
            info: head.info,
            setup,
            scene: head.scene,
            inputs: first.into_iter(),
        })
    }

    /// Path of the session.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.opened.path
    }

    /// Share of the session that has been read, 0 to 1.
    #[must_use]
    pub fn done(&self) -> f64 {
        self.opened.done()
    }

    /// Final record of the recorder, if the file has one. Present once all ticks are read.
    #[must_use]
    pub fn finish(&self) -> Option<Finish> {
        self.opened.finish
    }

    /// End of the reading: complete, cut off or damaged. Present once all ticks are read.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.opened.end()
    }
}

impl Iterator for Session {
    type Item = InputRecord;

    fn next(&mut self) -> Option<InputRecord> {
        loop {
            if let Some(record) = self.inputs.next() {
                return Some(record);
            }
            self.inputs = self.opened.next(Part::inputs)?.into_iter();
        }
    }
}
