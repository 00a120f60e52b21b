//! Organs of our own making, from signed distance functions.
//!
//! Axes as in the atlas: x to the patient's left, y to the head, z to the front; metres.

mod gallbladder;
mod intestine;
mod liver;
mod primitive;
mod skin;
mod stomach;
mod vessel;

pub use skin::skin;
pub use vessel::Course;

use serde::Deserialize;

use crate::Vec3;
use crate::mesh::Mesh;

/// A procedural organ, as the recipe's `shape` table names it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// A liver with its gallbladder fossa.
    Liver,
    /// A gallbladder with fundus, body, infundibulum and neck, in that fossa.
    Gallbladder,
    /// A stomach under the liver's left lobe.
    Stomach,
    /// Loops of small intestine below the liver.
    Intestine,
    /// From the gallbladder's neck to the bile duct.
    CysticDuct {
        /// How it runs.
        #[serde(default)]
        course: Course,
    },
    /// From the liver to the duodenum.
    BileDuct,
    /// To the liver, beside the bile duct.
    HepaticArtery,
    /// From the hepatic artery to the gallbladder.
    CysticArtery {
        /// How it runs.
        #[serde(default)]
        course: Course,
    },
}

impl Shape {
    pub(crate) fn from_table(table: toml::Table) -> Result<Self, String> {
        table
            .try_into()
            .map_err(|error: toml::de::Error| error.message().to_owned())
    }

    /// Negative inside; near the surface about the distance, m.
    #[must_use]
    pub fn distance(&self, p: &Vec3) -> f64 {
        match self {
            Self::Liver => liver::distance(p),
            Self::Gallbladder => gallbladder::distance(p),
            Self::Stomach => stomach::distance(p),
            Self::Intestine => intestine::distance(p),
            Self::CysticDuct { course } => vessel::cystic_duct(*course).distance(p),
            Self::BileDuct => vessel::bile_duct().distance(p),
            Self::HepaticArtery => vessel::hepatic_artery().distance(p),
            Self::CysticArtery { course } => vessel::cystic_artery(*course).distance(p),
        }
    }

    /// The surface as triangles.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let of_vessel = |vessel: &vessel::Vessel| (vessel.bounds, vessel.edge_m);
        let (bounds, edge_m) = match self {
            Self::Liver => (liver::BOUNDS.map(Vec3::from), liver::EDGE_M),
            Self::Gallbladder => (gallbladder::BOUNDS.map(Vec3::from), gallbladder::EDGE_M),
            Self::Stomach => (stomach::BOUNDS.map(Vec3::from), stomach::EDGE_M),
            Self::Intestine => (intestine::BOUNDS.map(Vec3::from), intestine::EDGE_M),
            Self::CysticDuct { course } => of_vessel(vessel::cystic_duct(*course)),
            Self::BileDuct => of_vessel(vessel::bile_duct()),
            Self::HepaticArtery => of_vessel(vessel::hepatic_artery()),
            Self::CysticArtery { course } => of_vessel(vessel::cystic_artery(*course)),
        };
        skin(&|p: &Vec3| self.distance(p), bounds, edge_m)
    }
}
