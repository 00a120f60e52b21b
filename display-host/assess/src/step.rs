//! Steps, hints, and reasons for the end of a task. Each is a kind with values. `Display` gives the
//! plain English of reports and JSON. The user interface has texts of its own.

use core::fmt;

use shared_mem::words::Instrument;

use crate::injury::{Injury, InjuryKind};
use crate::metrics::Metric;
use crate::view::ViewSide;

/// A step of a task.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Step {
    /// Hang the gallbladder on the abdominal wall.
    Hang {
        /// Number of sutures.
        count: usize,
    },
    /// Clear Calot's triangle.
    Triangle,
    /// Free the lower third of the gallbladder's bed.
    LowerBed,
    /// Show the critical view of safety to the endoscope and hold it.
    ShowView {
        /// Side of Calot's triangle from which the view is shown.
        side: ViewSide,
    },
    /// Leave cystic duct and artery intact.
    LeaveWhole,
    /// Clip a vessel.
    Clip {
        /// The vessel's name in the scene.
        organ: String,
        /// Number of clips.
        count: usize,
    },
    /// Divide a vessel between clips.
    Divide {
        /// The vessel's name in the scene.
        organ: String,
    },
    /// Free the gallbladder from the liver.
    Free,
    /// Show an organ with the endoscope.
    Show {
        /// The organ's name in the scene.
        organ: String,
    },
    /// Bring the instrument's tip into the middle of the picture.
    Meet,
    /// Grasp an organ.
    Grasp {
        /// The organ's name in the scene.
        organ: String,
    },
    /// Coagulate a strand of tissue between gallbladder and liver.
    Coagulate,
    /// Touch an organ with the instrument.
    Touch {
        /// The organ's name in the scene.
        organ: String,
    },
    /// Grasp an organ and carry it to another one.
    Carry {
        /// The organ's name in the scene.
        organ: String,
        /// Name of the other one.
        to: String,
    },
    /// Take layered tissue away with the hook.
    Clear {
        /// The organ's name in the scene.
        organ: String,
    },
    /// Pick up the stones that spilled. The step also ends after the time that the rules give.
    Collect {
        /// Number of stones that lie in the body.
        left: u32,
    },
}

impl fmt::Display for Step {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hang { count } => write!(to, "Suspend the gallbladder with {count} sutures"),
            Self::Triangle => to.write_str("Clear Calot's triangle"),
            Self::LowerBed => to.write_str("Free the lower third of the gallbladder from its bed"),
            Self::ShowView {
                side: ViewSide::Front,
            } => to.write_str("Show the critical view from the front, and hold it"),
            Self::ShowView {
                side: ViewSide::Behind,
            } => to.write_str("Show the critical view from behind, and hold it"),
            Self::LeaveWhole => to.write_str("Keep cystic duct and artery intact"),
            Self::Clip { organ, count } => write!(to, "Place {count} clips on the {organ}"),
            Self::Divide { organ } => write!(to, "Divide the {organ} between clips"),
            Self::Free => to.write_str("Free the gallbladder from the liver"),
            Self::Show { organ } => write!(to, "Show the {organ}"),
            Self::Meet => to.write_str("Bring the tip into the middle of the picture"),
            Self::Grasp { organ } => write!(to, "Grasp the {organ}"),
            Self::Coagulate => to.write_str("Coagulate a strand of tissue"),
            Self::Touch { organ } => write!(to, "Touch the {organ}"),
            Self::Carry { organ, to: goal } => write!(to, "Carry the {organ} to the {goal}"),
            Self::Clear { organ } => write!(to, "Take some of the {organ} away"),
            Self::Collect { left } => write!(to, "Pick up the spilled stones, {left} left"),
        }
    }
}

impl Step {
    /// Instrument for the step. `None` if the endoscope or any instrument does it, or if there is
    /// nothing to do.
    pub(crate) fn instrument(&self) -> Option<Instrument> {
        match self {
            Self::Hang { .. }
            | Self::Grasp { .. }
            | Self::Touch { .. }
            | Self::Carry { .. }
            | Self::Collect { .. } => Some(Instrument::Grasper),
            Self::Triangle | Self::LowerBed | Self::Free | Self::Coagulate | Self::Clear { .. } => {
                Some(Instrument::Hook)
            }
            Self::Clip { .. } => Some(Instrument::ClipApplier),
            Self::Divide { .. } => Some(Instrument::Scissors),
            Self::LeaveWhole | Self::ShowView { .. } | Self::Show { .. } | Self::Meet => None,
        }
    }
}

/// Names of the instruments in a written hint.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(remote = "Instrument", rename_all = "kebab-case")]
enum InstrumentText {
    Grasper,
    Hook,
    Scissors,
    ClipApplier,
    Irrigator,
}

/// Next instruction for a beginner.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Hint {
    /// The step to do.
    pub step: Step,
    /// Advice for the step.
    pub advice: Advice,
    /// Share of the step that is done, per cent, if it can be measured.
    #[serde(default)]
    pub percent: Option<u8>,
}

/// Advice for a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Advice {
    /// Take another instrument.
    Take(#[serde(with = "InstrumentText")] Instrument),
    /// Use the present instrument.
    Use(#[serde(with = "InstrumentText")] Instrument),
    /// Hold organ, view or tip in the middle of the picture.
    Hold,
}

impl fmt::Display for Hint {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = &self.step;
        match self.advice {
            Advice::Take(it) => {
                let key = it.number() + 1;
                write!(to, "{step}: take the {} ({key}).", it.name())
            }
            Advice::Use(_) if matches!(step, Step::Collect { .. }) => {
                write!(
                    to,
                    "{step}: hold each between the jaws, and draw it out through the trocar."
                )
            }
            Advice::Use(Instrument::Grasper) => {
                write!(
                    to,
                    "{step}: touch it, press the pedal, draw the thread to the abdominal wall, press again."
                )
            }
            Advice::Use(Instrument::Hook) => {
                write!(
                    to,
                    "{step}: hook a strand, lift it clear, then give a short burst of current."
                )
            }
            Advice::Use(Instrument::ClipApplier) => {
                write!(
                    to,
                    "{step}: pass both jaws around it, keep the tips in view, then close."
                )
            }
            Advice::Use(Instrument::Scissors) => {
                write!(to, "{step}: see both clips before you close the blades.")
            }
            Advice::Use(Instrument::Irrigator) => {
                write!(
                    to,
                    "{step}: hold the tip into the fluid; coagulation pedal: suction, cutting pedal: irrigation."
                )
            }
            Advice::Hold => write!(to, "{step}: keep it in the middle of the picture."),
        }
    }
}

/// Reason why a task is over, or not passed.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Reason {
    /// The task ended before a step was done.
    NotDone {
        /// The step.
        step: Step,
    },
    /// Cystic duct or artery was torn, or was divided and not closed by enough tight clips.
    Unclamped {
        /// The vessel's name in the scene.
        organ: String,
    },
    /// A structure was injured.
    Injured {
        /// The structure's name in the scene.
        organ: String,
        /// Kind of the injury.
        injury: InjuryKind,
    },
    /// A vessel that had to stay intact is damaged.
    NotWhole,
    /// The time limit was exceeded.
    TooLong {
        /// The limit, s.
        seconds: f64,
    },
    /// A value is below the least value of a pass rule.
    TooLittle {
        /// The metric; `None`: the score.
        metric: Option<Metric>,
        /// Value, in the metric's unit.
        value: f64,
        /// Least value allowed.
        limit: f64,
    },
    /// A value is above the largest value of a pass rule.
    TooMuch {
        /// The metric; `None`: the score.
        metric: Option<Metric>,
        /// Value, in the metric's unit.
        value: f64,
        /// Largest value allowed.
        limit: f64,
    },
}

impl Reason {
    /// The step that was not done, if that is the reason.
    #[must_use]
    pub fn open_step(&self) -> Option<&Step> {
        match self {
            Self::NotDone { step } => Some(step),
            _ => None,
        }
    }

    /// Reason that a task is not passed because of this injury.
    pub(crate) fn injured(injury: &Injury) -> Self {
        Self::Injured {
            organ: injury.organ.clone(),
            injury: injury.kind,
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |metric: &Option<Metric>| metric.map_or("score", Metric::name);
        match self {
            Self::NotDone { step } => write!(to, "not done: {step}"),
            Self::Unclamped { organ } => write!(
                to,
                "the {organ} was divided or torn, and clips do not close it"
            ),
            Self::Injured { organ, injury } => write!(to, "the {organ} was {injury}"),
            Self::NotWhole => to.write_str("cystic duct or artery is no longer intact"),
            Self::TooLong { seconds } => write!(to, "it took longer than {seconds:.0} s"),
            Self::TooLittle {
                metric,
                value,
                limit,
            } => {
                let name = name(metric);
                write!(to, "{name} is {value:.1}, at least {limit} is required")
            }
            Self::TooMuch {
                metric,
                value,
                limit,
            } => {
                let name = name(metric);
                write!(to, "{name} is {value:.1}, at most {limit} is allowed")
            }
        }
    }
}

/// Serializes reasons as plain English, for reports.
pub(crate) fn plainly<S: serde::Serializer>(
    reasons: &[Reason],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(reasons.iter().map(Reason::to_string))
}

/// Serializes steps as plain English, each with true if it is done.
pub(crate) fn plain_steps<S: serde::Serializer>(
    steps: &[(Step, bool)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(steps.iter().map(|(step, done)| (step.to_string(), done)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip() -> Step {
        Step::Clip {
            organ: "cystic duct".to_owned(),
            count: 2,
        }
    }

    #[test]
    fn reports_say_them_in_plain_english() {
        let hint = |advice| Hint {
            step: clip(),
            advice,
            percent: None,
        };
        for (said, told) in [
            (clip().to_string(), "Place 2 clips on the cystic duct"),
            (
                hint(Advice::Take(Instrument::ClipApplier)).to_string(),
                "Place 2 clips on the cystic duct: take the clip applier (4).",
            ),
            (
                hint(Advice::Use(Instrument::ClipApplier)).to_string(),
                "Place 2 clips on the cystic duct: pass both jaws around it, keep the tips in view, then close.",
            ),
            (
                Reason::NotDone { step: clip() }.to_string(),
                "not done: Place 2 clips on the cystic duct",
            ),
            (
                Reason::TooLong { seconds: 600.0 }.to_string(),
                "it took longer than 600 s",
            ),
            (
                Reason::TooMuch {
                    metric: Some(Metric::Blood),
                    value: 30.04,
                    limit: 20.0,
                }
                .to_string(),
                "blood_ml is 30.0, at most 20 is allowed",
            ),
            (
                Reason::TooLittle {
                    metric: None,
                    value: 60.0,
                    limit: 70.5,
                }
                .to_string(),
                "score is 60.0, at least 70.5 is required",
            ),
        ] {
            assert_eq!(said, told);
        }
    }

    #[test]
    fn steps_come_back_from_json_as_they_were() {
        let limits = |metric| Reason::TooLittle {
            metric,
            value: 0.25,
            limit: 0.9,
        };
        for reason in [
            Reason::NotDone { step: clip() },
            Reason::NotDone { step: Step::Free },
            Reason::NotDone {
                step: Step::Hang { count: 2 },
            },
            Reason::NotWhole,
            limits(None),
            limits(Some(Metric::CvsBed)),
        ] {
            let text = serde_json::to_string(&reason).unwrap();
            let back: Reason = serde_json::from_str(&text).unwrap();
            assert_eq!(back, reason, "{text}");
        }
        assert!(serde_json::from_str::<Reason>(r#"{"kind": "bored"}"#).is_err());
        let unknown = r#"{"kind": "too-much", "metric": "boredom", "value": 1, "limit": 0}"#;
        assert!(serde_json::from_str::<Reason>(unknown).is_err());
    }
}
