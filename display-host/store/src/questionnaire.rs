//! Questionnaires: the paper's fourteen items, or a file's; answers; mean and standard deviation.

use std::fmt::Display;
use std::io::Read as _;
use std::path::Path;

use rusqlite::params;

use crate::error::StoreError;
use crate::open::Store;
use crate::sheet::check_points;

/// The paper's, in our words.
const BUILT_IN: &str = include_str!("questionnaire.toml");
/// Longest file that is read.
const MAX_BYTES: u64 = 64 << 10;
/// Items that a questionnaire may have.
const ITEMS_MAX: usize = 100;
/// Longest text, characters.
const TEXT_MAX: usize = 300;

/// A questionnaire: each item is answered with 1 to 5.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Questionnaire {
    /// By which answers are kept.
    pub name: String,
    /// What is shown.
    pub title: String,
    /// Its items.
    #[serde(rename = "item")]
    pub items: Vec<Item>,
}

/// A question.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Item {
    /// By which answers are kept.
    pub id: String,
    /// What is asked.
    pub text: String,
    /// What the paper found, if it asked.
    pub paper_mean: Option<f64>,
    /// Its standard deviation.
    pub paper_sd: Option<f64>,
}

/// What an item's answers come to.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ItemSummary {
    /// What was asked.
    pub text: String,
    /// Answers.
    pub count: usize,
    /// Mean; none without answers.
    pub mean: Option<f64>,
    /// Standard deviation of the sample; none with fewer than two.
    pub sd: Option<f64>,
    /// The paper's mean and standard deviation.
    pub paper: Option<[f64; 2]>,
}

impl Default for Questionnaire {
    fn default() -> Self {
        // The built-in file is tested.
        Self::parse(BUILT_IN).unwrap_or_else(|_| Self {
            name: String::new(),
            title: String::new(),
            items: Vec::new(),
        })
    }
}

impl Questionnaire {
    /// Reads a file.
    ///
    /// # Errors
    /// [`StoreError::Questionnaire`], with the file and what is wrong.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        let wrong =
            |why: &dyn Display| StoreError::Questionnaire(format!("{}: {why}", path.display()));
        let mut text = String::new();
        let file = std::fs::File::open(path).map_err(|error| wrong(&error))?;
        let read = file.take(MAX_BYTES + 1).read_to_string(&mut text);
        if read.map_err(|error| wrong(&error))? as u64 > MAX_BYTES {
            return Err(wrong(&format_args!("at most {MAX_BYTES} bytes are read")));
        }
        Self::parse(&text)
    }

    /// Reads a file's text.
    ///
    /// # Errors
    /// [`StoreError::Questionnaire`], with what is wrong, and where.
    pub fn parse(text: &str) -> Result<Self, StoreError> {
        let wrong = |why: String| Err(StoreError::Questionnaire(why));
        let read: Self = match toml::from_str(text) {
            Ok(read) => read,
            Err(error) => return wrong(error.to_string().trim_end().to_owned()),
        };
        if !(1..=ITEMS_MAX).contains(&read.items.len()) {
            let count = read.items.len();
            return wrong(format!("{count} items; allowed are 1 to {ITEMS_MAX}"));
        }
        let texts = read.items.iter().flat_map(|item| [&item.id, &item.text]);
        for text in texts.chain([&read.name, &read.title]) {
            let length = text.chars().count();
            if !(1..=TEXT_MAX).contains(&length) || text.chars().any(char::is_control) {
                let shown: String = text.escape_debug().take(60).collect();
                return wrong(format!(
                    "the text '{shown}' has {length} characters; allowed are 1 to {TEXT_MAX} without control \
                     characters"
                ));
            }
        }
        for (number, item) in read.items.iter().enumerate() {
            if read
                .items
                .iter()
                .skip(number + 1)
                .any(|it| it.id == item.id)
            {
                return wrong(format!("two items have the id '{}'", item.id));
            }
            for value in [item.paper_mean, item.paper_sd].into_iter().flatten() {
                if !(0.0..=5.0).contains(&value) {
                    return wrong(format!("item '{}': {value}; allowed is 0 to 5", item.id));
                }
            }
        }
        Ok(read)
    }
}

impl Store {
    /// Keeps somebody's answers, one for each item in order; earlier ones are replaced.
    ///
    /// # Errors
    /// When there are too few or too many, one is not 1 to 5, or the name may not be.
    pub fn answer(
        &mut self,
        name: &str,
        questionnaire: &Questionnaire,
        answers: &[u8],
        at_unix_s: i64,
    ) -> Result<(), StoreError> {
        if answers.len() != questionnaire.items.len() {
            return Err(StoreError::Value {
                what: "the number of answers".to_owned(),
                value: answers.len().to_string(),
                allowed: "one for each item",
            });
        }
        for (item, value) in questionnaire.items.iter().zip(answers) {
            check_points(&item.id, *value)?;
        }
        let trainee = self.trainee_or_new(name)?;
        for (item, value) in questionnaire.items.iter().zip(answers) {
            self.connection
                .execute(
                    "INSERT OR REPLACE INTO answer (trainee, questionnaire, item, value, at_unix_s) \
                     VALUES (?1, ?2, ?3, ?4, ?5)",
                    params![trainee, questionnaire.name, item.id, value, at_unix_s],
                )
                .map_err(|error| self.refused(error))?;
        }
        Ok(())
    }

    /// What everybody's answers come to, item by item.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn summarise(&self, questionnaire: &Questionnaire) -> Result<Vec<ItemSummary>, StoreError> {
        let summary = questionnaire.items.iter().map(|item| {
            let values: Vec<f64> = self.rows(
                "SELECT value FROM answer WHERE questionnaire = ?1 AND item = ?2 ORDER BY trainee",
                params![questionnaire.name, item.id],
                |row| row.get(0),
            )?;
            let (mean, sd) = mean_and_sd(&values);
            Ok(ItemSummary {
                text: item.text.clone(),
                count: values.len(),
                mean,
                sd,
                paper: item
                    .paper_mean
                    .zip(item.paper_sd)
                    .map(|(mean, sd)| [mean, sd]),
            })
        });
        summary.collect()
    }
}

/// Mean, and standard deviation of a sample.
fn mean_and_sd(values: &[f64]) -> (Option<f64>, Option<f64>) {
    let count = values.len() as f64;
    if values.is_empty() {
        return (None, None);
    }
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let sd = (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt());
    (Some(mean), sd)
}
