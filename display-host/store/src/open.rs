//! Opening the store. To write, a missing store is made and an older one brought to this version.
//! To read, nothing is changed. A file of another program, of an unknown version or with damage is
//! refused.

use std::fs::{DirBuilder, File, OpenOptions, Permissions};
use std::io::{ErrorKind, Read as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior};

use crate::error::StoreError;
use crate::file::{make_or_migrate, one_file, opening, refused, version_of};
use crate::schema::SCHEMA_VERSION;

/// First bytes of every SQLite file.
const MAGIC: &[u8] = b"SQLite format 3\0";
/// Longest wait for another program that holds the file.
const PATIENCE: Duration = Duration::from_secs(10);
/// Interval between attempts to copy a file that another program holds.
const RETRY: Duration = Duration::from_millis(50);

/// An open store.
#[derive(Debug)]
pub struct Store {
    pub(crate) connection: Connection,
    path: PathBuf,
}

impl Store {
    /// Opens a store to write. Makes the file and its folder if they are missing, and brings a
    /// store of an older version to this one. No other user can read the file.
    ///
    /// # Errors
    /// See [`StoreError`]; a refused file is not changed.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        Self::open_within(path, PATIENCE)
    }

    /// Like [`Store::open`], but waits at most `patience` for another program.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open_within(path: &Path, patience: Duration) -> Result<Self, StoreError> {
        let io = |source| StoreError::Io {
            path: path.to_owned(),
            source,
        };
        let sqlite = |error| refused(path, error);
        if let Some(folder) = path.parent().filter(|it| !it.as_os_str().is_empty()) {
            let made = DirBuilder::new().recursive(true).mode(0o700).create(folder);
            made.map_err(io)?;
        }
        let made = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(path);
        let mut file = made.map_err(io)?;
        check_head(&mut file, path)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let mut connection = Connection::open_with_flags(path, flags).map_err(sqlite)?;
        connection.busy_timeout(patience).map_err(sqlite)?;
        // Deleted data are overwritten, so a forgotten trainee leaves no trace.
        connection
            .execute_batch("PRAGMA foreign_keys = ON; PRAGMA secure_delete = ON;")
            .map_err(|error| opening(path, error))?;
        // If two programs make the store at once, one waits for the other.
        let making = connection
            .transaction_with_behavior(TransactionBehavior::Immediate)
            .map_err(|error| opening(path, error))?;
        make_or_migrate(&making, path)?;
        making.commit().map_err(sqlite)?;
        // Another tool may have left the store with a log file, and may still hold it open. The
        // failure is ignored here, because [`Store::forget`] tries again.
        let _ = one_file(&connection);
        // A file that was copied here may be readable by other users.
        file.set_permissions(Permissions::from_mode(0o600))
            .map_err(io)?;
        Ok(Self {
            connection,
            path: path.to_owned(),
        })
    }

    /// Opens a store to read. Makes and changes nothing: neither file nor folder, mode nor version.
    ///
    /// # Errors
    /// [`StoreError::Missing`] if there is no such file, or if it is empty because another program
    /// is making the store; else as [`Store::open`].
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        Self::read_within(path, PATIENCE)
    }

    /// Like [`Store::read`], but waits at most `patience` for another program.
    ///
    /// # Errors
    /// As [`Store::read`].
    pub fn read_within(path: &Path, patience: Duration) -> Result<Self, StoreError> {
        let mut file = File::open(path).map_err(|source| match source.kind() {
            ErrorKind::NotFound => StoreError::Missing {
                path: path.to_owned(),
            },
            _ => StoreError::Io {
                path: path.to_owned(),
                source,
            },
        })?;
        check_head(&mut file, path)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let opened = Connection::open_with_flags(path, flags);
        let mut connection = opened.map_err(|error| refused(path, error))?;
        let waits = connection.busy_timeout(patience);
        waits.map_err(|error| refused(path, error))?;
        match version_of(&mut connection, path)? {
            Some(SCHEMA_VERSION) => {}
            Some(_) => connection = migrated_copy(&connection, path, patience)?,
            None => {
                return Err(StoreError::Missing {
                    path: path.to_owned(),
                });
            }
        }
        Ok(Self {
            connection,
            path: path.to_owned(),
        })
    }

    /// Path of the store's file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Begins a change of which all or nothing is kept.
    pub(crate) fn change(&mut self) -> Result<Transaction<'_>, StoreError> {
        let begun = self
            .connection
            .transaction_with_behavior(TransactionBehavior::Immediate);
        begun.map_err(|error| refused(&self.path, error))
    }

    pub(crate) fn refused(&self, error: rusqlite::Error) -> StoreError {
        refused(&self.path, error)
    }

    pub(crate) fn rows<T>(
        &self,
        query: &str,
        values: impl rusqlite::Params,
        read: impl FnMut(&rusqlite::Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, StoreError> {
        let mut statement = self
            .connection
            .prepare(query)
            .map_err(|error| self.refused(error))?;
        let rows = statement.query_map(values, read);
        rows.and_then(Iterator::collect)
            .map_err(|error| self.refused(error))
    }
}

/// Refuses a file that is no database. An empty file passes, because a store can be made in it.
fn check_head(file: &mut File, path: &Path) -> Result<(), StoreError> {
    let mut head = Vec::new();
    let read = file.take(MAGIC.len() as u64).read_to_end(&mut head);
    read.map_err(|source| StoreError::Io {
        path: path.to_owned(),
        source,
    })?;
    match head.is_empty() || head == MAGIC {
        true => Ok(()),
        false => Err(StoreError::NotAStore {
            path: path.to_owned(),
        }),
    }
}

/// Copy in memory of a store of an older version, brought to this version.
fn migrated_copy(
    from: &Connection,
    path: &Path,
    patience: Duration,
) -> Result<Connection, StoreError> {
    let sqlite = |error| refused(path, error);
    let mut copy = Connection::open_in_memory().map_err(sqlite)?;
    let backup = Backup::new(from, &mut copy).map_err(sqlite)?;
    let until = Instant::now() + patience;
    while backup.step(-1).map_err(sqlite)? != StepResult::Done {
        if Instant::now() >= until {
            return Err(StoreError::Busy {
                path: path.to_owned(),
            });
        }
        std::thread::sleep(RETRY);
    }
    drop(backup);
    let making = copy.transaction().map_err(sqlite)?;
    make_or_migrate(&making, path)?;
    making.commit().map_err(sqlite)?;
    Ok(copy)
}

/// Makes a session name: a UUID of version 7, which sorts by time.
#[must_use]
pub fn new_id() -> String {
    uuid::Uuid::now_v7().to_string()
}
