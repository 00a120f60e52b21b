//! Result of the preparation.

use shared_mem::scene::SceneData;

use crate::report::Report;
use crate::tetra::Tetra;

/// A compiled scene and its report.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// Ready to be written with [`SceneData::write`].
    pub scene: SceneData,
    /// Its quality.
    pub report: Report,
    /// Tetrahedra of each organ between its own spheres (numbered from the organ's first),
    /// ordered so that eight consecutive ones share no sphere, as far as possible.
    pub tetrahedra: Vec<Vec<Tetra>>,
}
