//! Screen of a running operation.

use egui::{Key, RichText, Ui};

use super::{Wish, pressed, screen};
use crate::ui::names;
use crate::ui::screens::title;
use crate::words::Words;

/// A running operation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Running {
    /// Name of the trainee; empty: a guest.
    pub trainee: String,
    /// True if the expert operates.
    pub watched: bool,
    /// Name of the task.
    pub task: String,
    /// Progress of the organs' preparation, while it lasts.
    pub preparing: Option<String>,
    /// True if it was asked to end.
    pub ending: bool,
    /// True if the operation has had time to end. The user may then stop it without a report.
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
    // No button has the focus, so that a second Enter at the start does not end the operation.
    let buttons = offered.map(|(id, wish)| (words.say(id), wish));
    screen(ui, "running", None, buttons.as_slice(), wishes, |ui, _| {
        ui.add_space(0.2 * ui.available_height());
        ui.vertical_centered(|ui| {
            let id = match (running.ending, &running.preparing) {
                (true, _) => "running-ending",
                (false, Some(_)) => "running-preparing-title",
                (false, None) => "running-title",
            };
            title(ui, &words.say(id));
            ui.label(words.say(&format!("task-{}", running.task)));
            if running.watched {
                ui.label(words.say("who-expert"));
            } else if !running.trainee.is_empty() {
                ui.label(names::drawn(&running.trainee));
            }
            ui.add_space(12.0);
            ui.label(words.say("running-note"));
            if let Some(said) = &running.preparing {
                ui.add_space(12.0);
                ui.label(RichText::new(said).weak());
            }
        });
    });
}
