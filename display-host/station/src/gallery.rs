//! `calot gallery`: pictures of everything that a scene can show.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::args::{SceneArgs, parse_size};
use crate::output::{self, Format, Overwrite};
use crate::problem::Problem;
use crate::say;
use crate::scene;

/// Options of `calot gallery`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  calot gallery --out gallery      writes pictures and gallery/index.html")]
pub(crate) struct GalleryArgs {
    /// Scene: a name or a file, as for `calot run`
    #[arg(long, value_name = "NAME|FILE", default_value = "triangle")]
    pub(crate) scene: String,
    /// Folder with the meshes that the recipe names, e.g. /data/hra [default: folder of the recipe]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
    /// Folder for the pictures and for index.html, which shows them
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Size of a picture, pixels, e.g. 1280x720 [default: 1280x720 on a graphics card, 640x480 on a
    /// software driver]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
}

/// Draws every organ, instrument and view of a scene, and prints the path of the page that shows
/// them.
pub(crate) fn run(args: &GalleryArgs) -> Result<ExitCode, Problem> {
    output::check_folder("--out", &args.out, Format::of_gallery, args.overwrite)?;
    let scene = scene::in_memory(&SceneArgs {
        scene: args.scene.clone(),
        meshes: args.meshes.clone(),
    })?;
    let pictures =
        display_host::gallery::make(&scene, &args.out, args.size, &mut |title, done| {
            say::note(format_args!("drawing {:3.0} %  {title}", done * 100.0));
        })?;
    say::answer(format_args!(
        "wrote {} pictures; open {}",
        pictures.len(),
        args.out.join("index.html").display()
    ));
    Ok(ExitCode::SUCCESS)
}
