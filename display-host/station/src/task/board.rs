//! Sends the state of a running task to the instructors' displays.

use assess::{Assessment, Difficulty, Metric, Task};
use display_host::latency::now_ns;
use display_host::ui::{BULLETIN_ALARMS, Bulletin, TaskNote};
use shared_mem::service::{Station, TaskSender};
use shared_mem::task::TaskMsg;

use super::view::view_of;
use crate::say;

/// Sends bulletins: the state of a task as text, with score, steps, newest alarms and metrics.
/// Create it in the thread that sends.
pub(super) struct Board(Option<TaskSender>);

impl Board {
    /// Opens the service. If that fails, the task runs without bulletins for instructors.
    pub(super) fn open(station: &Station) -> Self {
        let sender = TaskSender::open(station);
        if let Err(problem) = &sender {
            say::note(format_args!(
                "warning: instructors do not see the state of the task: {problem}"
            ));
        }
        Self(sender.ok())
    }

    /// Sends a bulletin about the current state.
    pub(super) fn post(&self, task: Task, difficulty: Difficulty, assessment: &Assessment) {
        let Some(sender) = &self.0 else { return };
        let text = bulletin(task, difficulty, assessment).text();
        if let Some(message) = TaskMsg::new(now_ns(), &text) {
            sender.send(&message);
        }
    }
}

fn bulletin(task: Task, difficulty: Difficulty, assessment: &Assessment) -> Bulletin {
    let alarms = assessment.alarms();
    let newest = alarms
        .iter()
        .skip(alarms.len().saturating_sub(BULLETIN_ALARMS));
    let values = assessment.metrics();
    let metrics = Metric::ALL.into_iter().filter_map(|metric| {
        let value = values.get(metric);
        // Values that are zero or undefined are left out.
        let has_value = value.is_finite() && value.abs() > 0.0;
        has_value.then(|| (metric.name().to_owned(), metric.unit().to_owned(), value))
    });
    Bulletin {
        // An instructor also sees the score and the steps that an exam hides from the trainee.
        task: view_of(task, Difficulty::Trainee, assessment.status()),
        difficulty: difficulty.name().to_owned(),
        alarms: newest
            .map(|alarm| {
                let note = TaskNote {
                    kind: alarm.kind.name().to_owned(),
                    organ: alarm.organ.clone(),
                };
                (alarm.at_s, note)
            })
            .collect(),
        metrics: metrics.collect(),
    }
}

#[cfg(test)]
mod tests {
    use assess::{Anatomy, Rules};

    use super::*;

    #[test]
    fn an_instructor_sees_the_score_of_an_exam() {
        let rules = Rules::default();
        let assessment = Assessment::new(Task::Cut, Difficulty::Exam, rules, Anatomy::default());
        let sent = bulletin(Task::Cut, Difficulty::Exam, &assessment);
        assert_eq!((&*sent.difficulty, &*sent.task.task), ("exam", "cut"));
        assert!(sent.task.score.is_some());
        assert!(TaskMsg::new(0, &sent.text()).is_some());
    }
}
