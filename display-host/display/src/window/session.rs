//! State of a window: the feed, the panel's state, and the user's requests.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use shared_mem::message::{CommandMsg, Event, EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::service::{Host, ServiceError, Station, TaskReceiver};
use shared_mem::task::TaskMsg;
use shared_mem::words::{self, EventKind, Fault};

use super::free_view::FreeCamera;
use super::operate::{Lead, Operate};
use super::pending::Pending;
use super::refusal::Refusal;
use crate::effects::{Causes, Effect};
use crate::feed::{Feed, Offer};
use crate::headless::{Ended, Observed, RunOutcome, zeroed_state};
use crate::kept::Watch;
use crate::latency::FrameRecord;
use crate::patch::{Lit, Patch};
use crate::render::camera::Scope;
use crate::sound::Sound;
use crate::sound::synth::{Current, Heard};
use crate::ui::{
    Asked, Bulletin, Link, Look, Overlay, RecordingView, ReplayView, Settings, TaskView, UiState,
    towards_tip,
};
use crate::words::{Language, Words};

/// Largest number of frame records kept: nearly two hours at 60 Hz. Then the older half is dropped.
const FRAMES_KEPT: usize = 400_000;
/// Time without a new state after which the controller counts as silent.
const SILENCE: Duration = Duration::from_millis(500);
/// Longest wait for the answer to a command. The picture waits as well.
const COMMAND_PATIENCE: Duration = Duration::from_millis(60);
/// Longest wait for the answer to a command that begins a task.
const START_PATIENCE: Duration = Duration::from_secs(2);
/// Duration of a task alarm's sound.
const TASK_ALARM: Duration = Duration::from_millis(1500);
/// Time span of the force plot, s.
const FORCE_S: f64 = 6.0;

pub(super) struct Session {
    host: Host,
    feed: Feed,
    inbox_state: Box<StateFrame>,
    inbox_tools: ToolFrame,
    last_state: Option<Instant>,
    start: Instant,
    forgot_dead: bool,
    force: VecDeque<[f64; 2]>,
    frames: Vec<FrameRecord>,
    frame_times: VecDeque<Instant>,
    warnings: Vec<String>,
    /// Effects of events since the last picture.
    pending: Pending,
    causes: Causes,
    /// Names of the organs.
    organs: Vec<String>,
    /// True if the next picture must clear all bleeding and stains.
    was_reset: bool,
    /// `None`: muted, or no sound card.
    sound: Option<Sound>,
    heard: Heard,
    task: Option<Arc<Mutex<TaskView>>>,
    /// Bulletins of the assessor, for an instructor.
    bulletins: Option<(TaskReceiver, Box<TaskMsg>)>,
    replay: Option<Arc<Mutex<ReplayView>>>,
    recording: Option<Arc<Mutex<RecordingView>>>,
    patch: Option<Arc<Patch>>,
    /// Pictures of the critical view that are to be kept.
    kept: Option<Watch>,
    /// The free view, if active.
    free: Option<FreeCamera>,
    /// Time of the last task alarm.
    alarmed: Option<Instant>,
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
        (language, look): (Language, Look),
    ) -> Self {
        let mut ui = UiState {
            station: station.name().to_owned(),
            scene: scene.name().to_owned(),
            ..UiState::default()
        };
        ui.set(Settings {
            language,
            look,
            ..Settings::default()
        });
        let mut operate = Operate::new(station);
        operate.set(lead(look));
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
            frames: Vec::new(),
            frame_times: VecDeque::new(),
            warnings: Vec::new(),
            pending: Pending::default(),
            causes: Causes::of(scene),
            organs: (scene.organs().iter())
                .map(|it| str_from_name(&it.name).unwrap_or_default().to_owned())
                .collect(),
            was_reset: false,
            sound,
            task,
            bulletins: None,
            replay: None,
            recording: None,
            patch: None,
            kept: None,
            free: None,
            alarmed: None,
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
            self.ui.instructor = true;
        }
        Ok(self)
    }

    /// Takes the assessor's latest bulletin.
    fn take_bulletin(&mut self) {
        let Some((receiver, inbox)) = &mut self.bulletins else {
            return;
        };
        if receiver.newest(inbox) {
            self.ui.watch(inbox.text().and_then(Bulletin::parse));
        }
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

    /// The tools as drawn: while the free view is active, with its camera.
    pub(super) fn seen_tools(&self, tools: &ToolFrame) -> ToolFrame {
        self.free.map_or(*tools, |free| free.seen(tools))
    }

    /// Updates the arrow towards the instrument, and the engineering view, if on.
    pub(super) fn update_overlay(&mut self, scene: &SceneFile, scope: &Scope) {
        let works = self.free.is_none() && self.replay.is_none();
        let tools = self.feed.tools().filter(|_| works);
        self.ui.tip_away = tools.and_then(|tools| towards_tip(tools, scope));
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

    /// Receives all messages from the services.
    pub(super) fn receive(&mut self, observer: &mut dyn FnMut(Observed<'_>)) {
        let restarts = self.feed.counters().restarts;
        if self.host.newest_state(&mut self.inbox_state)
            && self.feed.offer_state(&self.inbox_state) == Offer::Taken
        {
            self.last_state = Some(Instant::now());
            self.forgot_dead = false;
            observer(Observed::State(&self.inbox_state));
        }
        if self.host.newest_tools(&mut self.inbox_tools)
            && self.feed.offer_tools(&self.inbox_tools) == Offer::Taken
        {
            let [x, y, z] = self.inbox_tools.force_n.map(f64::from);
            let force_n = (x * x + y * y + z * z).sqrt();
            let now = self.start.elapsed().as_secs_f64();
            self.force.push_back([now, force_n]);
            while self.force.front().is_some_and(|old| old[0] < now - FORCE_S) {
                self.force.pop_front();
            }
            observer(Observed::Tools(&self.inbox_tools));
        }
        if self.feed.counters().restarts > restarts {
            self.forget_effects();
            // The new controller is another run, whose task comes in new bulletins.
            if self.bulletins.is_some() {
                self.ui.watch(None);
            }
        }
        self.take_bulletin();
        self.judge_link();
        let now = self.start.elapsed().as_secs_f64();
        let (feed, ui, pending) = (&mut self.feed, &mut self.ui, &mut self.pending);
        let (causes, newest_clip) = (&self.causes, &mut self.newest_clip);
        let (heard, was_reset) = (&mut self.heard, &mut self.was_reset);
        let organs = &self.organs;
        self.host.drain_events(|event| {
            feed.note_event(event);
            // Clear all bleeding and stains, whoever requested the reset.
            if event.is(EventKind::Reset) {
                pending.clear();
                (*newest_clip, *was_reset) = (None, true);
            }
            // A clip that closes while muted never clicks.
            if let Ok(Event::Clip { number }) = event.decode()
                && newest_clip.replace(number) != Some(number)
                && ui.settings.sound
            {
                heard.clips = heard.clips.wrapping_add(1);
            }
            if let Some((id, concerns_hand)) = alarm(event) {
                let text = Some(ui.words.say(id));
                match concerns_hand {
                    true => ui.alarm = text,
                    false => ui.machine_alarm = text,
                }
            }
            if let Some((id, organ)) = unrest(event).zip(organs.get(event.organ as usize)) {
                let organ = ui.words.organ(organ).into();
                let text = Some(ui.words.say_with(id, &[("organ", organ)]));
                // Only the hand can draw a buried instrument out. Falls and shakes are the scene's
                // fault.
                match event.is(EventKind::Buried) {
                    true => ui.alarm = text,
                    false => ui.machine_alarm = text,
                }
            }
            if let Some(effect) = causes.event(event).filter(|_| ui.link == Link::Live) {
                pending.push(now, effect);
            }
            observer(Observed::Event(event));
        });
        self.host.drain_timing(|batch| {
            if feed.note_timing(batch) {
                ui.health.take(batch);
                observer(Observed::Timing(batch));
            }
        });
        self.ui.tools = self.feed.tools().copied();
        if let Some(task) = &self.task {
            let task = task.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let before = self.ui.task_view.as_ref().map_or(0, |task| task.alarms);
            // An exam has no text of the alarm, so no alarm sounds.
            if task.alarms > before && task.alarm.is_some() {
                self.alarmed = Some(Instant::now());
            }
            self.ui.task_view = Some(task);
        }
        let newest = |it: &Arc<Mutex<_>>| *it.lock().unwrap_or_else(PoisonError::into_inner);
        self.ui.replay = self.replay.as_ref().map(newest);
        let newest = |it: &Arc<Mutex<_>>| *it.lock().unwrap_or_else(PoisonError::into_inner);
        let recording = self.recording.as_ref().map(newest);
        let before = self.ui.recording.map(|it| it.standing);
        self.ui.recording = recording.map(|health| health.at(Instant::now()));
        let failing = self.ui.recording.filter(|it| it.begins_to_fail(before));
        if failing.is_some() {
            self.ui.alarm = Some(self.ui.words.say("recording-alarm"));
        }
        self.ui.is_view_free = self.free.is_some();
        self.sound(observer);
        self.ui.in_hand = self.operate.is_on();
        self.ui.force = self.force.iter().copied().collect();
    }

    /// Plays the sounds. If they fail, reports the problem once and goes on without sound.
    fn sound(&mut self, observer: &mut dyn FnMut(Observed<'_>)) {
        let Some(sound) = &self.sound else { return };
        if let Some(problem) = sound.take_problem() {
            observer(Observed::Warning(&problem));
            self.sound = None;
            return;
        }
        let tools = self.feed.tools().filter(|_| self.ui.link == Link::Live);
        self.heard.current = match tools.map_or(words::Current::Off, |t| t.switches().current()) {
            words::Current::Cut => Current::Cut,
            words::Current::Coagulate => Current::Coagulate,
            words::Current::Off => Current::Off,
        };
        let task_alarm = self.alarmed.is_some_and(|at| at.elapsed() < TASK_ALARM);
        self.heard.alarm = self.ui.alarm.is_some() || task_alarm;
        self.heard.heart = tools.is_some() && !self.ui.is_paused();
        let clips = self.heard.clips;
        sound.hear(match self.ui.settings.sound {
            true => self.heard,
            false => Heard {
                clips,
                ..Heard::default()
            },
        });
    }

    fn judge_link(&mut self) {
        let silence = self.last_state.map(|last| last.elapsed());
        self.ui.link = match silence {
            _ if self.feed.other_scene_id().is_some() => Link::OtherScene,
            None => Link::Waiting,
            Some(silence) if silence < SILENCE => Link::Live,
            Some(silence) => Link::Silent(silence.as_secs_f32()),
        };
        if matches!(self.ui.link, Link::Silent(_)) && !self.forgot_dead {
            self.host.forget_dead();
            self.forgot_dead = true;
        }
    }

    /// Effects since the last picture. Since then `seconds` have been played.
    pub(super) fn take_effects(&mut self, seconds: f32) -> Vec<Effect> {
        let mut effects = self.pending.take(self.start.elapsed().as_secs_f64());
        // While the controller is silent or paused, the electrode burns nothing, whatever the last
        // frame says.
        let works = self.is_live() && !self.ui.is_paused();
        if let Some((state, tools)) = self.moment().filter(|_| works) {
            effects.extend(self.causes.electrode(state, tools, seconds.min(0.2)));
        }
        effects
    }

    /// True if the newest state is of this scene and younger than `SILENCE`.
    pub(super) fn is_live(&self) -> bool {
        self.ui.link == Link::Live
    }

    /// Makes the next picture clear all bleeding and stains: after a reset, a start, a seek or a
    /// restart of the controller.
    fn forget_effects(&mut self) {
        self.pending.clear();
        self.newest_clip = None;
        self.was_reset = true;
    }

    /// True if the next picture must clear all bleeding and stains.
    pub(super) fn take_reset(&mut self) -> bool {
        std::mem::take(&mut self.was_reset)
    }

    /// Carries out the requests, except those that the window itself handles.
    pub(super) fn carry_out(&mut self, asked: &[Asked], observer: &mut dyn FnMut(Observed<'_>)) {
        for asked in asked {
            if self.ui.instructor && asked.reaches_in() {
                continue;
            }
            let (kind, argument) = match *asked {
                Asked::Pause(on) => (CommandMsg::PAUSE, u32::from(on)),
                // A task that has a start of its own begins there again.
                Asked::Reset => match self.ui.task_view.as_ref().and_then(|it| it.start) {
                    Some(task) => (CommandMsg::START, task),
                    None => (CommandMsg::RESET, 0),
                },
                Asked::EnableForce(on) => (CommandMsg::ENABLE_FORCE, u32::from(on)),
                Asked::Instrument(number) => (CommandMsg::INSTRUMENT, number),
                Asked::Acknowledge => {
                    (self.ui.alarm, self.ui.machine_alarm) = (None, None);
                    continue;
                }
                Asked::ToggleEngineering => {
                    self.ui.turn_engineering();
                    continue;
                }
                Asked::TogglePanel => {
                    self.ui.panel_hidden = !self.ui.panel_hidden;
                    continue;
                }
                Asked::ToggleHand => {
                    if let Err(refusal) = self.operate.toggle() {
                        self.refuse(&refusal, observer);
                    }
                    continue;
                }
                Asked::ShowSettings(open) => {
                    // The settings need the mouse, so release the instrument.
                    if open && self.operate.is_on() {
                        self.carry_out(&[Asked::ToggleHand], observer);
                    }
                    self.ui.settings_open = open;
                    self.pause_for_settings(open, observer);
                    continue;
                }
                Asked::Set(settings) => {
                    self.ui.set(settings);
                    self.operate.set(lead(settings.look));
                    continue;
                }
                Asked::Seek(at_ms) => (CommandMsg::SEEK, at_ms),
                Asked::Speed(speed) => (CommandMsg::SPEED, speed),
                Asked::FreeView(free) => {
                    let tools = self.feed.tools().filter(|_| free);
                    self.free = tools.map(FreeCamera::at);
                    continue;
                }
                Asked::LookAround(by) => {
                    let tools = self.feed.tools();
                    let here = self.free.or_else(|| tools.map(FreeCamera::at));
                    self.free = here.map(|mut camera| {
                        camera.turn(by);
                        camera
                    });
                    continue;
                }
                Asked::Again => {
                    self.carry_out(&[Asked::Reset, Asked::Pause(false)], observer);
                    continue;
                }
                // The window itself handles these.
                Asked::NextScope
                | Asked::TurnScope(_)
                | Asked::TurnFocus(_)
                | Asked::WipeLens
                | Asked::ToggleSuction
                | Asked::ToggleFullScreen
                | Asked::Quit => continue,
            };
            let command = CommandMsg { kind, argument };
            let patience = match kind {
                CommandMsg::START => START_PATIENCE,
                _ => COMMAND_PATIENCE,
            };
            let refusal = match self.host.command(command, patience) {
                Ok(reply) if reply.outcome == 0 => {
                    if [CommandMsg::RESET, CommandMsg::START, CommandMsg::SEEK].contains(&kind) {
                        self.forget_effects();
                        self.force.clear();
                    }
                    continue;
                }
                Ok(reply) => Refusal::Answer {
                    command,
                    answer: reply.outcome,
                },
                Err(error) => Refusal::Command { command, error },
            };
            self.refuse(&refusal, observer);
        }
    }

    /// Pauses the controller while the settings are open.
    fn pause_for_settings(&mut self, open: bool, observer: &mut dyn FnMut(Observed<'_>)) {
        let works = !self.ui.instructor && self.replay.is_none() && self.is_live();
        if open && works && !self.ui.is_paused() {
            self.paused_for_settings = true;
            self.carry_out(&[Asked::Pause(true)], observer);
        } else if !open && core::mem::take(&mut self.paused_for_settings) {
            self.carry_out(&[Asked::Pause(false)], observer);
        }
    }

    /// Reports a refusal: as an alarm in the user's language, and in English to the operator of the
    /// station.
    fn refuse(&mut self, refusal: &Refusal, observer: &mut dyn FnMut(Observed<'_>)) {
        observer(Observed::Warning(&refusal.said(&Words::default())));
        self.ui.alarm = Some(refusal.said(&self.ui.words));
    }

    /// Takes the record of a shown frame.
    pub(super) fn note_frame(&mut self, frame: FrameRecord) {
        let now = Instant::now();
        self.frame_times.push_back(now);
        while self.frame_times.len() > 2
            && self
                .frame_times
                .front()
                .is_some_and(|old| now - *old > Duration::from_secs(2))
        {
            self.frame_times.pop_front();
        }
        if let Some(first) = self.frame_times.front() {
            let span = (now - *first).as_secs_f32().max(1e-3);
            self.ui.frames_per_second = (self.frame_times.len() - 1) as f32 / span;
        }
        if frame.live {
            self.ui.motion_to_picture_ms = frame.motion_to_picture_ns() as f32 * 1e-6;
        }
        if self.frames.len() == FRAMES_KEPT {
            self.frames.drain(..FRAMES_KEPT / 2);
        }
        self.frames.push(frame);
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

    /// Number of drawn pictures whose records are kept.
    pub(super) fn drawn(&self) -> u64 {
        self.frames.len() as u64
    }

    pub(super) fn outcome(
        self,
        adapter: Option<String>,
        software_adapter: bool,
        ended: Ended,
    ) -> RunOutcome {
        RunOutcome {
            adapter,
            software_adapter,
            frames: self.frames,
            counters: self.feed.counters(),
            ended,
            warnings: self.warnings,
        }
    }
}

/// Message for an organ that falls or shakes, or in which the instrument begins. The trainee is not
/// at fault.
fn unrest(event: &EventMsg) -> Option<&'static str> {
    match event.decode() {
        Ok(Event::Fall { .. }) => Some("unrest-falls"),
        Ok(Event::Shake { .. }) => Some("unrest-shakes"),
        Ok(Event::Buried { .. }) => Some("unrest-buried"),
        _ => None,
    }
}

/// Settings of mouse and keyboard in this look.
fn lead(look: Look) -> Lead {
    Lead {
        left_handed: look.left_handed,
        sensitivity: 0.01 * f64::from(look.sensitivity_percent),
    }
}

/// Message for a fault that switches off the force or the current, and true if the person at the
/// station can mend the fault. An instructor and an engineer see the other faults.
fn alarm(event: &EventMsg) -> Option<(&'static str, bool)> {
    let Ok(Event::Fault(fault)) = event.decode() else {
        return None;
    };
    match fault {
        Fault::BadForce => Some(("fault-no-number", false)),
        Fault::StaleDevice => Some(("fault-late", false)),
        Fault::LostDevice => Some(("fault-gone", true)),
        Fault::SpeedTrip => Some(("fault-fast", true)),
        Fault::BothElectrodes => Some(("fault-both", true)),
        Fault::SilentDevice => Some(("fault-silent", false)),
        Fault::FrozenDevice => Some(("fault-frozen", false)),
        Fault::DeviceClock => Some(("fault-clock", false)),
        Fault::DeviceBundles => Some(("fault-bundles", false)),
        Fault::DeafDevice => Some(("fault-deaf", false)),
        Fault::LostPedal => Some(("fault-pedal", true)),
        Fault::HeldPedal => Some(("fault-held", true)),
        Fault::DeviceFault => Some(("fault-device", false)),
        Fault::DeviceWatchdog => Some(("fault-watchdog", false)),
        _ => None,
    }
}
