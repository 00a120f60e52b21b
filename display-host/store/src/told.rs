//! Cohort and consent as they were stated, and the times of the statements. The later statement
//! counts, whichever store took it.

use rusqlite::Row;

use crate::trainees::Consent;

/// Columns of a trainee that [`told_of`] reads.
pub(crate) const TOLD: &str = "cohort, cohort_unix_s, consent, consent_unix_s";

/// Cohort and consent of a person, each with the time of its statement, s since 1970. `None`: there
/// was none, or an earlier version of the program took it.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Told {
    /// Cohort; empty: not stated, or taken back.
    pub cohort: String,
    /// Time of the cohort.
    pub cohort_unix_s: Option<i64>,
    /// Consent to studies.
    pub consent: Consent,
    /// Time of the consent.
    pub consent_unix_s: Option<i64>,
}

impl Told {
    /// Joins this with the data of another store. A value without a time fills gaps only, but a
    /// refusal without a time always counts.
    #[must_use]
    pub fn joined(mut self, other: &Self) -> Self {
        let is_newer = match other.cohort_unix_s {
            Some(at) => self.cohort_unix_s.is_none_or(|known| at > known),
            None => self.cohort.is_empty() && self.cohort_unix_s.is_none(),
        };
        if is_newer {
            self.cohort.clone_from(&other.cohort);
            self.cohort_unix_s = other.cohort_unix_s;
        }
        let refuses = other.consent == Consent::No;
        let is_newer = match other.consent_unix_s {
            Some(at) => {
                (self.consent_unix_s).is_none_or(|known| at > known || (at == known && refuses))
            }
            None => refuses || self.consent == Consent::Unknown && self.consent_unix_s.is_none(),
        };
        if is_newer {
            self.consent = other.consent;
            self.consent_unix_s = other.consent_unix_s.or(self.consent_unix_s);
        }
        self
    }

    /// The part that was stated after a forgetting.
    #[must_use]
    pub fn after(mut self, forgotten_unix_s: i64) -> Self {
        if self.cohort_unix_s.is_none_or(|it| it <= forgotten_unix_s) {
            (self.cohort, self.cohort_unix_s) = (String::new(), None);
        }
        if self.consent_unix_s.is_none_or(|it| it <= forgotten_unix_s) {
            (self.consent, self.consent_unix_s) = (Consent::Unknown, None);
        }
        self
    }
}

pub(crate) fn told_of(row: &Row<'_>) -> rusqlite::Result<Told> {
    let consent: String = row.get("consent")?;
    Ok(Told {
        cohort: row.get("cohort")?,
        cohort_unix_s: row.get("cohort_unix_s")?,
        consent: Consent::from_name(&consent).unwrap_or_default(),
        consent_unix_s: row.get("consent_unix_s")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(cohort: &str, consent: Consent, at: Option<i64>) -> Told {
        Told {
            cohort: cohort.to_owned(),
            cohort_unix_s: at,
            consent,
            consent_unix_s: at,
        }
    }

    #[test]
    fn the_later_telling_counts_in_whichever_order_it_is_heard() {
        let all = [
            told("novice", Consent::No, Some(10)),
            told("", Consent::Yes, Some(20)),
            told("expert", Consent::Unknown, Some(5)),
        ];
        for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2], [1, 2, 0]] {
            let joined = order
                .iter()
                .fold(Told::default(), |known, it| known.joined(&all[*it]));
            assert_eq!(joined, all[1], "{order:?}");
        }
    }

    #[test]
    fn a_refusal_counts_more_at_the_same_time_or_without_one() {
        let yes = told("", Consent::Yes, Some(10));
        for no in [Some(10), None] {
            let no = told("", Consent::No, no);
            assert_eq!(yes.clone().joined(&no).consent, Consent::No);
        }
        let same = told("", Consent::No, Some(10)).joined(&yes);
        assert_eq!(same.consent, Consent::No);
        let old = told("novice", Consent::Yes, None);
        assert_eq!(old.clone().joined(&yes).consent, Consent::Yes);
        assert_eq!(Told::default().joined(&old), old);
        let later = told("expert", Consent::Unknown, Some(3));
        assert_eq!(later.clone().joined(&old), later, "it has no time");
    }

    #[test]
    fn a_forgetting_leaves_what_was_told_later() {
        let it = Told {
            cohort: "novice".to_owned(),
            cohort_unix_s: Some(10),
            consent: Consent::No,
            consent_unix_s: Some(11),
        };
        let after = it.after(10);
        assert_eq!(
            after,
            Told {
                consent: Consent::No,
                consent_unix_s: Some(11),
                ..Told::default()
            }
        );
        assert_eq!(told("x", Consent::Yes, None).after(0), Told::default());
    }
}
