//! Options of `calot prepare`.

use std::path::PathBuf;

use clap::Args;

use super::mesh::MeshArgs;
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot prepare built-in --out built-in.calot
  calot prepare triangle --budget-us 300 --levels 3 --out triangle.calot
  calot prepare patient:17 --out patient-17.calot
  calot prepare liver.obj --spheres 581 --json report.json --picture liver.png
  calot prepare segmentation.stl --unit mm --axes LPS --pieces largest --out liver.calot
  calot prepare tests/assets/hra-female.toml --meshes DIR --out female.calot")]
pub(crate) struct PrepareArgs {
    /// Scene: `built-in` (liver and gallbladder), `triangle` (with Calot's triangle),
    /// `triangle-variant` (duct and artery take another course), `phantom` (for drills),
    /// `patient:NAME` or `patient:SEED` (a patient; the report begins with her case), a recipe
    /// (.toml) or a mesh (.obj .stl .ply .gltf .glb)
    #[arg(value_name = "RECIPE|MESH")]
    pub(crate) source: String,
    /// Folder with the meshes that the recipe names, e.g. /data/hra [default: folder of the recipe]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
    /// Total number of spheres, e.g. 581. Several organs share it in proportion to the counts of
    /// their recipe
    #[arg(long, value_name = "N")]
    pub(crate) spheres: Option<usize>,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    /// Error budget, mm, 0.05 to 50: use the fewest spheres that keep 95 % of the skin of each
    /// organ within this distance
    #[arg(long, value_name = "MM", value_parser = parse_budget_mm, conflicts_with = "spheres")]
    pub(crate) budget_mm: Option<f64>,
    /// Time budget of a tick, µs, 5 to 1000: use the most spheres that fit
    #[arg(long, value_name = "µs", value_parser = parse_budget_us, conflicts_with = "spheres")]
    pub(crate) budget_us: Option<f64>,
    /// Levels of detail in the file, each with half the spheres of the previous. A machine runs the
    /// finest level that fits [default: those of the recipe]
    #[arg(long, value_name = "N", value_parser = parse_levels)]
    pub(crate) levels: Option<usize>,
    /// File for the compiled scene (.calot) [default: only print the report]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Draw the spheres and links inside translucent organs to this file
    #[arg(long, value_name = "FILE.png", value_parser = parse_png)]
    pub(crate) picture: Option<PathBuf>,
    /// Write the report as JSON to this file; `-` is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}

fn parse_budget_mm(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(mm) if (0.05..=50.0).contains(&mm) => Ok(mm),
        _ => Err("an error budget is 0.05 to 50 mm".into()),
    }
}

fn parse_budget_us(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(us) if (5.0..=1000.0).contains(&us) => Ok(us),
        _ => Err("a time budget is 5 to 1000 µs a tick".into()),
    }
}

fn parse_levels(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(levels) if (1..=shared_mem::scene::LEVELS_MAX).contains(&levels) => Ok(levels),
        _ => Err(format!(
            "a file holds 1 to {} levels",
            shared_mem::scene::LEVELS_MAX
        )),
    }
}

fn parse_png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|e| e.to_str()) {
        Some(extension) if extension.eq_ignore_ascii_case("png") => Ok(path),
        _ => Err("a picture's name ends in .png".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_png() {
        assert_eq!(parse_png("a/b.PNG"), Ok(PathBuf::from("a/b.PNG")));
        for bad in ["", "a", "a.jpg", "png", ".png"] {
            assert!(parse_png(bad).is_err(), "{bad}");
        }
    }
}
