//! The gallery: pictures of every organ, instrument, effect and view of a scene, with a page to
//! browse them. Nothing moves in them, so no controller is needed.

mod cost;
mod page;
mod shot;

use std::fs::File;
use std::path::{Path, PathBuf};

use shared_mem::scene::SceneFile;

pub use self::cost::{ViewCost, cost};
use self::shot::Shot;
pub use self::shot::{Chapter, lying};
use crate::DisplayError;
use crate::picture::write_png;
use crate::render::gpu::Gpu;
use crate::render::{Quality, Renderer};

/// A picture of the gallery.
#[derive(Debug, Clone)]
pub struct Picture {
    /// File name in the folder.
    pub file: String,
    /// Caption.
    pub title: String,
    /// Chapter that shows the picture.
    pub chapter: Chapter,
}

/// Draws every picture into `out_dir`, with `index.html` and `sheet.png`, which show all of them.
/// With a `size` of `None` the adapter decides the size. Before each picture, `say` receives its
/// caption and the share of pictures done, 0 to 1.
///
/// # Errors
/// [`DisplayError`]: no graphics adapter, a scene too large for it, a size out of range, or a file
/// that cannot be written.
pub fn make(
    scene: &SceneFile,
    out_dir: &Path,
    size: Option<[u32; 2]>,
    say: &mut dyn FnMut(&str, f32),
) -> Result<Vec<Picture>, DisplayError> {
    std::fs::create_dir_all(out_dir).map_err(|error| cannot_write(out_dir, &error))?;
    let gpu = Gpu::open()?;
    let mut quality = Quality::for_adapter(&gpu);
    quality.size = size.unwrap_or(quality.size);
    let mut renderer = Renderer::new(&gpu, scene, quality)?;
    // Film grain is random, so without it the pictures are reproducible.
    renderer.exposure_mut().grain = 0.0;
    let state = crate::headless::at_rest(scene);
    let spheres = state.spheres().unwrap_or(&[]);
    let shots = shot::all(scene, quality.size);
    let mut pictures = Vec::new();
    let mut drawn = Vec::new();
    for (number, shot) in shots.iter().enumerate() {
        say(&shot.title, number as f32 / shots.len() as f32);
        let spheres = shot.spheres.as_deref().unwrap_or(spheres);
        shot.set_up(&gpu, &mut renderer, spheres);
        renderer.render(&gpu, spheres, &shot.tools, 0.0);
        let picture = renderer.read(&gpu)?;
        let file = shot.file(number);
        let path = out_dir.join(&file);
        let written = File::create(&path).and_then(|file| write_png(&picture, file));
        written.map_err(|error| cannot_write(&path, &error))?;
        drawn.push(picture);
        let Shot { title, chapter, .. } = shot;
        pictures.push(Picture {
            file,
            title: title.clone(),
            chapter: *chapter,
        });
    }
    let path = out_dir.join("sheet.png");
    let written = File::create(&path).and_then(|file| write_png(&page::sheet(&drawn), file));
    written.map_err(|error| cannot_write(&path, &error))?;
    let path = out_dir.join("index.html");
    std::fs::write(&path, page::html(scene.name(), &gpu.describe(), &pictures))
        .map_err(|error| cannot_write(&path, &error))?;
    Ok(pictures)
}

fn cannot_write(path: &Path, error: &dyn std::fmt::Display) -> DisplayError {
    DisplayError::Write {
        path: PathBuf::from(path),
        detail: error.to_string(),
    }
}
