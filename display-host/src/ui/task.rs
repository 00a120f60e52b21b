//! The task in the panel: time, what is to be done, what was wrong. Words and shapes, never colour alone.

use egui::{Color32, RichText, Ui};

use super::panel::{Mark, line};

/// How a task stands, as far as the trainee is to see it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TaskView {
    /// What is to be done.
    pub title: String,
    /// Time of the task, s.
    pub time_s: f64,
    /// Steps, and whether each is done; none in an exam.
    pub steps: Vec<(String, bool)>,
    /// The newest alarm; none in an exam.
    pub alarm: Option<String>,
    /// Alarms so far; what is new sounds.
    pub alarms: usize,
    /// Score so far; none in an exam.
    pub score: Option<f64>,
    /// What to do next, for beginners.
    pub hint: Option<String>,
    /// Set once it is over.
    pub end: Option<TaskEnd>,
}

/// How a task ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TaskEnd {
    /// Passed.
    pub passed: bool,
    /// In a word, and why.
    pub text: String,
}

pub(super) fn show(ui: &mut Ui, task: &TaskView) {
    ui.label(RichText::new(&task.title).strong());
    let seconds = task.time_s.max(0.0) as u64;
    let time = format!("Time: {}:{:02}", seconds / 60, seconds % 60);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(time).monospace());
        if let Some(score) = task.score {
            ui.label(format!("Score: {score:.0} of 100"));
        }
    });
    if let Some(end) = &task.end {
        let mark = if end.passed { Mark::Good } else { Mark::Bad };
        line(ui, mark, &end.text);
    }
    for (step, done) in &task.steps {
        let (mark, word) = if *done {
            (Mark::Good, "done")
        } else {
            (Mark::Off, "to do")
        };
        line(ui, mark, &format!("{step} ({word})"));
    }
    if let Some(hint) = &task.hint {
        ui.label(RichText::new(format!("Hint: {hint}")).italics());
    }
    if let Some(alarm) = &task.alarm {
        let text = format!("Alarm {}: {alarm}", task.alarms);
        egui::Frame::new()
            .fill(Color32::from_rgb(120, 20, 20))
            .inner_margin(6)
            .show(ui, |ui| {
                ui.colored_label(Color32::WHITE, format!("⚠ {text}"))
            });
    }
}
