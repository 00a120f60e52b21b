//! Before anything starts: names are checked, folders are made, the scene is compiled.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use shared_mem::service::Station;

use super::args::RunArgs;
use crate::folder::Folder;
use crate::problem::Problem;
use crate::scene;
use crate::stop;
use crate::task::Assigned;

/// A run of which no process has started.
pub(super) struct Planned<'a> {
    pub(super) args: &'a RunArgs,
    pub(super) stop: Arc<AtomicBool>,
    pub(super) station: Station,
    /// The task, if there is one.
    pub(super) assigned: Option<Assigned>,
    /// Folder of the results, if they are written.
    pub(super) out: Option<PathBuf>,
    pub(super) folder: Folder,
    /// The compiled scene.
    pub(super) scene: PathBuf,
}

impl<'a> Planned<'a> {
    pub(super) fn new(args: &'a RunArgs) -> Result<Self, Problem> {
        let stop = stop::flag()?;
        let station = Station::new(&args.station)?;
        let assigned = Assigned::read(&args.task)?;
        let out = results(args, assigned.as_ref());
        if let Some(out) = &out {
            // Before anything starts: a run whose results cannot be written is a run lost.
            std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
        }
        let folder = Folder::open(&args.station, args.attach)?;
        let scene = scene::compile(&args.scene, &folder.scene())?;
        Ok(Self {
            args,
            stop,
            station,
            assigned,
            out,
            folder,
            scene,
        })
    }
}

/// Folder of the results.
fn results(args: &RunArgs, assigned: Option<&Assigned>) -> Option<PathBuf> {
    args.out
        .clone()
        // A folder for each session of a task: the next one may be somebody else's.
        .or_else(|| assigned.map(|it| Path::new("out").join(it.id())))
        .or_else(|| args.headless.then(|| PathBuf::from("out")))
}
