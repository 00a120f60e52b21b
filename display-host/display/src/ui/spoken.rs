//! A bulletin in words, for readers without a window of their own.

use super::Bulletin;
use super::task::{alarm, outcome, title};
use crate::words::Words;

/// Words of a bulletin, in one language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spoken {
    /// The task.
    pub task: String,
    /// The step at hand; `None` after the last one.
    pub step: Option<String>,
    /// The alarms that the bulletin holds, the oldest first.
    pub alarms: Vec<String>,
    /// The outcome, with its reasons, once the task is over.
    pub end: Option<String>,
}

impl Spoken {
    /// Puts a bulletin into words.
    #[must_use]
    pub fn of(bulletin: &Bulletin, words: &Words) -> Self {
        let task = &bulletin.task;
        let step = task.steps.iter().find(|(_, done)| !done);
        let alarms = bulletin.alarms.iter();
        Self {
            task: title(words, task),
            step: step.map(|(step, _)| words.step(step)),
            alarms: alarms.map(|(_, note)| alarm(words, note)).collect(),
            end: task.end.as_ref().map(|end| outcome(words, end)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TaskEnd, TaskNote, TaskView};
    use super::*;
    use crate::words::Language;

    #[test]
    fn a_bulletin_is_said_in_both_languages() {
        let bulletin = Bulletin {
            task: TaskView {
                task: "clamp".to_owned(),
                end: Some(TaskEnd {
                    passed: false,
                    outcome: "failed".to_owned(),
                    reasons: Vec::new(),
                }),
                ..TaskView::default()
            },
            alarms: vec![(
                3.0,
                TaskNote {
                    kind: "perforated".to_owned(),
                    organ: Some("gallbladder".to_owned()),
                },
            )],
            ..Bulletin::default()
        };
        let [english, german] = Language::ALL.map(|it| Spoken::of(&bulletin, &Words::new(it)));
        assert!(english.alarms[0].contains("gallbladder"), "{english:?}");
        assert!(german.alarms[0].contains("Gallenblase"), "{german:?}");
        assert!(english.end.is_some() && english.step.is_none());
        assert_ne!(english.task, german.task);
    }
}
