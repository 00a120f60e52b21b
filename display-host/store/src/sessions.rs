//! Trainees and what their sessions came to.

use std::collections::BTreeMap;

use rusqlite::{OptionalExtension as _, Row, params};

use crate::error::StoreError;
use crate::open::Store;

/// A name's length, characters.
const NAME_MAX: usize = 64;

/// What a session came to.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SessionRecord {
    /// UUID of version 7.
    pub id: String,
    /// When it began, s since 1970.
    pub began_unix_s: i64,
    /// The task's name.
    pub task: String,
    /// How much help was given.
    pub difficulty: String,
    /// How it ended.
    pub outcome: String,
    /// 0 to 100.
    pub score: f64,
    /// How many alarms there were.
    pub alarms: i64,
    /// Version of the metrics' definitions: only equal ones compare.
    pub metrics_version: u32,
    /// Metrics by name; what was none is not there.
    pub metrics: BTreeMap<String, f64>,
    /// The scene's name.
    pub scene: String,
    /// The program that recorded it.
    pub program: String,
    /// The recording, where it was.
    pub file: Option<String>,
}

/// Somebody in the store.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Trainee {
    /// The chosen name.
    pub name: String,
    /// How many sessions there are.
    pub sessions: i64,
}

/// Whether a name may be: 1 to 64 characters without control characters, not blank.
///
/// # Errors
/// [`StoreError::Value`].
pub fn check_name(name: &str) -> Result<(), StoreError> {
    let length = name.chars().count();
    let sane = (1..=NAME_MAX).contains(&length) && !name.chars().any(char::is_control);
    match sane && !name.trim().is_empty() {
        true => Ok(()),
        false => Err(StoreError::Value {
            what: "a trainee's name".to_owned(),
            value: format!("'{}'", name.escape_debug().take(80).collect::<String>()),
            allowed: "1 to 64 characters, none of them a control character, not only spaces",
        }),
    }
}

impl Store {
    /// Adds what a session came to; whoever is new is added too.
    ///
    /// # Errors
    /// When the name may not be, or the file cannot be written.
    pub fn add_session(&mut self, name: &str, session: &SessionRecord) -> Result<(), StoreError> {
        let trainee = self.trainee_or_new(name)?;
        // A number that is none has no place in JSON.
        let metrics: BTreeMap<&String, f64> = session
            .metrics
            .iter()
            .filter(|(_, value)| value.is_finite())
            .map(|(name, value)| (name, *value))
            .collect();
        let metrics = serde_json::to_string(&metrics).unwrap_or_else(|_| "{}".to_owned());
        let score = if session.score.is_finite() {
            session.score
        } else {
            0.0
        };
        self.connection
            .execute(
                "INSERT OR REPLACE INTO session (id, trainee, began_unix_s, task, difficulty, outcome, score, \
                 alarms, metrics_version, metrics, scene, program, file) \
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)",
                params![
                    session.id,
                    trainee,
                    session.began_unix_s,
                    session.task,
                    session.difficulty,
                    session.outcome,
                    score,
                    session.alarms,
                    session.metrics_version,
                    metrics,
                    session.scene,
                    session.program,
                    session.file,
                ],
            )
            .map_err(|error| self.refused(error))?;
        Ok(())
    }

    pub(crate) fn trainee_or_new(&self, name: &str) -> Result<i64, StoreError> {
        check_name(name)?;
        self.connection
            .execute("INSERT OR IGNORE INTO trainee (name) VALUES (?1)", [name])
            .map_err(|error| self.refused(error))?;
        self.trainee(name)
    }

    pub(crate) fn trainee(&self, name: &str) -> Result<i64, StoreError> {
        let found = self
            .connection
            .query_row("SELECT id FROM trainee WHERE name = ?1", [name], |row| {
                row.get(0)
            })
            .optional();
        found
            .map_err(|error| self.refused(error))?
            .ok_or_else(|| StoreError::NoTrainee(name.escape_debug().to_string()))
    }

    /// Everybody, by name.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn trainees(&self) -> Result<Vec<Trainee>, StoreError> {
        self.rows(
            "SELECT name, count(session.id) FROM trainee LEFT JOIN session ON session.trainee = trainee.id \
             GROUP BY trainee.id ORDER BY name",
            [],
            |row| {
                Ok(Trainee {
                    name: row.get(0)?,
                    sessions: row.get(1)?,
                })
            },
        )
    }

    /// Somebody's sessions, oldest first; of one task, if one is named.
    ///
    /// # Errors
    /// When there is nobody of this name, or the file cannot be read.
    pub fn sessions(
        &self,
        name: &str,
        task: Option<&str>,
    ) -> Result<Vec<SessionRecord>, StoreError> {
        let trainee = self.trainee(name)?;
        self.rows(
            "SELECT id, began_unix_s, task, difficulty, outcome, score, alarms, metrics_version, metrics, scene, \
             program, file FROM session WHERE trainee = ?1 AND (?2 IS NULL OR task = ?2) \
             ORDER BY began_unix_s, id",
            params![trainee, task],
            session_of,
        )
    }

    pub(crate) fn rows<T>(
        &self,
        query: &str,
        values: impl rusqlite::Params,
        read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, StoreError> {
        let mut statement = self
            .connection
            .prepare(query)
            .map_err(|error| self.refused(error))?;
        let rows = statement.query_map(values, read);
        rows.and_then(Iterator::collect)
            .map_err(|error| self.refused(error))
    }

    /// Forgets somebody: sessions, answers, sheets, name. What was there is overwritten. Gives the
    /// recordings that were named, which lie where they lay.
    ///
    /// # Errors
    /// When there is nobody of this name, or the file cannot be written.
    pub fn forget(&mut self, name: &str) -> Result<Vec<String>, StoreError> {
        let files = self.sessions(name, None)?;
        self.connection
            .execute("DELETE FROM trainee WHERE name = ?1", [name])
            .map_err(|error| self.refused(error))?;
        self.connection
            .execute_batch("VACUUM")
            .map_err(|error| self.refused(error))?;
        Ok(files.into_iter().filter_map(|it| it.file).collect())
    }
}

fn session_of(row: &Row<'_>) -> rusqlite::Result<SessionRecord> {
    let metrics: String = row.get(8)?;
    Ok(SessionRecord {
        id: row.get(0)?,
        began_unix_s: row.get(1)?,
        task: row.get(2)?,
        difficulty: row.get(3)?,
        outcome: row.get(4)?,
        score: row.get(5)?,
        alarms: row.get(6)?,
        metrics_version: row.get(7)?,
        metrics: serde_json::from_str(&metrics).unwrap_or_default(),
        scene: row.get(9)?,
        program: row.get(10)?,
        file: row.get(11)?,
    })
}
