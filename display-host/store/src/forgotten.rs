//! Forgetting a trainee, and marks that keep the trainee forgotten when another store is merged.
//!
//! Another store may hold the forgotten name and sessions, so each is remembered by a hash, from
//! which it cannot be read. Two stores need no common secret: the mark of a name contains the
//! random key of its hash. A session's id has 74 random bits and needs no key.
//!
//! The mark of a name gives the time of the forgetting. Sessions that began by then stay out. A
//! person who comes back by choice works a new session, which counts.
//!
//! Whoever can read the file can test whether a guessed name was forgotten. A name has too few
//! letters to prevent that.

use std::collections::BTreeSet;

use rusqlite::{Connection, params};

use crate::error::StoreError;
use crate::file::one_file;
use crate::names::check_name;
use crate::open::{Store, new_id};
use crate::withdrawal::{person_id, withdraw};

/// Context of a key, as BLAKE3 wants it: it separates these hashes from all others.
const OF_NAME: &str = "Calot 2026-11-28 mark of a forgotten name";
const OF_SESSION: &str = "Calot 2026-11-28 mark of a forgotten session";

/// Marks of a store.
#[derive(Debug, Default)]
pub(crate) struct Forgotten {
    names: Vec<NameMark>,
    sessions: BTreeSet<Vec<u8>>,
}

#[derive(Debug)]
struct NameMark {
    mark: Vec<u8>,
    salt: Vec<u8>,
    /// Time after which sessions count again, s since 1970.
    at_unix_s: i64,
}

fn mark_of_name(name: &str, salt: &[u8]) -> Vec<u8> {
    let key = blake3::derive_key(OF_NAME, salt);
    blake3::keyed_hash(&key, name.as_bytes())
        .as_bytes()
        .to_vec()
}

fn mark_of_session(id: &str) -> Vec<u8> {
    blake3::derive_key(OF_SESSION, id.as_bytes()).to_vec()
}

impl Forgotten {
    pub(crate) fn read(from: &Connection) -> rusqlite::Result<Self> {
        let mut names = from.prepare("SELECT mark, salt, at_unix_s FROM forgotten_trainee")?;
        let names = names.query_map([], |row| {
            Ok(NameMark {
                mark: row.get(0)?,
                salt: row.get(1)?,
                at_unix_s: row.get(2)?,
            })
        })?;
        let mut sessions = from.prepare("SELECT mark FROM forgotten_session")?;
        let sessions = sessions.query_map([], |row| row.get(0))?;
        Ok(Self {
            names: names.collect::<rusqlite::Result<_>>()?,
            sessions: sessions.collect::<rusqlite::Result<_>>()?,
        })
    }

    /// Time at which the person of this name was forgotten last, s since 1970.
    pub(crate) fn when(&self, name: &str) -> Option<i64> {
        let of_name = self.of_name(name);
        of_name.map(|it| it.at_unix_s).max()
    }

    fn of_name(&self, name: &str) -> impl Iterator<Item = &NameMark> {
        let is_of = move |it: &&NameMark| mark_of_name(name, &it.salt) == it.mark;
        self.names.iter().filter(is_of)
    }

    /// True if this session is of somebody who was forgotten since it began.
    pub(crate) fn has(&self, name: &str, session: &str, began_unix_s: i64) -> bool {
        self.sessions.contains(&mark_of_session(session))
            || self.when(name).is_some_and(|at| began_unix_s <= at)
    }

    /// Adds these marks to a store.
    pub(crate) fn add_to(&self, store: &Connection) -> rusqlite::Result<()> {
        let add =
            "INSERT OR IGNORE INTO forgotten_trainee (mark, salt, at_unix_s) VALUES (?1, ?2, ?3)";
        for it in &self.names {
            store.execute(add, params![it.mark, it.salt, it.at_unix_s])?;
        }
        let add = "INSERT OR IGNORE INTO forgotten_session (mark) VALUES (?1)";
        for mark in &self.sessions {
            store.execute(add, [mark])?;
        }
        Ok(())
    }
}

/// Remains of a trainee who was forgotten.
#[derive(Debug)]
pub struct Gone {
    /// Paths of the trainee's recordings, which stay.
    pub files: Vec<String>,
    /// Reason for which the file kept its size. Its deleted data are overwritten all the same.
    pub loose: Option<StoreError>,
}

impl Store {
    /// Deletes a trainee with all sessions, sheets and answers, and overwrites the data. Leaves
    /// marks by which [`Store::merge`] keeps out sessions that began until `at_unix_s`, and a
    /// withdrawal for each centre ([`Store::withdrawals`]). Success means that the trainee is gone,
    /// even if the file cannot be made smaller.
    ///
    /// # Errors
    /// When no trainee has this name, the file cannot be written, or the deleted data would stay in
    /// a log file.
    pub fn forget(&mut self, name: &str, at_unix_s: i64) -> Result<Gone, StoreError> {
        let sessions = self.sessions(name, None)?;
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
        let name = check_name(name).unwrap_or_else(|_| name.trim().to_owned());
        let path = self.path().to_owned();
        let change = self.change()?;
        let forget = || -> rusqlite::Result<()> {
            // A person who is forgotten again needs one mark, the newest.
            for old in Forgotten::read(&change)?.of_name(&name) {
                change.execute("DELETE FROM forgotten_trainee WHERE mark = ?1", [&old.mark])?;
            }
            let salt = new_id().into_bytes();
            let marks = Forgotten {
                names: vec![NameMark {
                    mark: mark_of_name(&name, &salt),
                    salt,
                    at_unix_s,
                }],
                sessions: sessions.iter().map(|it| mark_of_session(&it.id)).collect(),
            };
            marks.add_to(&change)?;
            let ids: Vec<String> = sessions.iter().map(|it| it.id.clone()).collect();
            withdraw(&change, &person_id(&name), at_unix_s, &ids)?;
            change.execute("DELETE FROM trainee WHERE id = ?1", [trainee])?;
            Ok(())
        };
        forget().map_err(|error| crate::file::refused(&path, error))?;
        change.commit().map_err(|error| self.refused(error))?;
        let compacted = self.connection.execute_batch("VACUUM");
        Ok(Gone {
            files: sessions.into_iter().filter_map(|it| it.file).collect(),
            loose: compacted.err().map(|error| self.refused(error)),
        })
    }
}
