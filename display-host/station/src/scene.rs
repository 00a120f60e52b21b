//! Turns a scene that the user names into a compiled scene on disk.

use std::path::{Path, PathBuf};

use assess::report::Case;
use scene_prepare::patient::{PREFIX, Patient};
use scene_prepare::recipe::MeshOptions;
use scene_prepare::{Prepared, Progress, Recipe};
use shared_mem::scene::{SceneData, SceneFile};

use crate::args::SceneArgs;
use crate::kept::Kept;
use crate::problem::Problem;
use crate::say;

/// Number of coarser levels to try if a scene does not fit the machine.
const COARSER_LEVELS: u32 = 2;

/// Compiles the named scene to `target`, or returns the path of a scene that is compiled already.
pub(crate) fn compile(args: &SceneArgs, target: &Path) -> Result<PathBuf, Problem> {
    let named = Path::new(&args.scene);
    // `x.calot#1` is level 1 of the file `x.calot`.
    let file = args
        .scene
        .rsplit_once('#')
        .map_or(named, |(file, _)| Path::new(file));
    if has_extension(named, &["calot"]) || has_extension(file, &["calot"]) {
        SceneFile::open(named)?;
        return Ok(named.to_owned());
    }
    let recipe = recipe(&args.scene, args.meshes.as_deref(), &MeshOptions::default())?;
    bring(&recipe, target)?;
    Ok(target.to_owned())
}

/// Writes a recipe's compiled scene to `target`: from the cache, or prepared and then cached.
pub(crate) fn bring(recipe: &Recipe, target: &Path) -> Result<(), Problem> {
    let kept = Kept::of(recipe);
    if kept.as_ref().is_some_and(|kept| kept.fetch(target)) {
        return Ok(());
    }
    write(&levels(recipe)?, target)?;
    if let Some(kept) = kept {
        kept.keep(target);
    }
    Ok(())
}

/// Opens the named scene if it is compiled. Otherwise compiles its finest level, in memory only.
pub(crate) fn in_memory(args: &SceneArgs) -> Result<SceneFile, Problem> {
    let file = args.scene.split_once('#').map_or(&*args.scene, |(f, _)| f);
    if has_extension(Path::new(file), &["calot"]) {
        return Ok(SceneFile::open(Path::new(&args.scene))?);
    }
    let recipe = recipe(&args.scene, args.meshes.as_deref(), &MeshOptions::default())?;
    let prepared = prepare(&recipe.level(0))?;
    Ok(SceneFile::from_bytes(&prepared.scene.to_bytes()?)?)
}

/// Recipe of the scene with half the spheres at level 1 and a quarter at level 2. Returns `None` if
/// there is no such level: the scene is compiled already, or has too few spheres.
pub(crate) fn coarser(args: &SceneArgs, level: u32) -> Option<Recipe> {
    if level > COARSER_LEVELS {
        return None;
    }
    let recipe = recipe(&args.scene, args.meshes.as_deref(), &MeshOptions::default()).ok()?;
    let spheres: usize = recipe.organs.iter().map(|organ| organ.spheres).sum();
    recipe.with_spheres(spheres >> level).ok()
}

/// Recipe of a name: the built-in one, a recipe file, or one made for a mesh.
pub(crate) fn recipe(
    source: &str,
    meshes: Option<&Path>,
    mesh: &MeshOptions,
) -> Result<Recipe, Problem> {
    let path = Path::new(source);
    let is_mesh = has_extension(path, &["obj", "stl", "ply", "gltf", "glb"]);
    if !is_mesh && *mesh != MeshOptions::default() {
        return Err(format!(
            "{source}: --unit, --scale, --axes, --kind, --pieces, --closing and --part are for a single mesh; a \
             recipe says them of each organ, by the same names"
        )
        .into());
    }
    if source == "built-in" {
        return Ok(Recipe::built_in()?);
    }
    if source == "triangle" || source == "triangle-variant" {
        return Ok(Recipe::triangle(source != "triangle")?);
    }
    if source == "phantom" {
        return Ok(Recipe::phantom()?);
    }
    if let Some(word) = source.strip_prefix(PREFIX) {
        return Ok(Patient::of_word(word)?.recipe()?);
    }
    if has_extension(path, &["toml"]) {
        return Ok(Recipe::load(path, meshes)?);
    }
    if is_mesh {
        return Ok(Recipe::from_mesh(path, mesh)?);
    }
    Err(format!(
        "'{source}' is not a scene: name `built-in`, `triangle`, `triangle-variant`, `phantom`, `patient:NAME` or `patient:SEED`, a recipe \
         (.toml), a mesh (.obj .stl .ply .gltf .glb), or a compiled scene (.calot)"
    )
    .into())
}

/// The case of the scene with this name, if it is a patient of the generator.
pub(crate) fn case(scene: &str) -> Option<Case> {
    let patient = Patient::of_word(scene.strip_prefix(PREFIX)?).ok()?;
    Some(Case {
        bmi: patient.bmi,
        course: patient.course_word().to_owned(),
        wall: patient.wall.word().to_owned(),
        stones: patient.stones.count,
        stone_mm: patient.stones.size_mm,
        name: patient.name,
    })
}

/// Prepares every level of detail, finest first. The progress runs once from 0 to 100 %.
pub(crate) fn levels(recipe: &Recipe) -> Result<Vec<Prepared>, Problem> {
    let levels = (0..recipe.levels()).map(|level| recipe.level(level));
    let levels: Vec<Recipe> = levels.collect();
    let spheres = |it: &Recipe| it.organs.iter().map(|organ| organ.spheres).sum();
    let spheres: Vec<usize> = levels.iter().map(spheres).collect();
    let each = levels.iter().zip(parts(&spheres));
    each.map(|(level, part)| prepare_part(level, part))
        .collect()
}

/// Beginning and end of each level's part of the progress, 0..=1, by the level's spheres.
fn parts(spheres: &[usize]) -> Vec<[f64; 2]> {
    let all = spheres.iter().sum::<usize>().max(1) as f64;
    let mut end = 0;
    let part = |it: &usize| {
        let begin = end;
        end += it;
        [begin as f64 / all, end as f64 / all]
    };
    spheres.iter().map(part).collect()
}

/// Writes the levels to one file.
pub(crate) fn write(levels: &[Prepared], path: &Path) -> Result<(), Problem> {
    let scenes: Vec<SceneData> = levels.iter().map(|level| level.scene.clone()).collect();
    SceneData::write_levels(&scenes, path)?;
    Ok(())
}

/// Prepares a scene. Shows progress on standard error, after 1 s and then every 0.5 s.
pub(crate) fn prepare(recipe: &Recipe) -> Result<Prepared, Problem> {
    prepare_part(recipe, [0.0, 1.0])
}

/// Prepares a scene as [`prepare`] does. It is the part `begin` to `end` of the whole progress.
fn prepare_part(recipe: &Recipe, [begin, end]: [f64; 2]) -> Result<Prepared, Problem> {
    let start = std::time::Instant::now();
    let first = std::time::Duration::from_millis(500);
    let mut said = first;
    let prepared = scene_prepare::prepare(recipe, &mut |Progress { doing, done }| {
        let elapsed = start.elapsed();
        if elapsed >= said + std::time::Duration::from_millis(500) {
            let percent = 100.0 * (begin + (end - begin) * done);
            say::note(format_args!("preparing {percent:3.0} %  {doing}"));
            said = elapsed;
        }
    })?;
    // The last of the lines above may tell any share, and the launcher waits for the whole.
    if said > first {
        say::note(format_args!("preparing {:3.0} %", 100.0 * end));
    }
    Ok(prepared)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension()
        .and_then(|extension| extension.to_str())
        .is_some_and(|extension| extensions.iter().any(|e| e.eq_ignore_ascii_case(extension)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_courses_of_duct_and_artery_have_a_name() {
        let usual = recipe("triangle", None, &MeshOptions::default()).unwrap();
        let variant = recipe("triangle-variant", None, &MeshOptions::default()).unwrap();
        assert_ne!(usual.organs, variant.organs);
    }

    #[test]
    fn the_progress_of_the_levels_never_goes_back() {
        let parts = parts(&[400, 200, 100]);
        let ends = [0.0, 4.0, 4.0, 6.0, 6.0, 7.0].map(|it| it / 7.0);
        for (found, expected) in parts.as_flattened().iter().zip(ends) {
            assert!((found - expected).abs() < 1e-12, "{parts:?}");
        }
    }

    /// Bile that takes stones along is the bile that picture and metrics have.
    #[test]
    fn stones_leave_with_the_flow_of_the_built_in_rules() {
        use shared_mem::scene::OrganKind;
        let rules = assess::Rules::default();
        let ml_min = rules.flow_ml_min(Some(OrganKind::Gallbladder));
        let core_ml_min = 60.0e6 * f64::from(rt_core::procedure::stones::FULL_FLOW_M3_S);
        assert!((core_ml_min / ml_min - 1.0).abs() < 1e-6, "{core_ml_min}");
    }

    #[test]
    fn a_patient_s_recipe_has_the_stones_of_her_case() {
        let clara = recipe("patient:clara", None, &MeshOptions::default()).unwrap();
        let stones = clara.stones.unwrap();
        assert_eq!(stones.count, case("patient:clara").unwrap().stones);
        assert!((stones.diameter_m - 0.004).abs() < 1e-9, "{stones:?}");
        let triangle = recipe("triangle", None, &MeshOptions::default()).unwrap();
        assert_eq!(triangle.stones, None);
    }

    #[test]
    fn only_patients_have_a_case() {
        let frieda = case("patient:frieda").unwrap();
        assert_eq!((frieda.stones, frieda.wall.as_str()), (2, "scarred"));
        assert_eq!(frieda.course, "humped-artery");
        assert_eq!(case("patient:7").unwrap().name, "7");
        assert!(case("triangle").is_none() && case("patient:zoe").is_none());
    }

    #[test]
    fn patients_have_names_and_seeds() {
        let of = |source: &str| recipe(source, None, &MeshOptions::default());
        assert_eq!(of("patient:ada").unwrap().name, "patient:ada");
        assert_eq!(of("patient:7").unwrap(), of("patient:7").unwrap());
        assert_ne!(of("patient:7").unwrap(), of("patient:8").unwrap());
        let error = of("patient:zoe").unwrap_err().to_string();
        assert!(
            error.contains("is 'zoe'; allowed: a seed of 0 to"),
            "{error}"
        );
        assert!(error.contains("ada, berta"), "{error}");
    }

    #[test]
    fn coarser_levels_halve_the_spheres_until_there_are_none() {
        let of = |scene: &str, level| {
            let scene = scene.to_owned();
            let recipe = coarser(
                &SceneArgs {
                    scene,
                    meshes: None,
                },
                level,
            )?;
            Some(
                recipe
                    .organs
                    .iter()
                    .map(|organ| organ.spheres)
                    .sum::<usize>(),
            )
        };
        let finest = of("built-in", 0).unwrap();
        let half = of("built-in", 1).unwrap();
        assert!(half.abs_diff(finest / 2) < 4 && of("built-in", 2) < Some(half));
        assert_eq!(of("built-in", 3), None);
        assert_eq!(of("compiled.calot", 1), None);
    }

    #[test]
    fn a_file_that_is_no_scene_is_refused() {
        for source in ["", "liver", "scene.yaml", "built_in"] {
            let error = recipe(source, None, &MeshOptions::default())
                .unwrap_err()
                .to_string();
            assert!(error.contains("is not a scene"), "{error}");
        }
    }
}
