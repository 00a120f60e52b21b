//! Merging the stores of several stations: everything in one is added to another.
//!
//! Sessions need no coordinator, because no two stations make the same UUID of version 7. A chosen
//! name identifies a trainee: equal names at two stations are one person. Existing entries stay
//! unchanged, with three exceptions: the newer answer to a questionnaire replaces the older one; of
//! two statements of a cohort or consent, the later counts ([`Told`]); a session without a site
//! gets the site of the other store. A second merge of the same store changes nothing.
//!
//! Trainees who were forgotten in either store stay out ([`crate::Store::forget`]). The marks of
//! the other store are added to those here.

use std::collections::{BTreeMap, BTreeSet};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use rusqlite::types::Value;
use rusqlite::{OptionalExtension as _, Transaction, params, params_from_iter};

use crate::error::StoreError;
use crate::file::refused;
use crate::forgotten::Forgotten;
use crate::names::{are_alike, check_name, shown};
use crate::open::Store;
use crate::sessions::{COLUMNS, SITE, check_id, check_text};
use crate::told::{TOLD, Told, told_of};

/// Example query of a training centre, for any program that reads SQLite: number of sessions of
/// every trainee and task, and the means of the score and of one metric in the JSON.
pub const EXAMPLE_SQL: &str = "\
SELECT trainee.name, session.task, count(*) AS sessions, avg(session.score) AS score,
       avg(json_extract(session.metrics, '$.time_s')) AS time_s
FROM session JOIN trainee ON trainee.id = session.trainee
WHERE session.outcome IN ('passed', 'failed') AND session.hand = 'person'
GROUP BY trainee.name, session.task ORDER BY trainee.name, session.task;";

/// Counts of a merge.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize)]
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
    /// New points on scoring sheets.
    pub points: u64,
    /// Sessions that were left out because their trainee was forgotten.
    pub left_out_sessions: u64,
    /// Answers that were left out because their trainee was forgotten.
    pub left_out_answers: u64,
    /// Trainees that were left out because they were forgotten.
    pub left_out_trainees: u64,
    /// Trainees who are here and were forgotten there, and not here since.
    pub forgotten_there: Vec<String>,
    /// Known sessions that belong to another trainee there. They stay as they are here, and their
    /// scoring sheets from there are left out.
    pub other_owners: Vec<OtherOwner>,
    /// New names that are easily confused with one that is here: each pair once.
    pub alike: Vec<[String; 2]>,
}

/// A session that belongs to another trainee there than here.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct OtherOwner {
    /// Id of the session.
    pub session: String,
    /// Name of its trainee here, who keeps it.
    pub here: String,
    /// Name of its trainee there.
    pub there: String,
}

/// A merge at work.
struct Merge<'a> {
    theirs: &'a Store,
    ours: &'a Transaction<'a>,
    /// Path of our store.
    own: &'a Path,
    /// Marks of both stores.
    forgotten: Forgotten,
    /// Time at which each of their trainees was forgotten, by the name there. Those who were never
    /// forgotten are absent.
    when: BTreeMap<String, i64>,
    merged: Merged,
}

impl Store {
    /// Refuses a merge of `other` into the store at `into` that cannot begin. Makes and changes
    /// nothing; `into` may be missing.
    ///
    /// # Errors
    /// When both are one file, or `other` is not a store that can be read.
    pub fn can_merge(into: &Path, other: &Path) -> Result<(), StoreError> {
        check_not_same(into, other)?;
        Self::read(other).map(drop)
    }

    /// Adds everything that `other` holds, or nothing if any entry is invalid. `other` is only
    /// read. Leaves out trainees who were forgotten.
    ///
    /// # Errors
    /// When `other` is this store, is not a store, has a newer version, is damaged, or holds an
    /// invalid entry; when this store cannot be written.
    pub fn merge(&mut self, other: &Path) -> Result<Merged, StoreError> {
        check_not_same(self.path(), other)?;
        let theirs = Self::read(other)?;
        // Read one snapshot, because another program may go on writing to `other`.
        let still = theirs.connection.execute_batch("BEGIN");
        still.map_err(|error| refused(other, error))?;
        let own = self.path().to_owned();
        let into = |error| refused(&own, error);
        let before: BTreeSet<String> = self.trainees()?.into_iter().map(|it| it.name).collect();
        let ours = self.change()?;
        let marks = Forgotten::read(&theirs.connection).map_err(|error| refused(other, error))?;
        let old = Forgotten::read(&ours).map_err(into)?;
        let is_lost = |name: &&String| marks.when(name) > old.when(name);
        let forgotten_there = before.iter().filter(is_lost).cloned().collect();
        marks.add_to(&ours).map_err(into)?;
        let mut merge = Merge {
            theirs: &theirs,
            ours: &ours,
            own: &own,
            forgotten: Forgotten::read(&ours).map_err(into)?,
            when: BTreeMap::new(),
            merged: Merged::default(),
        };
        merge.trainees()?;
        merge.sessions()?;
        merge.answers()?;
        merge.ratings()?;
        merge.unwanted(&before)?;
        let mut merged = merge.merged;
        ours.commit().map_err(into)?;
        merged.forgotten_there = forgotten_there;
        let after = self.trainees()?.into_iter().map(|it| it.name);
        let new: Vec<String> = after.filter(|it| !before.contains(it)).collect();
        merged.trainees = new.len() as u64;
        for name in new {
            let alike = before.iter().find(|it| are_alike(it, &name)).cloned();
            merged.alike.extend(alike.map(|it| [it, name]));
        }
        Ok(merged)
    }
}

impl Merge<'_> {
    fn refused(&self, error: rusqlite::Error) -> StoreError {
        refused(self.own, error)
    }

    /// Adds all trainees. [`Self::unwanted`] removes some of them at the end.
    fn trainees(&mut self) -> Result<(), StoreError> {
        let query = format!("SELECT name, {TOLD} FROM trainee ORDER BY name");
        let read = |row: &rusqlite::Row<'_>| Ok((row.get("name")?, told_of(row)?));
        let theirs: Vec<(String, Told)> = self.theirs.rows(&query, [], read)?;
        let ours = format!("SELECT {TOLD} FROM trainee WHERE name = ?1");
        for (as_there, mut told) in theirs {
            let name = check_name(&as_there)?;
            let when = self.forgotten.when(&name);
            self.when.extend(when.map(|at| (as_there, at)));
            let add = "INSERT OR IGNORE INTO trainee (name) VALUES (?1)";
            let added = self.ours.execute(add, [&name]);
            added.map_err(|error| self.refused(error))?;
            if let Some(at) = when {
                told = told.after(at);
            }
            check_text(&name, &told.cohort)?;
            let known = self.ours.query_row(&ours, [&name], told_of);
            let joined = known.map_err(|error| self.refused(error))?.joined(&told);
            let change = "UPDATE trainee SET cohort = ?2, cohort_unix_s = ?3, consent = ?4, consent_unix_s = ?5 \
                          WHERE name = ?1";
            let consent = joined.consent.name();
            let values = params![
                name,
                joined.cohort,
                joined.cohort_unix_s,
                consent,
                joined.consent_unix_s
            ];
            let changed = self.ours.execute(change, values);
            changed.map_err(|error| self.refused(error))?;
        }
        Ok(())
    }

    fn sessions(&mut self) -> Result<(), StoreError> {
        let columns = COLUMNS.map(|it| format!("session.{it}"));
        // Sessions that were kept before their store had a site are of that site, too.
        let their_columns = columns.join(", ").replace("session.site", SITE);
        let query = |columns: &str, order: &str| {
            format!(
                "SELECT {columns}, trainee.name FROM session JOIN trainee ON trainee.id = session.trainee {order}"
            )
        };
        let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<Vec<Value>> {
            (0..=COLUMNS.len()).map(|it| row.get(it)).collect()
        };
        let theirs = query(&their_columns, "ORDER BY began_unix_s, session.id");
        let known = query(&columns.join(", "), "WHERE session.id = ?1");
        let slots: Vec<String> = (1..=COLUMNS.len()).map(|it| format!("?{it}")).collect();
        let add = format!(
            "INSERT INTO session ({}, trainee) SELECT {}, id FROM trainee WHERE name = ?{}",
            COLUMNS.join(", "),
            slots.join(", "),
            COLUMNS.len() + 1
        );
        for mut session in self.theirs.rows(&theirs, [], row)? {
            let (id, began_unix_s, name) = check_session(&mut session)?;
            if self.forgotten.has(&name, &id, began_unix_s) {
                self.merged.left_out_sessions += 1;
                continue;
            }
            let found = self.ours.query_row(&known, [&id], row).optional();
            if let Some(found) = found.map_err(|error| self.refused(error))? {
                self.merged.known += 1;
                self.merged.differing += u64::from(!are_same(&found, &session));
                if let Some(site) = value_at(&session, "site") {
                    let fill = "UPDATE session SET site = ?2 WHERE id = ?1 AND site = ''";
                    let filled = self.ours.execute(fill, params![id, site]);
                    filled.map_err(|error| self.refused(error))?;
                }
                if let Some(Value::Text(here)) = found.last()
                    && *here != name
                {
                    self.merged.other_owners.push(OtherOwner {
                        session: id,
                        here: here.clone(),
                        there: name,
                    });
                }
                continue;
            }
            let added = self.ours.execute(&add, params_from_iter(&session));
            added.map_err(|error| self.refused(error))?;
            self.merged.sessions += 1;
        }
        Ok(())
    }

    fn answers(&mut self) -> Result<(), StoreError> {
        let query = "SELECT name, questionnaire, item, value, at_unix_s FROM answer \
                     JOIN trainee ON trainee.id = answer.trainee";
        type Answer = (String, String, String, i64, i64);
        let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<Answer> {
            Ok((
                row.get(0)?,
                row.get(1)?,
                row.get(2)?,
                row.get(3)?,
                row.get(4)?,
            ))
        };
        for (name, questionnaire, item, value, at) in self.theirs.rows(query, [], row)? {
            if self.when.get(&name).is_some_and(|when| at <= *when) {
                self.merged.left_out_answers += 1;
                continue;
            }
            let changed = self.ours.execute(
                "INSERT INTO answer (trainee, questionnaire, item, value, at_unix_s) \
                 SELECT id, ?2, ?3, ?4, ?5 FROM trainee WHERE name = ?1 \
                 ON CONFLICT DO UPDATE SET value = excluded.value, at_unix_s = excluded.at_unix_s \
                 WHERE excluded.at_unix_s > answer.at_unix_s",
                params![check_name(&name)?, questionnaire, item, value, at],
            );
            self.merged.answers += changed.map_err(|error| self.refused(error))? as u64;
        }
        Ok(())
    }

    fn ratings(&mut self) -> Result<(), StoreError> {
        let query = "SELECT session, sheet, rater, blinded FROM rating ORDER BY rowid";
        let add = "INSERT OR IGNORE INTO rating (session, sheet, rater, blinded) \
                   SELECT ?1, ?2, ?3, ?4 WHERE EXISTS (SELECT 1 FROM session WHERE id = ?1)";
        self.copy::<4>(query, add)?;
        let query = "SELECT session, sheet, rater, item, value FROM point ORDER BY rowid";
        let add = "INSERT OR IGNORE INTO point (session, sheet, rater, item, value) \
                   SELECT ?1, ?2, ?3, ?4, ?5 WHERE EXISTS \
                   (SELECT 1 FROM rating WHERE session = ?1 AND sheet = ?2 AND rater = ?3)";
        self.merged.points += self.copy::<5>(query, add)?;
        Ok(())
    }

    /// Adds rows of `N` columns, of which the first is the session, and returns how many were new.
    /// Leaves out rows of sessions that belong to another trainee here.
    fn copy<const N: usize>(&self, query: &str, add: &str) -> Result<u64, StoreError> {
        let row = |row: &rusqlite::Row<'_>| -> rusqlite::Result<Vec<Value>> {
            (0..N).map(|it| row.get(it)).collect()
        };
        let mut new = 0;
        let others = self.merged.other_owners.iter();
        let others: BTreeSet<&str> = others.map(|it| it.session.as_str()).collect();
        for values in self.theirs.rows(query, [], row)? {
            if matches!(values.first(), Some(Value::Text(id)) if others.contains(id.as_str())) {
                continue;
            }
            for text in texts(&values) {
                check_text("of a sheet", text)?;
            }
            let added = self.ours.execute(add, params_from_iter(&values));
            new += added.map_err(|error| self.refused(error))? as u64;
        }
        Ok(new)
    }

    /// Removes new trainees who were forgotten and have neither sessions nor answers.
    fn unwanted(&mut self, before: &BTreeSet<String>) -> Result<(), StoreError> {
        for name in self.when.keys() {
            let name = check_name(name)?;
            if before.contains(&name) {
                continue;
            }
            let remove = "DELETE FROM trainee WHERE name = ?1 \
                          AND id NOT IN (SELECT trainee FROM session UNION SELECT trainee FROM answer)";
            let removed = self.ours.execute(remove, [name]);
            self.merged.left_out_trainees += removed.map_err(|error| self.refused(error))? as u64;
        }
        Ok(())
    }
}

/// Refuses two paths of one file. A link counts as its file.
fn check_not_same(into: &Path, other: &Path) -> Result<(), StoreError> {
    let file = |path: &Path| {
        let found = std::fs::metadata(path).ok();
        found.map(|it| (it.dev(), it.ino()))
    };
    match (file(into), file(other)) {
        (Some(one), Some(two)) if one == two => Err(StoreError::SameFile {
            into: into.to_owned(),
            other: other.to_owned(),
        }),
        _ => Ok(()),
    }
}

/// True if two sessions are equal. The site does not count, because a store fills it in when it
/// gets a site later.
fn are_same(one: &[Value], two: &[Value]) -> bool {
    let site = COLUMNS.iter().position(|it| *it == "site");
    let pairs = one.iter().zip(two).enumerate();
    one.len() == two.len()
        && pairs
            .into_iter()
            .all(|(at, (a, b))| Some(at) == site || a == b)
}

/// Value of a session in this column.
fn value_at<'a>(session: &'a [Value], column: &str) -> Option<&'a Value> {
    let at = COLUMNS.iter().position(|it| *it == column);
    at.and_then(|it| session.get(it))
}

fn texts(values: &[Value]) -> impl Iterator<Item = &str> {
    values.iter().filter_map(|it| match it {
        Value::Text(text) => Some(text.as_str()),
        _ => None,
    })
}

/// Checks a session that another program may have written: a value for each of [`COLUMNS`], and the
/// trainee's name, which is brought to its form. Returns id, start and name.
fn check_session(session: &mut [Value]) -> Result<(String, i64, String), StoreError> {
    let wrong = || StoreError::Value {
        what: "a session".to_owned(),
        value: "a row of another form".to_owned(),
        allowed: "the columns of its table".to_owned(),
    };
    let value = |column| value_at(session, column).ok_or_else(wrong);
    let Value::Text(id) = value("id")?.clone() else {
        return Err(wrong());
    };
    let (Value::Integer(began_unix_s), Value::Text(metrics)) =
        (value("began_unix_s")?, value("metrics")?)
    else {
        return Err(wrong());
    };
    check_id(&id)?;
    let parsed = serde_json::from_str::<BTreeMap<String, f64>>(metrics);
    parsed.map(drop).map_err(|_| StoreError::Value {
        what: format!("the metrics of session {id}"),
        value: format!("'{}'", shown(metrics)),
        allowed: "a JSON object of numbers".to_owned(),
    })?;
    for text in texts(session).filter(|text| text != metrics) {
        check_text(&id, text)?;
    }
    let began_unix_s = *began_unix_s;
    let Some(Value::Text(name)) = session.last_mut() else {
        return Err(wrong());
    };
    *name = check_name(name)?;
    let name = name.clone();
    Ok((id, began_unix_s, name))
}
