//! Screens of the launcher: start, running operation, debrief, questions. Each is a pure function
//! from the state to widgets and the user's wishes.

mod debrief;
mod failed;
mod points;
mod running;
mod start;

pub use debrief::{Debrief, Earlier, MetricRow};
pub use failed::Failed;
pub use points::{Asking, Points};
pub use running::Running;
pub use start::{DeviceLine, DeviceState, Start, StartForm};

use egui::{Button, Color32, Response, RichText, Ui};

use super::screens::{BODY, legible};
use super::task::minutes;
use crate::words::Words;

/// State of the launcher.
#[derive(Debug, Clone)]
pub struct Launcher {
    /// Words in the user's language.
    pub words: Words,
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
    /// There is nothing to debrief.
    Failed(Failed),
}

/// A wish of the user.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// Make these choices.
    Form(StartForm),
    /// Start the operation.
    Begin,
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
    /// Open the full report.
    OpenReport,
    /// Open the questionnaire or the sheet.
    Ask(Asking),
    /// Rate the present item.
    Answer(u8),
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

/// A screen: its content, and below it the buttons, always visible; Enter presses the meant one, if
/// any.
fn screen(
    ui: &mut Ui,
    name: &'static str,
    meant: Option<usize>,
    buttons: &[(String, Wish)],
    wishes: &mut Vec<Wish>,
    add: impl FnOnce(&mut Ui, &mut Vec<Wish>),
) {
    // Nothing can be focused on a screen's first frame.
    let none_chosen = ui.memory(|memory| memory.focused().is_none());
    if let Some((_, wish)) = meant.and_then(|it| buttons.get(it))
        && none_chosen
        && pressed(ui, egui::Key::Enter)
    {
        wishes.push(wish.clone());
    }
    egui::Panel::bottom("launcher buttons")
        .resizable(false)
        .show(ui, |ui| {
            legible(ui);
            ui.add_space(10.0);
            // Widget ids of this screen alone: the focus of the previous one does not carry over.
            ui.push_id(name, |ui| {
                ui.horizontal_wrapped(|ui| {
                    for (number, (text, wish)) in buttons.iter().enumerate() {
                        let response = match meant == Some(number) {
                            true => first(ui, text),
                            false => ui.button(text.as_str()),
                        };
                        if response.clicked() {
                            wishes.push(wish.clone());
                        }
                    }
                });
            });
            ui.add_space(6.0);
        });
    egui::CentralPanel::default().show(ui, |ui| {
        egui::ScrollArea::vertical().id_salt(name).show(ui, |ui| {
            legible(ui);
            bright(ui);
            ui.set_width(ui.available_width());
            add(ui, wishes);
        });
    });
}

/// Text bright enough to be read from a distance.
fn bright(ui: &mut Ui) {
    ui.visuals_mut().widgets.noninteractive.fg_stroke.color = Color32::from_gray(215);
}

/// The default button: Enter presses it unless another widget has the focus.
fn first(ui: &mut Ui, text: &str) -> Response {
    let text = RichText::new(text).size(1.2 * BODY).strong();
    let response =
        ui.add(Button::new(text.color(Color32::WHITE)).fill(Color32::from_rgb(25, 95, 60)));
    if ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    response
}

/// Drops key repeats: a held key asks once, and does not act on the next screen. Editing and
/// navigation keys repeat.
fn drop_repeats(ui: &Ui) {
    use egui::Key;
    let goes_on = |key: &Key| {
        matches!(
            key,
            Key::Backspace
                | Key::Delete
                | Key::Tab
                | Key::ArrowLeft
                | Key::ArrowRight
                | Key::ArrowUp
                | Key::ArrowDown
        )
    };
    ui.input_mut(|input| {
        input.events.retain(|event| match event {
            egui::Event::Key { repeat, key, .. } => !repeat || goes_on(key),
            _ => true,
        });
    });
}

fn pressed(ui: &Ui, key: egui::Key) -> bool {
    ui.input(|input| input.key_pressed(key))
}

/// Keys pressed since the last frame, in order: on a slow machine there may be several.
fn typed(ui: &Ui) -> Vec<egui::Key> {
    let key = |event: &egui::Event| match event {
        egui::Event::Key {
            key, pressed: true, ..
        } => Some(*key),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(key).collect())
}
