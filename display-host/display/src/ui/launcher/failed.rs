//! A failed operation: its last messages, and what the user can do next.

use egui::{Key, RichText, Ui};

use super::{Wish, pressed, screen};
use crate::ui::screens::title;
use crate::ui::widgets::{Mark, line};
use crate::words::Words;

/// An operation without a result.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Failed {
    /// Exit status of the process, as text.
    pub status: String,
    /// Its last messages.
    pub said: Vec<String>,
    /// True if the operation used real devices. The user may then repeat it with simulated ones.
    pub had_devices: bool,
}

pub(super) fn show(ui: &mut Ui, words: &Words, failed: &Failed, wishes: &mut Vec<Wish>) {
    let mut buttons = vec![(words.say("failed-again"), Wish::Again)];
    if failed.had_devices {
        buttons.push((words.say("failed-emulated"), Wish::AgainEmulated));
    }
    buttons.push((words.say("debrief-another"), Wish::Another));
    buttons.push((words.say("failed-quit"), Wish::Quit));
    if pressed(ui, Key::Escape) {
        wishes.push(Wish::Another);
    }
    screen(ui, "failed", Some(0), &buttons, wishes, |ui, _| {
        title(ui, &words.say("failed-title"));
        let status = failed.status.as_str().into();
        line(
            ui,
            Mark::Bad,
            &words.say_with("failed-status", &[("status", status)]),
        );
        ui.label(words.say("failed-note"));
        ui.add_space(10.0);
        for said in &failed.said {
            ui.label(RichText::new(said).monospace());
        }
    });
}
