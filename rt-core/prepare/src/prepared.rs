//! Result of the preparation.

use shared_mem::scene::SceneData;

use crate::report::Report;
use crate::tetra::Tetra;

/// A compiled scene and its report.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The scene, ready to be written with [`SceneData::write`].
    pub scene: SceneData,
    /// Figures of the scene's quality.
    pub report: Report,
    /// Tetrahedra of each organ. Spheres are numbered from the organ's first. Any eight consecutive
    /// tetrahedra share no sphere, as far as possible.
    pub tetrahedra: Vec<Vec<Tetra>>,
}
