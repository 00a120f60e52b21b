//! State of a window: the feed, the panel's state, and the user's requests.

mod acts;
mod carry_out;
mod effects;
mod hook;
mod notes;
mod receive;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use assess::report::PICTURES_MIN;
use shared_mem::message::{ActMsg, StateFrame, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::service::{ActSender, Host, ServiceError, Station, TaskReceiver};
use shared_mem::task::TaskMsg;

use self::acts::StuckMark;
use self::notes::Notes;
use super::frames::{Frames, rate};
use super::free_view::FreeCamera;
use super::operate::{Lead, Operate};
use super::pending::Pending;
use super::presented::Handed;
use crate::effects::Causes;
use crate::feed::Feed;
use crate::headless::{Ended, Observed, RunOutcome, zeroed_state};
use crate::kept::Watch;
use crate::latency::FrameRecord;
use crate::patch::{Lit, Patch};
use crate::presentation::{Missing, Presentation, Presented, Source};
use crate::render::camera::Scope;
use crate::sound::Sound;
use crate::sound::synth::Heard;
use crate::ui::{
    ActsView, Link, Look, Overlay, PauseNote, RecordingView, ReplayView, Settings, TaskView,
    UiState, towards_tip,
};

pub(super) struct Session {
    host: Host,
    feed: Feed,
    /// Buffers for the newest frames, which the feed has not checked yet.
    inbox_state: Box<StateFrame>,
    inbox_tools: ToolFrame,
    /// Time at which the last valid state arrived.
    last_state: Option<Instant>,
    /// Time at which the window opened.
    start: Instant,
    /// True if the resources of processes that died were removed since the last valid state.
    forgot_dead: bool,
    /// Force on the hand over the last seconds: time, s, and force, N.
    force: VecDeque<[f64; 2]>,
    frames: Frames,
    warnings: Vec<String>,
    /// Effects of events since the last picture.
    pending: Pending,
    causes: Causes,
    /// Names of the organs.
    organs: Vec<String>,
    /// True if the next picture must clear all bleeding and stains.
    was_reset: bool,
    /// Ticks so far in which the haptic device limited its force.
    limited_ticks: u64,
    /// `None`: muted, or no sound card.
    sound: Option<Sound>,
    heard: Heard,
    task: Option<Arc<Mutex<TaskView>>>,
    /// Acts of instructors, as the station or a replay reports them.
    acts: Option<Arc<Mutex<ActsView>>>,
    /// State of the note about an instructor's pause.
    pause_note: PauseNote,
    /// Sender of an instructor's acts to the station, and the acts that were sent, with their
    /// times, s.
    desk: Option<(ActSender, Vec<(f64, ActMsg)>)>,
    /// The instructor's mark, if there is one.
    mark: Option<StuckMark>,
    /// Optics of the last picture.
    scope: Scope,
    /// Number of times that an instructor fogged the lens, as far as the picture shows it.
    fogs: usize,
    /// Bulletins of the assessor, for an instructor.
    bulletins: Option<(TaskReceiver, Box<TaskMsg>)>,
    replay: Option<Arc<Mutex<ReplayView>>>,
    recording: Option<Arc<Mutex<RecordingView>>>,
    patch: Option<Arc<Patch>>,
    presentation: Presentation,
    /// Pictures of the critical view that are to be kept.
    kept: Option<Watch>,
    /// The free view, if active.
    free: Option<FreeCamera>,
    /// Time of the last task alarm.
    alarmed: Option<Instant>,
    /// Sentences to the trainee that end by themselves, and the age of the shown alarm.
    notes: Notes,
    /// Number of the newest closed clip. It clicks once, even if it lies on several organs.
    newest_clip: Option<u32>,
    /// True if the settings paused the task. The task goes on when the settings close.
    paused_for_settings: bool,
    /// Mouse and keyboard as the hand.
    pub(super) operate: Operate,
    /// State of the panel.
    pub(super) ui: UiState,
}

impl Session {
    pub(super) fn new(
        scene: &SceneFile,
        host: Host,
        station: &Station,
        sound: Option<Sound>,
        task: Option<Arc<Mutex<TaskView>>>,
        settings: Settings,
    ) -> Self {
        let mut ui = UiState {
            station: station.name().to_owned(),
            scene: scene.name().to_owned(),
            ..UiState::default()
        };
        ui.set(settings);
        let mut operate = Operate::new(station);
        operate.set(lead(settings.look));
        ui.task = ui.words.say("task-none");
        Self {
            host,
            feed: Feed::new(scene),
            inbox_state: zeroed_state(),
            inbox_tools: bytemuck::Zeroable::zeroed(),
            last_state: None,
            start: Instant::now(),
            forgot_dead: false,
            force: VecDeque::new(),
            frames: Frames::default(),
            warnings: Vec::new(),
            pending: Pending::default(),
            causes: Causes::of(scene),
            organs: (scene.organs().iter())
                .map(|it| str_from_name(&it.name).unwrap_or_default().to_owned())
                .collect(),
            was_reset: false,
            limited_ticks: 0,
            sound,
            task,
            acts: None,
            pause_note: PauseNote::default(),
            desk: None,
            mark: None,
            scope: Scope::default(),
            fogs: 0,
            bulletins: None,
            replay: None,
            recording: None,
            patch: None,
            presentation: Presentation::default(),
            kept: None,
            free: None,
            alarmed: None,
            notes: Notes::of(scene),
            heard: Heard::default(),
            newest_clip: None,
            operate,
            paused_for_settings: false,
            ui,
        }
    }

    /// Shows the assessor's bulletins of this station to an instructor, if a station is given.
    pub(super) fn watched_by_instructor(
        mut self,
        station: Option<&Station>,
    ) -> Result<Self, ServiceError> {
        if let Some(station) = station {
            let receiver = TaskReceiver::open(station)?;
            self.bulletins = Some((receiver, bytemuck::allocation::zeroed_box()));
            self.desk = Some((ActSender::open(station)?, Vec::new()));
            self.ui.instructor = true;
        }
        Ok(self)
    }

    /// Adds the views of a replay and of the recording.
    pub(super) fn showing(
        mut self,
        replay: Option<Arc<Mutex<ReplayView>>>,
        recording: Option<Arc<Mutex<RecordingView>>>,
    ) -> Self {
        (self.replay, self.recording) = (replay, recording);
        self
    }

    /// Sets who leads the instrument, and which devices are simulated.
    pub(super) fn of_player(mut self, watched: bool, simulated: [bool; 3]) -> Self {
        (self.ui.watched, self.ui.simulated) = (watched, simulated);
        self
    }

    /// Names the task of the replayed session.
    pub(super) fn of_replayed_task(mut self, task: Option<String>) -> Self {
        self.ui.replayed_task = task;
        self
    }

    pub(super) fn with_patch(mut self, patch: Option<Arc<Patch>>) -> Self {
        self.patch = patch;
        self
    }

    /// The square of `calot photon` for a picture of this moment, if the window has one.
    pub(super) fn patch(&self) -> Option<(Arc<Patch>, Lit)> {
        let patch = self.patch.as_ref()?;
        let (_, tools) = self.moment()?;
        Some((Arc::clone(patch), patch.lit(tools)))
    }

    /// Keeps pictures of the critical view in this folder, if there is a task.
    pub(super) fn keeping(mut self, folder: Option<&Path>) -> Self {
        let task = self.task.as_ref().zip(folder);
        self.kept = task.map(|(task, folder)| Watch::new(task, folder));
        self
    }

    /// Path of a picture that is to be kept now.
    pub(super) fn picture_due(&mut self) -> Option<PathBuf> {
        self.kept.as_mut().and_then(Watch::due)
    }

    pub(super) fn set_adapter(&mut self, adapter: String) {
        self.ui.adapter = adapter;
    }

    /// The newest state and tools, if both have arrived from this scene.
    pub(super) fn moment(&self) -> Option<(&StateFrame, &ToolFrame)> {
        self.feed.state().zip(self.feed.tools())
    }

    /// The tools that are drawn. While the free view is active, they have its camera.
    pub(super) fn seen_tools(&self, tools: &ToolFrame) -> ToolFrame {
        self.free.map_or(*tools, |free| free.seen(tools))
    }

    /// Updates the arrow towards the instrument, and the engineering view, if on.
    pub(super) fn update_overlay(&mut self, scene: &SceneFile, scope: &Scope) {
        let works = self.free.is_none() && self.replay.is_none();
        let tools = self.feed.tools().filter(|_| works);
        self.ui.tip_away = tools.and_then(|tools| towards_tip(tools, scope));
        self.scope = *scope;
        self.mark_acts(scope);
        if self.ui.overlay.is_none() {
            return;
        }
        if let Some((state, tools)) = self.feed.state().zip(self.feed.tools()) {
            let spheres = state.spheres().unwrap_or(&[]);
            let tools = self.seen_tools(tools);
            let mut overlay = Overlay::of(scene, spheres, &tools, scope);
            if self.ui.inside {
                overlay.leave_to_picture();
            }
            self.ui.overlay = Some(overlay);
        }
    }

    /// Seconds since the window opened.
    pub(super) fn time_s(&self) -> f32 {
        self.start.elapsed().as_secs_f32()
    }

    /// True if the newest state is of this scene and younger than `SILENCE`.
    pub(super) fn is_live(&self) -> bool {
        self.ui.link == Link::Live
    }

    /// Takes the record of a shown frame.
    pub(super) fn note_frame(&mut self, frame: FrameRecord) {
        if frame.live {
            self.ui.motion_to_picture_ms = frame.motion_to_picture_ns() as f32 * 1e-6;
        }
        if let Some(rate) = self.frames.note(frame) {
            self.ui.frames_per_second = rate;
        }
    }

    /// Counts a picture that was handed over. `refused`: reason for which the window
    /// system does not report it.
    pub(super) fn note_handed(&mut self, source: Option<Source>, refused: Option<&Missing>) {
        self.presentation.handed += 1;
        self.presentation.source = source;
        if self.presentation.refused.as_ref() != refused {
            self.presentation.refused = refused.cloned();
        }
    }

    /// Takes the end of a picture's way to the screen.
    pub(super) fn note_presented(&mut self, handed: &Handed, presented: Presented) {
        self.presentation.note(handed.frame.as_ref(), presented);
        if let Some((patch, lit)) = self.patch.as_ref().zip(handed.lit) {
            patch.presented(lit, handed.handed_ns, presented);
        }
    }

    /// Warns at once and in the summary.
    pub(super) fn warn(&mut self, warning: String, observer: &mut dyn FnMut(Observed<'_>)) {
        observer(Observed::Warning(&warning));
        self.warnings.push(warning);
    }

    /// Warns in the summary alone.
    pub(super) fn warn_later(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    /// Number of drawn pictures.
    pub(super) fn drawn(&self) -> u64 {
        self.frames.drawn()
    }

    pub(super) fn outcome(
        self,
        adapter: Option<String>,
        software_adapter: bool,
        ended: Ended,
    ) -> RunOutcome {
        let frames = self.frames.into_records();
        let pictures_per_second = rate(&frames);
        let slow = pictures_per_second.filter(|it| *it < PICTURES_MIN);
        let slow = slow.map(|rate| {
            format!(
                "the window showed {rate:.1} pictures a second, which is too few to train with; \
                 at least {PICTURES_MIN:.0} are needed: use a computer with a graphics card"
            )
        });
        RunOutcome {
            adapter,
            software_adapter,
            frames,
            pictures_per_second,
            presentation: self.presentation,
            fluids: None,
            counters: self.feed.counters(),
            ended,
            warnings: self.warnings.into_iter().chain(slow).collect(),
        }
    }
}

/// Settings of mouse and keyboard in this look.
fn lead(look: Look) -> Lead {
    Lead {
        left_handed: look.left_handed,
        sensitivity: 0.01 * f64::from(look.sensitivity_percent),
    }
}
