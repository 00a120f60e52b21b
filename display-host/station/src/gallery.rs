//! `calot gallery`.

use std::process::ExitCode;

use crate::cli::{GalleryArgs, SceneArgs};
use crate::say;
use crate::scene::{self, Problem};

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
