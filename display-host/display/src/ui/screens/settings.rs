//! Settings of the interface.

use egui::Ui;

use super::super::{Asked, UiState};
use super::{part, title};
use crate::words::{Language, Words};

/// Text sizes to choose from, per cent.
const SIZES: [u16; 5] = [80, 100, 125, 150, 200];
/// Sensitivities of mouse and keyboard to choose from, per cent.
const SENSITIVITIES: [u16; 5] = [50, 75, 100, 150, 200];

/// Choices for the look of the interface, and for mouse and keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Size of all text, per cent of the default.
    pub text_percent: u16,
    /// True for the theme of high contrast.
    pub high_contrast: bool,
    /// True for a left hand at the mouse: the mouse's buttons and the panel change sides.
    pub left_handed: bool,
    /// Motion of the instrument for a motion of mouse or key, per cent of the default.
    pub sensitivity_percent: u16,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            text_percent: 100,
            high_contrast: false,
            left_handed: false,
            sensitivity_percent: 100,
        }
    }
}

/// The choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The interface's language.
    pub language: Language,
    /// Look of the interface, and settings of mouse and keyboard.
    pub look: Look,
    /// True if sound is on.
    pub sound: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            language: Language::default(),
            look: Look::default(),
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
    look(ui, words, &mut settings.look);
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

/// Adds the choices of the look.
pub(in crate::ui) fn look(ui: &mut Ui, words: &Words, look: &mut Look) {
    part(ui, &words.say("settings-text"));
    ui.horizontal_wrapped(|ui| {
        for percent in SIZES {
            ui.radio_value(&mut look.text_percent, percent, format!("{percent} %"));
        }
    });
    part(ui, &words.say("settings-contrast"));
    ui.horizontal_wrapped(|ui| {
        for (high, text) in [
            (false, "settings-contrast-usual"),
            (true, "settings-contrast-high"),
        ] {
            ui.radio_value(&mut look.high_contrast, high, words.say(text));
        }
    });
    part(ui, &words.say("settings-hand"));
    ui.horizontal_wrapped(|ui| {
        for (left, text) in [(false, "settings-hand-right"), (true, "settings-hand-left")] {
            ui.radio_value(&mut look.left_handed, left, words.say(text));
        }
    });
    part(ui, &words.say("settings-sensitivity"));
    ui.horizontal_wrapped(|ui| {
        for percent in SENSITIVITIES {
            // The other choices are in per cent, too. This one is shown as a factor, so that a
            // screen reader tells them apart.
            let digits = match percent {
                _ if percent.is_multiple_of(100) => 0,
                _ if percent.is_multiple_of(10) => 1,
                _ => 2,
            };
            let times = words.number(0.01 * f64::from(percent), digits).into();
            let text = words.say_with("settings-times", &[("times", times)]);
            ui.radio_value(&mut look.sensitivity_percent, percent, text);
        }
    });
}
