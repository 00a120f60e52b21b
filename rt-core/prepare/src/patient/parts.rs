//! Parts of a case: course of duct and artery, wall, stones.

use std::fmt;

use super::random::Random;
use crate::shape::Course;

/// Courses of duct and artery, and how often a seed has each.
pub(super) const COURSES: [(Course, f64); 6] = [
    (Course::Usual, 0.5),
    (Course::ShortDuct, 0.1),
    (Course::LowUnion, 0.1),
    (Course::ArteryInFront, 0.1),
    (Course::AccessoryArtery, 0.1),
    (Course::HumpedArtery, 0.1),
];

/// States of the wall, and how often a seed has each.
pub(super) const WALLS: [(Wall, f64); 3] = [
    (Wall::Normal, 0.5),
    (Wall::Acute, 0.25),
    (Wall::Scarred, 0.25),
];

/// Volume of the usual gallbladder inside its wall, mm³.
const ROOM_MM3: f64 = 40_000.0;
/// Largest share of that volume that stones fill.
const FULL: f64 = 0.5;

/// State of the gallbladder's wall.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Wall {
    /// Thin and soft.
    #[default]
    Normal,
    /// Acute inflammation with oedema: distended, thick, friable.
    Acute,
    /// Scarred after many inflammations: shrunken and stiff, with a tough bed.
    Scarred,
}

/// Factors of the usual gallbladder and of its bed.
pub(super) struct State {
    pub(super) width: f64,
    pub(super) stiffness: f64,
    pub(super) toughness: f64,
    /// Stiffness and toughness of the bed.
    pub(super) bed: f64,
}

impl Wall {
    pub(super) const fn state(self) -> State {
        let [width, stiffness, toughness, bed] = match self {
            Self::Normal => [1.0, 1.0, 1.0, 1.0],
            Self::Acute => [1.12, 1.5, 0.6, 0.8],
            Self::Scarred => [0.9, 2.5, 1.2, 2.0],
        };
        State {
            width,
            stiffness,
            toughness,
            bed,
        }
    }
}

impl Wall {
    /// One word for programs.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Acute => "acute",
            Self::Scarred => "scarred",
        }
    }
}

impl fmt::Display for Wall {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Normal => "normal wall",
            Self::Acute => "acute inflammation with oedema",
            Self::Scarred => "scarred wall",
        })
    }
}

/// Stones in the gallbladder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stones {
    /// Number of stones.
    pub count: u32,
    /// Diameter of each, mm.
    pub size_mm: f64,
}

impl Stones {
    /// Volume of the usual gallbladder inside its wall, ml.
    pub const ROOM_ML: f64 = 1e-3 * ROOM_MM3;

    pub(super) fn random(random: &mut Random, wall: Wall) -> Self {
        // The shrunken gallbladder has less room.
        let width = wall.state().width.min(1.0);
        let size_mm = random.between(3.0, 25.0 * width);
        let most = FULL * ROOM_MM3 * width * width / volume_mm3(size_mm);
        let count = random.between(1.0, most.clamp(1.5, 30.0)) as u32;
        Self { count, size_mm }
    }

    /// Share of the gallbladder that the stones fill.
    #[must_use]
    pub fn share(&self) -> f64 {
        f64::from(self.count) * volume_mm3(self.size_mm) / ROOM_MM3
    }
}

impl fmt::Display for Stones {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stones = if self.count == 1 { "stone" } else { "stones" };
        write!(to, "{} {stones} of {:.0} mm", self.count, self.size_mm)
    }
}

fn volume_mm3(size_mm: f64) -> f64 {
    std::f64::consts::PI / 6.0 * size_mm.powi(3)
}

/// The course as a recipe names it.
pub(super) const fn word_of(course: Course) -> &'static str {
    match course {
        Course::Usual => "usual",
        Course::Variant => "variant",
        Course::ShortDuct => "short-duct",
        Course::LowUnion => "low-union",
        Course::ArteryInFront => "artery-in-front",
        Course::AccessoryArtery => "accessory-artery",
        Course::HumpedArtery => "humped-artery",
    }
}

/// The course in words.
pub(super) const fn words_of(course: Course) -> &'static str {
    match course {
        Course::Usual => "usual course",
        Course::Variant => "low union and artery in front",
        Course::ShortDuct => "short cystic duct",
        Course::LowUnion => "low union",
        Course::ArteryInFront => "artery in front of the bile duct",
        Course::AccessoryArtery => "accessory right hepatic artery",
        Course::HumpedArtery => "humped right hepatic artery",
    }
}
