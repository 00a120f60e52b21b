//! Withdrawals: people whom a centre has to forget as well. A withdrawal holds ids only. It waits
//! until the centre is reached and has forgotten the person, and is then deleted. A withdrawal for
//! centres that are named later stays.

use std::collections::BTreeSet;

use rusqlite::{Connection, OptionalExtension as _, params};
use uuid::Uuid;

use crate::error::StoreError;
use crate::names::{check_name, shown};
use crate::open::Store;

/// Namespace of the ids of people, for UUIDs of version 5.
const PEOPLE: Uuid = Uuid::from_u128(0x6b0a_5d5e_2f0f_4c58_9d1b_7a1f_0e6c_41d3);

/// Address under which withdrawals wait for centres that are not known yet.
const LATER: &str = "";

/// Id of a person at every centre: the same at each station, because equal names are one person. No
/// name can be read from it, but a guess can be tested.
#[must_use]
pub fn person_id(name: &str) -> String {
    let name = check_name(name).unwrap_or_else(|_| name.trim().to_owned());
    Uuid::new_v5(&PEOPLE, name.as_bytes()).to_string()
}

/// A person whom a centre has to forget.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Withdrawal {
    /// Id of the person at centres.
    pub person: String,
    /// Time of the forgetting, s since 1970. Sessions that began later stay.
    pub at_unix_s: i64,
    /// Sessions that may have been sent.
    pub sessions: Vec<String>,
}

impl Store {
    /// Addresses of the centres that have to forget somebody.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn owed(&self) -> Result<Vec<String>, StoreError> {
        let query = "SELECT address FROM destination \
                     WHERE id IN (SELECT destination FROM withdrawal) AND address <> ?1 ORDER BY address";
        self.rows(query, [LATER], |row| row.get(0))
    }

    /// Asks a centre to forget a session that arrived after its person was forgotten here.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn withdraw(
        &mut self,
        destination: i64,
        person: &str,
        session: &str,
        began_unix_s: i64,
    ) -> Result<(), StoreError> {
        let path = self.path().to_owned();
        let change = self.change()?;
        let sessions = BTreeSet::from([session.to_owned()]);
        add(&change, destination, person, began_unix_s, sessions)
            .and_then(|()| change.commit())
            .map_err(|error| crate::file::refused(&path, error))
    }

    /// People whom a centre has to forget.
    ///
    /// # Errors
    /// When the file cannot be read, or another program wrote a row that makes no sense.
    pub fn withdrawals(&self, destination: i64) -> Result<Vec<Withdrawal>, StoreError> {
        let query = "SELECT person, at_unix_s, sessions FROM withdrawal WHERE destination = ?1 ORDER BY 2, 1";
        let rows = self.rows(query, [destination], |row| {
            Ok((row.get(0)?, row.get(1)?, row.get(2)?))
        })?;
        let read = |(person, at_unix_s, sessions): (String, i64, String)| {
            let is_id = |it: &String| Uuid::parse_str(it).is_ok();
            let ids: Option<Vec<String>> = serde_json::from_str(&sessions).ok();
            match ids.filter(|ids| ids.iter().all(is_id) && is_id(&person)) {
                Some(sessions) => Ok(Withdrawal {
                    person,
                    at_unix_s,
                    sessions,
                }),
                None => Err(StoreError::Damaged {
                    path: self.path().to_owned(),
                    problem: format!("a withdrawal of '{}' makes no sense", shown(&person)),
                }),
            }
        };
        rows.into_iter().map(read).collect()
    }

    /// Notes that a centre has forgotten a person. If the person was forgotten here once more in
    /// the meantime, the new withdrawal stays.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn note_withdrawn(
        &mut self,
        destination: i64,
        done: &Withdrawal,
    ) -> Result<(), StoreError> {
        let sessions = serde_json::to_string(&done.sessions).unwrap_or_default();
        let remove = "DELETE FROM withdrawal \
                      WHERE destination = ?1 AND person = ?2 AND at_unix_s = ?3 AND sessions = ?4";
        let values = params![destination, done.person, done.at_unix_s, sessions];
        let removed = self.connection.execute(remove, values);
        removed.map(drop).map_err(|error| self.refused(error))
    }
}

/// Number of a centre. A new centre is added, with the withdrawals that wait for new centres.
pub(crate) fn number_of(change: &Connection, address: &str) -> rusqlite::Result<i64> {
    let find = "SELECT id FROM destination WHERE address = ?1";
    let known = change.query_row(find, [address], |row| row.get(0));
    if let Some(known) = known.optional()? {
        return Ok(known);
    }
    let add = "INSERT INTO destination (address) VALUES (?1)";
    change.execute(add, [address])?;
    let new = change.last_insert_rowid();
    let inherit = "INSERT INTO withdrawal (destination, person, at_unix_s, sessions) \
                   SELECT ?1, person, at_unix_s, sessions FROM withdrawal \
                   WHERE destination = (SELECT id FROM destination WHERE address = ?2)";
    change.execute(inherit, params![new, LATER])?;
    Ok(new)
}

/// Moves everything of a centre to another spelling of its address, if the first is known.
pub(crate) fn respell(change: &Connection, from: &str, to: &str) -> rusqlite::Result<()> {
    let find = "SELECT id FROM destination WHERE address = ?1";
    let old: Option<i64> = change
        .query_row(find, [from], |row| row.get(0))
        .optional()?;
    let Some(old) = old else { return Ok(()) };
    let new = number_of(change, to)?;
    let move_notes = "UPDATE OR IGNORE delivery SET destination = ?2 WHERE destination = ?1";
    change.execute(move_notes, [old, new])?;
    let find = "SELECT person, at_unix_s, sessions FROM withdrawal WHERE destination = ?1";
    let mut errands = change.prepare(find)?;
    let errands = errands.query_map([old], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?;
    let errands: Vec<(String, i64, String)> = errands.collect::<rusqlite::Result<_>>()?;
    for (person, at_unix_s, sessions) in errands {
        let sessions: BTreeSet<String> = serde_json::from_str(&sessions).unwrap_or_default();
        add(change, new, &person, at_unix_s, sessions)?;
    }
    let remove = "DELETE FROM destination WHERE id = ?1";
    change.execute(remove, [old]).map(drop)
}

/// Adds a withdrawal of this person for each centre. One more withdrawal is for centres that are
/// named later, because other stations may have sent them results. It names no session, because
/// this station sent them none.
pub(crate) fn withdraw(
    change: &Connection,
    person: &str,
    at_unix_s: i64,
    sessions: &[String],
) -> rusqlite::Result<()> {
    let later = number_of(change, LATER)?;
    let mut known = change.prepare("SELECT id FROM destination")?;
    let known: Vec<i64> = known
        .query_map([], |row| row.get(0))?
        .collect::<rusqlite::Result<_>>()?;
    for destination in known {
        let sent = match destination == later {
            true => BTreeSet::new(),
            false => sessions.iter().cloned().collect(),
        };
        add(change, destination, person, at_unix_s, sent)?;
    }
    Ok(())
}

/// Adds a withdrawal, or joins it with the one that waits.
fn add(
    change: &Connection,
    destination: i64,
    person: &str,
    at_unix_s: i64,
    mut sessions: BTreeSet<String>,
) -> rusqlite::Result<()> {
    let find = "SELECT sessions FROM withdrawal WHERE destination = ?1 AND person = ?2";
    let waiting = change.query_row(find, params![destination, person], |row| row.get(0));
    let waiting: Option<String> = waiting.optional()?;
    let ids: Vec<String> = waiting
        .and_then(|it| serde_json::from_str(&it).ok())
        .unwrap_or_default();
    sessions.extend(ids);
    let sessions = serde_json::to_string(&sessions).unwrap_or_default();
    let add = "INSERT INTO withdrawal (destination, person, at_unix_s, sessions) VALUES (?1, ?2, ?3, ?4) \
               ON CONFLICT DO UPDATE SET sessions = excluded.sessions, \
               at_unix_s = max(at_unix_s, excluded.at_unix_s)";
    let added = change.execute(add, params![destination, person, at_unix_s, sessions]);
    added.map(drop)
}
