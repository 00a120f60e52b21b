//! Progress of a trainee in the curriculum, and the task that comes next.

use egui::{CollapsingHeader, Ui};

use super::{StartForm, Wish};
use crate::ui::screens::part;
use crate::ui::widgets::{self, Mark, line};
use crate::words::Words;

/// A trainee's progress.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ProgressView {
    /// Number of tasks in which the trainee is proficient, and number of all tasks.
    pub done: [usize; 2],
    /// Levels of the curriculum.
    pub levels: Vec<LevelView>,
    /// Task and degree of help that come next. `None`: the curriculum is complete.
    pub next: Option<(String, String)>,
    /// True if at least one level is complete, so that there is a certificate.
    pub has_certificate: bool,
}

/// A level of the curriculum.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LevelView {
    /// Title in the user's language.
    pub title: String,
    /// Its tasks.
    pub tasks: Vec<TaskProgress>,
}

/// Progress in a task.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TaskProgress {
    /// Name of the task.
    pub task: String,
    /// Degree of help: a difficulty's name.
    pub difficulty: String,
    /// Number of passes in a row, and the number of them that makes the trainee proficient.
    pub passes: [usize; 2],
    /// True if the trainee is proficient.
    pub is_proficient: bool,
}

/// Shows the progress, with a button that chooses the next task, and one for the certificate.
pub(super) fn show(
    ui: &mut Ui,
    words: &Words,
    view: &ProgressView,
    form: &mut StartForm,
    wishes: &mut Vec<Wish>,
) {
    part(ui, &words.say("progress-title"));
    bar(ui, words, view);
    match &view.next {
        Some((task, difficulty)) => {
            let text = next(words, task, difficulty);
            if ui.button(text).clicked() {
                form.task.clone_from(task);
                form.difficulty.clone_from(difficulty);
            }
        }
        None => line(ui, Mark::Good, &words.say("progress-complete")),
    }
    if view.has_certificate && ui.button(words.say("certificate")).clicked() {
        wishes.push(Wish::Certificate);
    }
    CollapsingHeader::new(words.say("progress-levels"))
        .id_salt("levels")
        .show(ui, |ui| {
            for level in &view.levels {
                ui.label(&level.title);
                for it in &level.tasks {
                    task(ui, words, it);
                }
            }
        });
}

/// Shows the progress after an operation.
pub(super) fn after(ui: &mut Ui, words: &Words, view: &ProgressView) {
    part(ui, &words.say("progress-title"));
    bar(ui, words, view);
    if view.next.is_none() {
        line(ui, Mark::Good, &words.say("progress-complete"));
    }
}

/// Button of a debrief that goes on to the next task.
pub(super) fn button(words: &Words, view: &ProgressView) -> Option<(String, Wish)> {
    let (task, difficulty) = view.next.as_ref()?;
    let text = format!("{} (N)", next(words, task, difficulty));
    Some((text, Wish::Next))
}

fn next(words: &Words, task: &str, difficulty: &str) -> String {
    let values = [
        ("task", words.say(&format!("task-short-{task}")).into()),
        (
            "difficulty",
            words.say(&format!("difficulty-{difficulty}")).into(),
        ),
    ];
    words.say_with("progress-next", &values)
}

fn bar(ui: &mut Ui, words: &Words, view: &ProgressView) {
    let [done, of] = view.done;
    let values = [
        ("done", done.to_string().into()),
        ("of", of.to_string().into()),
    ];
    ui.label(words.say_with("progress-done", &values));
    let share = done as f32 / of.max(1) as f32;
    ui.add(widgets::bar(share).desired_height(10.0));
}

fn task(ui: &mut Ui, words: &Words, it: &TaskProgress) {
    let [passes, needed] = it.passes.map(|it| it.to_string().into());
    let values = [
        ("task", words.say(&format!("task-short-{}", it.task)).into()),
        (
            "difficulty",
            words.say(&format!("difficulty-{}", it.difficulty)).into(),
        ),
        ("passes", passes),
        ("needed", needed),
    ];
    let mark = if it.is_proficient {
        Mark::Good
    } else {
        Mark::Off
    };
    line(ui, mark, &words.say_with("progress-task", &values));
}
