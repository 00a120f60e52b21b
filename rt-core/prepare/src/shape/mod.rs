//! Organs of our own making, from signed distance functions.
//!
//! Axes as in the atlas: x to the patient's left, y to the head, z to the front; metres.

mod gallbladder;
mod intestine;
mod liver;
mod primitive;
mod skin;
mod stomach;

pub use skin::skin;

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
        }
    }

    /// The surface as triangles.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let (bounds, edge_m) = match self {
            Self::Liver => (liver::BOUNDS, liver::EDGE_M),
            Self::Gallbladder => (gallbladder::BOUNDS, gallbladder::EDGE_M),
            Self::Stomach => (stomach::BOUNDS, stomach::EDGE_M),
            Self::Intestine => (intestine::BOUNDS, intestine::EDGE_M),
        };
        let bounds = bounds.map(Vec3::from);
        skin::skin(&|p: &Vec3| self.distance(p), bounds, edge_m)
    }
}
