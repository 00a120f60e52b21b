//! The instructor's assessment sheet: the five items of GOALS, each 1 to 5.

use rusqlite::{OptionalExtension as _, params};

use crate::error::StoreError;
use crate::open::Store;

/// Short and full names of the items: Global Operative Assessment of Laparoscopic Skills (Vassiliou
/// 2005). Novices reach 13 of 25, experienced surgeons 19.4.
pub const GOALS: [(&str, &str); 5] = [
    ("depth", "Depth perception"),
    ("hands", "Bimanual dexterity"),
    ("efficiency", "Efficiency"),
    ("tissue", "Tissue handling"),
    ("autonomy", "Autonomy"),
];

impl Store {
    /// Stores an instructor's points for a session: one value for each item of [`GOALS`].
    ///
    /// # Errors
    /// When there is no such session, or a value is not 1 to 5.
    pub fn set_sheet(&mut self, session: &str, points: [u8; 5]) -> Result<(), StoreError> {
        for ((_, item), value) in GOALS.iter().zip(points) {
            check_points(item, value)?;
        }
        let known = self
            .connection
            .query_row("SELECT 1 FROM session WHERE id = ?1", [session], |_| Ok(()))
            .optional()
            .map_err(|error| self.refused(error))?;
        if known.is_none() {
            return Err(StoreError::NoSession(session.escape_debug().to_string()));
        }
        for ((item, _), value) in GOALS.iter().zip(points) {
            self.connection
                .execute(
                    "INSERT OR REPLACE INTO sheet (session, item, value) VALUES (?1, ?2, ?3)",
                    params![session, item, value],
                )
                .map_err(|error| self.refused(error))?;
        }
        Ok(())
    }

    /// Full name and points of each item, in the order of [`GOALS`]; empty if the session has no
    /// sheet.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn sheet(&self, session: &str) -> Result<Vec<(String, u8)>, StoreError> {
        let found = self.rows(
            "SELECT item, value FROM sheet WHERE session = ?1",
            [session],
            |row| Ok((row.get::<_, String>(0)?, row.get::<_, u8>(1)?)),
        )?;
        let in_order = GOALS.iter().filter_map(|(short, item)| {
            let (_, value) = found.iter().find(|(name, _)| name == short)?;
            Some(((*item).to_owned(), *value))
        });
        Ok(in_order.collect())
    }
}

pub(crate) fn check_points(what: &str, value: u8) -> Result<(), StoreError> {
    match value {
        1..=5 => Ok(()),
        _ => Err(StoreError::Value {
            what: what.to_owned(),
            value: value.to_string(),
            allowed: "1 to 5",
        }),
    }
}
