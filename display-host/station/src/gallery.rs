//! `calot gallery`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::args::{SceneArgs, parse_size};
use crate::problem::Problem;
use crate::say;
use crate::scene;

/// What `calot gallery` takes.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Example:
  calot gallery --out gallery      then open gallery/index.html")]
pub(crate) struct GalleryArgs {
    /// The scene, named as for `calot run`
    #[arg(long, value_name = "NAME|FILE", default_value = "triangle")]
    pub(crate) scene: String,
    /// Folder that holds the meshes which the recipe names [default: the recipe's own]
    #[arg(long, value_name = "DIR")]
    pub(crate) meshes: Option<PathBuf>,
    /// Where the pictures and their page go
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Size of a picture [default: 1280x720 on a graphics card, 640x480 on a software driver]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
}

/// Draws every organ, instrument and view of a scene, and says where to look.
pub(crate) fn run(args: &GalleryArgs) -> Result<ExitCode, Problem> {
    let scene = scene::in_memory(&SceneArgs {
        scene: args.scene.clone(),
        meshes: args.meshes.clone(),
    })?;
    let pictures =
        display_host::gallery::make(&scene, &args.out, args.size, &mut |title, done| {
            say::note(format_args!("drawing {:3.0} %  {title}", done * 100.0));
        })?;
    say::answer(format_args!(
        "{} pictures; look at {}",
        pictures.len(),
        args.out.join("index.html").display()
    ));
    Ok(ExitCode::SUCCESS)
}
