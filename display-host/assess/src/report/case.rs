//! The patient's case, as a debrief and a summary name it.

use super::words::Words;

/// A patient of the generator.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Case {
    /// Her name or seed.
    pub name: String,
    /// Body mass index, kg/m².
    pub bmi: f64,
    /// Course of duct and artery, as recipes name it.
    pub course: String,
    /// State of the gallbladder's wall: `normal`, `acute` or `scarred`.
    pub wall: String,
    /// Number of stones in the gallbladder.
    pub stones: u32,
    /// Diameter of each stone, mm.
    pub stone_mm: f64,
}

impl Case {
    /// One line for the reader: name, habitus, course, wall, stones.
    #[must_use]
    pub fn line(&self, words: &dyn Words) -> String {
        let mut letters = self.name.chars();
        let first = letters.next().map(|it| it.to_uppercase().to_string());
        let name = first.unwrap_or_default() + letters.as_str();
        let [course, wall] = [("course", &self.course), ("wall", &self.wall)]
            .map(|(what, word)| words.say(&format!("case-{what}-{word}")));
        let stones = if self.stones == 1 { "one" } else { "many" };
        let stones = words.say_with(
            &format!("case-stones-{stones}"),
            &[
                ("count", &self.stones.to_string()),
                ("size", &words.number(self.stone_mm, 0)),
            ],
        );
        words.say_with(
            "page-case",
            &[
                ("name", &name),
                ("bmi", &words.number(self.bmi, 0)),
                ("course", &course),
                ("wall", &wall),
                ("stones", &stones),
            ],
        )
    }
}
