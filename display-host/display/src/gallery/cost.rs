//! Cost of drawing, for every picture of the gallery.

use shared_mem::scene::SceneFile;

use super::shot;
use crate::DisplayError;
use crate::render::cost::{FrameCost, measure};
use crate::render::gpu::Gpu;
use crate::render::{Quality, Renderer};

/// A picture of the gallery and the cost of drawing it.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewCost {
    /// Chapter of the gallery that shows the picture.
    pub chapter: &'static str,
    /// Caption of the picture.
    pub title: String,
    /// Cost of drawing the picture once.
    pub frame: FrameCost,
}

/// Measures the cost of every picture of the gallery over `frames` frames. Before each picture,
/// `say` receives its caption and the share of pictures done so far, 0 to 1.
///
/// # Errors
/// [`DisplayError`]: a scene too large for the adapter, a size out of range, a lost device.
pub fn cost(
    gpu: &Gpu,
    scene: &SceneFile,
    quality: Quality,
    frames: usize,
    say: &mut dyn FnMut(&str, f32),
) -> Result<Vec<ViewCost>, DisplayError> {
    let mut renderer = Renderer::new(gpu, scene, quality)?;
    let state = crate::headless::at_rest(scene);
    let at_rest = state.spheres().unwrap_or(&[]);
    let shots = shot::all(scene, quality.size);
    let mut costs = Vec::new();
    for (number, shot) in shots.iter().enumerate() {
        say(&shot.title, number as f32 / shots.len() as f32);
        let spheres = shot.spheres.as_deref().unwrap_or(at_rest);
        shot.set_up(gpu, &mut renderer, spheres);
        costs.push(ViewCost {
            chapter: shot.chapter.title(),
            title: shot.title.clone(),
            frame: measure(gpu, &mut renderer, spheres, &shot.tools, frames)?,
        });
    }
    Ok(costs)
}
