//! `calot prepare`.

use std::path::Path;
use std::process::ExitCode;

use shared_mem::scene::SceneFile;

use crate::cli::PrepareArgs;
use crate::say;
use crate::scene::{self, Problem};

/// Size of the picture, pixels: two views side by side.
const PICTURE: [u32; 2] = [1280, 560];

/// Prepares, prints the report, writes what was asked for.
pub(crate) fn run(args: &PrepareArgs) -> Result<ExitCode, Problem> {
    let mut recipe = scene::recipe(&args.source, args.meshes.as_deref(), args.unit)?;
    if let Some(spheres) = args.spheres {
        recipe = recipe.with_spheres(spheres)?;
    }
    let prepared = scene::prepare(&recipe)?;
    let json = || serde_json::to_string_pretty(&prepared.report);
    match args.json.as_deref() {
        Some(path) if path == Path::new("-") => say::answer(format_args!("{}", json()?)),
        Some(path) => {
            std::fs::write(path, json()? + "\n")
                .map_err(|error| format!("{}: {error}", path.display()))?;
            say::answer(format_args!("{}", prepared.report));
        }
        None => say::answer(format_args!("{}", prepared.report)),
    }
    if let Some(out) = &args.out {
        prepared.scene.write(out)?;
        say::note(format_args!("wrote {}", out.display()));
    }
    if let Some(path) = &args.picture {
        let scene = SceneFile::from_bytes(&prepared.scene.to_bytes()?)?;
        let picture = display_host::render::inside::picture(&scene, PICTURE)?;
        picture
            .save(path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}
