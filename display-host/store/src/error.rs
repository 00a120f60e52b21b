//! Why the store refuses.

use std::path::PathBuf;

use crate::open::SCHEMA_VERSION;

/// Why the store refuses. Nothing in it is changed then.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file or its folder cannot be made or opened.
    #[error("{path}: {source}; name another file with --store")]
    Io {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// It is another program's file, or no database at all.
    #[error("{path} is no store of Calot; it is left as it is. Name another file with --store")]
    NotAStore {
        /// Which.
        path: PathBuf,
    },
    /// Another version of Calot made it.
    #[error(
        "{path} is a store of version {found}, this program keeps version {SCHEMA_VERSION}; it is left as it is. \
         Use the program that made it (`calot store export` there, to have what is in it)"
    )]
    Version {
        /// Which.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
    /// It is damaged.
    #[error(
        "{path} is damaged ({problem}); it is left as it is. Put a copy of it back, or move it away and begin anew"
    )]
    Damaged {
        /// Which.
        path: PathBuf,
        /// What SQLite found.
        problem: String,
    },
    /// Another program writes, and did not finish in time.
    #[error(
        "{path} is in use: another Calot, or another program, has it open and writes. Try again when that is done"
    )]
    Busy {
        /// Which.
        path: PathBuf,
    },
    /// What is deleted could stay readable in a file beside it.
    #[error(
        "{path} keeps a log beside it ({mode}), in which what is deleted could be read on, and another program \
         holds it open. Nobody was forgotten: end the programs that have it open, and try again"
    )]
    Log {
        /// Which.
        path: PathBuf,
        /// SQLite's journal mode.
        mode: String,
    },
    /// SQLite refuses.
    #[error("{path}: {source}")]
    Sqlite {
        /// Which.
        path: PathBuf,
        /// SQLite's words.
        source: rusqlite::Error,
    },
    /// There is nobody of this name.
    #[error("nobody is called '{0}' in the store; `calot store list` says who is")]
    NoTrainee(String),
    /// There is no such session.
    #[error("no session '{0}' in the store; `calot store list NAME` says which are")]
    NoSession(String),
    /// A session is somebody else's.
    #[error(
        "session '{session}' is in the store under another name; it stays so. `calot store export` says whose it is"
    )]
    Taken {
        /// Which.
        session: String,
    },
    /// A value is out of its range.
    #[error("{what} is {value}; allowed is {allowed}")]
    Value {
        /// Which.
        what: String,
        /// What it is.
        value: String,
        /// What it may be.
        allowed: &'static str,
    },
    /// A questionnaire's file is not of the expected form.
    #[error("questionnaire: {0}")]
    Questionnaire(String),
}
