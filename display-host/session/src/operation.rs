//! An operation read from a session for its assessment: the scene, what it was for, and its course.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use shared_mem::scene::SceneFile;

use crate::course::Entry;
use crate::info::{Assignment, Finish, Info};
use crate::read::{End, ReadError};
use crate::records::{Part, Records};

/// An operation, being read.
pub struct Operation {
    path: PathBuf,
    bytes: u64,
    records: Records,
    /// What the session says of itself.
    pub info: Info,
    /// The scene that ran.
    pub scene: SceneFile,
    /// What it was for.
    pub assignment: Option<Assignment>,
    first: Option<Entry>,
    finish: Option<Finish>,
}

impl core::fmt::Debug for Operation {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Operation")
            .field("path", &self.path)
            .field("info", &self.info)
            .finish_non_exhaustive()
    }
}

impl Operation {
    /// Opens a session and reads as far as the first entry of its course.
    ///
    /// # Errors
    /// As [`ReadError`] says; also of a session without a course, as older programs left them.
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
    /// As [`Operation::open`].
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let not = |problem: String| ReadError::NotASession {
            path: path.to_owned(),
            problem,
        };
        let mut records = Records::new(source);
        let (mut info, mut scene, mut assignment) = (None, None, None);
        let first = loop {
            match records.next() {
                Some(Part::Info(map)) => {
                    info = Some(Info::from_map(&map).map_err(|found| ReadError::Version {
                        path: path.to_owned(),
                        found,
                    })?);
                }
                Some(Part::Scene(found)) => scene = Some(found),
                Some(Part::Assignment(found)) => assignment = Some(found),
                Some(Part::Course(entry)) => break entry,
                Some(Part::Setup(_) | Part::Inputs(_) | Part::Finish(_)) => {}
                None => {
                    return Err(not(match &records.end {
                        Some(End::BrokenOff(why) | End::Damaged(why)) => why.clone(),
                        _ => {
                            "it has no course of an operation; older programs recorded none".into()
                        }
                    }));
                }
            }
        };
        let scene = scene.ok_or_else(|| not("its scene is not in it".into()))?;
        let scene = SceneFile::from_bytes(&scene)
            .map_err(|error| not(format!("its scene cannot be used: {error}")))?;
        Ok(Self {
            path: path.to_owned(),
            bytes,
            records,
            info: info.ok_or_else(|| not("it does not say what it is".into()))?,
            scene,
            assignment,
            first: Some(first),
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

    /// What its recorder said at its end; there once there is no more of it, unless it is cut, damaged, or
    /// of a program that did not say.
    #[must_use]
    pub fn finish(&self) -> Option<Finish> {
        self.finish
    }

    /// How it ended; there once there is no more of it.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.records.end.as_ref()
    }
}

impl Iterator for Operation {
    type Item = Entry;

    fn next(&mut self) -> Option<Entry> {
        if let Some(entry) = self.first.take() {
            return Some(entry);
        }
        loop {
            match self.records.next()? {
                Part::Course(entry) => return Some(entry),
                Part::Finish(finish) => self.finish = Some(finish),
                _ => {}
            }
        }
    }
}
