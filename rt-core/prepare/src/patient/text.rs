//! A patient's recipe.

use std::path::Path;

use super::case::{PREFIX, Patient};
use super::parts::{self, Stones};
use crate::error::RecipeError;
use crate::recipe::Recipe;
use crate::shape::Course;

/// Text of the recipe, with gaps.
const TEXT: &str = include_str!("../../recipes/patient.toml");
/// An organ more, in the course with an accessory artery.
const ACCESSORY: &str = r#"[[organ]]
name = "accessory artery"
kind = "vessel"
shape = { form = "accessory-artery" }
spheres = 24
# It comes from the superior mesenteric artery, behind the duodenum.
held = [{ ball = { center_m = [-0.03, 0.262, -0.0965], radius_m = 0.005 } }]
attached = [{ to = "liver", within_m = 0.008 }]

"#;

impl Patient {
    /// Text of her recipe.
    #[must_use]
    pub fn text(&self) -> String {
        let cover_mm = self.cover_mm();
        let fat = (self.bmi - 18.0) / 27.0;
        let (wall, stones) = (self.wall.state(), self.stones.share());
        let accessory = match self.course {
            Course::AccessoryArtery => ACCESSORY,
            _ => "",
        };
        let gaps = [
            ("name", format!("{PREFIX}{}", self.name)),
            ("course", parts::word_of(self.course).into()),
            ("cover_mm", format!("{cover_mm:.3}")),
            ("adhesion_mm", format!("{:.3}", self.adhesion_mm)),
            ("liver_size", format!("{:.4}", 0.99 + 0.05 * fat)),
            ("gallbladder_width", format!("{:.4}", wall.width)),
            ("fat_width", format!("{:.4}", 0.8 + 0.25 * fat)),
            (
                "gallbladder_young_pa",
                format!("{:.0}", 15_000.0 * wall.stiffness * (1.0 + 2.5 * stones)),
            ),
            (
                "gallbladder_density_kg_m3",
                format!("{:.0}", 1020.0 + 80.0 * stones),
            ),
            (
                "gallbladder_toughness_j_m2",
                format!("{:.0}", 960.0 * wall.toughness),
            ),
            ("bed_young_pa", format!("{:.0}", 3000.0 * wall.bed)),
            (
                "bed_density_kg_m3",
                format!("{:.0}", 1000.0 + 100.0 * (wall.bed - 1.0)),
            ),
            ("stone_count", self.stones.count.to_string()),
            ("stone_mm", format!("{:.3}", self.stones.size_mm)),
            ("stone_room_ml", format!("{:.3}", Stones::ROOM_ML)),
            ("bed_toughness_j_m2", format!("{:.0}", 75.0 * wall.bed)),
            ("accessory", accessory.into()),
        ];
        let fill =
            |text: String, (gap, value): &(&str, String)| text.replace(&format!("@{gap}@"), value);
        gaps.iter().fold(TEXT.to_owned(), fill)
    }

    /// Her recipe.
    ///
    /// # Errors
    /// Never in a build whose tests pass.
    pub fn recipe(&self) -> Result<Recipe, RecipeError> {
        Recipe::parse(&self.text(), &self.to_string(), Path::new("."))
    }
}
