//! The whole way from a recipe to a compiled scene.

use shared_mem::scene::SceneData;

use crate::{PrepareError, Recipe, Report};

/// How far the preparation is.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// What is being done: `liver: packing 581 spheres`.
    pub doing: String,
    /// Share of the whole, 0..=1.
    pub done: f64,
}

/// A compiled scene and its report.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// Ready to be written with [`SceneData::write`].
    pub scene: SceneData,
    /// Its quality.
    pub report: Report,
}

/// Builds the scene that the recipe describes.
///
/// # Errors
/// Names the file, the organ, what is wrong and what to do.
pub fn prepare(
    recipe: &Recipe,
    progress: &mut dyn FnMut(Progress),
) -> Result<Prepared, PrepareError> {
    progress(Progress {
        doing: recipe.name.clone(),
        done: 0.0,
    });
    Err(PrepareError::Room("not built yet".into()))
}
