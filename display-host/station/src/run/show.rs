//! Shows the display in this process until the run is over, and then ends the other processes.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use display_host::headless::{self, HeadlessConfig, Observed, Outcome};
use display_host::report::Recorder;
use display_host::window::{self, WindowConfig};
use session::{Recorded, Recording};
use shared_mem::scene::SceneFile;

use super::args::RunArgs;
use super::start::Started;
use crate::args::LanguageName;
use crate::folder::Folder;
use crate::problem::Problem;
use crate::say;
use crate::surgeon::AtWork;
use crate::task::{self, Live};

/// Default length of a headless run, s.
const HEADLESS_SECONDS: f64 = 10.0;
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(1);
/// Time that the display waits for a state.
const PATIENCE_FOR_STATE: Duration = Duration::from_secs(30);

/// A run whose processes have ended.
pub(super) struct Shown<'a> {
    pub(super) args: &'a RunArgs,
    pub(super) out: Option<PathBuf>,
    /// Holds the scene and the station's lock until the report is written.
    pub(super) _folder: Folder,
    pub(super) scene: SceneFile,
    pub(super) recorder: Recorder,
    pub(super) outcome: Outcome,
    /// Messages about processes that died by themselves.
    pub(super) dead: Vec<String>,
    pub(super) recorded: Option<Recorded>,
    pub(super) assessed: Option<task::Ended>,
}

impl<'a> Started<'a> {
    pub(super) fn show(mut self) -> Result<Shown<'a>, Problem> {
        let mut recorder = Recorder::new();
        let outcome = self.display(&mut recorder);
        let dead = self.watch.end();
        if let Some(why) = self.surgeon.take().and_then(AtWork::end) {
            say::note(format_args!("calot: the surgeon gave up: {why}"));
        }
        let recorded = self.recording.map(Recording::end);
        // The end of the recording also ends the assessment.
        let assessed = self.live.map(Live::end);
        let mut outcome = outcome?;
        if matches!(recorded, Some(None)) {
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
            recorded: recorded.flatten(),
            assessed: assessed.flatten(),
        })
    }

    fn display(&self, recorder: &mut Recorder) -> Result<Outcome, Problem> {
        let mut said = Instant::now();
        let mut observe = |observed: Observed<'_>| {
            match &observed {
                Observed::Progress(text) if said.elapsed() >= PROGRESS => {
                    say::note(format_args!("{text}"));
                    said = Instant::now();
                }
                Observed::Warning(text) => say::note(format_args!("warning: {text}")),
                Observed::Scope(rad) => self.sight.tell(*rad),
                // The controller ends while the last pictures are drawn.
                Observed::Over => self.watch.over.store(true, Ordering::Relaxed),
                _ => {}
            }
            recorder.observe(&observed);
        };
        Ok(match self.args.headless {
            true => headless::run(&self.headless(), &self.stop, &mut observe)?,
            false => window::run(&self.window(), &self.stop, &mut observe)?,
        })
    }

    fn headless(&self) -> HeadlessConfig {
        let args = self.args;
        HeadlessConfig {
            station: self.station.clone(),
            scene: self.scene.clone(),
            seconds: args.seconds.unwrap_or(HEADLESS_SECONDS),
            out_dir: self.out.as_deref().unwrap_or(Path::new("out")).to_owned(),
            size: args.size,
            frames: args.frames,
            patience: PATIENCE_FOR_STATE,
            tick_cpu: args.controller.realtime.core,
            task_over: self.live.as_ref().map(|task| task.over.clone()),
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
            language: LanguageName::or_users(args.language),
            task: self.live.as_ref().map(|task| task.view.clone()),
            instructor: false,
            replay: None,
            recording: self.recording.as_ref().map(Recording::health),
        }
    }
}
