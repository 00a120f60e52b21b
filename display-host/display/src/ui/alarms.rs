//! Alarms that are shown until somebody acknowledges them.

use egui::{Color32, Ui};

use super::{Asked, UiState};

/// Shows the alarm that concerns the hand and, if `all`, the alarm of the machine.
pub(super) fn show(ui: &mut Ui, state: &UiState, all: bool, asked: &mut Vec<Asked>) {
    let machine = state.machine_alarm.as_ref().filter(|_| all);
    let shown: Vec<&String> = state.alarm.iter().chain(machine).collect();
    if shown.is_empty() {
        return;
    }
    let words = &state.words;
    egui::Frame::new()
        .fill(Color32::from_rgb(120, 20, 20))
        .inner_margin(8)
        .show(ui, |ui| {
            for text in shown {
                let text = words.say_with("alarm", &[("text", text.as_str().into())]);
                ui.colored_label(Color32::WHITE, text);
            }
            if ui.button(words.say("alarm-acknowledge")).clicked() {
                asked.push(Asked::Acknowledge);
            }
        });
}
