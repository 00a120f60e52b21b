//! Merging the stores of several stations: everything in one is added to another.
//!
//! Sessions need no coordinator, because no two stations make the same UUID of version 7. A chosen
//! name identifies a trainee: equal names at two stations are one person. Existing entries stay
//! unchanged, except that the newer answer to a questionnaire replaces the older one. A second
//! merge of the same store changes nothing.

use std::collections::BTreeSet;
use std::path::Path;

use rusqlite::{Connection, OpenFlags, OptionalExtension as _, TransactionBehavior, params};

use crate::error::StoreError;
use crate::open::{Store, check_is_store, refused};
use crate::sessions::{check_id, check_name, check_text, shown};

/// Example query of a training centre, for any program that reads SQLite: number of sessions of
/// every trainee and task, and the means of the score and of one metric in the JSON.
pub const EXAMPLE_SQL: &str = "\
SELECT trainee.name, session.task, count(*) AS sessions, avg(session.score) AS score,
       avg(json_extract(session.metrics, '$.time_s')) AS time_s
FROM session JOIN trainee ON trainee.id = session.trainee
WHERE session.outcome IN ('passed', 'failed')
  AND session.id NOT IN (SELECT session FROM scripted)
GROUP BY trainee.name, session.task ORDER BY trainee.name, session.task;";

/// Counts of a merge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Merged {
    /// Sessions that were new.
    pub sessions: u64,
    /// Sessions that were already there.
    pub known: u64,
    /// Known sessions whose contents differ; the existing ones stay.
    pub differing: u64,
    /// Trainees that were new.
    pub trainees: u64,
    /// Answers that were new or newer.
    pub answers: u64,
    /// New points on instructors' sheets.
    pub points: u64,
}

impl Store {
    /// Adds everything that `other` holds, or nothing if any entry is invalid. `other` is only
    /// read.
    ///
    /// # Errors
    /// When `other` is not a store, has another version, is damaged, or holds an invalid name or
    /// session; when this store cannot be written.
    pub fn merge(&mut self, other: &Path) -> Result<Merged, StoreError> {
        let theirs = open_to_read(other)?;
        // Read one snapshot, because another program may go on writing to `other`.
        let still = theirs.execute_batch("BEGIN");
        still.map_err(|error| refused(other, error))?;
        let own = self.path().to_owned();
        let into = |error| refused(&own, error);
        let begun = self
            .connection
            .transaction_with_behavior(TransactionBehavior::Immediate);
        let ours = begun.map_err(into)?;
        let mut merged = Merged::default();
        for name in texts(&theirs, other, "SELECT name FROM trainee ORDER BY id")? {
            let name = check_name(&name)?;
            let added = ours.execute("INSERT OR IGNORE INTO trainee (name) VALUES (?1)", [name]);
            merged.trainees += added.map_err(into)? as u64;
        }
        merge_sessions(&theirs, &ours, (other, &own), &mut merged)?;
        merge_answers(&theirs, &ours, (other, &own), &mut merged)?;
        merge_sheets(&theirs, &ours, (other, &own), &mut merged)?;
        ours.commit().map_err(into)?;
        Ok(merged)
    }
}

/// Columns of a session, without its trainee.
const COLUMNS: &str = "session.id, began_unix_s, task, difficulty, outcome, score, alarms, metrics_version, metrics, \
                       scene, program, file";

type SessionRow = (
    (String, String, i64, String, String, String),
    (f64, i64, u32, String, String, String, Option<String>),
);

fn merge_sessions(
    theirs: &Connection,
    ours: &Connection,
    (other, own): (&Path, &Path),
    merged: &mut Merged,
) -> Result<(), StoreError> {
    let into = |error| refused(own, error);
    let query = |order: &str| {
        format!(
            "SELECT name, {COLUMNS} FROM session JOIN trainee ON trainee.id = session.trainee {order}"
        )
    };
    let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<SessionRow> {
        let first = (
            name_of(row)?,
            row.get(1)?,
            row.get(2)?,
            row.get(3)?,
            row.get(4)?,
            row.get(5)?,
        );
        let second = (
            row.get(6)?,
            row.get(7)?,
            row.get(8)?,
            row.get(9)?,
            row.get(10)?,
            row.get(11)?,
            row.get(12)?,
        );
        Ok((first, second))
    };
    let scripted = scripted(theirs, other)?;
    for session in rows(
        theirs,
        other,
        &query("ORDER BY began_unix_s, session.id"),
        row,
    )? {
        let ((name, id, began, task, difficulty, outcome), rest) = &session;
        let (score, alarms, version, metrics, scene, program, file) = rest;
        check_session(id, metrics)?;
        let file = file.as_deref().unwrap_or_default();
        for text in [task, difficulty, outcome, scene, program, file] {
            check_text(id, text)?;
        }
        let file = rest.6.as_deref();
        let known: Option<SessionRow> = ours
            .query_row(&query("WHERE session.id = ?1"), [id], row)
            .optional()
            .map_err(into)?;
        if let Some(known) = known {
            merged.known += 1;
            merged.differing += u64::from(known != session);
            continue;
        }
        ours.execute(
            "INSERT INTO session (id, trainee, began_unix_s, task, difficulty, outcome, score, alarms, \
             metrics_version, metrics, scene, program, file) SELECT ?1, trainee.id, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, \
             ?11, ?12, ?13 FROM trainee WHERE name = ?2",
            params![
                id, name, began, task, difficulty, outcome, score, alarms, version, metrics, scene, program, file
            ],
        )
        .map_err(into)?;
        if scripted.contains(id) {
            let mark = "INSERT OR IGNORE INTO scripted (session) VALUES (?1)";
            ours.execute(mark, [id]).map_err(into)?;
        }
        merged.sessions += 1;
    }
    Ok(())
}

/// Sessions that a scripted hand worked. A store of an older program has none.
fn scripted(theirs: &Connection, other: &Path) -> Result<BTreeSet<String>, StoreError> {
    let tables = "SELECT name FROM sqlite_schema WHERE type = 'table' AND name = 'scripted'";
    match texts(theirs, other, tables)?.is_empty() {
        true => Ok(BTreeSet::new()),
        false => {
            let all = texts(theirs, other, "SELECT session FROM scripted")?;
            Ok(all.into_iter().collect())
        }
    }
}

/// Checks a session that another program may have written.
fn check_session(id: &str, metrics: &str) -> Result<(), StoreError> {
    check_id(id)?;
    let parsed = serde_json::from_str::<std::collections::BTreeMap<String, f64>>(metrics);
    parsed.map(drop).map_err(|_| StoreError::Value {
        what: format!("the metrics of session {id}"),
        value: format!("'{}'", shown(metrics)),
        allowed: "a JSON object of numbers",
    })
}

fn merge_answers(
    theirs: &Connection,
    ours: &Connection,
    (other, own): (&Path, &Path),
    merged: &mut Merged,
) -> Result<(), StoreError> {
    let query = "SELECT name, questionnaire, item, value, at_unix_s FROM answer \
                 JOIN trainee ON trainee.id = answer.trainee";
    let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<(String, String, String, i64, i64)> {
        Ok((
            name_of(row)?,
            row.get(1)?,
            row.get(2)?,
            row.get(3)?,
            row.get(4)?,
        ))
    };
    for (name, questionnaire, item, value, at) in rows(theirs, other, query, row)? {
        let changed = ours.execute(
            "INSERT INTO answer (trainee, questionnaire, item, value, at_unix_s) \
             SELECT id, ?2, ?3, ?4, ?5 FROM trainee WHERE name = ?1 \
             ON CONFLICT DO UPDATE SET value = excluded.value, at_unix_s = excluded.at_unix_s \
             WHERE excluded.at_unix_s > answer.at_unix_s",
            params![name, questionnaire, item, value, at],
        );
        merged.answers += changed.map_err(|error| refused(own, error))? as u64;
    }
    Ok(())
}

fn merge_sheets(
    theirs: &Connection,
    ours: &Connection,
    (other, own): (&Path, &Path),
    merged: &mut Merged,
) -> Result<(), StoreError> {
    let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<(String, String, i64)> {
        Ok((row.get(0)?, row.get(1)?, row.get(2)?))
    };
    for (session, item, value) in
        rows(theirs, other, "SELECT session, item, value FROM sheet", row)?
    {
        let added = ours.execute(
            "INSERT OR IGNORE INTO sheet (session, item, value) VALUES (?1, ?2, ?3)",
            params![session, item, value],
        );
        merged.points += added.map_err(|error| refused(own, error))? as u64;
    }
    Ok(())
}

/// Trims the name, because an earlier version of Calot stored the spaces around it.
fn name_of(row: &rusqlite::Row<'_>) -> rusqlite::Result<String> {
    Ok(row.get::<_, String>(0)?.trim().to_owned())
}

fn texts(from: &Connection, path: &Path, query: &str) -> Result<Vec<String>, StoreError> {
    rows(from, path, query, |row| row.get(0))
}

fn rows<T>(
    from: &Connection,
    path: &Path,
    query: &str,
    read: impl FnMut(&rusqlite::Row<'_>) -> rusqlite::Result<T>,
) -> Result<Vec<T>, StoreError> {
    let read = from
        .prepare(query)
        .and_then(|mut it| it.query_map([], read)?.collect());
    read.map_err(|error| refused(path, error))
}

/// Opens a store without changing it, including its journal mode.
fn open_to_read(path: &Path) -> Result<Connection, StoreError> {
    std::fs::File::open(path).map_err(|source| StoreError::Io {
        path: path.to_owned(),
        source,
    })?;
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection =
        Connection::open_with_flags(path, flags).map_err(|error| refused(path, error))?;
    check_is_store(&connection, path)?;
    Ok(connection)
}
