//! Limits: thresholds of steps, forbidden structures, and the pass rules of the tasks.

use shared_mem::message::Event;
use shared_mem::scene::OrganKind;

use super::Rules;
use super::weights::Penalty;
use crate::hold::Lack;
use crate::injury::InjuryRule;
use crate::metrics::{Metric, Values};
use crate::steady::Held;
use crate::step::Reason;
use crate::task::{Difficulty, Task};

/// Thresholds at which steps count as done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Done {
    /// Least removed share of the tissue in the triangle.
    pub(crate) triangle: f64,
    /// Least removed share of the tissue in the lower third of the bed.
    pub(crate) lower_bed: f64,
    /// Least removed share of the tissue in the whole bed.
    pub(crate) bed: f64,
    /// Fewest clips on a vessel.
    pub(crate) clips: usize,
    /// Time from a division until its step may count as done, s. A leak may still show before then.
    pub(crate) settle_s: f64,
    /// Largest share of the whole vessel's flow that counts as no leak, and largest open share of a
    /// cut end that counts as closed, 0 to 1.
    pub(crate) leak: f64,
    /// Time for which an organ or the tip must be held in the picture, s.
    pub(crate) look_s: f64,
    /// Time that a task goes on after its last step while spilled stones lie in the body, s.
    pub(crate) collect_s: f64,
}

/// Time limit, pass rules and penalties of a task.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TaskRules {
    pub(super) time_max_s: f64,
    pub(super) time_source: Option<String>,
    pub(super) pass: Vec<Condition>,
    /// The task's own penalties instead of the general ones.
    pub(super) penalties: Option<Vec<Penalty>>,
    /// Structures that must not be burnt in this task, in addition to those of every task.
    pub(super) burn: Vec<OrganKind>,
}

impl Default for TaskRules {
    /// Nothing is required.
    fn default() -> Self {
        Self {
            time_max_s: f64::INFINITY,
            time_source: None,
            pass: Vec::new(),
            penalties: None,
            burn: Vec::new(),
        }
    }
}

/// Required range of the score or of a metric.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condition {
    /// The metric; `None`: the score.
    pub(super) metric: Option<Metric>,
    pub(super) at_least: f64,
    pub(super) at_most: f64,
    pub(super) source: Option<String>,
}

impl Rules {
    pub(crate) fn must_not_touch(&self, kind: Option<OrganKind>) -> bool {
        kind.is_some_and(|kind| self.touch.contains(&kind))
    }

    pub(crate) fn must_not_burn(&self, task: Task, kind: Option<OrganKind>) -> bool {
        let own = self.tasks.get(task.name()).map_or(&[][..], |it| &it.burn);
        kind.is_some_and(|kind| self.burn.contains(&kind) || own.contains(&kind))
    }

    /// True if a touch of a structure of this kind is hard enough to count.
    pub(crate) fn is_hard(&self, kind: Option<OrganKind>, touch: &Event) -> bool {
        let is_protected = self.must_not_touch(kind);
        let mut presses = self.press_n.iter();
        let limit_n = match is_protected {
            true => Some(self.touch_n),
            false => (presses.find(|(organ, _)| Some(*organ) == kind)).map(|(_, limit_n)| *limit_n),
        };
        match touch {
            // Without a limit of force, each touch of a protected structure counts.
            Event::Contact { .. } => is_protected && self.touch_n <= 0.0,
            Event::Press { force_n } => limit_n.is_some_and(|limit_n| {
                (limit_n > 0.0 || !is_protected) && f64::from(*force_n) >= limit_n
            }),
            _ => false,
        }
    }

    /// True if heat injures this kind of organ before it opens a hole.
    pub(crate) fn is_injured_by_heat(&self, kind: OrganKind) -> bool {
        self.injury(kind).is_some_and(|it| it.burn_j.is_finite())
    }

    /// Rule for the injuries of this kind of organ.
    pub(crate) fn injury(&self, kind: OrganKind) -> Option<&InjuryRule> {
        self.injuries.iter().find(|it| it.organ == kind)
    }

    /// Flow from an organ of this kind after a complete cut, ml/min.
    #[must_use]
    pub fn flow_ml_min(&self, kind: Option<OrganKind>) -> f64 {
        let mut flows = self.flow_ml_min.iter();
        flows
            .find(|(organ, _)| Some(*organ) == kind)
            .map_or(0.0, |(_, flow)| *flow)
    }

    /// Time limit of a task, s; infinite without one.
    #[must_use]
    pub fn time_max_s(&self, task: Task) -> f64 {
        let rules = self.tasks.get(task.name());
        rules.map_or(f64::INFINITY, |rules| rules.time_max_s)
    }

    /// Unmet pass rules of a task. The difficulty `Exam` adds the exam's rules.
    #[must_use]
    pub fn unmet(
        &self,
        task: Task,
        difficulty: Difficulty,
        score: f64,
        values: &Values,
    ) -> Vec<Reason> {
        let unmet = self.conditions(task, difficulty).filter_map(|condition| {
            let metric = condition.metric;
            let value = metric.map_or(score, |it| values.get(it));
            if value < condition.at_least {
                return Some(Reason::TooLittle {
                    metric,
                    value,
                    limit: condition.at_least,
                });
            }
            (value > condition.at_most).then_some(Reason::TooMuch {
                metric,
                value,
                limit: condition.at_most,
            })
        });
        unmet.collect()
    }

    /// Conditions of a pass. Free practice has no pass.
    pub(super) fn conditions(
        &self,
        task: Task,
        difficulty: Difficulty,
    ) -> impl Iterator<Item = &Condition> {
        let own = self.tasks.get(task.name()).map_or(&[][..], |it| &it.pass);
        let is_exam = difficulty == Difficulty::Exam && task != Task::Free;
        let exam = if is_exam { &self.exam[..] } else { &[] };
        own.iter().chain(exam)
    }
}

/// Least share of each criterion of the critical view that a picture must show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Least {
    /// The cleared triangle.
    pub triangle: f64,
    /// The freed lower third of the bed.
    pub lower_bed: f64,
    /// Visible share of the cystic duct, and of the cystic artery.
    pub two: f64,
}

/// Limits of a picture that is held: still and level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steadiness {
    /// Largest speed of the point 0.1 m before the lens, mm/s.
    pub sway_mm_s: f64,
    /// Largest tilt of the horizon, degrees.
    pub tilt_deg: f64,
}

impl Steadiness {
    pub(crate) fn lack(&self, held: &Held) -> Option<Lack> {
        if held.sway_mm_s() > self.sway_mm_s {
            return Some(Lack::Sway);
        }
        (held.tilt_deg > self.tilt_deg).then_some(Lack::Tilt)
    }
}

/// Rule for showing the critical view of safety.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewRule {
    /// Time for which each view is held, s.
    pub hold_s: f64,
    /// Least angle between the line of sight and the plane of duct and artery, degrees.
    pub side_deg: f64,
    /// Shares to be seen from the front.
    pub front: Least,
    /// Shares to be seen from behind.
    pub behind: Least,
    /// Limits of sway and tilt.
    pub steadiness: Steadiness,
    /// Source on which the rule is based.
    pub source: Option<String>,
}

/// Rule for showing an organ in the tasks `scope` and `basics`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShowRule {
    /// Least visible share of the organ.
    pub visible: f64,
    /// An organ that fills at least this share of the picture counts as visible, however much of it
    /// is outside or hidden.
    pub large: f64,
    /// Least share of the picture that the organ must fill.
    pub small: f64,
    /// Largest distance of the organ's seen part from the picture's middle, as a share of the
    /// picture's radius.
    pub off: f64,
    /// Limits of sway and tilt.
    pub steadiness: Steadiness,
}
