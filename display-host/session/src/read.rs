//! A session read from the front, a chunk at a time: whole, cut off by a kill, or damaged.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use shared_mem::inputs::{InputRecord, RunSetup};

use crate::file::FILE_VERSION;
use crate::info::{Finish, Info};
use crate::records::{Part, Records};

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
    path: PathBuf,
    bytes: u64,
    records: Records,
    /// What it says of itself.
    pub info: Info,
    /// What its run began with.
    pub setup: RunSetup,
    /// The compiled scene, if it is in it.
    pub scene: Option<Vec<u8>>,
    inputs: std::vec::IntoIter<InputRecord>,
    finish: Option<Finish>,
}

impl core::fmt::Debug for Session {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Session")
            .field("path", &self.path)
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
        let io = |source| ReadError::Io {
            path: path.to_owned(),
            source,
        };
        let file = File::open(path).map_err(io)?;
        let bytes = file.metadata().map_err(io)?.len();
        Self::read(path, bytes, Box::new(BufReader::new(file)))
    }

    /// The same from any source of bytes.
    ///
    /// # Errors
    /// As [`ReadError`] says.
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let not = |problem: &str| ReadError::NotASession {
            path: path.to_owned(),
            problem: problem.to_owned(),
        };
        let mut records = Records::new(source);
        let (mut info, mut setup, mut scene) = (None, None, None);
        let inputs = loop {
            match records.next() {
                Some(Part::Info(map)) => {
                    info = Some(Info::from_map(&map).map_err(|found| ReadError::Version {
                        path: path.to_owned(),
                        found,
                    })?);
                }
                Some(Part::Setup(found)) => setup = Some(found),
                Some(Part::Scene(found)) => scene = Some(found),
                Some(Part::Inputs(found)) => break found,
                Some(Part::Finish(_) | Part::Course(_) | Part::Assignment(_)) => {}
                None => {
                    let end = match &records.end {
                        Some(End::BrokenOff(why) | End::Damaged(why)) => why.as_str(),
                        _ => "it has no ticks",
                    };
                    return Err(not(end));
                }
            }
        };
        Ok(Self {
            path: path.to_owned(),
            bytes,
            records,
            info: info.ok_or_else(|| not("it does not say what it is"))?,
            setup: setup.ok_or_else(|| not("its first tick comes before its setup"))?,
            scene,
            inputs: inputs.into_iter(),
            finish: None,
        })
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Share of it that is read, 0 to 1.
    #[must_use]
    pub fn done(&self) -> f64 {
        self.records.at as f64 / self.bytes.max(1) as f64
    }

    /// What its recorder said at its end; there once there are no more ticks, unless the session is cut,
    /// damaged, or of a program that did not say.
    #[must_use]
    pub fn finish(&self) -> Option<Finish> {
        self.finish
    }

    /// How it ended; there once there are no more ticks.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.records.end.as_ref()
    }
}

impl Iterator for Session {
    type Item = InputRecord;

    fn next(&mut self) -> Option<InputRecord> {
        loop {
            if let Some(record) = self.inputs.next() {
                return Some(record);
            }
            match self.records.next()? {
                Part::Inputs(inputs) => self.inputs = inputs.into_iter(),
                Part::Finish(finish) => self.finish = Some(finish),
                Part::Info(_)
                | Part::Setup(_)
                | Part::Scene(_)
                | Part::Course(_)
                | Part::Assignment(_) => {}
            }
        }
    }
}
