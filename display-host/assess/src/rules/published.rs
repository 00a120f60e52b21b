//! Rules and published values for reports, each with its source.

use super::Rules;
use super::limits::Condition;
use crate::metrics::Metric;
use crate::task::{Difficulty, Task};

/// Text for a rule that names no source.
pub(super) const NO_SOURCE: &str = "no source";

/// A published value, which a report shows beside the trainee's.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The task that it belongs to.
    pub task: Task,
    /// The metric that it measures.
    pub metric: Metric,
    /// The value, in the metric's unit.
    pub value: f64,
    /// People who reached the value, or the programme whose aim it is.
    pub who: String,
    /// The publication.
    pub source: String,
}

/// A pass rule of a task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassRule<'a> {
    /// Name of the metric, or `score`.
    pub name: &'static str,
    /// Least value.
    pub at_least: f64,
    /// Largest value.
    pub at_most: f64,
    /// Source on which the rule is based.
    pub source: &'a str,
}

impl Condition {
    fn rule(&self) -> PassRule<'_> {
        PassRule {
            name: self.metric.map_or("score", Metric::name),
            at_least: self.at_least,
            at_most: self.at_most,
            source: self.source.as_deref().unwrap_or(NO_SOURCE),
        }
    }
}

impl Rules {
    /// Pass rules of a task for reports. The difficulty `Exam` adds the exam's rules.
    #[must_use]
    pub fn pass(&self, task: Task, difficulty: Difficulty) -> Vec<PassRule<'_>> {
        self.conditions(task, difficulty)
            .map(Condition::rule)
            .collect()
    }

    /// Time limit of a task as a rule for reports.
    #[must_use]
    pub fn time_rule(&self, task: Task) -> Option<PassRule<'_>> {
        let rules = self.tasks.get(task.name())?;
        rules.time_max_s.is_finite().then(|| PassRule {
            name: Metric::Time.name(),
            at_least: f64::NEG_INFINITY,
            at_most: rules.time_max_s,
            source: rules.time_source.as_deref().unwrap_or(NO_SOURCE),
        })
    }

    /// Source on which the weight of a metric in a task's score is based.
    #[must_use]
    pub fn weight_source(&self, task: Task, metric: &str) -> &str {
        let own = self.tasks.get(task.name());
        let own = own.and_then(|rules| rules.penalties.as_ref());
        let mut weights = own.unwrap_or(&self.penalties).iter();
        let weight = weights.find(|it| it.metric.name() == metric);
        weight
            .and_then(|it| it.source.as_deref())
            .unwrap_or(NO_SOURCE)
    }

    /// A source or a `who` of these rules in the language of this code. It stays as it is if the
    /// rules have no translation.
    #[must_use]
    pub fn said<'a>(&'a self, code: &str, text: &'a str) -> &'a str {
        let known = self.translations.get(code).and_then(|it| it.get(text));
        known.map_or(text, String::as_str)
    }

    /// Published values for a task.
    pub fn references(&self, task: Task) -> impl Iterator<Item = &Reference> {
        self.references.iter().filter(move |it| it.task == task)
    }
}
