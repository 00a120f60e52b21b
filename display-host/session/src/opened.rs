//! Opens a session: reads its description, and its parts up to the first one that the caller wants.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use shared_mem::inputs::RunSetup;

use crate::error::ReadError;
use crate::info::{Assignment, Finish, Info};
use crate::records::{End, Part, Records};

/// A file whose head has been read.
pub(crate) struct Opened {
    pub(crate) path: PathBuf,
    bytes: u64,
    records: Records,
    pub(crate) finish: Option<Finish>,
}

/// A session's description of itself.
pub(crate) struct Head {
    pub(crate) info: Info,
    pub(crate) setup: Option<RunSetup>,
    pub(crate) scene: Option<Vec<u8>>,
    pub(crate) assignment: Option<Assignment>,
}

/// Opens a file. Returns its length and its bytes.
pub(crate) fn source(path: &Path) -> Result<(u64, Box<dyn Read>), ReadError> {
    let io = |source| ReadError::Io {
        path: path.to_owned(),
        source,
    };
    let file = File::open(path).map_err(io)?;
    let bytes = file.metadata().map_err(io)?.len();
    Ok((bytes, Box::new(BufReader::new(file))))
}

impl Opened {
    /// Reads up to the first part that is `wanted`. `without` is the error for a complete file that
    /// has no such part.
    pub(crate) fn read<T>(
        path: &Path,
        (bytes, source): (u64, Box<dyn Read>),
        without: &str,
        wanted: impl Fn(Part) -> Option<T>,
    ) -> Result<(Self, Head, T), ReadError> {
        let mut records = Records::new(source);
        let (mut info, mut setup, mut scene, mut assignment) = (None, None, None, None);
        let first = loop {
            match records.next() {
                Some(Part::Info(map)) => {
                    info = Some(Info::from_map(&map).map_err(|found| ReadError::Version {
                        path: path.to_owned(),
                        found,
                    })?);
                }
                Some(Part::Setup(found)) => setup = Some(found),
                Some(Part::Scene(found)) => scene = Some(found),
                Some(Part::Assignment(found)) => assignment = Some(found),
                Some(part) => {
                    if let Some(first) = wanted(part) {
                        break first;
                    }
                }
                None => {
                    return Err(not_a_session(
                        path,
                        match &records.end {
                            Some(End::BrokenOff(why) | End::Damaged(why)) => why,
                            _ => without,
                        },
                    ));
                }
            }
        };
        let head = Head {
            info: info.ok_or_else(|| not_a_session(path, "it lacks its description"))?,
            setup,
            scene,
            assignment,
        };
        let opened = Self {
            path: path.to_owned(),
            bytes,
            records,
            finish: None,
        };
        Ok((opened, head, first))
    }

    /// Next part that is `wanted`.
    pub(crate) fn next<T>(&mut self, wanted: impl Fn(Part) -> Option<T>) -> Option<T> {
        loop {
            match self.records.next()? {
                Part::Finish(finish) => self.finish = Some(finish),
                part => {
                    if let Some(found) = wanted(part) {
                        return Some(found);
                    }
                }
            }
        }
    }

    /// Share of the file that has been read, 0 to 1.
    pub(crate) fn done(&self) -> f64 {
        self.records.at as f64 / self.bytes.max(1) as f64
    }

    /// The way in which the file ended; present once all parts are read.
    pub(crate) fn end(&self) -> Option<&End> {
        self.records.end.as_ref()
    }
}

pub(crate) fn not_a_session(path: &Path, problem: &str) -> ReadError {
    ReadError::NotASession {
        path: path.to_owned(),
        problem: problem.to_owned(),
    }
}
