//! Screens over the picture: running task, pause, settings. Each is a pure function from the state
//! to widgets and requests.

mod act;
mod guide;
mod hold;
mod hud;
mod pause;
mod settings;

pub(super) use settings::look;
pub use settings::{Look, Settings};

use egui::{FontId, Frame, Key, RichText, TextStyle, Ui};

use super::{Asked, Link, UiState};

/// Size of text to be read from a distance, points.
pub(super) const BODY_POINTS: f32 = 20.0;
/// Width of a screen's column, points.
const COLUMN_POINTS: f32 = 820.0;

/// Shows the screen that covers the picture, if any.
pub(super) fn cover(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) -> bool {
    if !state.settings_open {
        return false;
    }
    egui::ScrollArea::vertical().show(ui, |ui| {
        let margin = ((ui.available_width() - COLUMN_POINTS) * 0.5).clamp(12.0, 120.0) as i8;
        Frame::new()
            .inner_margin(egui::Margin::symmetric(margin, 24))
            .show(ui, |ui| {
                legible(ui);
                settings::show(ui, state, asked);
            });
    });
    true
}

/// Shows the cards over the picture.
pub(super) fn over(ui: &Ui, place: egui::Rect, state: &UiState, asked: &mut Vec<Asked>) {
    // The pause screen must not cover a paused replay.
    let covers = !state.instructor && state.replay.is_none();
    let is_paused = state.link == Link::Live && state.is_paused() && covers;
    if !is_paused {
        hold::show(ui, place, state);
    }
    hud::show(ui, place, state, asked);
    act::show(ui, place, state);
    if is_paused {
        pause::show(ui, hud::roomy(ui, place), state, asked);
    }
}

/// Requests by keys while the settings are open. `None` if they are closed.
pub(super) fn keys(ui: &Ui, state: &UiState) -> Option<Vec<Asked>> {
    let table = [
        (Key::Escape, Asked::ShowSettings(false)),
        (Key::O, Asked::ShowSettings(false)),
        (Key::F11, Asked::ToggleFullScreen),
    ];
    let pressed = |key: Key| ui.input(|input| input.key_pressed(key));
    let chosen = table.into_iter().filter(|(key, _)| pressed(*key));
    state
        .settings_open
        .then(|| chosen.map(|(_, asked)| asked).collect())
}

/// Sets sizes of text that are legible from two metres away.
pub(super) fn legible(ui: &mut Ui) {
    let style = ui.style_mut();
    for name in [TextStyle::Body, TextStyle::Button] {
        style
            .text_styles
            .insert(name, FontId::proportional(BODY_POINTS));
    }
    style
        .text_styles
        .insert(TextStyle::Monospace, FontId::monospace(0.75 * BODY_POINTS));
    style.spacing.item_spacing.y = 8.0;
    style.spacing.button_padding = egui::vec2(10.0, 5.0);
}

pub(super) fn title(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(1.6 * BODY_POINTS).strong());
}

pub(super) fn part(ui: &mut Ui, text: &str) -> egui::Response {
    ui.add_space(10.0);
    ui.label(RichText::new(text).strong())
}
