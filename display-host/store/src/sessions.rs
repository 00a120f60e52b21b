//! Trainees and the results of their sessions.

use std::collections::BTreeMap;

use rusqlite::{OptionalExtension as _, Row, params};

use crate::error::StoreError;
use crate::open::{Store, one_file};

/// Longest name, characters.
const NAME_MAX: usize = 64;

/// Hand that worked a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Hand {
    /// A person.
    #[default]
    Person,
    /// A script at emulated devices. The session tells nothing about the trainee.
    Scripted,
}

impl Hand {
    /// Name in exports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Person => "person",
            Self::Scripted => "scripted",
        }
    }
}

/// Result of a session.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SessionRecord {
    /// UUID of version 7.
    pub id: String,
    /// Start, s since 1970.
    pub began_unix_s: i64,
    /// The task's name.
    pub task: String,
    /// Difficulty: the degree of help during the task.
    pub difficulty: String,
    /// Outcome: `passed`, `failed`, `aborted`, `practised` or `cut-short`.
    pub outcome: String,
    /// Score, 0 to 100.
    pub score: f64,
    /// Number of alarms.
    pub alarms: i64,
    /// Version of the metrics' definitions. Only metrics of equal versions are comparable.
    pub metrics_version: u32,
    /// Metrics by name. A metric without a value is absent.
    pub metrics: BTreeMap<String, f64>,
    /// The scene's name.
    pub scene: String,
    /// Program that recorded the session.
    pub program: String,
    /// File of the recording, if there is one.
    pub file: Option<String>,
    /// Hand that worked it.
    pub hand: Hand,
}

/// A trainee in the store.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Trainee {
    /// The chosen name.
    pub name: String,
    /// Number of sessions.
    pub sessions: i64,
}

/// Trims a name and checks that it has 1 to 64 characters, all of them visible.
///
/// # Errors
/// [`StoreError::Value`] names the forbidden character.
pub fn check_name(name: &str) -> Result<&str, StoreError> {
    let name = name.trim();
    let unseen = name.chars().find(|it| is_unseen(*it));
    if unseen.is_none() && (1..=NAME_MAX).contains(&name.chars().count()) {
        return Ok(name);
    }
    let shown = shown(name);
    Err(StoreError::Value {
        what: "a trainee's name".to_owned(),
        value: match unseen {
            Some(it) => format!(
                "'{shown}', with the invisible character U+{:04X}",
                u32::from(it)
            ),
            None => format!("'{shown}'"),
        },
        allowed: "1 to 64 characters without control characters, characters of no width, and characters that \
                  reverse the text: two names that look alike would be two people",
    })
}

/// Checks a session name. Only one spelling of a UUID is allowed; another spelling would make the
/// same session a different one.
pub(crate) fn check_id(id: &str) -> Result<(), StoreError> {
    match uuid::Uuid::parse_str(id).is_ok_and(|it| it.hyphenated().to_string() == id) {
        true => Ok(()),
        false => Err(StoreError::Value {
            what: "a session's name".to_owned(),
            value: format!("'{}'", shown(id)),
            allowed: "a UUID in lower case with hyphens",
        }),
    }
}

/// Refuses control characters, which could command the terminal that shows the text.
pub(crate) fn check_text(id: &str, text: &str) -> Result<(), StoreError> {
    match text.chars().any(char::is_control) {
        false => Ok(()),
        true => Err(StoreError::Value {
            what: format!("a text of session {id}"),
            value: format!("'{}'", shown(text)),
            allowed: "text without control characters",
        }),
    }
}

/// Start of a refused text, escaped for a terminal.
pub(crate) fn shown(text: &str) -> String {
    text.escape_debug().take(80).collect()
}

/// True for control characters and for Unicode's format characters, line separators and fillers.
/// They are invisible or change how the following text looks.
fn is_unseen(it: char) -> bool {
    it.is_control()
        || matches!(
            u32::from(it),
            0xad | 0x34f | 0x600..=0x605 | 0x61c | 0x6dd | 0x70f | 0x890..=0x891 | 0x8e2
                | 0x115f..=0x1160 | 0x17b4..=0x17b5 | 0x180b..=0x180f | 0x200b..=0x200f
                | 0x2028..=0x202e | 0x2060..=0x206f | 0x2800 | 0x3164 | 0xfe00..=0xfe0f | 0xfeff
                | 0xffa0 | 0xfff0..=0xfffb | 0x110bd | 0x110cd | 0x13430..=0x1343f
                | 0x1bca0..=0x1bca3 | 0x1d173..=0x1d17a | 0xe0000..=0xe0fff
        )
}

impl Store {
    /// Adds the result of a session, and the trainee if the name is new. Replaces a session of the
    /// same id.
    ///
    /// # Errors
    /// When the name is invalid or the file cannot be written.
    pub fn add_session(&mut self, name: &str, session: &SessionRecord) -> Result<(), StoreError> {
        self.insert("REPLACE", name, session).map(drop)
    }

    /// Adds the result of a session from its recording, which may come from any source. Returns
    /// `false` if the store already holds the session, which then stays unchanged.
    ///
    /// # Errors
    /// As [`Store::add_session`]; also when the session belongs to another trainee, or its id or
    /// texts are invalid.
    pub fn add_recorded(
        &mut self,
        name: &str,
        session: &SessionRecord,
    ) -> Result<bool, StoreError> {
        let name = check_name(name)?;
        check_id(&session.id)?;
        let file = session.file.as_deref().unwrap_or_default();
        for text in [&session.task, &session.difficulty, &session.outcome] {
            check_text(&session.id, text)?;
        }
        for text in [session.scene.as_str(), &session.program, file] {
            check_text(&session.id, text)?;
        }
        // A refused session must not add a trainee.
        let added = match self.owner(&session.id)? {
            Some(_) => false,
            None => self.insert("IGNORE", name, session)?,
        };
        match self.owner(&session.id)? {
            Some(owner) if owner.trim() == name => Ok(added),
            _ => Err(StoreError::Taken {
                session: session.id.clone(),
            }),
        }
    }

    /// Name of the trainee to whom a session belongs, if it is in the store.
    fn owner(&self, id: &str) -> Result<Option<String>, StoreError> {
        let found = self.connection.query_row(
            "SELECT name FROM trainee JOIN session ON session.trainee = trainee.id WHERE session.id = ?1",
            [id],
            |row| row.get(0),
        );
        found.optional().map_err(|error| self.refused(error))
    }

    /// Adds a session; returns true if it was added. `conflict` is SQLite's action when the store
    /// already holds the id.
    fn insert(
        &self,
        conflict: &str,
        name: &str,
        session: &SessionRecord,
    ) -> Result<bool, StoreError> {
        let trainee = self.trainee_or_new(name)?;
        // JSON has no NaN and no infinity.
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
        let added = self
            .connection
            .execute(
                &format!(
                    "INSERT OR {conflict} INTO session (id, trainee, began_unix_s, task, difficulty, outcome, \
                     score, alarms, metrics_version, metrics, scene, program, file) \
                     VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)"
                ),
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
        if added > 0 && session.hand == Hand::Scripted {
            let mark = "INSERT OR IGNORE INTO scripted (session) VALUES (?1)";
            let marked = self.connection.execute(mark, [&session.id]);
            marked.map_err(|error| self.refused(error))?;
        }
        Ok(added > 0)
    }

    pub(crate) fn trainee_or_new(&self, name: &str) -> Result<i64, StoreError> {
        let name = check_name(name)?;
        self.connection
            .execute("INSERT OR IGNORE INTO trainee (name) VALUES (?1)", [name])
            .map_err(|error| self.refused(error))?;
        self.trainee(name)
    }

    pub(crate) fn trainee(&self, name: &str) -> Result<i64, StoreError> {
        // An earlier version may have stored a name with spaces around it.
        let found = self
            .connection
            .query_row(
                "SELECT id FROM trainee WHERE name IN (?1, ?2) ORDER BY name = ?1 DESC",
                [name, name.trim()],
                |row| row.get(0),
            )
            .optional();
        found
            .map_err(|error| self.refused(error))?
            .ok_or_else(|| StoreError::NoTrainee(name.escape_debug().to_string()))
    }

    /// All trainees, sorted by name.
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

    /// Sessions of a trainee, oldest first; of one task only, if `task` is given.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn sessions(
        &self,
        name: &str,
        task: Option<&str>,
    ) -> Result<Vec<SessionRecord>, StoreError> {
        let trainee = self.trainee(name)?;
        self.rows(
            "SELECT id, began_unix_s, task, difficulty, outcome, score, alarms, metrics_version, metrics, scene, \
             program, file, id IN (SELECT session FROM scripted) FROM session WHERE trainee = ?1 AND (?2 IS NULL OR task = ?2) \
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

    /// Deletes a trainee with all sessions, sheets and answers, and overwrites the data. Returns
    /// the paths of the trainee's recordings; the recordings themselves stay.
    ///
    /// # Errors
    /// When no trainee has this name, the file cannot be written, or the deleted data would stay in
    /// a log file.
    pub fn forget(&mut self, name: &str) -> Result<Vec<String>, StoreError> {
        let files = self.sessions(name, None)?;
        let trainee = self.trainee(name)?;
        let mode = one_file(&self.connection).map_err(|error| self.refused(error));
        match mode {
            Ok(mode) if mode == "delete" => {}
            Err(error) if !matches!(error, StoreError::Busy { .. }) => return Err(error),
            held => {
                return Err(StoreError::Log {
                    path: self.path().to_owned(),
                    mode: held.unwrap_or_else(|_| "wal".to_owned()),
                });
            }
        }
        self.connection
            .execute("DELETE FROM trainee WHERE id = ?1", [trainee])
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
        hand: match row.get(12)? {
            true => Hand::Scripted,
            false => Hand::Person,
        },
    })
}
