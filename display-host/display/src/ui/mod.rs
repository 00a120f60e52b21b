//! The panel: a pure function from the state to widgets and the user's requests.

mod acts;
mod alarms;
mod arrow;
mod asked;
mod current;
pub mod feel;
mod health;
mod instructor;
mod keys;
pub mod launcher;
mod names;
mod overlay;
mod page;
mod panel;
mod recording;
mod replay;
mod screens;
mod sketch;
mod spoken;
mod station;
mod task;
mod theme;
mod widgets;

pub(crate) use acts::PauseNote;
pub use acts::{ActsReader, ActsView};
pub(crate) use arrow::towards_tip;
pub use asked::{Asked, FreeView};
pub use health::TickHealth;
pub use instructor::{BULLETIN_ALARMS, Bulletin};
pub use overlay::{Circle, Line, Mark, Notes, Overlay};
pub use panel::ui;
pub use recording::RecordingView;
pub use replay::ReplayView;
pub use screens::{Look, Settings};
pub use spoken::Spoken;
pub use task::{TaskEnd, TaskNote, TaskView};

use crate::render::timing::PassTimes;
use crate::words::Words;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::words::Switches;

/// State of the connection to the controller.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Link {
    /// No state has arrived yet.
    #[default]
    Waiting,
    /// States arrive.
    Live,
    /// No state has arrived for this long, s.
    Silent(f32),
    /// The controller runs another scene.
    OtherScene,
}

/// State of the interface.
#[derive(Debug, Clone, Default)]
pub struct UiState {
    /// Name of the station.
    pub station: String,
    /// Name of the scene.
    pub scene: String,
    /// Position in the session, if this is a replay.
    pub replay: Option<ReplayView>,
    /// True if the user's free view replaces the endoscope's.
    pub is_view_free: bool,
    /// State of the recording, if there is one.
    pub recording: Option<RecordingView>,
    /// Text in place of the task, if there is no `task_view`.
    pub task: String,
    /// State of the task, if there is one.
    pub task_view: Option<TaskView>,
    /// True for an instructor's display, which does not command the controller.
    pub instructor: bool,
    /// State of the task, for an instructor.
    pub bulletin: Option<Bulletin>,
    /// Acts of instructors.
    pub acts: ActsView,
    /// Place of an instructor's mark in the picture, from its middle, in half heights, y up.
    pub act_mark: Option<glam::Vec2>,
    /// Answer of the station to this instructor's last act, and true if the act was carried out.
    pub act_answer: Option<(String, bool)>,
    /// Number of remarks that the station has saved. Each empties the panel's field.
    pub saved_remarks: usize,
    /// State of the connection to the controller.
    pub link: Link,
    /// The latest tools.
    pub tools: Option<ToolFrame>,
    /// Health of the ticks.
    pub health: TickHealth,
    /// Force on the hand over the last seconds: time, s, and force, N.
    pub force: Vec<[f64; 2]>,
    /// Time from the device's sample until the newest picture was shown, ms.
    pub motion_to_picture_ms: f32,
    /// Frames a second.
    pub frames_per_second: f32,
    /// Graphics adapter.
    pub adapter: String,
    /// Alarm that concerns the user's hand; shown until acknowledged.
    pub alarm: Option<String>,
    /// Alarm of the machine, for instructors and engineers; shown until acknowledged.
    pub machine_alarm: Option<String>,
    /// Direction in the picture, right and up, towards an instrument that is out of view.
    pub tip_away: Option<[f32; 2]>,
    /// The endoscope's picture, and its ratio of width to height.
    pub picture: Option<(egui::TextureId, f32)>,
    /// The engineering view, if on.
    pub overlay: Option<Overlay>,
    /// True if the picture shows spheres and links inside the organs.
    pub inside: bool,
    /// Angle between the endoscope's view and its shaft, and its turn about the shaft, degrees.
    pub scope_degrees: [f32; 2],
    /// Focus distance of the endoscope's camera, mm.
    pub focus_mm: f32,
    /// Share of the view hidden by fog and soot on the endoscope's lens.
    pub lens_veil: f32,
    /// Attenuation of light by smoke in the cavity, 1/m.
    pub haze_per_m: f32,
    /// True while smoke is evacuated.
    pub is_smoke_drawn_off: bool,
    /// Volume in the suction's jar, ml.
    pub jar_ml: f32,
    /// True if the jar is full, so that nothing is sucked.
    pub jar_is_full: bool,
    /// Costs of the passes of a recent picture, ms.
    pub pass_times: Option<PassTimes>,
    /// Quality tier in use, 0 the best, and the number of tiers.
    pub quality: [usize; 2],
    /// True while mouse and keyboard lead the instrument.
    pub in_hand: bool,
    /// Pedals that mouse and keyboard press, once they must act.
    pub pressed: Switches,
    /// True if the scripted expert leads the instrument, and the user watches.
    pub watched: bool,
    /// For haptic device, tracker and pedal: true if it is simulated.
    pub simulated: [bool; 3],
    /// Name of the task of a replayed session, if known.
    pub replayed_task: Option<String>,
    /// A sentence to the trainee that is no alarm and ends by itself.
    pub note: Option<String>,
    /// True once the task's newest alarm is so old that it leaves the picture.
    pub alarm_is_old: bool,
    /// True while the panel is hidden.
    pub panel_hidden: bool,
    /// Words in the user's language.
    pub words: Words,
    /// True while the settings cover the picture.
    pub settings_open: bool,
    /// Settings of the user.
    pub settings: Settings,
}

impl UiState {
    /// Health of haptic device, tracker and pedal, with the messages that name them.
    fn devices(&self) -> [(&'static str, Option<DeviceHealth>); 3] {
        let health = |i: usize| self.tools.as_ref().map(|tools| tools.health[i]);
        [
            ("device-haptic", health(0)),
            ("device-tracker", health(1)),
            ("device-pedal", health(2)),
        ]
    }

    /// Name of the scene in the user's language. A scene that has no message keeps its own name.
    fn scene_said(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let scene: String = self.scene.chars().map(plain).collect();
        let id = format!("scene-{scene}");
        let said = self.words.say(&id);
        if said == id { self.scene.clone() } else { said }
    }

    /// True if mouse and keyboard can lead the instrument, and nobody leads it yet.
    fn may_take_hand(&self) -> bool {
        let [handle, _, _] = self.simulated;
        let is_free = !self.in_hand && !self.watched && !self.instructor;
        handle && is_free && self.replay.is_none() && !self.is_paused()
    }

    /// Applies these settings.
    pub fn set(&mut self, settings: Settings) {
        if settings.language != self.words.language() {
            self.words = Words::new(settings.language);
        }
        self.settings = settings;
    }

    /// Takes the latest bulletin for an instructor. It is `None` if there is no bulletin any more,
    /// or if it cannot be parsed. The previous bulletin is outdated then, and is dropped.
    pub fn watch(&mut self, bulletin: Option<Bulletin>) {
        self.task_view = bulletin.as_ref().map(|it| it.task.clone());
        self.bulletin = bulletin;
    }

    /// Turns to the next state of the engineering view: off, marks on the picture, view inside the
    /// organs.
    pub fn turn_engineering(&mut self) {
        (self.overlay, self.inside) = match (&self.overlay, self.inside) {
            (None, _) => (Some(Overlay::default()), false),
            (Some(_), false) => (Some(Overlay::default()), true),
            (Some(_), true) => (None, false),
        };
    }

    /// True if the controller is paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.has_switch(Switches::PAUSED)
    }

    /// True if the force is enabled.
    #[must_use]
    pub fn is_force_enabled(&self) -> bool {
        self.has_switch(Switches::FORCE_ENABLED)
    }

    pub(crate) fn has_switch(&self, switch: Switches) -> bool {
        self.tools
            .as_ref()
            .is_some_and(|tools| tools.switches().contains(switch))
    }
}

/// Message that names an instrument, numbered as in [`ToolFrame::instrument`].
pub(crate) fn instrument_id(number: u32) -> &'static str {
    let ids = [
        "instrument-0",
        "instrument-1",
        "instrument-2",
        "instrument-3",
        "instrument-4",
    ];
    ids.get(number as usize)
        .copied()
        .unwrap_or("instrument-unknown")
}
