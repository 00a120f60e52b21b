//! Screens of the launcher: start, running operation, debrief, questions. Each is a pure function
//! from the state to widgets and the user's wishes.

mod debrief;
mod failed;
mod lessons;
mod points;
mod progress;
mod running;
mod start;

pub use debrief::{Debrief, Earlier, MetricRow};
pub use failed::Failed;
pub use lessons::{ClosePicture, LessonView};
pub use points::{Asking, Points};
pub use progress::{LevelView, ProgressView, TaskProgress};
pub use running::Running;
pub use start::{DeviceLine, DeviceState, Start, StartForm};

use egui::Ui;

use super::page::{Name, drop_repeats, pressed, screen, typed};
use super::screens::Look;
use super::task::minutes;
use super::theme;
use crate::words::Words;

/// State of the launcher.
#[derive(Debug, Clone)]
pub struct Launcher {
    /// Words in the user's language.
    pub words: Words,
    /// Look of the interface.
    pub look: Look,
    /// The present screen.
    pub screen: Screen,
}

/// A screen of the launcher.
#[derive(Debug, Clone, PartialEq)]
pub enum Screen {
    /// Choice of trainee, task and devices.
    Start(Start),
    /// The operation runs in its own window.
    Running(Running),
    /// Result of an operation.
    Debrief(Debrief),
    /// Ratings from 1 to 5: the questionnaire, or the instructor's sheet.
    Points(Points),
    /// The operation failed, so there is nothing to debrief.
    Failed(Failed),
}

/// A wish of the user.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// Make these choices.
    Form(StartForm),
    /// Start the operation.
    Begin,
    /// Start the guided first steps.
    Guided,
    /// Start the next task of the curriculum.
    Next,
    /// Watch the expert, a scripted surgeon, in the chosen task.
    Watch,
    /// End the operation, with its report.
    Stop,
    /// End the operation without a report.
    StopAtOnce,
    /// Repeat the operation.
    Again,
    /// Repeat the operation with simulated devices.
    AgainEmulated,
    /// Return to the start screen.
    Another,
    /// Replay this moment of the recording, s.
    Replay(f64),
    /// Open the full report.
    OpenReport,
    /// Write and open the certificate of the completed levels.
    Certificate,
    /// Open the questionnaire or the sheet.
    Ask(Asking),
    /// Rate the present item; 0: it does not apply.
    Answer(u8),
    /// The name of the rater who fills the sheet is this.
    Rater(String),
    /// Return to the previous item.
    Previous,
    /// Save the ratings.
    Keep,
    /// Return without saving.
    Back,
    /// Quit.
    Quit,
}

impl Launcher {
    /// Title of the window.
    #[must_use]
    pub fn title(&self) -> String {
        let words = &self.words;
        let page = match &self.screen {
            Screen::Start(_) => words.say("launcher-start"),
            Screen::Running(_) => words.say("launcher-running"),
            Screen::Debrief(_) => words.say("launcher-debrief"),
            Screen::Points(points) => points.title(words),
            Screen::Failed(_) => words.say("launcher-failed"),
        };
        format!("Calot: {page}")
    }
}

/// Shows the launcher. Returns the user's wishes.
pub fn launcher(ui: &mut Ui, state: &Launcher) -> Vec<Wish> {
    let mut wishes = Vec::new();
    drop_repeats(ui);
    let look = state.look;
    ui.ctx()
        .set_zoom_factor(f32::from(look.text_percent) * 0.01);
    theme::apply(ui.ctx(), look.high_contrast);
    let words = &state.words;
    match &state.screen {
        Screen::Start(it) => start::show(ui, words, it, &mut wishes),
        Screen::Running(it) => running::show(ui, words, it, &mut wishes),
        Screen::Debrief(it) => debrief::show(ui, words, it, &mut wishes),
        Screen::Points(it) => points::show(ui, words, it, &mut wishes),
        Screen::Failed(it) => failed::show(ui, words, it, &mut wishes),
    }
    wishes
}
