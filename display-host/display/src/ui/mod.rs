//! The panel: a pure function from what is known to widgets, and to what the user asks for.

mod asked;
mod health;
mod instructor;
pub mod launcher;
mod overlay;
mod panel;
mod recording;
mod replay;
mod screens;
mod task;

pub use asked::{Asked, FreeView};
pub use health::TickHealth;
pub use instructor::{BULLETIN_ALARMS, Bulletin};
pub use overlay::{Circle, Line, Mark, Notes, Overlay};
pub use panel::ui;
pub use recording::RecordingView;
pub use replay::ReplayView;
pub use screens::Settings;
pub use task::{TaskEnd, TaskNote, TaskView};

use crate::render::timing::PassTimes;
use crate::words::Words;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::words::Switches;

/// How the controller does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Link {
    /// No state came yet.
    #[default]
    Waiting,
    /// States arrive.
    Live,
    /// States came, but none for this long, s.
    Silent(f32),
    /// It runs another scene.
    OtherScene,
}

/// Everything that the interface shows.
#[derive(Debug, Clone, Default)]
pub struct UiState {
    /// Station's name.
    pub station: String,
    /// Scene's name.
    pub scene: String,
    /// Where the show is, if this is a session shown again.
    pub replay: Option<ReplayView>,
    /// The picture is seen from where the user has turned it to, not through the endoscope.
    pub is_view_free: bool,
    /// How the recording does, if there is one.
    pub recording: Option<RecordingView>,
    /// What the trainee is to do.
    pub task: String,
    /// How a task stands, if there is one.
    pub task_view: Option<TaskView>,
    /// An instructor watches: nothing here reaches into the station.
    pub instructor: bool,
    /// How the task stands, for an instructor.
    pub bulletin: Option<Bulletin>,
    /// How the controller does.
    pub link: Link,
    /// Newest tools.
    pub tools: Option<ToolFrame>,
    /// How the ticks do.
    pub health: TickHealth,
    /// Force on the hand over the last seconds: time (s), N.
    pub force: Vec<[f64; 2]>,
    /// Newest frame's age when shown, ms: from the device sample.
    pub motion_to_photon_ms: f32,
    /// Frames a second.
    pub frames_per_second: f32,
    /// Graphics adapter.
    pub adapter: String,
    /// Something the user should know; shown until acknowledged.
    pub alarm: Option<String>,
    /// The endoscope's picture and its width over height.
    pub picture: Option<(egui::TextureId, f32)>,
    /// The engineering view, if it is on.
    pub overlay: Option<Overlay>,
    /// The picture shows spheres and springs inside the organs.
    pub inside: bool,
    /// The endoscope's angle, and how far its cable is turned.
    pub scope_degrees: [f32; 2],
    /// Where its camera is focused, mm before it.
    pub focus_mm: f32,
    /// How much of the view fog and soot on its lens take: 0 none, 1 all.
    pub lens_veil: f32,
    /// How thick smoke hangs in the cavity: light that it takes from a beam, 1/m.
    pub haze_per_m: f32,
    /// Whether it is being drawn off.
    pub is_smoke_drawn_off: bool,
    /// What the passes of a recent picture cost, ms.
    pub pass_times: Option<PassTimes>,
    /// Quality tier in use, 0 the best, and how many there are.
    pub quality: [usize; 2],
    /// Mouse and keyboard lead the instrument.
    pub in_hand: bool,
    /// The panel is hidden.
    pub panel_hidden: bool,
    /// What is said, in the user's language.
    pub words: Words,
    /// The settings cover the picture.
    pub settings_open: bool,
    /// The user's choices.
    pub settings: Settings,
}

impl UiState {
    /// Health of haptic device, tracker, pedal, with the messages that name them.
    fn devices(&self) -> [(&'static str, Option<DeviceHealth>); 3] {
        let health = |i: usize| self.tools.as_ref().map(|tools| tools.health[i]);
        [
            ("device-haptic", health(0)),
            ("device-tracker", health(1)),
            ("device-pedal", health(2)),
        ]
    }

    /// Takes these settings.
    pub fn set(&mut self, settings: Settings) {
        if settings.language != self.words.language() {
            self.words = Words::new(settings.language);
        }
        self.settings = settings;
    }

    /// Takes the newest that an instructor was told of the task; `None`: there is none any more, or nobody here
    /// understands it. What was told before is old then.
    pub fn watch(&mut self, bulletin: Option<Bulletin>) {
        self.task_view = bulletin.as_ref().map(|it| it.task.clone());
        self.bulletin = bulletin;
    }

    /// The next of the engineering view's states: off, marks on the picture, inside the organs.
    pub fn turn_engineering(&mut self) {
        (self.overlay, self.inside) = match (&self.overlay, self.inside) {
            (None, _) => (Some(Overlay::default()), false),
            (Some(_), false) => (Some(Overlay::default()), true),
            (Some(_), true) => (None, false),
        };
    }

    /// Whether the controller stands still.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.has_switch(Switches::PAUSED)
    }

    /// Whether force may leave.
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

/// The message that names an instrument, as [`ToolFrame::instrument`] counts them.
pub(crate) fn instrument_id(number: u32) -> &'static str {
    let ids = [
        "instrument-0",
        "instrument-1",
        "instrument-2",
        "instrument-3",
    ];
    ids.get(number as usize)
        .copied()
        .unwrap_or("instrument-unknown")
}
