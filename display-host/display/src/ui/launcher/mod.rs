//! The launcher's screens: start, while an operation runs, debrief, questions. Each is a pure
//! function from what is known to widgets, and to what is wished for.

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

/// What the launcher shows.
#[derive(Debug, Clone)]
pub struct Launcher {
    /// What is said, in the user's language.
    pub words: Words,
    /// The screen.
    pub screen: Screen,
}

/// One screen of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Screen {
    /// Who does what, and how.
    Start(Start),
    /// The operation runs in its own window.
    Running(Running),
    /// What it came to.
    Debrief(Debrief),
    /// Points from 1 to 5: the questionnaire, or the instructor's sheet.
    Points(Points),
    /// There is nothing to debrief.
    Failed(Failed),
}

/// What the user wishes for.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// These choices.
    Form(StartForm),
    /// The operation.
    Begin,
    /// The operation to end, with its report.
    Stop,
    /// The operation to end without one.
    StopAtOnce,
    /// The same once more.
    Again,
    /// The same with emulated devices.
    AgainEmulated,
    /// The start screen.
    Another,
    /// The whole report.
    OpenReport,
    /// The questionnaire, or the sheet.
    Ask(Asking),
    /// These points for the item that is asked.
    Answer(u8),
    /// The item before.
    Previous,
    /// The points to be kept.
    Keep,
    /// Back without keeping them.
    Back,
    /// The end.
    Quit,
}

impl Launcher {
    /// The window's title.
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

/// Shows the launcher; returns what is wished for.
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

/// A screen: its buttons below, always in sight, one of them perhaps what Enter presses, and what
/// it says above them.
fn screen(
    ui: &mut Ui,
    name: &'static str,
    meant: Option<usize>,
    buttons: &[(String, Wish)],
    wishes: &mut Vec<Wish>,
    add: impl FnOnce(&mut Ui, &mut Vec<Wish>),
) {
    // A screen that is a frame old has chosen nothing yet.
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
            // Of this screen alone: what was chosen on the one before is not chosen here.
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

/// Text that is bright enough to be read from afar.
fn bright(ui: &mut Ui) {
    ui.visuals_mut().widgets.noninteractive.fg_stroke.color = Color32::from_gray(215);
}

/// The button that is meant: Enter presses it unless another widget was chosen.
fn first(ui: &mut Ui, text: &str) -> Response {
    let text = RichText::new(text).size(1.2 * BODY).strong();
    let response =
        ui.add(Button::new(text.color(Color32::WHITE)).fill(Color32::from_rgb(25, 95, 60)));
    if ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    response
}

/// A key that is held asks for one thing, not for what stands there next. What edits and what moves
/// about goes on while it is held.
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

/// The keys that were pressed since the last frame, in their order: on a slow machine there are
/// several.
fn typed(ui: &Ui) -> Vec<egui::Key> {
    let key = |event: &egui::Event| match event {
        egui::Event::Key {
            key, pressed: true, ..
        } => Some(*key),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(key).collect())
}
