//! Keys of the instrument, at the foot of the panel while mouse and keyboard lead it.

use egui::{RichText, Ui};

use super::UiState;
use crate::words::Words;

/// Size of the text, points.
const TEXT_POINTS: f32 = 14.0;
/// Height of a window below which the keys scroll with the panel, points, as with large text.
const LOW_POINTS: f32 = 420.0;

/// Text of the keys.
pub(super) fn text(words: &Words, left_handed: bool) -> String {
    words.say(if left_handed { "help-left" } else { "help" })
}

/// Shows the keys at the foot of the panel. In a low window they follow the other content instead.
pub(super) fn foot(ui: &mut Ui, state: &UiState) {
    if !state.in_hand || ui.available_height() < LOW_POINTS {
        return;
    }
    egui::Panel::bottom("keys")
        .resizable(false)
        .show(ui, |ui| label(ui, state));
}

/// Shows the keys among the panel's other content, in a window too low for [`foot`].
pub(super) fn among(ui: &mut Ui, state: &UiState, height: f32) {
    if state.in_hand && height < LOW_POINTS {
        label(ui, state);
    }
}

fn label(ui: &mut Ui, state: &UiState) {
    let text = text(&state.words, state.settings.look.left_handed);
    ui.label(RichText::new(text).size(TEXT_POINTS));
}
