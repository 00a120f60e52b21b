//! Starts the recorder, the processes, the task and its scripted surgeon.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

use display_host::report::DeviceSummary;
use session::{Acts, Listening, Recording, Sight};
use shared_mem::scene::SceneFile;
use shared_mem::service::Station;

use super::args::{RunArgs, session_path};
use super::desk::{Desk, Terms};
use super::plan::Planned;
use super::processes::{self, Running};
use super::watch::Watch;
use crate::build::build;
use crate::centre::{Centre, Told};
use crate::folder::Folder;
use crate::problem::Problem;
use crate::surgeon::AtWork;
use crate::task::{self, Assigned, Live};

/// A run whose processes have started.
pub(super) struct Started<'a> {
    pub(super) args: &'a RunArgs,
    pub(super) stop: Arc<AtomicBool>,
    pub(super) station: Station,
    pub(super) out: Option<PathBuf>,
    pub(super) folder: Folder,
    /// Level of the scene that runs.
    pub(super) scene: PathBuf,
    /// Content of the file `scene`, because the report needs it even if somebody removes the file.
    pub(super) open_scene: SceneFile,
    pub(super) live: Option<Live>,
    pub(super) recording: Option<Recording>,
    /// Passes the viewing angle of the endoscope to the recording.
    pub(super) sight: Sight,
    /// Answers instructors. `None` with `--attach`: there the run that started the station answers.
    pub(super) desk: Option<Desk>,
    pub(super) watch: Watch,
    /// Warnings about the controller, for the summary.
    pub(super) warnings: Vec<String>,
    /// Devices that the controller opened.
    pub(super) devices: Vec<DeviceSummary>,
    pub(super) surgeon: Option<AtWork>,
    /// Tells a centre of this station.
    pub(super) told: Option<Told>,
}

impl<'a> Planned<'a> {
    pub(super) fn start(self) -> Result<Started<'a>, Problem> {
        let Self {
            args,
            stop,
            station,
            player,
            assigned,
            out,
            folder,
            scene,
            centre,
        } = self;
        let listening = match session_path(args, out.as_deref()) {
            // The recorder must be ready before the controller: replay needs the first tick.
            Some(path) => Some((path, listen(args, &station)?)),
            None => None,
        };
        let Running {
            children,
            scene,
            warnings,
            devices,
            ..
        } = match args.attach {
            true => Running {
                children: Vec::new(),
                scene, // the user names the scene of the running station
                warnings: Vec::new(),
                devices: Vec::new(),
                admitted_ns: None,
            },
            false => processes::start(args, player, &scene, folder.path(), &stop)?,
        };
        folder.announce_scene(&scene)?;
        let open_scene = SceneFile::open(&scene)?;
        let assignment = assigned.as_ref().map(Assigned::assignment);
        let task = assigned.as_ref().map(Assigned::task);
        let difficulty = assigned.as_ref().map(Assigned::difficulty);
        let begins = assigned.as_ref().and_then(Assigned::start);
        let live = assigned.map(|it| it.begin(&SceneFile::open(&scene)?, &station));
        let (live, course) = live.transpose()?.unzip();
        let (sight, acts) = (Sight::default(), Acts::default());
        let (hears, news) = mpsc::channel();
        let recording = match listening {
            Some((path, listening)) => Some(listening.record(session::Config {
                path,
                build: build(),
                scene: SceneFile::open(&scene)?,
                assignment,
                sight: sight.clone(),
                acts: acts.clone(),
                course,
                hears: Some(hears),
            })?),
            None => None,
        };
        let terms = Terms::new(difficulty, recording.as_ref().map(Recording::health));
        let desk = match args.attach {
            true => None,
            false => Some(Desk::begin(&station, terms, acts, news)?),
        };
        let watch = Watch::begin(children, stop.clone());
        if let Some(begins) = begins
            && let Err(problem) = task::start(begins, &station)
        {
            watch.end();
            return Err(problem);
        }
        let surgeon = match (task, args.task.hand) {
            (Some(task), Some(hand)) => {
                let scene = SceneFile::open(&scene)?;
                Some(AtWork::begin(hand, task, &station, scene)?)
            }
            _ => None,
        };
        Ok(Started {
            args,
            stop,
            station,
            out,
            folder,
            scene,
            open_scene,
            live,
            recording,
            sight,
            desk,
            watch,
            warnings,
            devices,
            surgeon,
            told: centre.map(Centre::tell).transpose()?,
        })
    }
}

fn listen(args: &RunArgs, station: &Station) -> Result<Listening, Problem> {
    Ok(Listening::begin(
        station,
        display_host::priority::step_aside,
        args.controller.realtime.core,
    )?)
}
