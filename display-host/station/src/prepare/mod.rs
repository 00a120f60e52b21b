//! `calot prepare`: compiles a recipe or a mesh to a scene.

pub(crate) mod args;
mod mesh;
mod targets;

use std::path::Path;
use std::process::ExitCode;

use scene_prepare::Prepared;
use scene_prepare::patient::{PREFIX, Patient};
use shared_mem::scene::SceneFile;

use self::args::PrepareArgs;
use crate::build::build;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;
use crate::scene;

/// Size of the picture, pixels: two views side by side.
const PICTURE: [u32; 2] = [1280, 560];

/// Prepares the scene, prints the report, and writes the requested files.
pub(crate) fn run(args: &PrepareArgs) -> Result<ExitCode, Problem> {
    targets::check(
        &args.source,
        &[
            ("--out", Format::Scene, args.out.as_deref()),
            ("--picture", Format::Picture, args.picture.as_deref()),
            ("--json", Format::Json, args.json.as_deref()),
        ],
        args.overwrite,
    )?;
    let mut recipe = scene::recipe(&args.source, args.meshes.as_deref(), &args.mesh.options())?;
    if let Some(spheres) = args.spheres {
        recipe = recipe.with_spheres(spheres)?;
    }
    if let Some(budget_mm) = args.budget_mm {
        for organ in &mut recipe.organs {
            organ.gap_95_m = Some(1e-3 * budget_mm);
        }
    }
    recipe.tick_us = args.budget_us.or(recipe.tick_us);
    let mut prepared = vec![scene::prepare(&recipe.level(0))?];
    if let Some(count) = args.levels {
        let counts: Vec<usize> = prepared[0]
            .report
            .organs
            .iter()
            .map(|o| o.spheres)
            .collect();
        recipe = recipe.with_levels(count, &counts);
    }
    for level in 1..recipe.levels() {
        prepared.push(scene::prepare(&recipe.level(level))?);
    }
    let json = || {
        let mut figures = serde_json::to_value(&prepared[0].report)?;
        let levels: Vec<_> = prepared.iter().skip(1).map(|p| &p.report).collect();
        figures["program"] = build().into();
        figures["coarser_levels"] = serde_json::to_value(levels)?;
        serde_json::to_string_pretty(&document::PREPARATION.of(figures))
    };
    match args.json.as_deref() {
        Some(path) if path == Path::new("-") => say::answer(format_args!("{}", json()?)),
        Some(path) => {
            output::write(path, &(json()? + "\n"))
                .map_err(|error| format!("{}: {error}", path.display()))?;
            tell(&prepared);
        }
        None => {
            if let Some(word) = args.source.strip_prefix(PREFIX) {
                say::answer(format_args!("{}", Patient::of_word(word)?));
            }
            tell(&prepared);
        }
    }
    if let Some(out) = &args.out {
        scene::write(&prepared, out)?;
        let levels = match prepared.len() {
            1 => String::new(),
            n => format!(", {n} levels of detail; the finest that fits its machine runs"),
        };
        say::note(format_args!("wrote {}{levels}", out.display()));
    }
    if let Some(path) = &args.picture {
        let scene = SceneFile::from_bytes(&prepared[0].scene.to_bytes()?)?;
        let picture = display_host::render::inside::picture(&scene, PICTURE)?;
        display_host::picture::write_png(&picture, std::fs::File::create(path)?)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints the report of each level.
fn tell(levels: &[Prepared]) {
    for (level, prepared) in levels.iter().enumerate() {
        if levels.len() > 1 {
            say::answer(format_args!(
                "level {level} of {}, 0 the finest:",
                levels.len()
            ));
        }
        say::answer(format_args!("{}", prepared.report));
    }
}
