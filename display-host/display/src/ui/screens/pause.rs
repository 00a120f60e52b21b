//! Pause screen.

use egui::{Align2, Rect, Ui};

use super::super::{Asked, UiState};
use super::hud::{card, fitting, is_tight};
use super::title;

pub(super) fn show(ui: &Ui, place: Rect, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    card(ui, "pause", place, Align2::CENTER_CENTER, |ui| {
        fitting(ui, place);
        ui.set_max_width(place.width() - 48.0);
        match is_tight(place) {
            true => _ = ui.strong(words.say("pause-title")),
            false => title(ui, &words.say("pause-title")),
        }
        ui.label(words.say("pause-note"));
        let choices = [
            ("pause-go-on", Asked::Pause(false)),
            ("pause-again", Asked::Again),
            ("settings", Asked::ShowSettings(true)),
            ("pause-end", Asked::Quit),
        ];
        for (text, what) in choices {
            // A decided task cannot be restarted from here.
            let is_over = state.task_view.as_ref().is_some_and(|it| it.end.is_some());
            if what == Asked::Again && is_over {
                continue;
            }
            if ui.button(words.say(text)).clicked() {
                asked.push(what);
            }
        }
    });
}
