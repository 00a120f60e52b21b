//! Export as CSV. The columns of a table are always the same, in the same order. Quotes follow RFC
//! 4180. Lines end with a line feed alone, so that no file mixes two kinds of line ends.

use std::collections::BTreeMap;

use crate::error::StoreError;
use crate::open::Store;
use crate::sessions::SessionRecord;
use crate::sheet::{GOALS, Rating};
use crate::trainees::Trainee;

/// Columns of a session before those of its metrics.
const COLUMNS: [&str; 22] = [
    "trainee",
    "cohort",
    "consent",
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
    "realtime",
    "missed_ticks",
    "device",
    "driver",
    "site",
    "program",
    "file",
    "goals",
    "goals_raters",
];

impl Store {
    /// Sessions of one trainee, or of everybody, one per row. `metrics` are the names of the
    /// metrics that are columns, in their order; further metrics are in the last column as JSON.
    /// Points of GOALS are means over the raters.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_csv(&self, name: Option<&str>, metrics: &[&str]) -> Result<String, StoreError> {
        let items = GOALS.map(|(short, _)| format!("goals_{short}"));
        // A metric with the name of another column gets a prefix.
        let metric = |it: &&str| match COLUMNS.contains(it) || items.iter().any(|item| item == it) {
            true => format!("metric_{it}"),
            false => (*it).to_owned(),
        };
        let columns = COLUMNS.iter().map(|it| (*it).to_owned());
        let columns = columns
            .chain(items.iter().cloned())
            .chain(metrics.iter().map(metric));
        let mut table = Table::new(columns.chain(["other_metrics".to_owned()]));
        for person in self.people(name)? {
            let ratings = self.ratings_of(&person.name)?;
            for session in self.sessions(&person.name, None)? {
                let ratings = ratings.iter().filter(|it| it.session == session.id);
                table.row(session_row(&person, &session, ratings, metrics));
            }
        }
        Ok(table.0)
    }

    /// Answers to questionnaires of one trainee, or of everybody, one per row.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_answers_csv(&self, name: Option<&str>) -> Result<String, StoreError> {
        let columns = [
            "trainee",
            "cohort",
            "consent",
            "questionnaire",
            "item",
            "value",
            "at_unix_s",
        ];
        let mut table = Table::new(columns.map(str::to_owned));
        for person in self.people(name)? {
            for it in self.answers_of(&person.name)? {
                table.row([
                    person.name.clone(),
                    person.cohort.clone(),
                    person.consent.name().to_owned(),
                    it.questionnaire,
                    it.item,
                    it.value.to_string(),
                    it.at_unix_s.to_string(),
                ]);
            }
        }
        Ok(table.0)
    }

    /// Points on scoring sheets of one trainee's sessions, or of everybody's, one per row.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_sheets_csv(&self, name: Option<&str>) -> Result<String, StoreError> {
        let columns = [
            "trainee", "cohort", "consent", "session", "sheet", "rater", "blinded", "item", "value",
        ];
        let mut table = Table::new(columns.map(str::to_owned));
        for person in self.people(name)? {
            for it in self.ratings_of(&person.name)? {
                for (item, value) in &it.points {
                    table.row([
                        person.name.clone(),
                        person.cohort.clone(),
                        person.consent.name().to_owned(),
                        it.session.clone(),
                        it.sheet.clone(),
                        it.rater.clone(),
                        u8::from(it.blinded).to_string(),
                        item.clone(),
                        value.to_string(),
                    ]);
                }
            }
        }
        Ok(table.0)
    }

    /// One trainee, or everybody.
    pub(crate) fn people(&self, name: Option<&str>) -> Result<Vec<Trainee>, StoreError> {
        let mut people = self.trainees()?;
        if let Some(name) = name {
            let id = self.trainee(name)?;
            let query = "SELECT name FROM trainee WHERE id = ?1";
            let found: Vec<String> = self.rows(query, [id], |row| row.get(0))?;
            people.retain(|it| found.contains(&it.name));
        }
        Ok(people)
    }
}

fn session_row<'a>(
    person: &Trainee,
    it: &SessionRecord,
    ratings: impl Iterator<Item = &'a Rating>,
    metrics: &[&str],
) -> Vec<String> {
    let goals: Vec<&Rating> = ratings.filter(|it| it.sheet == "goals").collect();
    let mean = |points: &dyn Fn(&Rating) -> Option<f64>| {
        let points: Vec<f64> = goals.iter().filter_map(|it| points(it)).collect();
        let sum: f64 = points.iter().sum();
        let mean = (!points.is_empty()).then(|| sum / points.len() as f64);
        text(mean)
    };
    let made = &it.circumstances;
    let mut row = vec![
        person.name.clone(),
        person.cohort.clone(),
        person.consent.name().to_owned(),
        it.id.clone(),
        it.began_unix_s.to_string(),
        it.task.clone(),
        it.difficulty.clone(),
        it.outcome.clone(),
        it.score.to_string(),
        it.alarms.to_string(),
        it.metrics_version.to_string(),
        it.scene.clone(),
        it.hand.name().to_owned(),
        text(made.realtime.map(u8::from)),
        text(made.missed_ticks),
        made.device.clone(),
        made.driver.clone(),
        made.site.clone(),
        it.program.clone(),
        it.file.clone().unwrap_or_default(),
        mean(&|it| Some(f64::from(it.sum()))),
        goals.len().to_string(),
    ];
    for (item, _) in GOALS {
        row.push(mean(&|it| it.points.get(item).copied().map(f64::from)));
    }
    for metric in metrics {
        row.push(text(it.metrics.get(*metric)));
    }
    let mut others: BTreeMap<&String, f64> = BTreeMap::new();
    let is_other = |(name, _): &(&String, &f64)| !metrics.contains(&name.as_str());
    others.extend(it.metrics.iter().filter(is_other).map(|(k, v)| (k, *v)));
    row.push(match others.is_empty() {
        true => String::new(),
        false => serde_json::to_string(&others).unwrap_or_default(),
    });
    row
}

fn text(value: Option<impl ToString>) -> String {
    value.map(|it| it.to_string()).unwrap_or_default()
}

/// Text of a table. Numbers have just enough digits to be read back exactly.
struct Table(String);

impl Table {
    fn new(columns: impl IntoIterator<Item = String>) -> Self {
        let mut table = Self(String::new());
        table.row(columns);
        table
    }

    fn row(&mut self, fields: impl IntoIterator<Item = String>) {
        let fields: Vec<String> = fields.into_iter().map(|it| csv_field(&it)).collect();
        self.0 += &fields.join(",");
        self.0.push('\n');
    }
}

/// Escapes a field of CSV: quoted if it holds a comma, a quotation mark or a line end. An
/// apostrophe goes before a field that a spreadsheet would read as a formula, but not before a
/// number.
#[must_use]
pub fn csv_field(text: &str) -> String {
    let is_number = text.parse::<f64>().is_ok();
    let formula = !is_number && text.starts_with(['=', '+', '-', '@', '\t', '\r']);
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
