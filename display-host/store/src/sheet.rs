//! Sheets that raters filled for a session.

use std::collections::BTreeMap;

use rusqlite::{OptionalExtension as _, params};

use crate::error::StoreError;
use crate::file::refused;
use crate::form::Sheet;
use crate::names::{are_alike, checked, shown};
use crate::open::Store;

/// Key of the sheet of GOALS.
const GOALS_SHEET: &str = "goals";

/// Short and full names of the items: Global Operative Assessment of Laparoscopic Skills (Vassiliou
/// 2005). Novices reach 13 of 25, experienced surgeons 19.4.
pub const GOALS: [(&str, &str); 5] = [
    ("depth", "Depth perception"),
    ("hands", "Bimanual dexterity"),
    ("efficiency", "Efficiency"),
    ("tissue", "Tissue handling"),
    ("autonomy", "Autonomy"),
];

/// A sheet that a rater filled.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Rating {
    /// Id of the session.
    pub session: String,
    /// Name of the sheet.
    pub sheet: String,
    /// Name that the rater chose; empty: none.
    pub rater: String,
    /// True if the rater did not know who operated.
    pub blinded: bool,
    /// Points by item.
    pub points: BTreeMap<String, u8>,
}

impl Rating {
    /// Sum of the points.
    #[must_use]
    pub fn sum(&self) -> u32 {
        self.points.values().map(|it| u32::from(*it)).sum()
    }
}

impl From<Rating> for StoreError {
    /// The error of a second sheet.
    fn from(first: Rating) -> Self {
        Self::Rated {
            rater: first.rater,
            sheet: first.sheet,
            session: first.session,
        }
    }
}

/// Checks a rater's name and brings it to the stored form; empty: no name.
fn check_rater(rater: &str) -> Result<String, StoreError> {
    match rater.trim() {
        "" => Ok(String::new()),
        rater => checked(rater, "a rater's name"),
    }
}

impl Store {
    /// Stores an instructor's points for a session: one value for each item of [`GOALS`]. They
    /// replace earlier ones of the same rater, whose name may be empty.
    ///
    /// # Errors
    /// When there is no such session, a value is not 1 to 5, or the rater's name is invalid.
    pub fn set_sheet(
        &mut self,
        session: &str,
        rater: &str,
        points: [u8; 5],
    ) -> Result<(), StoreError> {
        let goals = Sheet::named(GOALS_SHEET)?;
        let kept = self.rate_again(session, &goals, (rater, false), &points);
        kept.map(drop)
    }

    /// Stores the points that a rater gave a session, one for each item of a sheet, in order.
    /// `rater` is a pair: the name, which may be empty, and true if the rater did not know who
    /// operated.
    ///
    /// # Errors
    /// [`StoreError::Rated`] if the rater filled this sheet for this session before. When there is
    /// no such session, there are more or fewer points than items, a value is outside the sheet's
    /// scale, or the rater's name is invalid.
    pub fn rate(
        &mut self,
        session: &str,
        sheet: &Sheet,
        rater: (&str, bool),
        points: &[u8],
    ) -> Result<(), StoreError> {
        if let Some(old) = self.rated(session, sheet, rater.0)? {
            return Err(old.into());
        }
        self.put_sheet("INSERT", session, sheet, rater, points)
    }

    /// Like [`Store::rate`], but replaces an earlier sheet of this kind by the same rater, and
    /// returns it.
    ///
    /// # Errors
    /// As [`Store::rate`], without [`StoreError::Rated`].
    pub fn rate_again(
        &mut self,
        session: &str,
        sheet: &Sheet,
        rater: (&str, bool),
        points: &[u8],
    ) -> Result<Option<Rating>, StoreError> {
        let old = self.rated(session, sheet, rater.0)?;
        self.put_sheet("INSERT OR REPLACE", session, sheet, rater, points)?;
        Ok(old)
    }

    /// The sheet of this kind that a rater filled for a session.
    ///
    /// # Errors
    /// When there is no such session, or the rater's name is invalid.
    pub fn rated(
        &self,
        session: &str,
        sheet: &Sheet,
        rater: &str,
    ) -> Result<Option<Rating>, StoreError> {
        let rater = check_rater(rater)?;
        let mut all = self.ratings(session)?.into_iter();
        Ok(all.find(|it| it.sheet == sheet.name && it.rater == rater))
    }

    fn put_sheet(
        &mut self,
        insert: &str,
        session: &str,
        sheet: &Sheet,
        (rater, is_blinded): (&str, bool),
        points: &[u8],
    ) -> Result<(), StoreError> {
        let rater = check_rater(rater)?;
        if points.len() != sheet.items.len() {
            return Err(StoreError::Value {
                what: format!("the number of points for {}", sheet.title),
                value: points.len().to_string(),
                allowed: format!("{}, one for each item", sheet.items.len()),
            });
        }
        for (item, value) in sheet.items.iter().zip(points) {
            if !sheet.has(*value) {
                return Err(StoreError::Value {
                    what: item.text.clone(),
                    value: value.to_string(),
                    allowed: format!("{} to {}", sheet.least, sheet.most),
                });
            }
        }
        let path = self.path().to_owned();
        let change = self.change()?;
        let kept = || -> rusqlite::Result<()> {
            change.execute(
                &format!(
                    "{insert} INTO rating (session, sheet, rater, blinded) VALUES (?1, ?2, ?3, ?4)"
                ),
                params![session, sheet.name, rater, is_blinded],
            )?;
            for (item, value) in sheet.items.iter().zip(points) {
                change.execute(
                    "INSERT INTO point (session, sheet, rater, item, value) VALUES (?1, ?2, ?3, ?4, ?5)",
                    params![session, sheet.name, rater, item.id, value],
                )?;
            }
            Ok(())
        };
        kept().map_err(|error| refused(&path, error))?;
        change.commit().map_err(|error| refused(&path, error))
    }

    /// Rater whose name is easily confused with this new one. `None`: there is none, or a rater has
    /// this very name.
    ///
    /// # Errors
    /// When the name is invalid, or the file cannot be read.
    pub fn alike_rater(&self, rater: &str) -> Result<Option<String>, StoreError> {
        let rater = check_rater(rater)?;
        let query = "SELECT DISTINCT rater FROM rating WHERE rater <> '' ORDER BY rater";
        let known: Vec<String> = self.rows(query, [], |row| row.get(0))?;
        if known.contains(&rater) {
            return Ok(None);
        }
        Ok(known.into_iter().find(|it| are_alike(it, &rater)))
    }

    fn session_exists(&self, session: &str) -> Result<(), StoreError> {
        let query = "SELECT 1 FROM session WHERE id = ?1";
        let known = self.connection.query_row(query, [session], |_| Ok(()));
        let known = known.optional().map_err(|error| self.refused(error))?;
        known.ok_or_else(|| StoreError::NoSession(shown(session)))
    }

    /// Sheets of a session, in the order in which they were filled.
    ///
    /// # Errors
    /// When there is no such session, or the file cannot be read.
    pub fn ratings(&self, session: &str) -> Result<Vec<Rating>, StoreError> {
        self.session_exists(session)?;
        self.ratings_where("rating.session = ?1", session)
    }

    /// All sheets of a trainee's sessions, in the order of the sessions.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn ratings_of(&self, name: &str) -> Result<Vec<Rating>, StoreError> {
        let trainee = self.trainee(name)?;
        self.ratings_where("session.trainee = ?1", trainee)
    }

    fn ratings_where(
        &self,
        filter: &str,
        value: impl rusqlite::ToSql,
    ) -> Result<Vec<Rating>, StoreError> {
        let query = format!(
            "SELECT rating.session, rating.sheet, rating.rater, blinded, item, value FROM rating \
             JOIN session ON session.id = rating.session \
             JOIN point ON (point.session, point.sheet, point.rater) = (rating.session, rating.sheet, rating.rater) \
             WHERE {filter} ORDER BY began_unix_s, rating.session, rating.rowid"
        );
        let points = self.rows(&query, [value], |row| {
            Ok((
                Rating {
                    session: row.get(0)?,
                    sheet: row.get(1)?,
                    rater: row.get(2)?,
                    blinded: row.get(3)?,
                    points: BTreeMap::new(),
                },
                row.get::<_, String>(4)?,
                row.get::<_, u8>(5)?,
            ))
        })?;
        let mut ratings: Vec<Rating> = Vec::new();
        for (rating, item, value) in points {
            let is_new = ratings.last().is_none_or(|it| {
                (&it.session, &it.sheet, &it.rater)
                    != (&rating.session, &rating.sheet, &rating.rater)
            });
            if is_new {
                ratings.push(rating);
            }
            if let Some(last) = ratings.last_mut() {
                last.points.insert(item, value);
            }
        }
        Ok(ratings)
    }

    /// Full name and points of each item of GOALS, in the order of [`GOALS`], as the last rater
    /// gave them; empty if the session has no such sheet.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn sheet(&self, session: &str) -> Result<Vec<(String, u8)>, StoreError> {
        let all = self.ratings_where("rating.session = ?1", session)?;
        let Some(last) = all.into_iter().rfind(|it| it.sheet == GOALS_SHEET) else {
            return Ok(Vec::new());
        };
        let in_order = GOALS
            .iter()
            .filter_map(|(short, item)| Some(((*item).to_owned(), *last.points.get(*short)?)));
        Ok(in_order.collect())
    }
}
