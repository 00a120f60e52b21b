//! Export of one trainee's data, or of everybody's, as JSON and CSV.

use core::fmt::Write as _;
use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::error::StoreError;
use crate::open::Store;
use crate::sessions::SessionRecord;

/// Columns of a session. The columns of its metrics follow.
const COLUMNS: [&str; 11] = [
    "trainee",
    "session",
    "began_unix_s",
    "task",
    "difficulty",
    "outcome",
    "score",
    "alarms",
    "metrics_version",
    "scene",
    "hand",
];

impl Store {
    /// Everything the store holds about one trainee, or about everybody: names, sessions with their
    /// assessment sheets, answers.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_json(&self, name: Option<&str>) -> Result<Value, StoreError> {
        let mut people = Vec::new();
        for name in self.names(name)? {
            let mut sessions = Vec::new();
            for session in self.sessions(&name, None)? {
                let sheet = self.sheet(&session.id)?;
                let mut value = serde_json::to_value(&session).unwrap_or_default();
                if let Some(object) = value.as_object_mut() {
                    let sheet = sheet.into_iter().map(|(item, value)| (item, value.into()));
                    object.insert("sheet".to_owned(), Value::Object(sheet.collect()));
                }
                sessions.push(value);
            }
            let answers = self.rows(
                "SELECT questionnaire, item, value, at_unix_s FROM answer WHERE trainee = ?1 \
                 ORDER BY questionnaire, item",
                [self.trainee(&name)?],
                |row| {
                    Ok(json!({
                        "questionnaire": row.get::<_, String>(0)?,
                        "item": row.get::<_, String>(1)?,
                        "value": row.get::<_, i64>(2)?,
                        "at_unix_s": row.get::<_, i64>(3)?,
                    }))
                },
            )?;
            people.push(json!({ "name": name, "sessions": sessions, "answers": answers }));
        }
        Ok(json!({ "trainees": people }))
    }

    /// Sessions of one trainee, or of everybody, one per row; each metric is a column. Every line
    /// ends with a line feed alone, because strict readers refuse mixed line ends.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_csv(&self, name: Option<&str>) -> Result<String, StoreError> {
        let mut rows: Vec<(String, SessionRecord)> = Vec::new();
        for name in self.names(name)? {
            let sessions = self.sessions(&name, None)?;
            rows.extend(sessions.into_iter().map(|it| (name.clone(), it)));
        }
        let metrics: BTreeSet<&String> =
            rows.iter().flat_map(|(_, it)| it.metrics.keys()).collect();
        let mut text = COLUMNS.join(",");
        for metric in &metrics {
            // A metric with the name of a session column gets a prefix.
            let taken = COLUMNS.contains(&metric.as_str());
            let before = if taken { "metric_" } else { "" };
            let _ = write!(text, ",{}", field(&format!("{before}{metric}")));
        }
        for (name, it) in &rows {
            let _ = write!(
                text,
                "\n{},{},{},{},{},{},{},{},{},{},{}",
                field(name),
                field(&it.id),
                it.began_unix_s,
                field(&it.task),
                field(&it.difficulty),
                field(&it.outcome),
                it.score,
                it.alarms,
                it.metrics_version,
                field(&it.scene),
                it.hand.name()
            );
            for metric in &metrics {
                let value = it.metrics.get(*metric);
                let _ = write!(text, ",{}", value.map(f64::to_string).unwrap_or_default());
            }
        }
        Ok(text + "\n")
    }

    fn names(&self, name: Option<&str>) -> Result<Vec<String>, StoreError> {
        match name {
            Some(name) => self.trainee(name).map(|_| vec![name.to_owned()]),
            None => Ok(self.trainees()?.into_iter().map(|it| it.name).collect()),
        }
    }
}

/// Escapes a CSV field (RFC 4180). An apostrophe goes before a field that a spreadsheet would read
/// as a formula.
fn field(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let text = if formula {
        format!("'{text}")
    } else {
        text.to_owned()
    };
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}
