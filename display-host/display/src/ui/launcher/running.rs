//! While the operation runs in its own window.

use egui::{Key, RichText, Ui};

use super::{Wish, minutes, pressed, screen};
use crate::ui::screens::title;
use crate::words::Words;

/// An operation that runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Running {
    /// Whose it is; empty: nobody's.
    pub trainee: String,
    /// The task's name.
    pub task: String,
    /// How long it has run, s.
    pub seconds: f64,
    /// What it last said.
    pub said: Option<String>,
    /// It was asked to end.
    pub ending: bool,
    /// It has had time to: it may be ended without its report.
    pub overdue: bool,
}

pub(super) fn show(ui: &mut Ui, words: &Words, running: &Running, wishes: &mut Vec<Wish>) {
    let offered = match (running.ending, running.overdue) {
        (false, _) => Some(("running-stop", Wish::Stop)),
        (true, true) => Some(("running-stop-at-once", Wish::StopAtOnce)),
        (true, false) => None,
    };
    if let Some((_, wish)) = &offered
        && pressed(ui, Key::S)
    {
        wishes.push(wish.clone());
    }
    // Nothing is chosen by itself: a second Enter at the start ends no operation.
    let buttons = offered.map(|(id, wish)| (words.say(id), wish));
    screen(ui, "running", None, buttons.as_slice(), wishes, |ui, _| {
        ui.add_space(0.2 * ui.available_height());
        ui.vertical_centered(|ui| {
            let id = if running.ending {
                "running-ending"
            } else {
                "running-title"
            };
            title(ui, &words.say(id));
            ui.label(words.say(&format!("task-{}", running.task)));
            if !running.trainee.is_empty() {
                ui.label(&running.trainee);
            }
            let time = minutes(running.seconds);
            ui.label(words.say_with("task-time", &[("time", time.into())]));
            ui.add_space(12.0);
            ui.label(words.say("running-note"));
            if let Some(said) = &running.said {
                ui.add_space(12.0);
                ui.label(RichText::new(said).weak());
            }
        });
    });
}
