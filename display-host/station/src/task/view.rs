//! A task as its trainee sees it.

use assess::{Difficulty, Outcome, Status, Task};
use display_host::ui::{TaskEnd, TaskNote, TaskView};

/// State of the task as the trainee sees it. An exam hides steps, alarm, hold and score until its
/// end.
pub(super) fn view_of(task: Task, difficulty: Difficulty, status: Status) -> TaskView {
    let is_over = status.outcome != Outcome::Running;
    let open = is_over || difficulty != Difficulty::Exam;
    let end = is_over.then(|| TaskEnd {
        passed: status.outcome == Outcome::Passed,
        outcome: status.outcome.name().to_owned(),
        reasons: status.reasons,
    });
    let note = |alarm: assess::Alarm| TaskNote {
        kind: alarm.kind.name().to_owned(),
        organ: alarm.organ,
    };
    TaskView {
        task: task.name().to_owned(),
        time_s: status.time_s,
        steps: if open { status.steps } else { Vec::new() },
        alarm: status.alarm.filter(|_| open).map(note),
        alarms: status.alarms,
        score: open.then_some(status.score),
        hint: status.hint,
        hold: status.hold.filter(|_| open),
        views_held: status.views_held,
        end,
        start: None,
    }
}
