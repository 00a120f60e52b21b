//! Prepares a run before anything starts: checks names, makes folders, compiles the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hardware::station::StationFile;
use shared_mem::service::Station;

use display_host::window;

use super::args::{RunArgs, session_path};
use super::player::Player;
use super::room;
use crate::args::DeviceArgs;
use crate::folder::Folder;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;
use crate::scene;
use crate::stop;
use crate::task::Assigned;

/// A run before its processes start.
pub(super) struct Planned<'a> {
    pub(super) args: &'a RunArgs,
    pub(super) stop: Arc<AtomicBool>,
    pub(super) station: Station,
    pub(super) player: Player,
    /// Task, if there is one.
    pub(super) assigned: Option<Assigned>,
    /// Folder of the results, if they are written.
    pub(super) out: Option<PathBuf>,
    pub(super) folder: Folder,
    /// File of the compiled scene.
    pub(super) scene: PathBuf,
}

impl<'a> Planned<'a> {
    pub(super) fn new(args: &'a RunArgs) -> Result<Self, Problem> {
        if !args.headless {
            window::answers()?;
        }
        let stop = stop::flag()?;
        let station = Station::new(&args.station)?;
        let player = Player::of(args)?;
        let assigned = Assigned::read(&args.task, player.is_scripted())?;
        let out = results(args, assigned.as_ref())?;
        if let Some(path) = &args.record {
            output::check("--record", path, Format::Session, args.overwrite)?;
        }
        if let Some(path) = &args.gif {
            output::check("--gif", path, Format::Animation, args.overwrite)?;
        }
        let folder = Folder::open(&args.station, args.attach)?;
        if !args.attach {
            station.check_room()?;
        }
        let scene = scene::compile(&args.scene, &folder.scene())?;
        if let Some(path) = session_path(args, out.as_deref()) {
            session::check_target(&path)?;
            let seconds = match args.headless {
                true => Some(args.headless_s()),
                false => args.seconds,
            };
            room::check(&path, std::fs::metadata(&scene)?.len(), seconds)?;
        }
        if let Some(device) = unfelt(&args.controller.devices) {
            say::note(format_args!(
                "calot: no record says that {} passed `calot devices feel`: its axes and forces are \
                 untested. A station file keeps the record",
                device.display()
            ));
        }
        Ok(Self {
            args,
            stop,
            station,
            player,
            assigned,
            out,
            folder,
            scene,
        })
    }
}

/// Path of the named haptic device, unless the station file says that it passed its test by hand.
fn unfelt(devices: &DeviceArgs) -> Option<PathBuf> {
    if let Some(path) = &devices.haptic {
        return Some(path.clone());
    }
    // A station file with an error is refused later.
    let file = StationFile::read(devices.station_file.as_deref()?).ok()?;
    let spec = file.haptic.filter(|it| !it.is_felt)?;
    Some(spec.path)
}

/// Makes the folder of the results. `None` if the run writes none.
fn results(args: &RunArgs, assigned: Option<&Assigned>) -> Result<Option<PathBuf>, Problem> {
    // Each session of a task has its own folder, because the next session may be of another
    // trainee.
    let of_task = assigned.map(|it| Path::new("out").join(it.id()));
    let named = args.out.as_deref().or(of_task.as_deref());
    if named.is_none() && !args.headless {
        return Ok(None);
    }
    output::folder(named, "out", Format::of_result, args.overwrite).map(Some)
}
