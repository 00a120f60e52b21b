//! Questionnaires: the fourteen items of the paper whose simulator Calot re-implements, or the
//! items of a file; the answers, their mean and standard deviation.

use std::path::Path;

use rusqlite::params;

use crate::error::StoreError;
use crate::open::Store;
use crate::text_file;

/// Questionnaire of the paper, in our words.
const BUILT_IN: &str = include_str!("questionnaire.toml");
/// Answer to an item that does not apply to the trainee. It is not stored.
pub const NOT_APPLICABLE: u8 = 0;
/// Largest number of items of a questionnaire.
const ITEMS_MAX: usize = 100;

/// A questionnaire. Each item is answered with 1 to 5, or with [`NOT_APPLICABLE`].
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Questionnaire {
    /// Key of the questionnaire in the store.
    pub name: String,
    /// Title for display.
    pub title: String,
    /// Items in the order of their answers.
    #[serde(rename = "item")]
    pub items: Vec<Item>,
}

/// A question of a questionnaire.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Item {
    /// Key under which answers are stored.
    pub id: String,
    /// Text of the question.
    pub text: String,
    /// Mean that the paper reports, if it asked this question.
    pub paper_mean: Option<f64>,
    /// Standard deviation that the paper reports.
    pub paper_sd: Option<f64>,
}

/// An answer of a trainee.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Answer {
    /// Key of the questionnaire.
    pub questionnaire: String,
    /// Key of the item.
    pub item: String,
    /// The answer, 1 to 5.
    pub value: i64,
    /// Time of the answer, s since 1970.
    pub at_unix_s: i64,
}

/// Summary of the answers to one item.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ItemSummary {
    /// Text of the question.
    pub text: String,
    /// Number of answers.
    pub count: usize,
    /// Mean; `None` without answers.
    pub mean: Option<f64>,
    /// Standard deviation of the sample; `None` with fewer than two answers.
    pub sd: Option<f64>,
    /// Mean and standard deviation of the paper.
    pub paper: Option<[f64; 2]>,
}

impl Default for Questionnaire {
    fn default() -> Self {
        // The empty questionnaire is never used: a test parses the built-in file.
        Self::parse(BUILT_IN).unwrap_or_else(|_| Self {
            name: String::new(),
            title: String::new(),
            items: Vec::new(),
        })
    }
}

impl Questionnaire {
    /// Reads a questionnaire file.
    ///
    /// # Errors
    /// [`StoreError::Questionnaire`] names the problem, and the file if it could not be read.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        let wrong = |why| StoreError::Questionnaire(format!("{}: {why}", path.display()));
        let text = text_file::read(path).map_err(wrong)?;
        Self::parse(&text)
    }

    /// Parses the text of a questionnaire file.
    ///
    /// # Errors
    /// [`StoreError::Questionnaire`] names the problem.
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
            text_file::check(text).map_err(StoreError::Questionnaire)?;
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
    /// Stores a trainee's answers, one for each item in order. They replace earlier answers. An
    /// item that does not apply has no answer any more.
    ///
    /// # Errors
    /// When the number of answers is wrong, an answer is not 0 to 5, or the name is invalid.
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
                allowed: "one for each item".to_owned(),
            });
        }
        for (item, value) in questionnaire.items.iter().zip(answers) {
            check_answer(&item.id, *value)?;
        }
        let trainee = self.trainee_or_new(name)?;
        for (item, value) in questionnaire.items.iter().zip(answers) {
            let changed = match *value {
                NOT_APPLICABLE => self.connection.execute(
                    "DELETE FROM answer WHERE trainee = ?1 AND questionnaire = ?2 AND item = ?3",
                    params![trainee, questionnaire.name, item.id],
                ),
                _ => self.connection.execute(
                    "INSERT OR REPLACE INTO answer (trainee, questionnaire, item, value, at_unix_s) \
                     VALUES (?1, ?2, ?3, ?4, ?5)",
                    params![trainee, questionnaire.name, item.id, value, at_unix_s],
                ),
            };
            changed.map_err(|error| self.refused(error))?;
        }
        Ok(())
    }

    /// A trainee's answers, by questionnaire and item.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn answers_of(&self, name: &str) -> Result<Vec<Answer>, StoreError> {
        self.rows(
            "SELECT questionnaire, item, value, at_unix_s FROM answer WHERE trainee = ?1 \
             ORDER BY questionnaire, item",
            [self.trainee(name)?],
            |row| {
                Ok(Answer {
                    questionnaire: row.get(0)?,
                    item: row.get(1)?,
                    value: row.get(2)?,
                    at_unix_s: row.get(3)?,
                })
            },
        )
    }

    /// Summarises everybody's answers, item by item.
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

/// Mean, and standard deviation of the sample.
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

fn check_answer(what: &str, value: u8) -> Result<(), StoreError> {
    match value {
        NOT_APPLICABLE..=5 => Ok(()),
        _ => Err(StoreError::Value {
            what: what.to_owned(),
            value: value.to_string(),
            allowed: "1 to 5, or 0: does not apply".to_owned(),
        }),
    }
}
