//! Shows the display in this process until the run is over, and then ends the other processes.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use display_host::DisplayError;
use display_host::headless::{self, HeadlessConfig, Observed, RunOutcome};
use display_host::report::{DeviceSummary, Recorder};
use display_host::window::{self, WindowConfig};
use session::{Recorded, Recording};
use shared_mem::scene::SceneFile;

use super::args::RunArgs;
use super::player;
use super::start::Started;
use crate::centre::Told;
use crate::folder::Folder;
use crate::problem::Problem;
use crate::say;
use crate::settings;
use crate::surgeon::AtWork;
use crate::task::{self, Live};

/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);
/// Time that the display waits for a state.
const PATIENCE_FOR_STATE: Duration = Duration::from_secs(30);

/// Locks the recorder, even if the window's thread has panicked.
fn lock(recorder: &Mutex<Recorder>) -> MutexGuard<'_, Recorder> {
    recorder.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A run whose processes have ended.
pub(super) struct Shown<'a> {
    pub(super) args: &'a RunArgs,
    pub(super) out: Option<PathBuf>,
    /// Folder of the station, which keeps the scene and the lock until the report is written.
    pub(super) _folder: Folder,
    pub(super) scene: SceneFile,
    pub(super) recorder: Recorder,
    pub(super) outcome: RunOutcome,
    /// Messages about processes that died by themselves.
    pub(super) dead: Vec<String>,
    /// True if a thread of the recorder panicked, so that nothing is known of the recording.
    pub(super) recorder_panicked: bool,
    pub(super) recorded: Option<Recorded>,
    pub(super) assessed: Option<task::Ended>,
    /// Devices that the controller opened.
    pub(super) devices: Vec<DeviceSummary>,
    /// Reports this station to a centre, until the run's results are in the store.
    pub(super) told: Option<Told>,
}

impl<'a> Started<'a> {
    pub(super) fn show(mut self) -> Result<Shown<'a>, Problem> {
        let recorder = Arc::new(Mutex::new(Recorder::new()));
        let outcome = self.display(&recorder);
        // Close the desk before the recording ends, so that every accepted act is recorded.
        drop(self.desk.take());
        let dead = self.watch.end();
        if let Some(why) = self.surgeon.take().and_then(AtWork::end) {
            say::note(format_args!("calot: the surgeon gave up: {why}"));
        }
        let recorded = self.recording.map(Recording::end);
        // The end of the recording also ends the assessment.
        let assessed = self.live.map(Live::end);
        let mut outcome = outcome.unwrap_or_else(|lost| RunOutcome::lost(lost.to_string()));
        let recorder = std::mem::take(&mut *lock(&recorder));
        outcome.warnings.extend(self.warnings);
        let recorder_panicked = matches!(recorded, Some(None));
        if recorder_panicked {
            let warning = "the recorder panicked; please report this";
            outcome.warnings.push(warning.to_owned());
        }
        Ok(Shown {
            args: self.args,
            out: self.out,
            _folder: self.folder,
            scene: self.open_scene,
            recorder,
            outcome,
            dead,
            recorder_panicked,
            recorded: recorded.flatten(),
            assessed: assessed.flatten(),
            devices: self.devices,
            told: self.told,
        })
    }

    fn display(&self, recorder: &Arc<Mutex<Recorder>>) -> Result<RunOutcome, DisplayError> {
        let mut said = Instant::now();
        let (recorder, sight, over) = (
            recorder.clone(),
            self.sight.clone(),
            self.watch.over.clone(),
        );
        let mut observe = move |observed: Observed<'_>| {
            match &observed {
                Observed::Progress(text) if said.elapsed() >= PROGRESS => {
                    say::note(format_args!("{text}"));
                    said = Instant::now();
                }
                Observed::Warning(text) => say::note(format_args!("warning: {text}")),
                Observed::Scope(rad) => sight.tell(*rad),
                Observed::Settings(changed) => settings::keep(changed),
                // The controller ends while the last pictures are drawn.
                Observed::Over => over.store(true, Ordering::Relaxed),
                _ => {}
            }
            lock(&recorder).observe(&observed);
        };
        match self.args.headless {
            true => headless::run(&self.headless(), &self.stop, &mut observe),
            false => window::run_apart(self.window(), self.stop.clone(), observe),
        }
    }

    fn headless(&self) -> HeadlessConfig {
        let args = self.args;
        HeadlessConfig {
            station: self.station.clone(),
            scene: self.scene.clone(),
            seconds: args.headless_s(),
            out_dir: self.out.as_deref().unwrap_or(Path::new("out")).to_owned(),
            size: args.size,
            frames: args.frames,
            patience: PATIENCE_FOR_STATE,
            tick_cpu: args.controller.realtime.core,
            task_over: self.live.as_ref().map(|task| task.over.clone()),
            task: self.live.as_ref().map(|task| task.view.clone()),
            need_pictures: false,
        }
    }

    fn window(&self) -> WindowConfig {
        let args = self.args;
        WindowConfig {
            station: self.station.clone(),
            scene: self.scene.clone(),
            size: args.size.unwrap_or([1280, 720]),
            scope_angle: args.scope.radians(),
            cold_lens: args.cold_lens,
            muted: args.mute,
            seconds: args.seconds,
            lose_device_after: None,
            tick_cpu: args.controller.realtime.core,
            settings: args.look.settings(args.language),
            task: self.live.as_ref().map(|task| task.view.clone()),
            pictures: self.out.clone(),
            instructor: false,
            watched: self.surgeon.is_some(),
            simulated: player::simulated(args),
            replayed_task: None,
            acts: self.desk.as_ref().map(|desk| desk.view.clone()),
            replay: None,
            recording: self.recording.as_ref().map(Recording::health),
            patch: None,
        }
    }
}
