//! Checks of the values that a file of rules holds.

use std::fmt::Display;
use std::ops::RangeInclusive;

use shared_mem::scene::OrganKind;
use toml::Spanned;

use super::error::RulesError;
use super::limits::{Condition, Least, ShowRule, Steadiness, TaskRules, ViewRule};
use super::published::{NO_SOURCE, Reference};
use super::weights::Penalty;
use super::written;
use crate::injury::{InjuryRule, Severity};
use crate::metrics::Metric;
use crate::task::Task;

/// Checks the values of a text, and names the line of a wrong one.
pub(super) struct Check<'a> {
    pub(super) text: &'a str,
}

impl Check<'_> {
    pub(super) fn refuse<T>(
        &self,
        at: &Spanned<T>,
        what: String,
        value: &str,
        allowed: String,
    ) -> RulesError {
        let before = self.text.get(..at.span().start).unwrap_or_default();
        let value = session::printable(value);
        RulesError::Value {
            line: before.matches('\n').count() + 1,
            what,
            value,
            allowed,
        }
    }

    pub(super) fn number<T: Copy + PartialOrd + Display>(
        &self,
        what: &str,
        value: &Spanned<T>,
        allowed: RangeInclusive<T>,
    ) -> Result<T, RulesError> {
        let number = *value.get_ref();
        match allowed.contains(&number) {
            true => Ok(number),
            false => {
                let range = format!("{} to {}", allowed.start(), allowed.end());
                Err(self.refuse(value, what.to_owned(), &number.to_string(), range))
            }
        }
    }

    pub(super) fn organ(&self, name: &Spanned<String>) -> Result<OrganKind, RulesError> {
        let known = KINDS.iter().find(|(_, known)| known == name.get_ref());
        known.map(|(kind, _)| *kind).ok_or_else(|| {
            let all: Vec<&str> = KINDS.iter().map(|(_, name)| *name).collect();
            self.refuse(name, "an organ".into(), name.get_ref(), all.join(", "))
        })
    }

    pub(super) fn organs(&self, names: &[Spanned<String>]) -> Result<Vec<OrganKind>, RulesError> {
        names.iter().map(|name| self.organ(name)).collect()
    }

    pub(super) fn metric(&self, name: &Spanned<String>) -> Result<Metric, RulesError> {
        Metric::from_name(name.get_ref()).ok_or_else(|| {
            let all: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
            self.refuse(name, "a metric".into(), name.get_ref(), all.join(", "))
        })
    }

    pub(super) fn penalty(&self, penalty: &written::Penalty) -> Result<Penalty, RulesError> {
        let free = penalty.free.as_ref();
        let free = free.map(|free| self.number("free", free, 0.0..=1e6));
        Ok(Penalty {
            metric: self.metric(&penalty.metric)?,
            free: free.transpose()?.unwrap_or(0.0),
            each: self.number("each", &penalty.each, 0.0..=1e6)?,
            most: self.number("most", &penalty.most, 0.0..=100.0)?,
            source: penalty.source.clone(),
        })
    }

    pub(super) fn injury(&self, injury: &written::Injury) -> Result<InjuryRule, RulesError> {
        let open = &injury.open;
        let burn = injury.burn_j.as_ref();
        let burn = burn.map(|burn_j| self.number("burn_j", burn_j, 0.0..=1e6));
        let deep = injury.burn_mm.as_ref();
        let deep = deep.map(|burn_mm| self.number("burn_mm", burn_mm, 0.0..=100.0));
        Ok(InjuryRule {
            organ: self.organ(&injury.organ)?,
            source: injury
                .source
                .clone()
                .unwrap_or_else(|| NO_SOURCE.to_owned()),
            open: match open.get_ref().as_str() {
                "fails" => Severity::Grave,
                "unpassed" => Severity::Serious,
                "costs" => Severity::Minor,
                other => {
                    let allowed = "fails (the task ends), unpassed (it goes on) or costs (points)";
                    let allowed = allowed.to_owned();
                    return Err(self.refuse(open, "open".into(), other, allowed));
                }
            },
            burn_j: burn.transpose()?.unwrap_or(f64::INFINITY),
            burn_mm: deep.transpose()?.unwrap_or(f64::INFINITY),
        })
    }

    fn share(&self, what: &str, value: &Spanned<f64>) -> Result<f64, RulesError> {
        self.number(what, value, 0.0..=1.0)
    }

    fn steadiness(
        &self,
        sway_mm_s: &Spanned<f64>,
        tilt_deg: &Spanned<f64>,
    ) -> Result<Steadiness, RulesError> {
        Ok(Steadiness {
            sway_mm_s: self.number("sway_mm_s", sway_mm_s, 0.1..=1e4)?,
            tilt_deg: self.number("tilt_deg", tilt_deg, 0.1..=90.0)?,
        })
    }

    pub(super) fn view(&self, view: &written::View) -> Result<ViewRule, RulesError> {
        let least = |it: &written::Least| {
            Ok::<Least, RulesError>(Least {
                triangle: self.share("triangle", &it.triangle)?,
                lower_bed: self.share("lower_bed", &it.lower_bed)?,
                two: self.share("two", &it.two)?,
            })
        };
        Ok(ViewRule {
            hold_s: self.number("hold_s", &view.hold_s, 0.1..=60.0)?,
            side_deg: self.number("side_deg", &view.side_deg, 0.0..=80.0)?,
            front: least(&view.front)?,
            behind: least(&view.behind)?,
            steadiness: self.steadiness(&view.sway_mm_s, &view.tilt_deg)?,
            source: view.source.clone(),
        })
    }

    pub(super) fn show(&self, show: &written::Show) -> Result<ShowRule, RulesError> {
        Ok(ShowRule {
            visible: self.share("visible", &show.visible)?,
            large: self.share("large", &show.large)?,
            small: self.share("small", &show.small)?,
            off: self.share("off", &show.off)?,
            steadiness: self.steadiness(&show.sway_mm_s, &show.tilt_deg)?,
        })
    }

    pub(super) fn task_name(&self, name: &Spanned<String>) -> Result<Task, RulesError> {
        let known = Task::from_name(name.get_ref()).filter(|task| *task != Task::Free);
        known.ok_or_else(|| {
            let names = Task::ALL.into_iter().filter(|task| *task != Task::Free);
            let allowed: Vec<&str> = names.map(Task::name).collect();
            self.refuse(name, "a task".into(), name.get_ref(), allowed.join(", "))
        })
    }

    pub(super) fn reference(
        &self,
        reference: &written::Reference,
    ) -> Result<Reference, RulesError> {
        Ok(Reference {
            task: self.task_name(&reference.task)?,
            metric: self.metric(&reference.metric)?,
            value: self.number("a published value", &reference.value, -1e9..=1e9)?,
            who: reference.who.clone(),
            source: reference.source.clone(),
        })
    }

    pub(super) fn condition(
        &self,
        condition: &written::Condition,
    ) -> Result<Condition, RulesError> {
        let bound = |value: &Option<Spanned<f64>>| {
            let value = value.as_ref();
            value.map(|value| self.number("a bound", value, -1e9..=1e9))
        };
        let name = &condition.metric;
        let metric = match name.get_ref().as_str() {
            "score" => None,
            _ => Some(self.metric(name)?),
        };
        let least = bound(&condition.at_least).transpose()?;
        let most = bound(&condition.at_most).transpose()?;
        let asks = |value: String, allowed: String| {
            self.refuse(
                name,
                format!("what is asked of {}", name.get_ref()),
                &value,
                allowed,
            )
        };
        match (least, most) {
            (None, None) => {
                let allowed = "at_least, at_most, or both: this would pass anybody";
                Err(asks("nothing".into(), allowed.into()))
            }
            (Some(least), Some(most)) if least > most => Err(asks(
                format!("at least {least} and at most {most}"),
                "at_least no more than at_most: this could not be passed".into(),
            )),
            _ => Ok(Condition {
                metric,
                at_least: least.unwrap_or(f64::NEG_INFINITY),
                at_most: most.unwrap_or(f64::INFINITY),
                source: condition.source.clone(),
            }),
        }
    }

    pub(super) fn task(&self, task: &written::Task) -> Result<TaskRules, RulesError> {
        let time = task.time_max_s.as_ref();
        let time = time.map(|time| self.number("time_max_s", time, 1.0..=86_400.0));
        let pass = task.pass.iter().map(|condition| self.condition(condition));
        let penalties = task.penalty.as_ref().map(|all| {
            let all = all.iter().map(|penalty| self.penalty(penalty));
            all.collect::<Result<_, _>>()
        });
        Ok(TaskRules {
            penalties: penalties.transpose()?,
            time_max_s: time.transpose()?.unwrap_or(f64::INFINITY),
            time_source: task.time_source.clone(),
            pass: pass.collect::<Result<_, _>>()?,
            burn: self.organs(&task.burn)?,
        })
    }
}

/// Names of organs in rules. Recipes of scenes use the same names.
const KINDS: [(OrganKind, &str); 11] = [
    (OrganKind::Liver, "liver"),
    (OrganKind::Gallbladder, "gallbladder"),
    (OrganKind::CysticDuct, "cystic-duct"),
    (OrganKind::CysticArtery, "cystic-artery"),
    (OrganKind::BileDuct, "bile-duct"),
    (OrganKind::Stomach, "stomach"),
    (OrganKind::Intestine, "intestine"),
    (OrganKind::Fat, "fat"),
    (OrganKind::ConnectiveTissue, "connective-tissue"),
    (OrganKind::AbdominalWall, "abdominal-wall"),
    (OrganKind::Vessel, "vessel"),
];
