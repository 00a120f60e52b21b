//! Settings of the interface.

use egui::Ui;

use super::super::{Asked, UiState};
use super::{part, title};
use crate::words::Language;

/// Text sizes to choose from, per cent.
const SIZES: [u16; 4] = [80, 100, 125, 150];

/// The choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The interface's language.
    pub language: Language,
    /// Size of all text, per cent of the default.
    pub text_percent: u16,
    /// True if sound is on.
    pub sound: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            language: Language::default(),
            text_percent: 100,
            sound: true,
        }
    }
}

pub(super) fn show(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    title(ui, &words.say("settings-title"));
    let mut settings = state.settings;
    part(ui, &words.say("settings-language"));
    ui.horizontal(|ui| {
        for language in Language::ALL {
            ui.radio_value(&mut settings.language, language, language.name());
        }
    });
    part(ui, &words.say("settings-text"));
    ui.horizontal(|ui| {
        for percent in SIZES {
            ui.radio_value(&mut settings.text_percent, percent, format!("{percent} %"));
        }
    });
    part(ui, &words.say("settings-sound"));
    ui.horizontal(|ui| {
        for (on, text) in [(true, "settings-sound-on"), (false, "settings-sound-off")] {
            ui.radio_value(&mut settings.sound, on, words.say(text));
        }
    });
    if settings != state.settings {
        asked.push(Asked::Set(settings));
    }
    ui.add_space(14.0);
    ui.horizontal_wrapped(|ui| {
        if ui.button(words.say("settings-screen")).clicked() {
            asked.push(Asked::ToggleFullScreen);
        }
        if ui.button(words.say("settings-close")).clicked() {
            asked.push(Asked::ShowSettings(false));
        }
    });
}
