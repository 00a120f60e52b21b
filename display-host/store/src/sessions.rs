//! The results of sessions.

use std::collections::BTreeMap;

use rusqlite::{OptionalExtension as _, Row, params};

use crate::error::StoreError;
use crate::forgotten::Forgotten;
use crate::names::{check_name, shown};
use crate::open::Store;

/// Hand that worked a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
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

/// Circumstances in which a session was worked, as its run's `summary.json` names them.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Circumstances {
    /// True if the controller had realtime privileges throughout; `None`: unknown.
    pub realtime: Option<bool>,
    /// Number of control periods that were skipped; `None`: unknown.
    pub missed_ticks: Option<i64>,
    /// Name that the haptic device gives itself; empty: none or unknown.
    pub device: String,
    /// Driver of the haptic device as in a station file, or `emulated`; empty: none or unknown.
    pub driver: String,
    /// Name of the site; empty: that of the store when the session is added.
    pub site: String,
}

/// Result of a session.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
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
    /// Hand that worked the session.
    pub hand: Hand,
    /// Circumstances of the run.
    #[serde(flatten)]
    pub circumstances: Circumstances,
}

/// Checks a session name. Only one spelling of a UUID is allowed; another spelling would make the
/// same session a different one.
pub(crate) fn check_id(id: &str) -> Result<(), StoreError> {
    match uuid::Uuid::parse_str(id).is_ok_and(|it| it.hyphenated().to_string() == id) {
        true => Ok(()),
        false => Err(StoreError::Value {
            what: "a session's name".to_owned(),
            value: format!("'{}'", shown(id)),
            allowed: "a UUID in lower case with hyphens".to_owned(),
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
            allowed: "text without control characters".to_owned(),
        }),
    }
}

/// Site of a session. A session that was stored before the store had a site gets the store's site.
pub(crate) const SITE: &str = "coalesce(nullif(session.site, ''), (SELECT value FROM setting WHERE setting.name = 'site'), '')";

/// Columns of a session that a query takes, without its trainee.
pub(crate) const COLUMNS: [&str; 18] = [
    "id",
    "began_unix_s",
    "task",
    "difficulty",
    "outcome",
    "score",
    "alarms",
    "metrics_version",
    "metrics",
    "scene",
    "program",
    "file",
    "hand",
    "realtime",
    "missed_ticks",
    "device",
    "driver",
    "site",
];

impl Store {
    /// Adds the result of a session, and the trainee if the name is new. Replaces a session of the
    /// same id.
    ///
    /// # Errors
    /// When the name is invalid, the session is of somebody who was forgotten since it began, or
    /// the file cannot be written.
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
        let made = &session.circumstances;
        for text in [&session.task, &session.difficulty, &session.outcome] {
            check_text(&session.id, text)?;
        }
        for text in [session.scene.as_str(), &session.program, file] {
            check_text(&session.id, text)?;
        }
        for text in [&made.device, &made.driver, &made.site] {
            check_text(&session.id, text)?;
        }
        // A refused session must not add a trainee.
        let added = match self.owner(&session.id)? {
            Some(_) => false,
            None => self.insert("IGNORE", &name, session)?,
        };
        match self.owner(&session.id)? {
            Some(owner) if check_name(&owner).is_ok_and(|it| it == name) => Ok(added),
            _ => Err(StoreError::Taken {
                session: session.id.clone(),
            }),
        }
    }

    /// Name of the trainee to whom a session belongs, if it is in the store.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn owner(&self, id: &str) -> Result<Option<String>, StoreError> {
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
        let forgotten = Forgotten::read(&self.connection).map_err(|it| self.refused(it))?;
        if forgotten.has(&check_name(name)?, &session.id, session.began_unix_s) {
            return Err(StoreError::Forgotten {
                session: session.id.clone(),
            });
        }
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
        let made = &session.circumstances;
        let site = match made.site.as_str() {
            "" => self.site()?,
            site => site.to_owned(),
        };
        let columns = COLUMNS.join(", ");
        let added = self
            .connection
            .execute(
                &format!(
                    "INSERT OR {conflict} INTO session ({columns}, trainee) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, \
                     ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19)"
                ),
                params![
                    session.id,
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
                    session.hand.name(),
                    made.realtime,
                    made.missed_ticks,
                    made.device,
                    made.driver,
                    site,
                    trainee,
                ],
            )
            .map_err(|error| self.refused(error))?;
        Ok(added > 0)
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
        let query = format!(
            "SELECT {} FROM session WHERE trainee = ?1 AND (?2 IS NULL OR task = ?2) ORDER BY began_unix_s, id",
            COLUMNS.join(", ")
        );
        self.rows(&query, params![trainee, task], session_of)
    }

    /// The session with this id, whoever worked it, if it is in the store.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn session(&self, id: &str) -> Result<Option<SessionRecord>, StoreError> {
        let columns = COLUMNS.join(", ");
        let query = format!("SELECT {columns} FROM session WHERE id = ?1");
        Ok(self.rows(&query, params![id], session_of)?.pop())
    }
}

pub(crate) fn session_of(row: &Row<'_>) -> rusqlite::Result<SessionRecord> {
    let metrics: String = row.get("metrics")?;
    let hand: String = row.get("hand")?;
    Ok(SessionRecord {
        id: row.get("id")?,
        began_unix_s: row.get("began_unix_s")?,
        task: row.get("task")?,
        difficulty: row.get("difficulty")?,
        outcome: row.get("outcome")?,
        score: row.get("score")?,
        alarms: row.get("alarms")?,
        metrics_version: row.get("metrics_version")?,
        metrics: serde_json::from_str(&metrics).unwrap_or_default(),
        scene: row.get("scene")?,
        program: row.get("program")?,
        file: row.get("file")?,
        hand: match hand == Hand::Scripted.name() {
            true => Hand::Scripted,
            false => Hand::Person,
        },
        circumstances: Circumstances {
            realtime: row.get("realtime")?,
            missed_ticks: row.get("missed_ticks")?,
            device: row.get("device")?,
            driver: row.get("driver")?,
            site: row.get("site")?,
        },
    })
}
