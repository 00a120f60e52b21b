//! Opening the store. A missing store is made; a file of another program, of another version or
//! with damage is refused.

use std::fs::{DirBuilder, OpenOptions, Permissions};
use std::io::Read as _;
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags};

use crate::error::StoreError;
use crate::schema::{APPLICATION, SCHEMA_VERSION, SCRIPTED, TABLES};

/// First bytes of every SQLite file.
const MAGIC: &[u8] = b"SQLite format 3\0";
/// Longest wait for another program that holds the file.
const PATIENCE: Duration = Duration::from_secs(10);

/// An open store.
#[derive(Debug)]
pub struct Store {
    pub(crate) connection: Connection,
    path: PathBuf,
}

impl Store {
    /// Opens a store. Makes the file and its folder if they are missing. No other user can read
    /// the file.
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
        let sqlite = |source| StoreError::Sqlite {
            path: path.to_owned(),
            source,
        };
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
        let mut head = Vec::new();
        let read = (&mut file).take(MAGIC.len() as u64).read_to_end(&mut head);
        read.map_err(io)?;
        if !head.is_empty() && head != MAGIC {
            return Err(StoreError::NotAStore {
                path: path.to_owned(),
            });
        }
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let mut connection = Connection::open_with_flags(path, flags).map_err(sqlite)?;
        connection.busy_timeout(patience).map_err(sqlite)?;
        // Deleted data are overwritten, so a forgotten trainee leaves no trace.
        connection
            .execute_batch("PRAGMA foreign_keys = ON; PRAGMA secure_delete = ON;")
            .map_err(|error| opening(path, error))?;
        Self::make_or_check(&mut connection, path)?;
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

    fn make_or_check(connection: &mut Connection, path: &Path) -> Result<(), StoreError> {
        let broken = |error: rusqlite::Error| opening(path, error);
        let sqlite = |source| refused(path, source);
        // If two programs make the store at once, one waits for the other.
        let making = connection
            .transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)
            .map_err(broken)?;
        if marks(&making, path)? != (0, 0, 0) {
            check_is_store(&making, path)?;
            making.execute_batch(SCRIPTED).map_err(sqlite)?;
            return making.commit().map_err(sqlite);
        }
        making.execute_batch(TABLES).map_err(sqlite)?;
        making.execute_batch(SCRIPTED).map_err(sqlite)?;
        making
            .pragma_update(None, "application_id", APPLICATION)
            .map_err(sqlite)?;
        making
            .pragma_update(None, "user_version", SCHEMA_VERSION)
            .map_err(sqlite)?;
        making.commit().map_err(sqlite)
    }

    /// Path of the store's file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn refused(&self, error: rusqlite::Error) -> StoreError {
        refused(&self.path, error)
    }
}

/// Application id, version, and number of tables and indices.
fn marks(connection: &Connection, path: &Path) -> Result<(i64, i64, i64), StoreError> {
    let broken = |error| opening(path, error);
    let number = |name: &str| {
        connection
            .pragma_query_value(None, name, |row| row.get::<_, i64>(0))
            .map_err(broken)
    };
    let tables = connection.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0));
    Ok((
        number("application_id")?,
        number("user_version")?,
        tables.map_err(broken)?,
    ))
}

/// Refuses a file that is not an undamaged store of this version.
pub(crate) fn check_is_store(connection: &Connection, path: &Path) -> Result<(), StoreError> {
    let path = path.to_owned();
    match marks(connection, &path)? {
        (APPLICATION, SCHEMA_VERSION, _) => {}
        (APPLICATION, found, _) => return Err(StoreError::Version { path, found }),
        _ => return Err(StoreError::NotAStore { path }),
    }
    let found = connection.query_row("PRAGMA quick_check(1)", [], |row| row.get(0));
    let found: String = found.map_err(|error| opening(&path, error))?;
    match found.as_str() {
        "ok" => Ok(()),
        problem => Err(StoreError::Damaged {
            problem: problem.to_owned(),
            path,
        }),
    }
}

/// Keeps all data in one file and returns the resulting journal mode. The mode is "delete", unless
/// another program holds the store open with a log file.
pub(crate) fn one_file(connection: &Connection) -> rusqlite::Result<String> {
    connection.query_row("PRAGMA journal_mode = DELETE", [], |row| row.get(0))
}

/// Translates an error of SQLite.
pub(crate) fn refused(path: &Path, error: rusqlite::Error) -> StoreError {
    use rusqlite::ErrorCode::{DatabaseBusy, DatabaseCorrupt, DatabaseLocked, NotADatabase};
    match error.sqlite_error_code() {
        Some(DatabaseBusy | DatabaseLocked) => StoreError::Busy {
            path: path.to_owned(),
        },
        Some(DatabaseCorrupt | NotADatabase) => damaged(path, &error),
        _ => StoreError::Sqlite {
            path: path.to_owned(),
            source: error,
        },
    }
}

/// Translates an error of the first queries to a file. Every undamaged database can answer these
/// queries, so an answer that makes no sense means damage. A file that is locked, or that the
/// machine cannot read, is not damaged.
fn opening(path: &Path, error: rusqlite::Error) -> StoreError {
    use rusqlite::ErrorCode::{ApiMisuse, TypeMismatch, Unknown};
    match error.sqlite_error_code() {
        None | Some(Unknown | TypeMismatch | ApiMisuse) => damaged(path, &error),
        Some(_) => refused(path, error),
    }
}

fn damaged(path: &Path, error: &rusqlite::Error) -> StoreError {
    StoreError::Damaged {
        path: path.to_owned(),
        problem: error.to_string(),
    }
}

/// Makes a session name: a UUID of version 7, which sorts by time.
#[must_use]
pub fn new_id() -> String {
    uuid::Uuid::now_v7().to_string()
}
