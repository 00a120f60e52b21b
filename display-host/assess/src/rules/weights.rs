//! Weights: the points that each metric costs, and the score.

use super::Rules;
use crate::metrics::{Metric, Values};
use crate::task::Task;

/// Points that a metric costs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Penalty {
    pub(super) metric: Metric,
    /// Value up to which the metric costs nothing.
    pub(super) free: f64,
    /// Points for each unit above `free`.
    pub(super) each: f64,
    /// Largest number of points that the metric costs.
    pub(super) most: f64,
    pub(super) source: Option<String>,
}

/// Points lost by one metric.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Lost {
    /// The metric.
    pub metric: &'static str,
    /// Value of the metric.
    pub value: f64,
    /// Lost points.
    pub points: f64,
}

impl Rules {
    /// Score of a task, 0 to 100, and the lost points.
    #[must_use]
    pub fn score(&self, task: Task, values: &Values) -> (f64, Vec<Lost>) {
        let own = self.tasks.get(task.name());
        let own = own.and_then(|rules| rules.penalties.as_ref());
        let lost = own.unwrap_or(&self.penalties).iter().filter_map(|penalty| {
            let value = values.get(penalty.metric);
            let points = penalty.each * (value - penalty.free);
            // A metric without a value costs nothing.
            (points > 0.0).then(|| Lost {
                metric: penalty.metric.name(),
                value,
                points: points.min(penalty.most),
            })
        });
        let lost: Vec<Lost> = lost.collect();
        let sum: f64 = lost.iter().map(|lost| lost.points).sum();
        ((100.0 - sum).max(0.0), lost)
    }
}
