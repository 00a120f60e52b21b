//! Errors of reading a session.

use std::path::PathBuf;

use crate::file::FILE_VERSION;

/// Reason why a session cannot be read, or why a file made of it cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}; `calot run --record FILE` records a session")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not a session, or is damaged before its first tick or entry.
    #[error("{path} is not a session of Calot: {problem}; `calot run --record FILE` records one")]
    NotASession {
        /// Path of the file.
        path: PathBuf,
        /// The missing or faulty part.
        problem: String,
    },
    /// The file was written by another version of Calot.
    #[error(
        "{path}: the session has version '{found}', and this program reads {FILE_VERSION}; replay it with the program that recorded it"
    )]
    Version {
        /// Path of the file.
        path: PathBuf,
        /// The file's version.
        found: String,
    },
    /// A file made of a session cannot be written.
    #[error("{path}: {problem}; choose another place, or make room on the disk")]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system or of the MCAP library.
        problem: String,
    },
    /// The session ran on another scene than the one that is to replace its own.
    #[error(
        "{path}: the session ran on scene {wanted}, and the given scene is {found}; name the same compiled scene"
    )]
    OtherScene {
        /// Path of the session.
        path: PathBuf,
        /// Identity of the session's scene.
        wanted: String,
        /// Identity of the given scene.
        found: String,
    },
    /// The session is being recorded.
    #[error("{path} is being recorded; end that run first")]
    BeingRecorded {
        /// Path of the file.
        path: PathBuf,
    },
}
