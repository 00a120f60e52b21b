//! Pass rules and weights, from a TOML file that is not trusted.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::ops::RangeInclusive;

use serde::Deserialize;
use shared_mem::message::Event;
use shared_mem::scene::OrganKind;
use toml::Spanned;

use crate::injury::{InjuryRule, Severity};
use crate::metrics::{Metric, Values};
use crate::step::Reason;
use crate::task::Task;

mod published;

use published::NO_SOURCE;
pub use published::{PassRule, Reference};

/// The built-in rules.
const BUILT_IN: &str = include_str!("../rules.toml");
/// Version of the file format.
const VERSION: u32 = 1;
/// Longest file accepted, bytes.
const MAX_BYTES: usize = 64 << 10;

/// Reason why rules are refused.
#[derive(Debug, thiserror::Error)]
pub enum RulesError {
    /// The file cannot be read.
    #[error(
        "{path}: {source}; name a file of rules with --rules, or omit it to use the built-in ones"
    )]
    Io {
        /// Path of the file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not TOML of the expected form.
    #[error("rules: {0}copy the built-in ones (`calot report --rules-file`) and edit the copy")]
    Form(String),
    /// A value is out of range.
    #[error("rules, line {line}: {what} is {value}; allowed is {allowed}")]
    Value {
        /// Line, from 1.
        line: usize,
        /// The value's name.
        what: String,
        /// The value.
        value: String,
        /// Allowed values.
        allowed: String,
    },
}

/// Pass rules and weights, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    text: String,
    touch: Vec<OrganKind>,
    burn: Vec<OrganKind>,
    pub(crate) quiet_s: f64,
    /// Heat from which on a structure counts as burnt, J.
    pub(crate) burn_j: f64,
    /// Force from which on a touch counts, N; 0: any touch.
    touch_n: f64,
    pub(crate) done: Done,
    flow_ml_min: Vec<(OrganKind, f64)>,
    injuries: Vec<InjuryRule>,
    penalties: Vec<Penalty>,
    tasks: BTreeMap<&'static str, TaskRules>,
    references: Vec<Reference>,
}

/// Thresholds at which steps count as done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Done {
    pub(crate) triangle: f64,
    pub(crate) lower_bed: f64,
    pub(crate) bed: f64,
    pub(crate) clips: usize,
    pub(crate) settle_s: f64,
    pub(crate) leak: f64,
    pub(crate) look_s: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Penalty {
    metric: Metric,
    free: f64,
    each: f64,
    most: f64,
    source: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
struct TaskRules {
    time_max_s: f64,
    time_source: Option<String>,
    pass: Vec<Condition>,
    /// The task's own penalties instead of the general ones.
    penalties: Option<Vec<Penalty>>,
}

impl Default for TaskRules {
    /// Nothing is required.
    fn default() -> Self {
        Self {
            time_max_s: f64::INFINITY,
            time_source: None,
            pass: Vec::new(),
            penalties: None,
        }
    }
}

/// Required range of the score or of a metric.
#[derive(Debug, Clone, PartialEq)]
struct Condition {
    /// The metric; `None`: the score.
    metric: Option<Metric>,
    at_least: f64,
    at_most: f64,
    source: Option<String>,
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

mod written {
    //! The rules as the file writes them.
    use super::{BTreeMap, Deserialize, Spanned};

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct File {
        pub(super) version: Spanned<u32>,
        pub(super) alarm: Alarm,
        pub(super) done: Done,
        #[serde(default)]
        pub(super) flow_ml_min: BTreeMap<Spanned<String>, Spanned<f64>>,
        /// Optional in older files, for which the built-in ones hold.
        pub(super) injury: Option<Vec<Injury>>,
        #[serde(default)]
        pub(super) penalty: Vec<Penalty>,
        #[serde(default)]
        pub(super) task: BTreeMap<Spanned<String>, Task>,
        #[serde(default)]
        pub(super) reference: Vec<Reference>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Alarm {
        pub(super) touch: Vec<Spanned<String>>,
        pub(super) burn: Vec<Spanned<String>>,
        pub(super) quiet_s: Spanned<f64>,
        /// Optional in older files, in which any heat counted.
        pub(super) burn_j: Option<Spanned<f64>>,
        /// Optional in older files, in which any touch counted.
        pub(super) touch_n: Option<Spanned<f64>>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Done {
        pub(super) triangle: Spanned<f64>,
        pub(super) lower_bed: Spanned<f64>,
        pub(super) bed: Spanned<f64>,
        pub(super) clips: Spanned<u32>,
        pub(super) settle_s: Spanned<f64>,
        pub(super) leak: Spanned<f64>,
        pub(super) look_s: Spanned<f64>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Injury {
        pub(super) organ: Spanned<String>,
        pub(super) open: Spanned<String>,
        pub(super) burn_j: Option<Spanned<f64>>,
        pub(super) source: Option<String>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Penalty {
        pub(super) metric: Spanned<String>,
        pub(super) free: Option<Spanned<f64>>,
        pub(super) each: Spanned<f64>,
        pub(super) most: Spanned<f64>,
        pub(super) source: Option<String>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Task {
        pub(super) time_max_s: Option<Spanned<f64>>,
        pub(super) time_source: Option<String>,
        pub(super) pass: Vec<Condition>,
        pub(super) penalty: Option<Vec<Penalty>>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Condition {
        pub(super) metric: Spanned<String>,
        pub(super) at_least: Option<Spanned<f64>>,
        pub(super) at_most: Option<Spanned<f64>>,
        pub(super) source: Option<String>,
    }

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Reference {
        pub(super) task: Spanned<String>,
        pub(super) metric: Spanned<String>,
        pub(super) value: Spanned<f64>,
        pub(super) who: String,
        pub(super) source: String,
    }
}

impl Default for Rules {
    fn default() -> Self {
        // A test checks the built-in file. If the file were broken, nothing would be required and
        // no point lost.
        Self::parse(BUILT_IN).unwrap_or_else(|_| Self {
            text: String::new(),
            touch: Vec::new(),
            burn: Vec::new(),
            quiet_s: 1.0,
            burn_j: 0.0,
            touch_n: 0.0,
            done: Done {
                triangle: 1.0,
                lower_bed: 1.0,
                bed: 1.0,
                clips: 2,
                settle_s: 2.0,
                leak: 0.0,
                look_s: 1.0,
            },
            flow_ml_min: Vec::new(),
            injuries: Vec::new(),
            penalties: Vec::new(),
            tasks: BTreeMap::new(),
            references: Vec::new(),
        })
    }
}

impl Rules {
    /// Text of the built-in rules.
    #[must_use]
    pub const fn built_in() -> &'static str {
        BUILT_IN
    }

    /// Reads a file.
    ///
    /// # Errors
    /// See [`RulesError`].
    pub fn read(path: &std::path::Path) -> Result<Self, RulesError> {
        let io = |source| RulesError::Io {
            path: path.to_owned(),
            source,
        };
        let mut text = String::new();
        // At most one byte more than allowed is read, because some files never end. `parse` refuses
        // a text that is one byte too long.
        let file = std::fs::File::open(path).map_err(io)?;
        let mut file = file.take(MAX_BYTES as u64 + 1);
        file.read_to_string(&mut text).map_err(io)?;
        Self::parse(&text)
    }

    /// Parses a text.
    ///
    /// # Errors
    /// See [`RulesError`]; lines count from 1.
    pub fn parse(text: &str) -> Result<Self, RulesError> {
        if text.len() > MAX_BYTES {
            let why = format!(
                "a file of {} bytes or more, at most {MAX_BYTES} are read; ",
                text.len()
            );
            return Err(RulesError::Form(why));
        }
        let file: written::File = toml::from_str(text)
            .map_err(|error| RulesError::Form(format!("{}\n", error.to_string().trim_end())))?;
        let check = Check { text };
        if *file.version.get_ref() != VERSION {
            let what = "version".to_owned();
            let value = file.version.get_ref().to_string();
            return Err(check.refuse(&file.version, what, &value, VERSION.to_string()));
        }
        let done = &file.done;
        let share = |name, value| check.number(name, value, 0.0..=1.0);
        let mut tasks = BTreeMap::new();
        for (name, task) in &file.task {
            tasks.insert(check.task_name(name)?.name(), check.task(task)?);
        }
        // Older files have no penalties of the endoscope drill. Those of an operation would cost
        // points for an instrument that nobody needs there.
        let drill = tasks.entry(Task::Scope.name()).or_default();
        if drill.penalties.is_none() {
            let built_in = Self::default().tasks.remove(Task::Scope.name());
            drill.penalties = built_in.and_then(|rules| rules.penalties);
        }
        let flows = file.flow_ml_min.iter().map(|(organ, flow)| {
            Ok((
                check.organ(organ)?,
                check.number("a flow", flow, 0.0..=5000.0)?,
            ))
        });
        Ok(Self {
            text: text.to_owned(),
            touch: check.organs(&file.alarm.touch)?,
            burn: check.organs(&file.alarm.burn)?,
            quiet_s: check.number("quiet_s", &file.alarm.quiet_s, 0.0..=60.0)?,
            burn_j: match &file.alarm.burn_j {
                Some(burn_j) => check.number("burn_j", burn_j, 0.0..=100.0)?,
                None => 0.0,
            },
            touch_n: match &file.alarm.touch_n {
                Some(touch_n) => check.number("touch_n", touch_n, 0.0..=100.0)?,
                None => 0.0,
            },
            done: Done {
                triangle: share("triangle", &done.triangle)?,
                lower_bed: share("lower_bed", &done.lower_bed)?,
                bed: share("bed", &done.bed)?,
                clips: check.whole("clips", &done.clips, 1..=3)? as usize,
                settle_s: check.number("settle_s", &done.settle_s, 0.0..=60.0)?,
                leak: share("leak", &done.leak)?,
                look_s: check.number("look_s", &done.look_s, 0.1..=60.0)?,
            },
            flow_ml_min: flows.collect::<Result<_, _>>()?,
            injuries: match &file.injury {
                Some(injuries) => injuries
                    .iter()
                    .map(|injury| check.injury(injury))
                    .collect::<Result<_, _>>()?,
                None => Self::default().injuries,
            },
            penalties: file
                .penalty
                .iter()
                .map(|penalty| check.penalty(penalty))
                .collect::<Result<_, _>>()?,
            tasks,
            references: (file.reference.iter())
                .map(|reference| check.reference(reference))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Text from which the rules were parsed.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn must_not_touch(&self, kind: Option<OrganKind>) -> bool {
        kind.is_some_and(|kind| self.touch.contains(&kind))
    }

    pub(crate) fn must_not_burn(&self, kind: Option<OrganKind>) -> bool {
        kind.is_some_and(|kind| self.burn.contains(&kind))
    }

    /// Rule for the injuries of this kind of organ.
    pub(crate) fn injury(&self, kind: OrganKind) -> Option<&InjuryRule> {
        self.injuries.iter().find(|it| it.organ == kind)
    }

    /// Flow from an organ of this kind after a complete cut, ml/min.
    pub(crate) fn flow_ml_min(&self, kind: Option<OrganKind>) -> f64 {
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

    /// Pass rules of a task that are not met.
    #[must_use]
    pub fn unmet(&self, task: Task, score: f64, values: &Values) -> Vec<Reason> {
        let Some(rules) = self.tasks.get(task.name()) else {
            return Vec::new();
        };
        let unmet = rules.pass.iter().filter_map(|condition| {
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

    /// True if a touch of a protected structure is hard enough to count.
    pub(crate) fn is_hard(&self, touch: &Event) -> bool {
        match touch {
            Event::Contact { .. } => self.touch_n <= 0.0,
            Event::Press { force_n } => self.touch_n > 0.0 && f64::from(*force_n) >= self.touch_n,
            _ => false,
        }
    }
}

/// Checks the values of a text, and names the line of a wrong one.
struct Check<'a> {
    text: &'a str,
}

impl Check<'_> {
    fn refuse<T>(&self, at: &Spanned<T>, what: String, value: &str, allowed: String) -> RulesError {
        let before = self.text.get(..at.span().start).unwrap_or_default();
        let value = session::printable(value);
        RulesError::Value {
            line: before.matches('\n').count() + 1,
            what,
            value,
            allowed,
        }
    }

    fn number(
        &self,
        what: &str,
        value: &Spanned<f64>,
        allowed: RangeInclusive<f64>,
    ) -> Result<f64, RulesError> {
        let number = *value.get_ref();
        match allowed.contains(&number) {
            true => Ok(number),
            false => {
                let range = format!("{} to {}", allowed.start(), allowed.end());
                Err(self.refuse(value, what.to_owned(), &number.to_string(), range))
            }
        }
    }

    fn whole(
        &self,
        what: &str,
        value: &Spanned<u32>,
        allowed: RangeInclusive<u32>,
    ) -> Result<u32, RulesError> {
        let number = *value.get_ref();
        match allowed.contains(&number) {
            true => Ok(number),
            false => {
                let range = format!("{} to {}", allowed.start(), allowed.end());
                Err(self.refuse(value, what.to_owned(), &number.to_string(), range))
            }
        }
    }

    fn organ(&self, name: &Spanned<String>) -> Result<OrganKind, RulesError> {
        let known = KINDS.iter().find(|(_, known)| known == name.get_ref());
        known.map(|(kind, _)| *kind).ok_or_else(|| {
            let all: Vec<&str> = KINDS.iter().map(|(_, name)| *name).collect();
            self.refuse(name, "an organ".into(), name.get_ref(), all.join(", "))
        })
    }

    fn organs(&self, names: &[Spanned<String>]) -> Result<Vec<OrganKind>, RulesError> {
        names.iter().map(|name| self.organ(name)).collect()
    }

    fn metric(&self, name: &Spanned<String>) -> Result<Metric, RulesError> {
        Metric::from_name(name.get_ref()).ok_or_else(|| {
            let all: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
            self.refuse(name, "a metric".into(), name.get_ref(), all.join(", "))
        })
    }

    fn penalty(&self, penalty: &written::Penalty) -> Result<Penalty, RulesError> {
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

    fn injury(&self, injury: &written::Injury) -> Result<InjuryRule, RulesError> {
        let open = &injury.open;
        let burn = injury.burn_j.as_ref();
        let burn = burn.map(|burn_j| self.number("burn_j", burn_j, 0.0..=1e6));
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
        })
    }

    fn task_name(&self, name: &Spanned<String>) -> Result<Task, RulesError> {
        let known = Task::from_name(name.get_ref()).filter(|task| *task != Task::Free);
        known.ok_or_else(|| {
            let names = Task::ALL.into_iter().filter(|task| *task != Task::Free);
            let allowed: Vec<&str> = names.map(Task::name).collect();
            self.refuse(name, "a task".into(), name.get_ref(), allowed.join(", "))
        })
    }

    fn reference(&self, reference: &written::Reference) -> Result<Reference, RulesError> {
        Ok(Reference {
            task: self.task_name(&reference.task)?,
            metric: self.metric(&reference.metric)?,
            value: self.number("a published value", &reference.value, -1e9..=1e9)?,
            who: reference.who.clone(),
            source: reference.source.clone(),
        })
    }

    fn task(&self, task: &written::Task) -> Result<TaskRules, RulesError> {
        let time = task.time_max_s.as_ref();
        let time = time.map(|time| self.number("time_max_s", time, 1.0..=86_400.0));
        let pass = task.pass.iter().map(|condition| {
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
        });
        let penalties = task.penalty.as_ref().map(|all| {
            let all = all.iter().map(|penalty| self.penalty(penalty));
            all.collect::<Result<_, _>>()
        });
        Ok(TaskRules {
            penalties: penalties.transpose()?,
            time_max_s: time.transpose()?.unwrap_or(f64::INFINITY),
            time_source: task.time_source.clone(),
            pass: pass.collect::<Result<_, _>>()?,
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

#[cfg(test)]
mod tests;
