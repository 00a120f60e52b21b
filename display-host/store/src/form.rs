//! Scoring sheets as forms: their items, anchors and scale. Three sheets are built in; other sheets
//! are files.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::StoreError;
use crate::text_file;

/// Sheets that are built in.
const BUILT_IN: [&str; 3] = [
    include_str!("sheets/goals.toml"),
    include_str!("sheets/osats.toml"),
    include_str!("sheets/cvs.toml"),
];
/// Largest number of items of a sheet.
const ITEMS_MAX: usize = 100;
/// Largest number of points of an item.
const POINTS_MAX: u8 = 100;

/// A scoring sheet. Each item is scored on one scale.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Key of the sheet in the store.
    pub name: String,
    /// Title for display.
    pub title: String,
    /// Publication of the sheet; may be left out.
    #[serde(default)]
    pub source: String,
    /// Least points of an item.
    pub least: u8,
    /// Most points of an item, 100 at most.
    pub most: u8,
    /// Items in the order of their points.
    #[serde(rename = "item")]
    pub items: Vec<SheetItem>,
}

/// An item of a scoring sheet.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SheetItem {
    /// Key under which points are stored.
    pub id: String,
    /// Name of the scored skill or event.
    pub text: String,
    /// Meaning of some of the points; the points are the keys.
    #[serde(default)]
    pub anchors: BTreeMap<String, String>,
}

impl Sheet {
    /// The built-in sheets: GOALS, the global rating of OSATS, the critical view of safety.
    #[must_use]
    pub fn built_in() -> Vec<Self> {
        // None is left out: a test parses all.
        BUILT_IN
            .iter()
            .filter_map(|it| Self::parse(it).ok())
            .collect()
    }

    /// The built-in sheet of this name, else the sheet in the file of this name.
    ///
    /// # Errors
    /// [`StoreError::Sheet`] names the problem, and the built-in sheets.
    pub fn named(name: &str) -> Result<Self, StoreError> {
        let known = Self::built_in();
        if let Some(found) = known.iter().find(|it| it.name == name) {
            return Ok(found.clone());
        }
        let wrong = |why: String| {
            let names: Vec<&str> = known.iter().map(|it| it.name.as_str()).collect();
            let names = names.join(", ");
            StoreError::Sheet(format!(
                "{name}: {why}. Name one of {names}, or a file of that form"
            ))
        };
        let text = text_file::read(Path::new(name)).map_err(wrong)?;
        Self::parse(&text)
    }

    /// Parses the text of a sheet's file.
    ///
    /// # Errors
    /// [`StoreError::Sheet`] names the problem.
    pub fn parse(text: &str) -> Result<Self, StoreError> {
        let wrong = |why: String| Err(StoreError::Sheet(why));
        let read: Self = match toml::from_str(text) {
            Ok(read) => read,
            Err(error) => return wrong(error.to_string().trim_end().to_owned()),
        };
        let count = read.items.len();
        if !(1..=ITEMS_MAX).contains(&count) {
            return wrong(format!("{count} items; allowed are 1 to {ITEMS_MAX}"));
        }
        if read.least >= read.most || read.most > POINTS_MAX {
            let (least, most) = (read.least, read.most);
            return wrong(format!(
                "a scale from {least} to {most}; allowed is 0 to {POINTS_MAX}, the least below the most"
            ));
        }
        let items = read.items.iter();
        let texts = items.clone().flat_map(|item| [&item.id, &item.text]);
        let anchors = items.flat_map(|item| item.anchors.values());
        for text in texts.chain(anchors).chain([&read.name, &read.title]) {
            text_file::check(text).map_err(StoreError::Sheet)?;
        }
        for (number, item) in read.items.iter().enumerate() {
            let mut others = read.items.iter().skip(number + 1);
            if others.any(|it| it.id == item.id) {
                return wrong(format!("two items have the id '{}'", item.id));
            }
            let mut points = item.anchors.keys();
            let is_off = |it: &&String| !it.parse().is_ok_and(|it| read.has(it));
            if let Some(off) = points.find(is_off) {
                let (least, most) = (read.least, read.most);
                return wrong(format!(
                    "item '{}' has an anchor at '{off}'; allowed is {least} to {most}",
                    item.id
                ));
            }
        }
        Ok(read)
    }

    /// True if an item can have these points.
    #[must_use]
    pub fn has(&self, points: u8) -> bool {
        (self.least..=self.most).contains(&points)
    }

    /// Most points of the whole sheet.
    #[must_use]
    pub fn total(&self) -> u32 {
        u32::from(self.most) * self.items.len() as u32
    }
}
