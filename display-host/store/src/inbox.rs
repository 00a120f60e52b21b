//! Takes results from stations into the store of a centre: each once, and none of a person who was
//! forgotten since.

use rusqlite::{OptionalExtension as _, params};

use crate::error::StoreError;
use crate::names::shown;
use crate::open::Store;
use crate::outbox::{Delivery, Outgoing};
use crate::sessions::SessionRecord;
use crate::told::{TOLD, told_of};
use crate::withdrawal::{Withdrawal, person_id};

impl Store {
    /// Takes a session of a station. A repetition changes nothing.
    ///
    /// # Errors
    /// When a value is invalid, or the file cannot be read or written.
    pub fn receive(&mut self, it: &Outgoing) -> Result<Delivery, StoreError> {
        if it.person != person_id(&it.name) {
            return Err(StoreError::Value {
                what: "the person of a session".to_owned(),
                value: format!("'{}'", shown(&it.person)),
                allowed: "the id that belongs to the name".to_owned(),
            });
        }
        let mark = "SELECT 1 FROM forgotten_person WHERE person = ?1 AND at_unix_s >= ?2";
        let values = params![it.person, it.session.began_unix_s];
        let mark = self.connection.query_row(mark, values, |_| Ok(()));
        let mark = mark.optional().map_err(|error| self.refused(error))?;
        if mark.is_some() {
            return Ok(Delivery::Forgotten);
        }
        // The path of a recording means nothing outside of its station.
        let session = SessionRecord {
            file: None,
            ..it.session.clone()
        };
        match self.add_recorded(&it.name, &session) {
            Ok(true) => {}
            Ok(false) if self.has_same(&it.name, &session)? => {}
            Ok(false) => return Ok(Delivery::Differs),
            Err(StoreError::Forgotten { .. }) => return Ok(Delivery::Forgotten),
            Err(StoreError::Taken { .. }) => return Ok(Delivery::Differs),
            Err(error) => return Err(error),
        }
        self.learn(it)?;
        Ok(Delivery::There)
    }

    /// True if this person has a session that says the same, whatever its site.
    fn has_same(&self, name: &str, session: &SessionRecord) -> Result<bool, StoreError> {
        let all = match self.sessions(name, None) {
            Err(StoreError::NoTrainee(_)) => return Ok(false),
            all => all?,
        };
        let found = all.into_iter().find(|it| it.id == session.id);
        Ok(found.is_some_and(|mut it| {
            it.circumstances
                .site
                .clone_from(&session.circumstances.site);
            it.file = None;
            it == *session
        }))
    }

    /// Takes the data that came with a session: cohort, consent, sheets, a site that was named
    /// later.
    fn learn(&mut self, it: &Outgoing) -> Result<(), StoreError> {
        let path = self.path().to_owned();
        let trainee = self.trainee(&it.name)?;
        let change = self.change()?;
        let learnt = || -> rusqlite::Result<()> {
            let known = format!("SELECT {TOLD} FROM trainee WHERE id = ?1");
            let known = change.query_row(&known, [trainee], told_of)?;
            let told = known.joined(&it.told);
            let set = "UPDATE trainee SET cohort = ?2, cohort_unix_s = ?3, consent = ?4, consent_unix_s = ?5 \
                       WHERE id = ?1";
            let (cohort_at, consent_at) = (told.cohort_unix_s, told.consent_unix_s);
            change.execute(
                set,
                params![
                    trainee,
                    told.cohort,
                    cohort_at,
                    told.consent.name(),
                    consent_at
                ],
            )?;
            let site = &it.session.circumstances.site;
            let fill = "UPDATE session SET site = ?2 WHERE id = ?1 AND site = ''";
            change.execute(fill, [&it.session.id, site])?;
            for sheet in &it.ratings {
                let key = params![it.session.id, sheet.sheet, sheet.rater, sheet.blinded];
                let add = "INSERT OR REPLACE INTO rating (session, sheet, rater, blinded) VALUES (?1, ?2, ?3, ?4)";
                change.execute(add, key)?;
                for (item, value) in &sheet.points {
                    let add = "INSERT INTO point (session, sheet, rater, item, value) VALUES (?1, ?2, ?3, ?4, ?5)";
                    let point = params![it.session.id, sheet.sheet, sheet.rater, item, value];
                    change.execute(add, point)?;
                }
            }
            Ok(())
        };
        learnt().map_err(|error| crate::file::refused(&path, error))?;
        change.commit().map_err(|error| self.refused(error))
    }

    /// Forgets all data of a person up to that time, whichever station sent them. `now_unix_s`
    /// bounds the time of a station whose clock is ahead. A repetition changes nothing.
    ///
    /// # Errors
    /// When the file cannot be read or written.
    pub fn forget_person(&mut self, it: &Withdrawal, now_unix_s: i64) -> Result<(), StoreError> {
        let at = it.at_unix_s.min(now_unix_s);
        let mark = "INSERT INTO forgotten_person (person, at_unix_s) VALUES (?1, ?2) \
                    ON CONFLICT DO UPDATE SET at_unix_s = max(at_unix_s, excluded.at_unix_s)";
        let marked = self.connection.execute(mark, params![it.person, at]);
        marked.map_err(|error| self.refused(error))?;
        let people = self.trainees()?.into_iter();
        for person in people.filter(|known| known.person == it.person) {
            let sessions = self.sessions(&person.name, None)?;
            let goes = |id: &String, began: i64| began <= at || it.sessions.contains(id);
            let (old, new): (Vec<_>, Vec<_>) = { sessions.into_iter() }
                .partition(|session| goes(&session.id, session.began_unix_s));
            if new.is_empty() {
                self.forget(&person.name, at)?;
                continue;
            }
            // A person who came back stays, without the earlier statements.
            let trainee = self.trainee(&person.name)?;
            let path = self.path().to_owned();
            let change = self.change()?;
            let forgotten = || -> rusqlite::Result<()> {
                for session in &old {
                    change.execute("DELETE FROM session WHERE id = ?1", [&session.id])?;
                }
                let known = format!("SELECT {TOLD} FROM trainee WHERE id = ?1");
                let told = change.query_row(&known, [trainee], told_of)?.after(at);
                let set = "UPDATE trainee SET cohort = ?2, cohort_unix_s = ?3, consent = ?4, consent_unix_s = ?5 \
                           WHERE id = ?1";
                let (cohort_at, consent_at) = (told.cohort_unix_s, told.consent_unix_s);
                let values = params![
                    trainee,
                    told.cohort,
                    cohort_at,
                    told.consent.name(),
                    consent_at
                ];
                change.execute(set, values)?;
                let answers = "DELETE FROM answer WHERE trainee = ?1 AND at_unix_s <= ?2";
                change.execute(answers, [trainee, at]).map(drop)
            };
            forgotten().map_err(|error| crate::file::refused(&path, error))?;
            change.commit().map_err(|error| self.refused(error))?;
        }
        Ok(())
    }
}
