//! An operation read from a session for its assessment: scene, purpose and course.

use std::io::Read;
use std::path::Path;

use shared_mem::scene::SceneFile;

use crate::course::Entry;
use crate::error::ReadError;
use crate::info::{Assignment, Finish, Info};
use crate::opened::{self, Opened};
use crate::records::{End, Part};

/// An operation being read.
pub struct Operation {
    opened: Opened,
    /// The session's description of itself.
    pub info: Info,
    /// The scene of the operation.
    pub scene: SceneFile,
    /// Purpose of the session.
    pub assignment: Option<Assignment>,
    first: Option<Entry>,
}

impl core::fmt::Debug for Operation {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Operation")
            .field("path", &self.opened.path)
            .field("info", &self.info)
            .finish_non_exhaustive()
    }
}

impl Operation {
    /// Opens a session and reads up to the first entry of its course.
    ///
    /// # Errors
    /// See [`ReadError`]. A session without a course is an error, too; older programs wrote such.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (bytes, source) = opened::source(path)?;
        Self::read(path, bytes, source)
    }

    /// Reads a session from any source of bytes.
    ///
    /// # Errors
    /// See [`Operation::open`].
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let without = "it has no course of an operation (older programs recorded none)";
        let (opened, head, first) = Opened::read(path, (bytes, source), without, Part::entry)?;
        let not = |problem: &str| opened::not_a_session(path, problem);
        let scene = head.scene.ok_or_else(|| not("it lacks its scene"))?;
        let scene = SceneFile::from_bytes(&scene)
            .map_err(|error| not(&format!("its scene cannot be used: {error}")))?;
        Ok(Self {
            opened,
            info: head.info,
            scene,
            assignment: head.assignment,
            first: Some(first),
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

    /// The recorder's final record. Present once everything is read, unless the session is cut off
    /// or damaged, or its program wrote no such record.
    #[must_use]
    pub fn finish(&self) -> Option<Finish> {
        self.opened.finish
    }

    /// The way in which the session ended; present once everything is read.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.opened.end()
    }
}

impl Iterator for Operation {
    type Item = Entry;

    fn next(&mut self) -> Option<Entry> {
        self.first.take().or_else(|| self.opened.next(Part::entry))
    }
}
