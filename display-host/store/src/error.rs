//! Errors of the store.

use std::path::PathBuf;

use crate::schema::SCHEMA_VERSION;

/// Reasons for which the store refuses a request. A refused request changes nothing.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file or its folder cannot be made or opened.
    #[error("{path}: {source}; name another file with --store")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file belongs to another program, or is not a database.
    #[error("{path} is not a store of Calot and is left as it is. Name another file with --store")]
    NotAStore {
        /// The file.
        path: PathBuf,
    },
    /// There is no store yet.
    #[error(
        "there is no store {path}, and this command makes none. `calot run --task clamp --trainee NAME` keeps the first \
         session; name another file with --store"
    )]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// A store is to be merged into itself.
    #[error(
        "{other} and {into}, the store that --store names, are the same file: a store cannot be merged into itself. \
         Name another file with --store, or leave {other} out"
    )]
    SameFile {
        /// Store to merge into.
        into: PathBuf,
        /// Store to read.
        other: PathBuf,
    },
    /// Another version of Calot made the store.
    #[error(
        "{path} is a store of version {found}; this program reads versions up to {SCHEMA_VERSION}. It is left as it is. \
         Use the program that made it (its `calot store export` writes out the contents)"
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Version of the store.
        found: i64,
    },
    /// The file is damaged.
    #[error(
        "{path} is damaged ({problem}) and is left as it is. Restore a backup, or move the file away to start a new store"
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Problem that SQLite reports.
        problem: String,
    },
    /// Another program was still writing when the waiting time ended.
    #[error(
        "{path} is in use: another program is writing to it. Try again when that program has finished"
    )]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// Deleted data could stay readable in a log file next to the store.
    #[error(
        "{path} has a log file ({mode}) in which deleted data would stay readable, and another program \
         holds it open. Nobody was forgotten: close the programs that use the store, then try again"
    )]
    Log {
        /// The file.
        path: PathBuf,
        /// Journal mode of SQLite.
        mode: String,
    },
    /// SQLite refuses the request.
    #[error("{path}: {source}")]
    Sqlite {
        /// The file.
        path: PathBuf,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
    /// No trainee has this name.
    #[error("no trainee '{0}' in the store; `calot store list` shows all names")]
    NoTrainee(String),
    /// No session has this name.
    #[error("no session '{0}' in the store; `calot store list NAME` shows those of a trainee")]
    NoSession(String),
    /// The session belongs to another trainee.
    #[error(
        "session '{session}' already belongs to another trainee and stays there. `calot store export` shows whose it is"
    )]
    Taken {
        /// Name of the session.
        session: String,
    },
    /// The session began before its trainee was forgotten.
    #[error(
        "session '{session}' belongs to somebody who was forgotten after it began, and stays out. A new session of the \
         same person is kept"
    )]
    Forgotten {
        /// Name of the session.
        session: String,
    },
    /// A value is outside its range.
    #[error("{what} is {value}; allowed is {allowed}")]
    Value {
        /// Name of the value.
        what: String,
        /// The value.
        value: String,
        /// Allowed range.
        allowed: String,
    },
    /// A questionnaire file has the wrong form.
    #[error("questionnaire: {0}")]
    Questionnaire(String),
    /// A scoring sheet has the wrong form, or there is none of this name.
    #[error("scoring sheet: {0}")]
    Sheet(String),
    /// The rater filled this sheet for this session before.
    #[error(
        "{} already filled the sheet '{sheet}' for session '{session}', and it stays. Add --replace to replace it, or \
         name another rater with --rater",
        rater_in_words(rater)
    )]
    Rated {
        /// Name of the rater; empty: none.
        rater: String,
        /// Name of the sheet.
        sheet: String,
        /// Name of the session.
        session: String,
    },
}

/// A rater as the subject of a sentence; `rater` is the name, which may be empty.
#[must_use]
pub fn rater_in_words(rater: &str) -> String {
    match rater {
        "" => "a rater without a name".to_owned(),
        rater => format!("the rater '{rater}'"),
    }
}
