//! `calot run`: starts the processes, becomes the display, ends them, and reports.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use display_host::headless::{self, Ended, HeadlessConfig, Observed, Outcome};
use display_host::report::{Machine, Recorder, write};
use display_host::window::{self, WindowConfig};
use hardware::station::StationFile;
use session::{Listening, Recorded, Recording, Sight};
use shared_mem::scene::SceneFile;
use shared_mem::service::Station;

use crate::build::build;
use crate::children::{EndedEarly, Process, args as words, option};
use crate::cli::{DeviceArgs, LanguageName, RunArgs};
use crate::report;
use crate::rt::DOES_NOT_FIT;
use crate::say;
use crate::scene::{self, Problem};
use crate::stop;
use crate::surgeon::AtWork;
use crate::task::{self, Assigned, Live};

/// A headless run's length when none is given, s.
const HEADLESS_SECONDS: f64 = 10.0;
/// How long a child may take to be ready: a real device's handshake takes seconds.
const PATIENCE_TO_START: Duration = Duration::from_secs(60);
/// How often a waiting user is told how far it is.
const PROGRESS: Duration = Duration::from_secs(1);
/// How long the display waits for a state.
const PATIENCE_FOR_STATE: Duration = Duration::from_secs(30);
/// How often, and after which pause, a station's lock is tried again.
const LOCK_LOOKS: u32 = 5;
/// See [`LOCK_LOOKS`].
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// Runs the station. The exit code tells whether it ran to its end.
pub(crate) fn run(args: &RunArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    let station = Station::new(&args.station)?;
    let assigned = Assigned::read(&args.task)?;
    let out = args
        .out
        .clone()
        // A folder for each session of a task: the next one may be somebody else's.
        .or_else(|| assigned.as_ref().map(|it| Path::new("out").join(it.id())))
        .or_else(|| args.headless.then(|| PathBuf::from("out")));
    if let Some(out) = &out {
        // Before anything starts: a run whose results cannot be written is a run lost.
        std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    }
    let folder = Folder::open(&args.station, args.attach)?;
    let scene = scene::compile(&args.scene, &folder.scene())?;
    let listening = match session_path(args, out.as_deref()) {
        // Before the controller starts: replay needs its first tick.
        Some(path) => Some((path, listen(args, &station)?)),
        None => None,
    };
    let (children, scene) = match args.attach {
        true => (Vec::new(), scene), // its user tells it the scene
        false => start(args, &scene, &folder.path, &stop)?,
    };
    folder.tell(&scene)?;
    let assignment = assigned.as_ref().map(Assigned::assignment);
    let task = assigned.as_ref().map(Assigned::task);
    let begins = assigned.as_ref().and_then(Assigned::start);
    let live = assigned.map(|it| it.begin(&SceneFile::open(&scene)?, &station));
    let (live, course) = live.transpose()?.unzip();
    let sight = Sight::default();
    let recording = match listening {
        Some((path, listening)) => Some(listening.record(session::Config {
            path,
            build: build(),
            scene: SceneFile::open(&scene)?,
            assignment,
            sight: sight.clone(),
            course,
        })?),
        None => None,
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

    let mut recorder = Recorder::new();
    let shown = Shown {
        station: &station,
        scene: &scene,
        out: out.as_deref(),
        task: live.as_ref(),
        recording: recording.as_ref(),
        sight: &sight,
    };
    let outcome = show(args, &shown, &stop, &watch.over, &mut recorder);
    let dead = watch.end();
    if let Some(why) = surgeon.and_then(AtWork::end) {
        say::note(format_args!("calot: the surgeon gave up: {why}"));
    }

    let recorded = recording.map(Recording::end);
    // With the recording its course has ended.
    let assessed = live.map(Live::end);

    let mut outcome = outcome?;
    let recorded = match recorded {
        Some(None) => {
            outcome
                .warnings
                .push("the recorder panicked; please report this".to_owned());
            None
        }
        recorded => recorded.flatten(),
    };
    outcome
        .warnings
        .extend(recorded.as_ref().and_then(Recorded::warning));
    if !dead.is_empty() {
        outcome.ended = Ended::ProcessDied;
    }
    outcome.warnings.extend(dead.iter().cloned());
    let mut summary = recorder.summary(&SceneFile::open(&scene)?, &outcome, Machine::read());
    if let Some(recorded) = &recorded {
        // A controller that died before the display saw any of its ticks has run them all the same.
        summary.ticks = summary.ticks.max(recorded.ticks);
    }
    summary.recording = recorded;
    let assessed = assessed.flatten();
    summary.task = assessed.as_ref().map(|it| it.summary.clone());
    let recording = summary.recording.as_ref().map(|it| it.file.clone());
    let mut whole = dead.is_empty() && outcome.ended != Ended::ControllerGone;
    if let Some(assessed) = &assessed
        && let Err(problem) = assessed.keep(&summary.scene, recording.as_deref())
    {
        let warning = format!(
            "not kept in the store: {problem}. What it came to is in summary.json and debrief.html"
        );
        summary.warnings.push(warning.clone());
        outcome.warnings.push(warning);
        whole = false;
    }
    if let Some(out) = out {
        let written = write(&out, &summary, &recorder, &outcome)?;
        say::note(format_args!(
            "wrote {} and {}",
            written.summary.display(),
            written.report.display()
        ));
        if let Some(assessed) = &assessed {
            whole &= debrief(assessed, recording, &out, &outcome);
        }
    }
    if args.json {
        say::answer(format_args!("{}", serde_json::to_string_pretty(&summary)?));
    }
    for warning in &outcome.warnings {
        say::note(format_args!("calot: {warning}"));
    }
    // Last: what the run came to does not wait for it, nor fail with it.
    if let Some(gif) = &args.gif
        && let Err(problem) = animate(&outcome, gif)
    {
        say::note(format_args!("warning: no animation: {problem}"));
        whole = false;
    }
    Ok(if whole {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The run's pictures, but those of single moments, as an animation.
fn animate(outcome: &Outcome, gif: &Path) -> Result<(), Problem> {
    let is_of_course = |path: &PathBuf| {
        let name = path.file_name().and_then(|it| it.to_str());
        name.is_some_and(|it| it.starts_with("frame_"))
    };
    let pictures = outcome.frames.iter().filter_map(|it| it.path.clone());
    let mut pictures: Vec<PathBuf> = pictures.filter(is_of_course).collect();
    pictures.sort();
    display_host::animation::write_gif(&pictures, gif)?;
    say::note(format_args!(
        "wrote {}: {} pictures",
        gif.display(),
        pictures.len()
    ));
    Ok(())
}

/// The page of the task, from the recording, as `calot report` makes it, with this run's pictures. Whether
/// it was made.
fn debrief(
    assessed: &task::Ended,
    session: Option<PathBuf>,
    out: &Path,
    outcome: &Outcome,
) -> bool {
    let made = session
        .ok_or_else(|| Problem::from("nothing was recorded"))
        .and_then(|session| report::chapter(&session, None, None))
        .and_then(|report::Found { mut chapter, .. }| {
            let drawn = outcome.frames.iter().filter_map(|it| it.path.clone());
            chapter.pictures = report::chosen(drawn);
            chapter.ticks = report::ticks(out);
            if let Err(problem) = assessed.add_past(&mut chapter) {
                say::note(format_args!(
                    "calot: debrief.html without earlier sessions: {problem}"
                ));
            }
            report::write(&[chapter], &out.join("debrief.html"))
        });
    if let Err(problem) = &made {
        say::note(format_args!("calot: no debrief.html: {problem}"));
    }
    made.is_ok()
}

/// Where the session goes, if it is recorded. One that is joined cannot be replayed: its beginning
/// is over.
fn session_path(args: &RunArgs, out: Option<&Path>) -> Option<PathBuf> {
    let beside = out.filter(|_| !args.attach);
    args.record
        .clone()
        .or_else(|| beside.map(|out| out.join("session.mcap")))
}

fn listen(args: &RunArgs, station: &Station) -> Result<Listening, Problem> {
    Ok(Listening::begin(
        station,
        display_host::priority::step_aside,
        args.controller.realtime.core,
    )?)
}

/// What the display is told.
struct Shown<'a> {
    station: &'a Station,
    scene: &'a Path,
    out: Option<&'a Path>,
    task: Option<&'a Live>,
    recording: Option<&'a Recording>,
    sight: &'a Sight,
}

/// The display, in this process.
fn show(
    args: &RunArgs,
    &Shown {
        station,
        scene,
        out,
        task,
        recording,
        sight,
    }: &Shown<'_>,
    stop: &AtomicBool,
    over: &AtomicBool,
    recorder: &mut Recorder,
) -> Result<Outcome, Problem> {
    let mut said = std::time::Instant::now();
    let mut observe = |observed: Observed<'_>| {
        match &observed {
            Observed::Progress(text) if said.elapsed() >= PROGRESS => {
                say::note(format_args!("{text}"));
                said = std::time::Instant::now();
            }
            Observed::Warning(text) => say::note(format_args!("warning: {text}")),
            Observed::Scope(rad) => sight.tell(*rad),
            // The controller ends while the last pictures are drawn.
            Observed::Over => over.store(true, Ordering::Relaxed),
            _ => {}
        }
        recorder.observe(&observed);
    };
    if args.headless {
        let config = HeadlessConfig {
            station: station.clone(),
            scene: scene.to_owned(),
            seconds: args.seconds.unwrap_or(HEADLESS_SECONDS),
            out_dir: out.unwrap_or(Path::new("out")).to_owned(),
            size: args.size,
            frames: args.frames,
            patience: PATIENCE_FOR_STATE,
            tick_cpu: args.controller.realtime.core,
            task_over: task.map(|task| task.over.clone()),
            need_pictures: false,
        };
        return Ok(headless::run(&config, stop, &mut observe)?);
    }
    let config = WindowConfig {
        station: station.clone(),
        scene: scene.to_owned(),
        size: args.size.unwrap_or([1280, 720]),
        scope_angle: args.scope.radians(),
        cold_lens: args.cold_lens,
        muted: args.mute,
        seconds: args.seconds,
        lose_device_after: None,
        tick_cpu: args.controller.realtime.core,
        language: LanguageName::or_users(args.language),
        task: task.map(|task| task.view.clone()),
        instructor: false,
        replay: None,
        recording: recording.map(Recording::health),
    };
    Ok(window::run(&config, stop, &mut observe)?)
}

/// Starts emulated devices for those that are not named, then the controller. Gives the level of the
/// scene that it took, which the display must show too.
pub(crate) fn start(
    args: &RunArgs,
    scene: &Path,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<(Vec<Process>, PathBuf), Problem> {
    let mut children = Vec::new();
    let parent = std::process::id().to_string();
    let devices = folder.join("devices");
    let named = &args.controller.devices;
    let file = named.station_file.as_deref().map(StationFile::read);
    let file = file.transpose()?.unwrap_or_default();
    let emulated = [
        named.haptic.is_none() && file.haptic.is_none(),
        named.tracker.is_none() && file.tracker.is_none(),
        named.pedal.is_none() && file.pedal.is_none(),
    ];
    if emulated.contains(&true) {
        let seed = args.seed.to_string();
        let gamepad = args.gamepad.gamepad.word();
        let emulate = words([
            &"emulate",
            &"--with-parent",
            &parent,
            &"--dir",
            &devices,
            &"--scene",
            &scene,
            &"--seed",
            &seed,
            &"--station",
            &args.station,
            &"--gamepad",
            &gamepad,
        ]);
        children.push(Process::start(
            "emulate",
            &emulate,
            PATIENCE_TO_START,
            stop,
        )?);
    }
    let path = |named: &Option<PathBuf>, emulated: bool, name: &str| {
        named.clone().or(emulated.then(|| devices.join(name)))
    };
    let devices = DeviceArgs {
        haptic: path(&named.haptic, emulated[0], "haptic"),
        tracker: path(&named.tracker, emulated[1], "tracker"),
        pedal: path(&named.pedal, emulated[2], "pedal"),
        station_file: named.station_file.clone(),
    };
    let mut scene = scene.to_owned();
    for level in 1.. {
        // Levels that the user names are the controller's to choose from; else they are made here,
        // when one is needed.
        let next = match args.controller.realtime.coarser.is_empty() {
            true => scene::coarser(&args.scene, level),
            false => None,
        };
        let mut realtime = args.controller.realtime.clone();
        realtime.strict |= next.is_some();
        let mut rt = words([
            &"rt",
            &"--with-parent",
            &parent,
            &"--scene",
            &scene,
            &"--station",
            &args.station,
        ]);
        rt.extend(realtime.words());
        option(&mut rt, "--haptic", devices.haptic.as_deref());
        option(&mut rt, "--tracker", devices.tracker.as_deref());
        option(&mut rt, "--pedal", devices.pedal.as_deref());
        option(&mut rt, "--station-file", devices.station_file.as_deref());
        let problem = match Process::start("rt", &rt, PATIENCE_TO_START, stop) {
            Ok(controller) => {
                scene = taken(&controller, scene, &args.controller.realtime.coarser)?;
                children.push(controller);
                break;
            }
            Err(problem) => problem,
        };
        let early = problem.downcast_ref::<EndedEarly>();
        let code = early.and_then(|early| early.status.code());
        match next {
            Some(recipe) if code == Some(DOES_NOT_FIT.into()) => {
                say::note("calot: taking the next coarser level of the scene");
                scene = folder.join(format!("coarser-{level}.calot"));
                scene::bring(&recipe, &scene)?;
            }
            _ => return Err(problem),
        }
    }
    Ok((children, scene))
}

/// Which of the levels, of the scene's own file or of those that the user named, the controller took.
fn taken(controller: &Process, finest: PathBuf, coarser: &[PathBuf]) -> Result<PathBuf, Problem> {
    let ready: serde_json::Value = serde_json::from_str(controller.said())?;
    let own = SceneFile::levels(&finest).into_iter().skip(1);
    for path in own.chain(coarser.iter().flat_map(|file| SceneFile::levels(file))) {
        let id = SceneFile::open(&path)?.id();
        let id: String = id.iter().map(|byte| format!("{byte:02x}")).collect();
        if ready["scene_id"] == id.as_str() {
            say::note(format_args!(
                "calot: the coarser level {} runs",
                path.display()
            ));
            return Ok(path);
        }
    }
    Ok(finest)
}

/// Watches the children from a thread: one that dies ends the run.
struct Watch {
    thread: std::thread::JoinHandle<Vec<String>>,
    over: Arc<AtomicBool>,
}

impl Watch {
    fn begin(mut children: Vec<Process>, stop: Arc<AtomicBool>) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let watched = over.clone();
        let thread = std::thread::spawn(move || {
            let (mut dead, mut died) = (Vec::new(), Vec::new());
            while !watched.load(Ordering::Relaxed) && dead.is_empty() {
                for child in &mut children {
                    if let Ok(Some(status)) = child.ended() {
                        died.push(child.name());
                        dead.push(format!("the {} process died ({status})", child.name()));
                        stop.store(true, Ordering::Relaxed);
                    }
                }
                std::thread::sleep(Duration::from_millis(20));
            }
            // The controller first: it sends its last, zero force while the device still listens.
            for child in children.into_iter().rev() {
                let name = child.name();
                if let Some(problem) = child.end()
                    && !died.contains(&name)
                {
                    dead.push(problem);
                }
            }
            dead
        });
        Self { thread, over }
    }

    /// Ends the children; returns which had died by themselves.
    fn end(self) -> Vec<String> {
        self.over.store(true, Ordering::Relaxed);
        self.thread
            .join()
            .unwrap_or_else(|_| vec!["the watching thread panicked".into()])
    }
}

/// The folder of a station that runs: its compiled scene, its devices' links, its lock.
pub(crate) struct Folder {
    path: PathBuf,
    attached: bool,
    /// Held while the station runs; the kernel lets go of it however this process ends.
    _lock: Option<std::fs::File>,
}

impl Folder {
    pub(crate) fn open(station: &str, attached: bool) -> Result<Self, Problem> {
        let path = shared_mem::service::user_folder()?.join(station);
        let failed = |error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(&path).map_err(failed)?;
        if attached {
            return Ok(Self {
                path,
                attached,
                _lock: None,
            });
        }
        let lock = std::fs::OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path.join("lock"))
            .map_err(failed)?;
        let mut locked = lock.try_lock();
        for _ in 0..LOCK_LOOKS {
            // Whoever asks whether it runs has it for a moment.
            if !matches!(locked, Err(std::fs::TryLockError::WouldBlock)) {
                break;
            }
            std::thread::sleep(LOCK_PAUSE);
            locked = lock.try_lock();
        }
        match locked {
            Ok(()) => {
                // Of one that was killed: its scene is not what runs next.
                let _ = std::fs::remove_file(path.join(RUNNING));
                Ok(Self {
                    path,
                    attached,
                    _lock: Some(lock),
                })
            }
            Err(std::fs::TryLockError::WouldBlock) => Err(format!(
                "station '{station}' runs already; show it with `calot run --attach`, or choose \
                 another name with --station"
            )
            .into()),
            Err(std::fs::TryLockError::Error(error)) => Err(failed(error).into()),
        }
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Tells displays that join which compiled scene runs.
    pub(crate) fn tell(&self, scene: &Path) -> Result<(), Problem> {
        use std::os::unix::ffi::OsStrExt as _;
        if self.attached {
            return Ok(());
        }
        let path = std::path::absolute(scene)?;
        // Renamed into its place: nobody reads half of it.
        let half = self.path.join(format!("{RUNNING}.new"));
        let written = std::fs::write(&half, path.as_os_str().as_bytes());
        let written = written.and_then(|()| std::fs::rename(&half, self.path.join(RUNNING)));
        written.map_err(|error| format!("{}: {error}", half.display()).into())
    }

    /// Where the scene is compiled to. A display that joins has its own: it must not replace the
    /// running one's.
    pub(crate) fn scene(&self) -> PathBuf {
        match self.attached {
            true => self
                .path
                .join(format!("attached-{}.calot", std::process::id())),
            false => self.path.join("scene.calot"),
        }
    }
}

/// The file in a station's folder that says which compiled scene runs.
const RUNNING: &str = "running";

/// The compiled scene that a station runs, if its `calot run` has said so.
pub(crate) fn running(station: &str) -> Result<Option<PathBuf>, Problem> {
    use std::os::unix::ffi::OsStringExt as _;
    let folder = shared_mem::service::user_folder()?.join(station);
    let file = folder.join(RUNNING);
    match std::fs::read(&file) {
        // One that was killed has left its word, but not its lock.
        Ok(_) if !is_held(&folder.join("lock")) => Ok(None),
        Ok(path) => Ok(Some(std::ffi::OsString::from_vec(path).into())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(format!("{}: {error}", file.display()).into()),
    }
}

/// Whether a station has the lock.
fn is_held(lock: &Path) -> bool {
    std::fs::File::open(lock).is_ok_and(|file| {
        let tried = file.try_lock_shared();
        matches!(tried, Err(std::fs::TryLockError::WouldBlock))
    })
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.attached {
            let _ = std::fs::remove_file(self.path.join(RUNNING));
        }
        let _ = std::fs::remove_file(self.scene());
    }
}
