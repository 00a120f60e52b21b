//! Prepares a run before anything starts: checks names, makes folders, compiles the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hardware::station::StationFile;
use shared_mem::service::Station;

use display_host::window;

use super::args::{RunArgs, session_path};
use super::free_space;
use super::player::Player;
use crate::args::DeviceArgs;
use crate::centre::Centre;
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
    /// The centre to which the station is reported, if there is one.
    pub(super) centre: Option<Centre>,
}

impl<'a> Planned<'a> {
    pub(super) fn new(args: &'a RunArgs) -> Result<Self, Problem> {
        if !args.headless {
            window::answers()?;
        }
        let stop = stop::flag()?;
        let station = Station::new(&args.station)?;
        let player = Player::of(args)?;
        let centre = Centre::of(args)?;
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
            free_space::check(&path, std::fs::metadata(&scene)?.len(), seconds)?;
        }
        if let Some(unfelt) = Unfelt::of(&args.controller.devices) {
            say::note(format_args!("calot: {}", unfelt.in_words()));
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
            centre,
        })
    }
}

/// A named haptic device whose station file does not say that it passed its test by hand.
struct Unfelt {
    path: PathBuf,
    /// Checks that it did not pass, if the record names them.
    failed: Vec<String>,
}

impl Unfelt {
    fn of(devices: &DeviceArgs) -> Option<Self> {
        if let Some(path) = &devices.haptic {
            return Some(Self {
                path: path.clone(),
                failed: Vec::new(),
            });
        }
        // A station file with an error is refused later.
        let file = StationFile::read(devices.station_file.as_deref()?).ok()?;
        let spec = file.haptic.filter(|it| !it.is_felt)?;
        Some(Self {
            path: spec.path,
            failed: spec.failed_felt.unwrap_or_default(),
        })
    }

    fn in_words(&self) -> String {
        let path = self.path.display();
        match self.failed.as_slice() {
            [] => format!(
                "no record says that {path} passed `calot devices feel`: its axes and forces are \
                 untested. A station file keeps the record"
            ),
            failed => format!(
                "{path} did not pass `calot devices feel` ({}): mend it and test it again before \
                 you trust its forces",
                failed.join(", ")
            ),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_test_by_hand_is_reported_with_its_checks() {
        let unfelt = |failed: &[&str]| Unfelt {
            path: PathBuf::from("/dev/ttyACM0"),
            failed: failed.iter().map(|&it| it.to_owned()).collect(),
        };
        let said = unfelt(&["push up", "velocity"]).in_words();
        assert!(said.contains("did not pass"), "{said}");
        assert!(said.contains("(push up, velocity): mend it"), "{said}");
        let said = unfelt(&[]).in_words();
        assert!(said.contains("are untested"), "{said}");
    }
}
