//! The store as a file of SQLite: its marks, its version, its errors.

use std::path::Path;

use rusqlite::{Connection, Transaction};

use crate::error::StoreError;
use crate::names::check_name;
use crate::schema::{
    APPLICATION, FIFTH, FOURTH, FROM_FIRST, OLDEST_VERSION, SCHEMA_VERSION, SECOND, TABLES, THIRD,
};

/// Version of the store that the file holds; `None` if the file is empty, because its maker has not
/// come further. Sees one state of the file, also while another program makes the store.
pub(crate) fn version_of(
    connection: &mut Connection,
    path: &Path,
) -> Result<Option<i64>, StoreError> {
    let seen = connection.transaction();
    let seen = seen.map_err(|error| opening(path, error))?;
    match marks(&seen, path)? {
        (0, 0, 0) => Ok(None),
        _ => check_is_store(&seen, path).map(Some),
    }
}

/// Makes the tables of an empty file, or brings those of an older version to this one. Refuses
/// every other file. The caller commits.
pub(crate) fn make_or_migrate(making: &Transaction<'_>, path: &Path) -> Result<(), StoreError> {
    let sqlite = |error| refused(path, error);
    let mut found = 2;
    if marks(making, path)? == (0, 0, 0) {
        making.execute_batch(TABLES).map_err(sqlite)?;
        making.execute_batch(SECOND).map_err(sqlite)?;
        making
            .pragma_update(None, "application_id", APPLICATION)
            .map_err(sqlite)?;
    } else {
        found = check_is_store(making, path)?;
        if found == SCHEMA_VERSION {
            return Ok(());
        }
        if found < 2 {
            making.execute_batch(SECOND).map_err(sqlite)?;
            making.execute_batch(FROM_FIRST).map_err(sqlite)?;
            normalise_names(making).map_err(sqlite)?;
        }
    }
    if found < 3 {
        making.execute_batch(THIRD).map_err(sqlite)?;
    }
    if found < 4 {
        making.execute_batch(FOURTH).map_err(sqlite)?;
    }
    making.execute_batch(FIFTH).map_err(sqlite)?;
    making
        .pragma_update(None, "user_version", SCHEMA_VERSION)
        .map_err(sqlite)
}

/// Brings names to the form in which they are looked up, except a name whose form another trainee
/// has already.
fn normalise_names(making: &Transaction<'_>) -> rusqlite::Result<()> {
    let names: Vec<String> = making
        .prepare("SELECT name FROM trainee")?
        .query_map([], |row| row.get(0))?
        .collect::<rusqlite::Result<_>>()?;
    for name in names {
        if let Ok(normal) = check_name(&name)
            && normal != name
        {
            let change = "UPDATE OR IGNORE trainee SET name = ?2 WHERE name = ?1";
            making.execute(change, [&name, &normal])?;
        }
    }
    Ok(())
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

/// Refuses a file that is not an undamaged store of a version that this program reads. Returns the
/// version.
fn check_is_store(connection: &Connection, path: &Path) -> Result<i64, StoreError> {
    let path = path.to_owned();
    let version = match marks(connection, &path)? {
        (APPLICATION, found @ OLDEST_VERSION..=SCHEMA_VERSION, _) => found,
        (APPLICATION, found, _) => return Err(StoreError::Version { path, found }),
        _ => return Err(StoreError::NotAStore { path }),
    };
    let found = connection.query_row("PRAGMA quick_check(1)", [], |row| row.get(0));
    let found: String = found.map_err(|error| opening(&path, error))?;
    match found.as_str() {
        "ok" => Ok(version),
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
pub(crate) fn opening(path: &Path, error: rusqlite::Error) -> StoreError {
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
