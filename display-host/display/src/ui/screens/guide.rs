//! Card of a guided step: a moving picture, one sentence, the goal, and the next step.

use assess::Hint;
use egui::{RichText, Ui, vec2};

use super::super::UiState;
use super::super::sketch::{self, Sketch};
use super::super::task::TaskView;
use super::super::widgets::bar;
use crate::words::Words;

/// Names of the guided tasks.
const TASKS: [&str; 2] = ["basics", "phantom"];
/// Size of the moving picture, points.
const PICTURE_POINTS: [f32; 2] = [112.0, 84.0];
/// Length of the bar, points.
const BAR_POINTS: f32 = 240.0;
/// Size of the sentence, points.
const SENTENCE_TEXT_POINTS: f32 = 19.0;
/// Size of the other lines, points.
const OTHER_TEXT_POINTS: f32 = 15.0;

/// True for a guided task with a present step.
pub(super) fn is_of(task: &TaskView) -> bool {
    TASKS.contains(&task.task.as_str()) && task.hint.is_some()
}

/// Shows the present step of a guided task; if `is_short`, only its sentence and its progress.
pub(super) fn show(ui: &mut Ui, state: &UiState, task: &TaskView, is_short: bool) {
    let words = &state.words;
    let Some(hint) = task.hint.as_ref().filter(|_| is_of(task)) else {
        return;
    };
    if is_short {
        small(ui, &words.hint(hint));
        progress(ui, hint);
        return;
    }
    ui.horizontal_top(|ui| {
        let size = vec2(PICTURE_POINTS[0], PICTURE_POINTS[1]);
        sketch::show(ui, Sketch::of_step(&hint.step), size, &words.hint(hint));
        ui.vertical(|ui| instructions(ui, words, task, hint));
    });
}

fn instructions(ui: &mut Ui, words: &Words, task: &TaskView, hint: &Hint) {
    let number = task.steps.iter().take_while(|(_, done)| *done).count();
    let of = [
        ("number", (number + 1).to_string().into()),
        ("of", task.steps.len().to_string().into()),
    ];
    ui.label(
        RichText::new(words.hint(hint))
            .size(SENTENCE_TEXT_POINTS)
            .strong(),
    );
    // Two texts in a line leave more of the picture free.
    ui.horizontal_wrapped(|ui| {
        small(ui, &words.place(&hint.step));
        small(ui, &goal(words, &hint.step));
    });
    progress(ui, hint);
    let next = task.steps.get(number + 1);
    let next = match next.map(|(step, _)| words.step(step)) {
        Some(step) => words.say_with("guide-next", &[("step", step.into())]),
        None => words.say("guide-last"),
    };
    ui.horizontal_wrapped(|ui| {
        small(ui, &words.say_with("guide-step", &of));
        small(ui, &next);
    });
}

/// Shows the measured progress of the step as a bar.
fn progress(ui: &mut Ui, hint: &Hint) {
    let Some(percent) = hint.percent else { return };
    let bar = bar(0.01 * f32::from(percent));
    ui.add(bar.desired_height(8.0).desired_width(BAR_POINTS));
}

fn small(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(OTHER_TEXT_POINTS));
}

/// Condition under which the step is done.
fn goal(words: &Words, step: &assess::Step) -> String {
    use assess::Step;
    words.say(match step {
        Step::Show { .. } => "guide-goal-show",
        Step::Meet => "guide-goal-meet",
        Step::Grasp { .. } => "guide-goal-grasp",
        Step::Clip { count: 1, .. } => "guide-goal-clip",
        Step::Clip { .. } => "guide-goal-clips",
        Step::Divide { .. } => "guide-goal-divide",
        Step::Touch { .. } => "guide-goal-touch",
        Step::Carry { .. } => "guide-goal-carry",
        Step::Clear { .. } => "guide-goal-clear",
        _ => "guide-goal-current",
    })
}
