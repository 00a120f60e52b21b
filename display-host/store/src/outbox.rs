//! Results that wait for a centre. Nothing is copied: a session without a note has to be sent, so a
//! store that is offline for weeks loses nothing. A program that is killed between a delivery and
//! its note sends the session again, under the same id.

use rusqlite::{Transaction, TransactionBehavior, params};

use crate::error::StoreError;
use crate::open::Store;
use crate::sessions::{COLUMNS, SITE, SessionRecord, session_of};
use crate::sheet::Rating;
use crate::told::{TOLD, Told, told_of};
use crate::withdrawal::{number_of, person_id, respell};

/// State of a session on its way to a centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Delivery {
    /// It is at the centre.
    There,
    /// The centre holds another session with this id, and keeps it.
    Differs,
    /// The centre forgot this person after the session began.
    Forgotten,
    /// A centre of this kind takes no such result.
    LeftOut,
}

impl Delivery {
    /// Name in the store.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::There => "there",
            Self::Differs => "differs",
            Self::Forgotten => "forgotten",
            Self::LeftOut => "left-out",
        }
    }
}

/// A session that has to be sent, with its trainee and sheets.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Outgoing {
    /// Id of the trainee at centres.
    pub person: String,
    /// Name of the trainee.
    pub name: String,
    /// Cohort of the trainee and consent to studies.
    pub told: Told,
    /// The session.
    pub session: SessionRecord,
    /// Its scoring sheets.
    pub ratings: Vec<Rating>,
}

impl Store {
    /// Number of a centre, under which its notes are kept. `address` holds no password. A new
    /// centre is added, and has to forget whoever was forgotten here before.
    ///
    /// # Errors
    /// When the file cannot be read or written.
    pub fn destination(&mut self, address: &str) -> Result<i64, StoreError> {
        let path = self.path().to_owned();
        let change = self.change()?;
        number_of(&change, address)
            .and_then(|found| change.commit().map(|()| found))
            .map_err(|error| crate::file::refused(&path, error))
    }

    /// Moves the notes and withdrawals of a centre to another spelling of its address.
    ///
    /// # Errors
    /// When the file cannot be read or written.
    pub fn respell(&mut self, from: &str, to: &str) -> Result<(), StoreError> {
        if from == to {
            return Ok(());
        }
        let path = self.path().to_owned();
        let change = self.change()?;
        respell(&change, from, to)
            .and_then(|()| change.commit())
            .map_err(|error| crate::file::refused(&path, error))
    }

    /// Sessions that a centre has not received yet, oldest first.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn outgoing(&self, destination: i64) -> Result<Vec<Outgoing>, StoreError> {
        let unsent = "LEFT JOIN delivery ON delivery.session = session.id AND destination = ?1 \
                      WHERE state IS NULL ORDER BY began_unix_s, session.id";
        self.found(unsent, [destination])
    }

    /// Sessions that fulfil a condition, as they are sent.
    fn found(
        &self,
        condition: &str,
        values: impl rusqlite::Params,
    ) -> Result<Vec<Outgoing>, StoreError> {
        let columns = COLUMNS.map(|it| match it {
            "site" => format!("{SITE} AS site"),
            other => format!("session.{other}"),
        });
        let query = format!(
            "SELECT name, {TOLD}, {} FROM session JOIN trainee ON trainee.id = session.trainee {condition}",
            columns.join(", ")
        );
        let mut found = self.rows(&query, values, |row| {
            let name: String = row.get("name")?;
            Ok(Outgoing {
                person: person_id(&name),
                name,
                told: told_of(row)?,
                session: session_of(row)?,
                ratings: Vec::new(),
            })
        })?;
        for it in &mut found {
            it.ratings = self.ratings(&it.session.id)?;
        }
        Ok(found)
    }

    /// Notes the outcomes of deliveries. Returns the sessions that the store no longer holds,
    /// because their trainee was forgotten: these have to be withdrawn ([`Store::withdraw`]). A
    /// session that was changed since it was read gets no note: it waits, and is sent again.
    ///
    /// # Errors
    /// When the file cannot be read or written.
    pub fn note_deliveries(
        &mut self,
        destination: i64,
        notes: &[(&Outgoing, Delivery)],
    ) -> Result<Vec<String>, StoreError> {
        let change = Transaction::new_unchecked(&self.connection, TransactionBehavior::Immediate)
            .map_err(|error| self.refused(error))?;
        let mut lost = Vec::new();
        for (sent, state) in notes {
            let id = &sent.session.id;
            let written = match self.found("WHERE session.id = ?1", [id])?.pop() {
                None => {
                    lost.push(id.clone());
                    continue;
                }
                Some(now) if now == **sent => change.execute(
                    "INSERT INTO delivery (destination, session, state) VALUES (?1, ?2, ?3) \
                     ON CONFLICT DO UPDATE SET state = excluded.state",
                    params![destination, id, state.name()],
                ),
                // Another program may have sent the new contents before these old ones arrived.
                Some(_) => change.execute(
                    "DELETE FROM delivery WHERE destination = ?1 AND session = ?2",
                    params![destination, id],
                ),
            };
            written.map_err(|error| self.refused(error))?;
        }
        change.commit().map_err(|error| self.refused(error))?;
        Ok(lost)
    }
}
