//! The instructor's panel: state of the task and the station, and what the instructor may do there.

use egui::{Id, Key, RichText, TextEdit, Ui};
use shared_mem::message::{ActMsg, REMARK_BYTES};
use shared_mem::words::ActKind;

use super::station::{controller, devices, passes, ticks};
use super::task::{self, alarm};
use super::widgets::{Mark, fine, line};
use super::{Asked, TaskNote, TaskView, UiState, alarms};

/// Largest number of alarms in a [`Bulletin`].
pub const BULLETIN_ALARMS: usize = 12;
/// Smallest width of the table of metrics, points.
const TABLE_WIDTH_MIN_POINTS: f32 = 220.0;

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
    acts(ui, state, asked);
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
    task::show(ui, words, &bulletin.task, state.alarm_is_old);
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
    if ui.available_width() < TABLE_WIDTH_MIN_POINTS {
        for (name, unit, value) in &bulletin.metrics {
            let (name, amount) = (words.metric(name), words.amount(*value, unit));
            ui.label(format!("{name}: {amount}"));
        }
        return;
    }
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

/// Shows what the instructor may do at the station, and the station's answer.
fn acts(ui: &mut Ui, state: &UiState, asked: &mut Vec<Asked>) {
    let words = &state.words;
    ui.label(RichText::new(words.say("observe-acts")).strong());
    ui.label(words.say("observe-point"));
    let pause = match state.is_paused() {
        true => ActKind::Resume,
        false => ActKind::Pause,
    };
    ui.horizontal_wrapped(|ui| {
        for kind in [pause, ActKind::Fog, ActKind::Bleeding, ActKind::SlippedClip] {
            let text = words.say(&format!("observe-{}", kind.name().replace('_', "-")));
            if ui.button(text).clicked() {
                asked.push(Asked::Act(ActMsg::of(kind)));
            }
        }
    });
    // The answer is above the field, so that it stays in view in a low window.
    if let Some((answer, is_done)) = &state.act_answer {
        let mark = if *is_done { Mark::Good } else { Mark::Care };
        line(ui, mark, answer);
    }
    let id = Id::unique("remark");
    let kept: Option<(String, usize)> = ui.data(|it| it.get_temp(id));
    let (mut text, saved) = kept.unwrap_or_default();
    // A remark that was not saved stays in the field.
    if saved != state.saved_remarks {
        text.clear();
    }
    let name = ui.label(words.say("observe-remark"));
    let field = TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
    let field = ui.add(field).labelled_by(name.id);
    text.truncate(text.floor_char_boundary(REMARK_BYTES));
    let is_entered = field.lost_focus() && ui.input(|it| it.key_pressed(Key::Enter));
    let is_sent = ui.button(words.say("observe-send")).clicked() || is_entered;
    if let Some(act) = ActMsg::remark(&text).filter(|_| is_sent) {
        asked.push(Asked::Act(act));
    }
    ui.data_mut(|it| it.insert_temp(id, (text, state.saved_remarks)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bulletin_is_read_as_written_and_garbage_is_none() {
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
