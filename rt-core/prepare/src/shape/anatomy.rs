//! Sizes and places of the built-in organs.

use serde::Deserialize;

use super::primitive::Through;
use crate::Vec3;

/// Course of the cystic duct and the cystic artery.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// The usual course: the cystic duct joins the bile duct halfway down, and the cystic artery
    /// crosses behind the bile duct.
    #[default]
    Usual,
    /// A variant: the cystic duct runs along the bile duct and joins it low, and the cystic artery
    /// crosses in front of the bile duct.
    Variant,
    /// The cystic duct is short: it joins the bile duct 15 mm from the neck.
    ShortDuct,
    /// The cystic duct runs along the bile duct and joins it low.
    LowUnion,
    /// The cystic artery crosses in front of the bile duct.
    ArteryInFront,
    /// An accessory right hepatic artery climbs behind the bile duct and through the triangle.
    AccessoryArtery,
    /// The right hepatic artery makes a loop towards the gallbladder's neck (Moynihan's hump), from
    /// which a short cystic artery rises.
    HumpedArtery,
}

/// Size and place of one organ, relative to its usual size and place.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Build {
    /// Factor of all lengths, about the organ's middle; 0.7..=1.4. Of cystic duct and cystic artery
    /// it scales only the thickness, because other organs give their ends.
    pub size: f64,
    /// Factor of the thickness alone; 0.5..=2. It applies to organs with a centre line and to the
    /// layer of connective tissue. For that layer, values above 1 count as 1.
    pub width: f64,
    /// Shift from the usual place along x, y and z, mm; −30..=30. The ends of cystic duct and
    /// cystic artery stay at the organs that they join, so a shift moves only the middles of these
    /// two.
    pub shift_mm: [f64; 3],
}

impl Default for Build {
    fn default() -> Self {
        Self {
            size: 1.0,
            width: 1.0,
            shift_mm: [0.0; 3],
        }
    }
}

impl Build {
    pub(super) fn shift_m(&self) -> Vec3 {
        Vec3::from(self.shift_mm) * 1e-3
    }

    /// Place of point `p` of an organ in this build; `middle` is the organ's usual middle, m.
    pub(super) fn place(&self, p: &Vec3, middle: &Vec3) -> Vec3 {
        middle + (p - middle) * self.size + self.shift_m()
    }

    /// The organ's centre line in this build.
    pub(super) fn line(&self, usual: &[Through]) -> Vec<Through> {
        let middle = middle(usual);
        let place = |&(p, radius): &Through| {
            let placed = self.place(&Vec3::from(p), &middle);
            (placed.into(), radius * self.size * self.width)
        };
        usual.iter().map(place).collect()
    }

    /// A centre line whose ends follow the organs that they join. `first` and `last` are the
    /// displacements of its ends, m. Between the ends the displacement is interpolated, and the
    /// organ's own shift is added, in full at the middle.
    pub(super) fn line_between(&self, usual: &[Through], first: Vec3, last: Vec3) -> Vec<Through> {
        let steps = (usual.len() - 1) as f64;
        let place = |(i, &(p, radius)): (usize, &Through)| {
            let t = i as f64 / steps;
            let by = first * (1.0 - t) + last * t + self.shift_m() * (4.0 * t * (1.0 - t));
            ((Vec3::from(p) + by).into(), radius * self.size * self.width)
        };
        usual.iter().enumerate().map(place).collect()
    }
}

pub(super) fn middle(line: &[Through]) -> Vec3 {
    line.iter().map(|(p, _)| Vec3::from(*p)).sum::<Vec3>() / line.len() as f64
}

/// The `[anatomy]` table of a recipe.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
#[allow(missing_docs)]
pub struct Anatomy {
    pub course: Course,
    pub liver: Build,
    pub gallbladder: Build,
    pub stomach: Build,
    pub duodenum: Build,
    pub intestine: Build,
    pub cystic_duct: Build,
    pub bile_duct: Build,
    pub hepatic_artery: Build,
    pub cystic_artery: Build,
    pub fat: Build,
    pub connective_tissue: Build,
    /// Thickness of the fat and peritoneum over cystic duct and cystic artery, mm; 0..=8. With 0
    /// both emerge from the fat.
    #[serde(rename = "cover_mm")]
    pub cover_mm: f64,
    /// Distance from the end of the gallbladder's neck up to which that cover adheres to the
    /// gallbladder, mm; 0..=25.
    #[serde(rename = "adhesion_mm")]
    pub adhesion_mm: f64,
    /// Lets the hepatic artery run on to the stomach, behind which it begins.
    #[serde(rename = "runs_on")]
    pub runs_on: bool,
}

impl Anatomy {
    /// Every organ's build, with the name of the organ's form in a recipe.
    #[must_use]
    pub fn builds(&self) -> [(&'static str, &Build); 11] {
        [
            ("liver", &self.liver),
            ("gallbladder", &self.gallbladder),
            ("stomach", &self.stomach),
            ("duodenum", &self.duodenum),
            ("intestine", &self.intestine),
            ("cystic-duct", &self.cystic_duct),
            ("bile-duct", &self.bile_duct),
            ("hepatic-artery", &self.hepatic_artery),
            ("cystic-artery", &self.cystic_artery),
            ("fat", &self.fat),
            ("connective-tissue", &self.connective_tissue),
        ]
    }
}
