//! Pass rules and weights, from a TOML file that is not trusted.

mod check;
mod error;
mod limits;
mod published;
mod weights;
mod written;

use std::collections::BTreeMap;
use std::io::Read as _;

use shared_mem::scene::OrganKind;

use crate::injury::InjuryRule;
use crate::task::Task;
use check::Check;
pub use error::RulesError;
pub(crate) use limits::Done;
use limits::{Condition, TaskRules};
pub use limits::{Least, ShowRule, Steadiness, ViewRule};
pub use published::{PassRule, Reference};
pub(crate) use weights::Lost;
use weights::Penalty;

/// The built-in rules.
const BUILT_IN: &str = include_str!("../rules.toml");
/// Version of the file format.
const VERSION: u32 = 1;
/// Longest file accepted, bytes.
const MAX_BYTES: usize = 64 << 10;

/// Pass rules and weights, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    text: String,
    touch: Vec<OrganKind>,
    burn: Vec<OrganKind>,
    pub(crate) quiet_s: f64,
    /// Least heat of a structure that counts as burnt, J.
    pub(crate) burn_j: f64,
    /// Least force of a touch that counts, N; 0: any touch.
    touch_n: f64,
    /// Least force of a press on a structure that may be touched, by kind, N.
    press_n: Vec<(OrganKind, f64)>,
    pub(crate) done: Done,
    /// Rule for the critical view; `None`: it need not be shown.
    pub(crate) view: Option<ViewRule>,
    pub(crate) show: ShowRule,
    flow_ml_min: Vec<(OrganKind, f64)>,
    injuries: Vec<InjuryRule>,
    penalties: Vec<Penalty>,
    /// Pass rules of an exam, in addition to those of its task.
    exam: Vec<Condition>,
    tasks: BTreeMap<&'static str, TaskRules>,
    references: Vec<Reference>,
    /// Translations of sources and of `who`, by the language's code and the file's text.
    translations: BTreeMap<String, BTreeMap<String, String>>,
}

impl Default for Rules {
    fn default() -> Self {
        // A test checks the built-in file. If the file were broken, there would be no pass rule and
        // no point would be lost.
        Self::parse(BUILT_IN).unwrap_or_else(|_| Self {
            text: String::new(),
            touch: Vec::new(),
            burn: Vec::new(),
            quiet_s: 1.0,
            burn_j: 0.0,
            touch_n: 0.0,
            press_n: Vec::new(),
            done: Done {
                triangle: 1.0,
                lower_bed: 1.0,
                bed: 1.0,
                clips: 2,
                settle_s: 2.0,
                leak: 0.0,
                look_s: 1.0,
                collect_s: 0.0,
            },
            view: None,
            show: ShowRule {
                visible: 1.0,
                large: 1.0,
                small: 0.0,
                off: 1.0,
                steadiness: Steadiness {
                    sway_mm_s: f64::INFINITY,
                    tilt_deg: f64::INFINITY,
                },
            },
            flow_ml_min: Vec::new(),
            injuries: Vec::new(),
            penalties: Vec::new(),
            exam: Vec::new(),
            tasks: BTreeMap::new(),
            references: Vec::new(),
            translations: BTreeMap::new(),
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
        let presses = file.alarm.press_n.iter().map(|(organ, press_n)| {
            Ok((
                check.organ(organ)?,
                check.number("press_n", press_n, 0.0..=100.0)?,
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
            press_n: presses.collect::<Result<_, _>>()?,
            done: Done {
                triangle: share("triangle", &done.triangle)?,
                lower_bed: share("lower_bed", &done.lower_bed)?,
                bed: share("bed", &done.bed)?,
                clips: check.number("clips", &done.clips, 1..=3)? as usize,
                settle_s: check.number("settle_s", &done.settle_s, 0.0..=60.0)?,
                leak: share("leak", &done.leak)?,
                look_s: check.number("look_s", &done.look_s, 0.1..=60.0)?,
                collect_s: match &done.collect_s {
                    Some(collect_s) => check.number("collect_s", collect_s, 0.0..=600.0)?,
                    None => 0.0,
                },
            },
            view: (file.view.as_ref())
                .map(|view| check.view(view))
                .transpose()?,
            show: match &file.show {
                Some(show) => check.show(show)?,
                None => Self::default().show,
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
            exam: match &file.exam {
                Some(exam) => (exam.pass.iter())
                    .map(|condition| check.condition(condition))
                    .collect::<Result<_, _>>()?,
                None => Vec::new(),
            },
            tasks,
            references: (file.reference.iter())
                .map(|reference| check.reference(reference))
                .collect::<Result<_, _>>()?,
            translations: file.translation,
        })
    }

    /// Rule for the critical view of safety; `None`: it need not be shown.
    #[must_use]
    pub fn view(&self) -> Option<&ViewRule> {
        self.view.as_ref()
    }

    /// Rule for an organ that the tasks `scope` and `basics` show.
    #[must_use]
    pub fn show(&self) -> &ShowRule {
        &self.show
    }

    /// Text from which the rules were parsed.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

#[cfg(test)]
mod tests;
