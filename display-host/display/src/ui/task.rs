//! Task in the panel: time, steps, errors. Every state shows by a word or a shape, never by colour
//! alone.

use assess::{Advice, Hint, Hold, Reason, Step};
use egui::{Color32, RichText, Ui};

use super::UiState;
use super::widgets::{Mark, line};
use crate::words::Words;

/// State of a task, as far as the trainee may see it.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TaskView {
    /// Name of the task on the command line.
    pub task: String,
    /// Time of the task, s.
    pub time_s: f64,
    /// Steps, each with true if it is done; empty in an exam.
    pub steps: Vec<(Step, bool)>,
    /// The newest alarm; `None` in an exam.
    pub alarm: Option<TaskNote>,
    /// Number of alarms so far; a new one sounds.
    pub alarms: usize,
    /// Score so far; `None` in an exam.
    pub score: Option<f64>,
    /// Next instruction, for beginners.
    pub hint: Option<Hint>,
    /// The running hold of the present step; `None` in an exam.
    pub hold: Option<Hold>,
    /// True for each side, front and behind, from which the critical view was held.
    pub views_held: [bool; 2],
    /// The end of the task, once it is over.
    pub end: Option<TaskEnd>,
    /// Number of the task in `CommandMsg::START`; `None` for one that begins with the organs at
    /// rest.
    pub start: Option<u32>,
}

/// An error of the trainee.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TaskNote {
    /// Name of its kind, as in `summary.json`.
    pub kind: String,
    /// The organ concerned, if any.
    pub organ: Option<String>,
}

/// End of a task.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TaskEnd {
    /// True if passed.
    pub passed: bool,
    /// Name of the outcome, as in `summary.json`.
    pub outcome: String,
    /// Reasons for the outcome.
    pub reasons: Vec<Reason>,
}

/// Title of the task.
pub(super) fn title(words: &Words, task: &TaskView) -> String {
    words.say(&format!("task-{}", task.task))
}

/// Time in minutes and seconds, with its label.
pub(super) fn time(words: &Words, task: &TaskView) -> String {
    words.say_with("task-time", &[("time", minutes(task.time_s).into())])
}

/// Time in minutes and seconds.
pub(super) fn minutes(seconds: f64) -> String {
    let seconds = seconds.max(0.0) as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// Text of an alarm.
pub(super) fn alarm(words: &Words, alarm: &TaskNote) -> String {
    let organ = words.organ(alarm.organ.as_deref().unwrap_or("?")).into();
    let id = format!("alarm-{}", alarm.kind.replace('_', "-"));
    words.say_with(&id, &[("organ", organ)])
}

/// Outcome of a task, with its reasons.
pub(super) fn outcome(words: &Words, end: &TaskEnd) -> String {
    let outcome = words.say(&format!("outcome-{}", end.outcome));
    if end.reasons.is_empty() {
        return outcome;
    }
    let reasons: Vec<_> = end.reasons.iter().map(|it| words.reason(it)).collect();
    let reasons = reasons.join("; ").into();
    words.say_with(
        "task-end",
        &[("outcome", outcome.into()), ("reasons", reasons)],
    )
}

/// The task with a hint that fits the instrument in the hand. The assessor is a little later than
/// the picture, and may still advise to take the instrument that is already there.
pub(super) fn with_tool(state: &UiState, task: &TaskView) -> TaskView {
    let mut task = task.clone();
    if let (Some(hint), Some(tools)) = (&mut task.hint, &state.tools)
        && let Advice::Take(instrument) = hint.advice
        && instrument.number() == tools.instrument
    {
        hint.advice = Advice::Use(instrument);
    }
    task
}

/// Shows the task. An old alarm stands there without its red frame.
pub(super) fn show(ui: &mut Ui, words: &Words, task: &TaskView, alarm_is_old: bool) {
    ui.label(RichText::new(title(words, task)).strong());
    ui.label(RichText::new(time(words, task)).monospace());
    if let Some(score) = task.score {
        let score = format!("{score:.0}").into();
        ui.label(words.say_with("task-score", &[("score", score)]));
    }
    if let Some(end) = &task.end {
        let mark = if end.passed { Mark::Good } else { Mark::Bad };
        line(ui, mark, &outcome(words, end));
    }
    for (step, done) in &task.steps {
        let (mark, id) = match done {
            true => (Mark::Good, "task-done"),
            false => (Mark::Off, "task-to-do"),
        };
        let step = words.step(step).into();
        line(ui, mark, &words.say_with(id, &[("step", step)]));
    }
    if let Some(hint) = &task.hint {
        if let Some(left) = words.left(hint) {
            ui.label(left);
        }
        let hint = words.say_with("task-hint", &[("text", words.hint(hint).into())]);
        ui.label(RichText::new(hint).italics());
    }
    if let Some(note) = &task.alarm {
        let values = [
            ("number", task.alarms.to_string().into()),
            ("text", alarm(words, note).into()),
        ];
        let text = words.say_with("task-alarm", &values);
        if alarm_is_old {
            line(ui, Mark::Bad, &text);
            return;
        }
        egui::Frame::new()
            .fill(Color32::from_rgb(120, 20, 20))
            .inner_margin(6)
            .show(ui, |ui| line(ui, Mark::Bad, &text));
    }
}
