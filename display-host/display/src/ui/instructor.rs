//! The instructor's panel: state of the task and the station, without any control over them.

use egui::{RichText, Ui};

use super::station::{controller, devices, passes, ticks};
use super::task::{self, alarm};
use super::widgets::{Mark, fine, line};
use super::{Asked, TaskNote, TaskView, UiState, alarms};

/// Largest number of alarms in a [`Bulletin`].
pub const BULLETIN_ALARMS: usize = 12;

/// Complete state of a task for observers, even in an exam. It is the text of service `task`.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bulletin {
    /// The trainee's view, without the restrictions of an exam.
    pub task: TaskView,
    /// Degree of help: a difficulty's name.
    pub difficulty: String,
    /// The newest alarms, the oldest first: time since the task began, s, and the error.
    pub alarms: Vec<(f64, TaskNote)>,
    /// Metrics so far: name, unit, value.
    pub metrics: Vec<(String, String, f64)>,
}

impl Bulletin {
    /// Parses a message's text; `None` if it is not a bulletin.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// Text of the message.
    #[must_use]
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

pub(super) fn show(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    let station = state.station.as_str().into();
    ui.heading(words.say_with("observe-title", &[("station", station)]));
    ui.label(&state.scene);
    alarms::show(ui, state, true, asked);
    match &state.bulletin {
        Some(bulletin) => assessment(ui, state, bulletin),
        None => line(ui, Mark::Off, &words.say("observe-no-task")),
    }
    ui.separator();
    controller(ui, state);
    devices(ui, state, true);
    ui.separator();
    fine(ui, |ui| {
        ticks(ui, state);
        passes(ui, state);
    });
    ui.separator();
    for (text, what) in [
        ("switch-engineering", Asked::ToggleEngineering),
        ("scope-next", Asked::NextScope),
        ("settings", Asked::ShowSettings(true)),
        ("quit", Asked::Quit),
    ] {
        if ui.button(words.say(text)).clicked() {
            asked.push(what);
        }
    }
}

fn assessment(ui: &mut Ui, state: &UiState, bulletin: &Bulletin) {
    let words = &state.words;
    let difficulty = words.say(&format!("difficulty-{}", bulletin.difficulty));
    ui.label(words.say_with("observe-difficulty", &[("difficulty", difficulty.into())]));
    task::show(ui, words, &bulletin.task);
    ui.separator();
    ui.label(RichText::new(words.say("observe-alarms")).strong());
    if bulletin.alarms.is_empty() {
        line(ui, Mark::Good, &words.say("observe-no-alarms"));
    }
    for (at_s, note) in bulletin.alarms.iter().rev() {
        let text = format!("{}  {}", task::minutes(*at_s), alarm(words, note));
        line(ui, Mark::Bad, &text);
    }
    ui.separator();
    ui.label(RichText::new(words.say("observe-metrics")).strong());
    egui::Grid::new("observed metrics")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for (name, unit, value) in &bulletin.metrics {
                ui.label(words.metric(name));
                ui.label(words.amount(*value, unit));
                ui.end_row();
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bulletin_comes_back_as_it_was_and_garbage_is_none() {
        let bulletin = Bulletin {
            task: TaskView {
                task: "clamp".into(),
                steps: vec![(assess::Step::LowerBed, true)],
                score: Some(77.5),
                ..TaskView::default()
            },
            difficulty: "exam".into(),
            alarms: vec![(3.5, TaskNote::default())],
            metrics: vec![("time_s".into(), "s".into(), 12.25)],
        };
        assert_eq!(Bulletin::parse(&bulletin.text()), Some(bulletin));
        for text in ["", "{}", "[1]", "\u{0}"] {
            assert_eq!(Bulletin::parse(text), None, "{text:?}");
        }
    }
}
