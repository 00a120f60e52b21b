//! A session read from the front, a chunk at a time: whole, cut off by a kill, or damaged.

use std::io::Read;
use std::path::{Path, PathBuf};

use shared_mem::inputs::{InputRecord, RunSetup};

use crate::file::FILE_VERSION;
use crate::info::{Finish, Info};
use crate::opened::{self, Opened};
use crate::records::Part;

/// Why a session cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}; a session is what `calot run --record FILE` leaves")]
    Io {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// It is something else, or damaged before its first tick or entry.
    #[error(
        "{path} is no session of Calot: {problem}; a session is what `calot run --record FILE` leaves"
    )]
    NotASession {
        /// Which.
        path: PathBuf,
        /// What is missing or wrong.
        problem: String,
    },
    /// Another version of Calot wrote it.
    #[error(
        "{path}: a session of version '{found}', this program reads {FILE_VERSION}; replay it with the program that recorded it"
    )]
    Version {
        /// Which.
        path: PathBuf,
        /// Its version.
        found: String,
    },
}

/// How a session ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// It was ended in order.
    Whole,
    /// It breaks off in the middle of what it says is there: the recorder was killed, or the disk was
    /// full; where. All before it is as it was recorded. A damaged length of the last record that is
    /// not a chunk looks the same.
    BrokenOff(String),
    /// It is damaged; where and how. What comes after is not read.
    Damaged(String),
}

/// A session, being read.
pub struct Session {
    opened: Opened,
    /// What it says of itself.
    pub info: Info,
    /// What its run began with.
    pub setup: RunSetup,
    /// The compiled scene, if it is in it.
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
    /// Opens a session and reads as far as its first tick.
    ///
    /// # Errors
    /// As [`ReadError`] says.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (bytes, source) = opened::source(path)?;
        Self::read(path, bytes, source)
    }

    /// The same from any source of bytes.
    ///
    /// # Errors
    /// As [`ReadError`] says.
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let without = "it has no ticks";
        let (opened, head, first) = Opened::read(path, (bytes, source), without, Part::inputs)?;
        let setup = head
            .setup
            .ok_or_else(|| opened::not_a_session(path, "its first tick comes before its setup"))?;
        Ok(Self {
            opened,
            info: head.info,
            setup,
            scene: head.scene,
            inputs: first.into_iter(),
        })
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.opened.path
    }

    /// Share of it that is read, 0 to 1.
    #[must_use]
    pub fn done(&self) -> f64 {
        self.opened.done()
    }

    /// What its recorder said at its end; there once there are no more ticks, unless the session is cut,
    /// damaged, or of a program that did not say.
    #[must_use]
    pub fn finish(&self) -> Option<Finish> {
        self.opened.finish
    }

    /// How it ended; there once there are no more ticks.
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
