//! Trainees: their names, cohorts and consent; settings of the store.

use std::collections::BTreeSet;

use rusqlite::{OptionalExtension as _, params};

use crate::error::StoreError;
use crate::names::{are_alike, check_name, checked, shown};
use crate::open::Store;
use crate::withdrawal::person_id;

/// A trainee's consent to a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Consent {
    /// The person consented.
    Yes,
    /// The person refused or withdrew.
    No,
    /// Nobody asked.
    #[default]
    Unknown,
}

impl Consent {
    /// All values.
    pub const ALL: [Self; 3] = [Self::Yes, Self::No, Self::Unknown];

    /// Name in the store and in exports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::No => "no",
            Self::Unknown => "unknown",
        }
    }

    /// The consent of this name, if there is one.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// A trainee in the store.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Trainee {
    /// The chosen name.
    pub name: String,
    /// Number of sessions.
    pub sessions: i64,
    /// Cohort of a study, e.g. `novice`; empty: not stated.
    pub cohort: String,
    /// Consent to a study.
    pub consent: Consent,
    /// Id of the person at a centre, a UUID of version 5 from the name.
    pub person: String,
}

impl Store {
    /// All trainees, sorted by name.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn trainees(&self) -> Result<Vec<Trainee>, StoreError> {
        self.rows(
            "SELECT name, count(session.id), cohort, consent FROM trainee LEFT JOIN session \
             ON session.trainee = trainee.id GROUP BY trainee.id ORDER BY name",
            [],
            |row| {
                let (name, consent): (String, String) = (row.get(0)?, row.get(3)?);
                Ok(Trainee {
                    person: person_id(&name),
                    name,
                    sessions: row.get(1)?,
                    cohort: row.get(2)?,
                    consent: Consent::from_name(&consent).unwrap_or_default(),
                })
            },
        )
    }

    /// Name of the trainee of the newest session. `None`: the store holds no session.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn last_trainee(&self) -> Result<Option<String>, StoreError> {
        let newest = self.rows(
            "SELECT name FROM trainee JOIN session ON session.trainee = trainee.id \
             ORDER BY began_unix_s DESC, session.id DESC LIMIT 1",
            [],
            |row| row.get(0),
        )?;
        Ok(newest.into_iter().next())
    }

    /// Sets a trainee's cohort and consent as far as they are given, and adds the trainee if the
    /// name is new. An empty cohort means none. `at_unix_s` is the time of the statement: when
    /// stores are joined, the later statement counts.
    ///
    /// # Errors
    /// When the name or the cohort is invalid, or the file cannot be written.
    pub fn enrol(
        &mut self,
        name: &str,
        cohort: Option<&str>,
        consent: Option<Consent>,
        at_unix_s: i64,
    ) -> Result<(), StoreError> {
        let cohort = match cohort.map(str::trim) {
            None => None,
            Some("") => Some(String::new()),
            Some(text) => Some(checked(text, "a cohort")?),
        };
        let trainee = self.trainee_or_new(name)?;
        let change = "UPDATE trainee SET cohort = coalesce(?2, cohort), consent = coalesce(?3, consent), \
                      cohort_unix_s = iif(?2 IS NULL, cohort_unix_s, ?4), \
                      consent_unix_s = iif(?3 IS NULL, consent_unix_s, ?4) WHERE id = ?1";
        let values = params![trainee, cohort, consent.map(Consent::name), at_unix_s];
        let changed = self.connection.execute(change, values);
        changed.map(drop).map_err(|error| self.refused(error))
    }

    /// Trainee whose name is easily confused with this new one. `None`: there is none, or a trainee
    /// has this very name.
    ///
    /// # Errors
    /// When the name is invalid, or the file cannot be read.
    pub fn alike(&self, name: &str) -> Result<Option<String>, StoreError> {
        let name = check_name(name)?;
        let known: BTreeSet<String> = self.trainees()?.into_iter().map(|it| it.name).collect();
        if known.contains(&name) {
            return Ok(None);
        }
        Ok(known.into_iter().find(|it| are_alike(it, &name)))
    }

    /// Name of the site that new sessions get; empty: none.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn site(&self) -> Result<String, StoreError> {
        let found =
            self.connection
                .query_row("SELECT value FROM setting WHERE name = 'site'", [], |row| {
                    row.get(0)
                });
        let found = found.optional().map_err(|error| self.refused(error))?;
        Ok(found.unwrap_or_default())
    }

    /// Sets the name of the site that new sessions get.
    ///
    /// # Errors
    /// When the name is invalid, or the file cannot be written.
    pub fn set_site(&mut self, site: &str) -> Result<(), StoreError> {
        let site = checked(site, "a site")?;
        let set = "INSERT OR REPLACE INTO setting (name, value) VALUES ('site', ?1)";
        let set = self.connection.execute(set, [site]);
        set.map(drop).map_err(|error| self.refused(error))
    }

    pub(crate) fn trainee_or_new(&self, name: &str) -> Result<i64, StoreError> {
        let name = check_name(name)?;
        self.connection
            .execute("INSERT OR IGNORE INTO trainee (name) VALUES (?1)", [&name])
            .map_err(|error| self.refused(error))?;
        self.trainee(&name)
    }

    pub(crate) fn trainee(&self, name: &str) -> Result<i64, StoreError> {
        // An earlier version stored names in any form.
        let normal = check_name(name).unwrap_or_else(|_| name.trim().to_owned());
        let found = self
            .connection
            .query_row(
                "SELECT id FROM trainee WHERE name IN (?1, ?2) ORDER BY name = ?1 DESC",
                [name, &normal],
                |row| row.get(0),
            )
            .optional();
        found
            .map_err(|error| self.refused(error))?
            .ok_or_else(|| StoreError::NoTrainee(shown(name)))
    }
}
