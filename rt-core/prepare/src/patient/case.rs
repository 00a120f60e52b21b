//! A case, from a seed or by a name.

use std::fmt;

use super::parts::{self, Stones, Wall};
use super::random::Random;
use crate::error::RecipeError;
use crate::shape::Course;

/// Prefix of a patient's name among scenes.
pub const PREFIX: &str = "patient:";
/// Names of the six patients with a name, from easy to hard.
pub const NAMES: [&str; 6] = ["ada", "berta", "clara", "dora", "edith", "frieda"];

/// A case.
#[derive(Debug, Clone, PartialEq)]
pub struct Patient {
    /// Her name: one of [`NAMES`], or her seed.
    pub name: String,
    /// Body mass index, kg/m²; 18 to 45.
    pub bmi: f64,
    /// Course of duct and artery.
    pub course: Course,
    /// State of the gallbladder's wall.
    pub wall: Wall,
    /// Stones in the gallbladder.
    pub stones: Stones,
    /// Length of the infundibulum to which the cover adheres, mm; 0 to 20.
    pub adhesion_mm: f64,
}

impl Patient {
    /// The patient of a seed.
    #[must_use]
    pub fn of_seed(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let bmi = random.between(18.0, 45.0);
        let course = random.choose(&parts::COURSES).unwrap_or_default();
        let wall = random.choose(&parts::WALLS).unwrap_or_default();
        let stones = Stones::random(&mut random, wall);
        let adhesion_mm = match wall {
            Wall::Normal => random.between(0.0, 6.0),
            Wall::Acute => random.between(2.0, 12.0),
            Wall::Scarred => random.between(6.0, 20.0),
        };
        Self {
            name: seed.to_string(),
            bmi,
            course,
            wall,
            stones,
            adhesion_mm,
        }
    }

    /// The patient of a name from [`NAMES`], or of a seed.
    ///
    /// # Errors
    /// When the word is neither; the error lists the names.
    pub fn of_word(word: &str) -> Result<Self, RecipeError> {
        if let Some(patient) = named(word) {
            return Ok(patient);
        }
        word.parse().map(Self::of_seed).map_err(|_| RecipeError {
            file: format!("{PREFIX}{word}"),
            line: 0,
            key: "patient".into(),
            problem: format!(
                "is '{word}'; allowed: a seed of 0 to {}, or one of {}",
                u64::MAX,
                NAMES.join(", ")
            ),
        })
    }

    /// Course of duct and artery, as a recipe names it.
    #[must_use]
    pub const fn course_word(&self) -> &'static str {
        parts::word_of(self.course)
    }

    /// Thickness of fat and peritoneum over duct and artery, mm.
    #[must_use]
    pub fn cover_mm(&self) -> f64 {
        3.4 + 0.04 * (self.bmi - 18.0)
    }
}

/// The patient of this name.
fn named(name: &str) -> Option<Patient> {
    let (bmi, course, wall, (count, size_mm), adhesion_mm) = match name {
        "ada" => (20.0, Course::Usual, Wall::Normal, (1, 12.0), 0.0),
        "berta" => (24.0, Course::ShortDuct, Wall::Normal, (4, 8.0), 2.0),
        "clara" => (28.0, Course::LowUnion, Wall::Normal, (20, 4.0), 4.0),
        "dora" => (31.0, Course::ArteryInFront, Wall::Acute, (1, 22.0), 6.0),
        "edith" => (36.0, Course::AccessoryArtery, Wall::Scarred, (8, 9.0), 10.0),
        "frieda" => (42.0, Course::HumpedArtery, Wall::Scarred, (2, 18.0), 16.0),
        _ => return None,
    };
    Some(Patient {
        name: name.to_owned(),
        bmi,
        course,
        wall,
        stones: Stones { count, size_mm },
        adhesion_mm,
    })
}

/// One line for people.
impl fmt::Display for Patient {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "patient {}: BMI {:.0}, {}, {}, {}; {:.1} mm of fat over the duct, adherent over {:.0} mm",
            self.name,
            self.bmi,
            parts::words_of(self.course),
            self.wall,
            self.stones,
            self.cover_mm(),
            self.adhesion_mm
        )
    }
}
