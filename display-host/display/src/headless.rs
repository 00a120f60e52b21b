//! The display without a window: watches a run and saves pictures of it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::Vec3;
use shared_mem::message::{EventMsg, SphereState, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::{SceneFile, VertexRecord};
use shared_mem::service::{Host, Station};
use shared_mem::words::{CapsuleRole, EventKind};

use crate::DisplayError;
use crate::effects::EffectCollector;
use crate::effects::fluid::Balance;
use crate::feed::{Feed, FeedCounters, Offer, hex};
use crate::kept::Watch;
use crate::latency::FrameRecord;
use crate::painter::{Painter, Still};
use crate::presentation::Presentation;
use crate::ui::{Settings, TaskView};

/// Period at which the services are read.
const POLL: Duration = Duration::from_millis(2);
/// Least depth of the tip below the skin at rest at which `deepest_press.png` is drawn, m.
const PRESS_MIN_M: f32 = 0.001;
/// Difference of depth below which two presses count as equally deep, m. The last of equally deep
/// moments is drawn, because by then the tissue has settled.
const PRESS_SAME_M: f32 = 0.0005;
/// Largest number of pictures. A state waits in memory (75 kB) until its picture is drawn.
const FRAMES_MAX: u32 = 4096;

/// Configuration of a run without a window.
#[derive(Debug, Clone)]
pub struct HeadlessConfig {
    /// Station to watch: the name that its controller and displays share.
    pub station: Station,
    /// Path of the compiled scene.
    pub scene: PathBuf,
    /// Duration of the run, s. It starts once the first state has arrived and pictures can be
    /// drawn.
    pub seconds: f64,
    /// Folder of the pictures, created if missing.
    pub out_dir: PathBuf,
    /// Pixels; `None`: 1280×720 on a GPU, 640×480 on a software driver.
    pub size: Option<[u32; 2]>,
    /// Number of pictures, spread evenly over the run: `frame_0000.png`, …. A press also gives
    /// `deepest_press.png` and `before_press.png`, the same view of the untouched tissue. A grasp
    /// gives `grasp.png`. With 0 no picture is drawn.
    pub frames: u32,
    /// Longest wait for the first state, and longest silence of the controller after it.
    pub patience: Duration,
    /// Core of the realtime thread, which the display avoids.
    pub tick_cpu: Option<usize>,
    /// Set once the outcome of the run's task is decided: the run then ends.
    pub task_over: Option<Arc<AtomicBool>>,
    /// State of the task. A critical view is drawn once the trainee has held it.
    pub task: Option<Arc<Mutex<TaskView>>>,
    /// True if a missing graphics driver is an error; otherwise it is a warning, and the run
    /// continues without pictures.
    pub need_pictures: bool,
}

/// An observation during a run, passed to the caller as it happens.
#[derive(Debug)]
pub enum Observed<'a> {
    /// An event.
    Event(&'a EventMsg),
    /// A batch of timing records with a valid record count.
    Timing(&'a TimingBatch),
    /// The latest valid tools.
    Tools(&'a ToolFrame),
    /// The latest valid state.
    State(&'a StateFrame),
    /// The endoscope's view changed: its angle to the shaft, and its turn about the shaft, rad.
    Scope([f32; 2]),
    /// The user changed the settings.
    Settings(Settings),
    /// The first state has arrived and pictures can be drawn: the run's time starts.
    Begun,
    /// Progress for a waiting user, at most twice a second.
    Progress(&'a str),
    /// Warning for the user.
    Warning(&'a str),
    /// The run is over; only drawing remains. The caller may stop the controller now.
    Over,
}

/// Reason for the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The time of the run was up.
    TimeOver,
    /// The outcome of the run's task was decided.
    TaskOver,
    /// A stop was requested, or the window was closed.
    Stopped,
    /// The controller was silent for too long.
    ControllerGone,
    /// A process of the station died, or did not end on request. Only the program that started the
    /// processes sets this.
    ProcessDied,
    /// The display failed, or its window or screen was lost.
    DisplayLost,
}

/// Result of a run, as raw numbers; reports are made elsewhere.
#[derive(Debug, Clone)]
pub struct RunOutcome {
    /// Graphics adapter and driver; `None`: no picture could be drawn.
    pub adapter: Option<String>,
    /// True if the adapter is a CPU.
    pub software_adapter: bool,
    /// Pictures in the order of drawing.
    pub frames: Vec<FrameRecord>,
    /// Pictures a second that the window showed: the median. `None` without a window, or after few
    /// pictures.
    pub pictures_per_second: Option<f64>,
    /// When the screen got the window's pictures.
    pub presentation: Presentation,
    /// Blood, bile and water since the last reset. `None` if no picture was drawn.
    pub fluids: Option<Balance>,
    /// Counters of received, refused and lost messages.
    pub counters: FeedCounters,
    /// Reason for the end of the run.
    pub ended: Ended,
    /// All warnings that the observer received.
    pub warnings: Vec<String>,
}

impl RunOutcome {
    /// Outcome of a run whose display was lost for this reason.
    #[must_use]
    pub fn lost(reason: String) -> Self {
        Self {
            adapter: None,
            software_adapter: false,
            frames: Vec::new(),
            pictures_per_second: None,
            presentation: Presentation::default(),
            fluids: None,
            counters: FeedCounters::default(),
            ended: Ended::DisplayLost,
            warnings: vec![reason],
        }
    }
}

/// Watches a station for some time and draws pictures of it. Waits for the controller's first state
/// up to `patience`. Starts no other process.
///
/// # Errors
/// See [`DisplayError`]. After [`Observed::Begun`] only two errors end a run: a file that cannot be
/// written, and a failing graphics device when pictures are needed.
pub fn run(
    config: &HeadlessConfig,
    stop: &AtomicBool,
    observer: &mut dyn FnMut(Observed<'_>),
) -> Result<RunOutcome, DisplayError> {
    if !(config.seconds > 0.0 && config.seconds <= 86_400.0) {
        return Err(DisplayError::Seconds(config.seconds));
    }
    let scene = Arc::new(SceneFile::open(&config.scene)?);
    std::fs::create_dir_all(&config.out_dir).map_err(|error| DisplayError::Write {
        path: config.out_dir.clone(),
        detail: error.to_string(),
    })?;
    let host = Host::open(&config.station)?;
    let painter = match config.frames {
        0 => None,
        _ => Some(Painter::start(scene.clone(), config.size, config.tick_cpu)?),
    };
    let mut run = Run {
        config,
        stop,
        host,
        feed: Feed::new(&scene),
        plan: Plan::new(config, scene.clone()),
        effects: EffectCollector::new(&scene),
        scene,
        painter,
        inbox_state: zeroed_state(),
        inbox_tools: bytemuck::Zeroable::zeroed(),
        last_state: Instant::now(),
        warnings: Vec::new(),
        kept: (config.task.as_ref()).map(|task| Watch::new(task, &config.out_dir)),
    };
    let ended = if run.wait_for_controller(observer)? {
        observer(Observed::Begun);
        run.watch(observer)?
    } else {
        Ended::Stopped
    };
    observer(Observed::Over);
    run.finish(ended, observer)
}

/// An empty state frame on the heap, because it is large.
pub(crate) fn zeroed_state() -> Box<StateFrame> {
    bytemuck::allocation::zeroed_box()
}

struct Run<'a> {
    config: &'a HeadlessConfig,
    stop: &'a AtomicBool,
    host: Host,
    scene: Arc<SceneFile>,
    feed: Feed,
    painter: Option<Painter>,
    plan: Plan,
    effects: EffectCollector,
    inbox_state: Box<StateFrame>,
    inbox_tools: ToolFrame,
    last_state: Instant,
    warnings: Vec<String>,
    kept: Option<Watch>,
}

impl Run<'_> {
    /// Waits until the run can begin. Returns `false` if a stop was requested before.
    fn wait_for_controller(
        &mut self,
        observer: &mut dyn FnMut(Observed<'_>),
    ) -> Result<bool, DisplayError> {
        let start = Instant::now();
        let mut progress = Progress::new();
        // A picture shows the newest state of its moment, so the run starts only when pictures can
        // be drawn.
        while !self.is_ready() {
            self.receive(observer);
            self.check_painter(observer)?;
            let waited = start.elapsed();
            if let Some(running) = self.feed.other_scene_id() {
                // A controller of another scene may still publish although it is about to be
                // replaced, so the run waits a little.
                if waited > self.config.patience.min(Duration::from_secs(2)) {
                    return Err(self.other_scene(running));
                }
            }
            if self.stop.load(Ordering::Relaxed) {
                return Ok(false);
            }
            if waited > self.config.patience && self.feed.state().is_none() {
                return Err(DisplayError::NoController {
                    station: self.config.station.name().to_owned(),
                    waited_s: waited.as_secs_f64(),
                });
            }
            let what = match self.feed.state() {
                None => "waiting for the controller",
                Some(_) => "preparing to draw",
            };
            progress.say(observer, || {
                format!("{what} ({:.0} s)", waited.as_secs_f64())
            });
            std::thread::sleep(POLL);
        }
        Ok(true)
    }

    /// True if a state and tools have arrived, and pictures can be drawn or are not wanted.
    fn is_ready(&self) -> bool {
        let painter = self.painter.as_ref().is_none_or(Painter::is_ready);
        painter && self.feed.state().is_some() && self.feed.tools().is_some()
    }

    fn watch(&mut self, observer: &mut dyn FnMut(Observed<'_>)) -> Result<Ended, DisplayError> {
        let start = Instant::now();
        let mut progress = Progress::new();
        let mut silent = false;
        loop {
            self.receive(observer);
            let elapsed = start.elapsed();
            if let (Some(state), Some(tools)) = (self.feed.state(), self.feed.tools()) {
                let free = self.painter.as_ref().is_some_and(Painter::is_free);
                self.effects.look(state, tools);
                if let Some(path) = self.kept.as_mut().and_then(Watch::due)
                    && let Some(painter) = &mut self.painter
                {
                    painter.paint(Still::kept(state, tools, path));
                }
                if let Some(mut still) = self.plan.next(elapsed, state, tools, free)
                    && let Some(painter) = &mut self.painter
                {
                    still.effects = Some(self.effects.take(still.state.tick));
                    painter.paint(still);
                }
            }
            self.check_painter(observer)?;
            if self.stop.load(Ordering::Relaxed) {
                return Ok(Ended::Stopped);
            }
            let task_over = self.config.task_over.as_ref();
            if task_over.is_some_and(|over| over.load(Ordering::Relaxed)) {
                return Ok(Ended::TaskOver);
            }
            if elapsed.as_secs_f64() >= self.config.seconds {
                return Ok(Ended::TimeOver);
            }
            let silence = self.last_state.elapsed();
            if silence > self.config.patience {
                self.warn(
                    observer,
                    "the controller stopped responding; the run ends here",
                );
                return Ok(Ended::ControllerGone);
            }
            if silence > Duration::from_millis(500) && !silent {
                self.host.forget_dead();
            }
            silent = silence > Duration::from_millis(500);
            progress.say(observer, || {
                let of = self.config.seconds;
                let note = if silent { ", controller silent" } else { "" };
                format!("{:.0} of {of:.0} s{note}", elapsed.as_secs_f64())
            });
            std::thread::sleep(POLL);
        }
    }

    fn finish(
        mut self,
        ended: Ended,
        observer: &mut dyn FnMut(Observed<'_>),
    ) -> Result<RunOutcome, DisplayError> {
        let mut progress = Progress::new();
        if ended != Ended::Stopped {
            for still in self.plan.last_stills() {
                if let Some(painter) = &mut self.painter {
                    painter.paint(still);
                }
            }
        } else if let Some(painter) = &mut self.painter {
            painter.drop_waiting();
        }
        while self.painter.as_ref().is_some_and(|p| p.left() > 0) {
            self.receive(observer);
            self.check_painter(observer)?;
            if self.stop.load(Ordering::Relaxed)
                && let Some(painter) = &mut self.painter
            {
                painter.drop_waiting();
            }
            let left = self.painter.as_ref().map_or(0, Painter::left);
            progress.say(observer, || format!("drawing: {left} pictures left"));
            std::thread::sleep(POLL);
        }
        self.receive(observer);
        let painted = self.painter.map(Painter::end).unwrap_or_default();
        Ok(RunOutcome {
            adapter: painted.adapter,
            software_adapter: painted.software,
            frames: painted.frames,
            fluids: painted.fluids,
            pictures_per_second: None,
            presentation: Presentation::default(),
            counters: self.feed.counters(),
            ended,
            warnings: self.warnings,
        })
    }

    /// Receives all messages from the services.
    fn receive(&mut self, observer: &mut dyn FnMut(Observed<'_>)) {
        let restarts = self.feed.counters().restarts;
        if self.host.newest_state(&mut self.inbox_state)
            && self.feed.offer_state(&self.inbox_state) == Offer::Taken
        {
            self.last_state = Instant::now();
            observer(Observed::State(&self.inbox_state));
        }
        if self.host.newest_tools(&mut self.inbox_tools)
            && self.feed.offer_tools(&self.inbox_tools) == Offer::Taken
        {
            observer(Observed::Tools(&self.inbox_tools));
        }
        if self.feed.counters().restarts > restarts {
            self.effects.clear();
        }
        let (feed, plan, effects) = (&mut self.feed, &mut self.plan, &mut self.effects);
        self.host.drain_events(|event| {
            feed.note_event(event);
            plan.note_event(event);
            effects.event(event);
            observer(Observed::Event(event));
        });
        self.host.drain_timing(|batch| {
            if feed.note_timing(batch) {
                observer(Observed::Timing(batch));
            }
        });
    }

    /// Drops a painter that has failed. The run goes on without pictures, unless they are needed.
    fn check_painter(
        &mut self,
        observer: &mut dyn FnMut(Observed<'_>),
    ) -> Result<(), DisplayError> {
        let failure = self.painter.as_mut().and_then(Painter::collect);
        let Some(error) = failure else { return Ok(()) };
        if self.config.need_pictures || matches!(error, DisplayError::Write { .. }) {
            return Err(error);
        }
        self.painter = None;
        self.warn(observer, &format!("no pictures: {error}"));
        Ok(())
    }

    fn warn(&mut self, observer: &mut dyn FnMut(Observed<'_>), text: &str) {
        observer(Observed::Warning(text));
        self.warnings.push(text.to_owned());
    }

    fn other_scene(&self, running: [u8; 16]) -> DisplayError {
        DisplayError::OtherScene {
            running: hex(running),
            ours: hex(self.scene.short_id()),
            name: self.scene.name().to_owned(),
        }
    }
}

/// Selection of the moments to draw.
struct Plan {
    out_dir: PathBuf,
    seconds: f64,
    frames: u32,
    next_frame: u32,
    scene: Arc<SceneFile>,
    deepest: Option<Still>,
    /// Depth of the deepest press so far, m.
    deepest_m: f32,
    /// The last state without contact before the first recorded press. Without such a state it is
    /// the tissue at rest.
    untouched: Box<StateFrame>,
    grasp: Option<Still>,
    grasp_due: bool,
}

impl Plan {
    fn new(config: &HeadlessConfig, scene: Arc<SceneFile>) -> Self {
        Self {
            untouched: at_rest(&scene),
            scene,
            out_dir: config.out_dir.clone(),
            seconds: config.seconds,
            frames: config.frames.min(FRAMES_MAX),
            next_frame: 0,
            deepest: None,
            deepest_m: 0.0,
            grasp: None,
            grasp_due: false,
        }
    }

    fn note_event(&mut self, event: &EventMsg) {
        if event.is(EventKind::Grasp) && self.grasp.is_none() {
            self.grasp_due = true;
        }
    }

    /// Records the deepest press and the grasp, which are drawn at the end. Returns the picture of
    /// the series that is due now, if any. A painter that is `free` draws this picture at once.
    fn next(
        &mut self,
        elapsed: Duration,
        state: &StateFrame,
        tools: &ToolFrame,
        free: bool,
    ) -> Option<Still> {
        if self.frames == 0 {
            return None;
        }
        let depth_m = self.depth_m(state, tools);
        if tools.contact_count == 0 && self.deepest.is_none() {
            *self.untouched = *state;
        }
        if depth_m > PRESS_MIN_M && depth_m > self.deepest_m - PRESS_SAME_M {
            self.deepest_m = self.deepest_m.max(depth_m);
            let path = self.out_dir.join("deepest_press.png");
            self.deepest = Some(Still::kept(state, tools, path));
        }
        if self.grasp_due && self.grasp.is_none() {
            self.grasp = Some(Still::kept(state, tools, self.out_dir.join("grasp.png")));
        }
        let due_s = (f64::from(self.next_frame) + 0.5) / f64::from(self.frames) * self.seconds;
        if self.next_frame >= self.frames || elapsed.as_secs_f64() < due_s {
            return None;
        }
        let path = frame_path(&self.out_dir, self.next_frame);
        self.next_frame += 1;
        let mut still = Still::kept(state, tools, path);
        still.live = free;
        Some(still)
    }

    /// Depth of the instrument's tip below the skin at rest, m. It is 0 without a contact, and
    /// while tissue is grasped.
    fn depth_m(&self, state: &StateFrame, tools: &ToolFrame) -> f32 {
        let grasped = |s: &SphereState| s.bits & SphereState::GRASPED != 0;
        if tools.contact_count == 0 || state.spheres().unwrap_or(&[]).iter().any(grasped) {
            return 0.0;
        }
        let tips = tools.capsules().unwrap_or(&[]).iter();
        let depths = tips.filter(|c| !c.is(CapsuleRole::Shaft)).map(|capsule| {
            let tip = Vec3::from(capsule.b_m);
            let far = |v: &VertexRecord| Vec3::from(v.position_m).distance_squared(tip);
            let skin = self.scene.vertices().iter();
            let nearest = skin.min_by(|a, b| far(a).total_cmp(&far(b)));
            nearest.map_or(0.0, |v| {
                (Vec3::from(v.position_m) - tip).dot(Vec3::from(v.normal))
            })
        });
        depths.fold(0.0, f32::max)
    }

    /// Pictures of moments that are only known at the end.
    fn last_stills(&mut self) -> Vec<Still> {
        let deepest = self.deepest.take();
        let before = deepest.as_ref().map(|press| {
            let tools = ToolFrame {
                contact_count: 0,
                ..press.tools
            };
            let path = self.out_dir.join("before_press.png");
            Still::kept(&self.untouched, &tools, path)
        });
        [before, deepest, self.grasp.take()]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// The tissue at rest.
pub(crate) fn at_rest(scene: &SceneFile) -> Box<StateFrame> {
    let mut state = zeroed_state();
    state.scene_id = scene.short_id();
    for (now, rest) in state.spheres.iter_mut().zip(scene.spheres()) {
        now.center_m = rest.center_m;
        state.sphere_count += 1;
    }
    state
}

fn frame_path(out_dir: &Path, number: u32) -> PathBuf {
    out_dir.join(format!("frame_{number:04}.png"))
}

/// Reports progress at most twice a second.
struct Progress(Option<Instant>);

impl Progress {
    fn new() -> Self {
        Self(None)
    }

    fn say(&mut self, observer: &mut dyn FnMut(Observed<'_>), text: impl FnOnce() -> String) {
        let due = self
            .0
            .is_none_or(|last| last.elapsed() >= Duration::from_millis(500));
        if due {
            observer(Observed::Progress(&text()));
            self.0 = Some(Instant::now());
        }
    }
}
