//! What is to be done, what helps, and why a task is over: a kind and its values. `Display` is the plain English
//! of reports and JSON; an interface says them in its own words.

use core::fmt;

use shared_mem::words::Instrument;

use crate::metrics::Metric;

/// Something that is to be done.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Step {
    /// The gallbladder is hung on the abdominal wall.
    Hang {
        /// Sutures.
        count: usize,
    },
    /// Calot's triangle is cleared.
    Triangle,
    /// The lower third of the gallbladder's bed is free.
    LowerBed,
    /// Cystic duct and artery stay whole.
    LeaveWhole,
    /// A vessel is clipped.
    Clip {
        /// Which, as scenes name it.
        organ: String,
        /// Clips on it.
        count: usize,
    },
    /// A vessel is divided between clips.
    Divide {
        /// Which, as scenes name it.
        organ: String,
    },
    /// The gallbladder is off the liver.
    Free,
    /// An organ is shown with the endoscope.
    Show {
        /// Which, as the scene names it.
        organ: String,
    },
}

impl fmt::Display for Step {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hang { count } => write!(to, "Hang the gallbladder by {count} sutures"),
            Self::Triangle => to.write_str("Clear Calot's triangle"),
            Self::LowerBed => to.write_str("Free the lower third of the gallbladder's bed"),
            Self::LeaveWhole => to.write_str("Leave cystic duct and artery whole"),
            Self::Clip { organ, count } => write!(to, "Put {count} clips on the {organ}"),
            Self::Divide { organ } => write!(to, "Divide the {organ} between clips"),
            Self::Free => to.write_str("Free the gallbladder from the liver"),
            Self::Show { organ } => write!(to, "Show the {organ}"),
        }
    }
}

impl Step {
    /// The instrument that it is done with; none: the endoscope.
    pub(crate) fn instrument(&self) -> Option<Instrument> {
        match self {
            Self::Hang { .. } => Some(Instrument::Grasper),
            Self::Triangle | Self::LowerBed | Self::Free => Some(Instrument::Hook),
            Self::Clip { .. } => Some(Instrument::ClipApplier),
            Self::Divide { .. } => Some(Instrument::Scissors),
            Self::LeaveWhole | Self::Show { .. } => None,
        }
    }
}

/// An instrument as the status writes it.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(remote = "Instrument", rename_all = "kebab-case")]
enum InstrumentText {
    Grasper,
    Hook,
    Scissors,
    ClipApplier,
}

/// What a beginner is told to do next.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Hint {
    /// What is to be done.
    pub step: Step,
    /// What helps.
    pub advice: Advice,
}

/// What helps with a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Advice {
    /// Another instrument.
    Take(#[serde(with = "InstrumentText")] Instrument),
    /// How the one that is held is used.
    Use(#[serde(with = "InstrumentText")] Instrument),
    /// To hold it in the middle of the picture.
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
            Advice::Use(Instrument::Grasper) => {
                write!(
                    to,
                    "{step}: touch it, press the pedal, carry the thread towards the wall, press again."
                )
            }
            Advice::Use(Instrument::Hook) => {
                write!(
                    to,
                    "{step}: hook a strand, lift it clear, then a short current."
                )
            }
            Advice::Use(Instrument::ClipApplier) => {
                write!(
                    to,
                    "{step}: both jaws around it, tips in sight, then close."
                )
            }
            Advice::Use(Instrument::Scissors) => {
                write!(to, "{step}: see both clips before the blades close.")
            }
            Advice::Hold => write!(to, "{step}: hold it in the middle of the picture."),
        }
    }
}

/// Why a task is over, or not passed.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Reason {
    /// It ended before this was done.
    NotDone {
        /// What.
        step: Step,
    },
    /// A vessel was divided unclamped.
    Unclamped {
        /// Which, as scenes name it.
        organ: String,
    },
    /// A vessel that was to stay whole is not.
    NotWhole,
    /// It took longer than it may.
    TooLong {
        /// How long it may take, s.
        seconds: f64,
    },
    /// Less than a pass rule asks for.
    TooLittle {
        /// Of what; none: of the score.
        metric: Option<Metric>,
        /// How much it is, in the metric's unit.
        value: f64,
        /// What is asked.
        limit: f64,
    },
    /// More than a pass rule allows.
    TooMuch {
        /// Of what; none: of the score.
        metric: Option<Metric>,
        /// How much it is, in the metric's unit.
        value: f64,
        /// What is allowed.
        limit: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |metric: &Option<Metric>| metric.map_or("score", Metric::name);
        match self {
            Self::NotDone { step } => write!(to, "not done: {step}"),
            Self::Unclamped { organ } => write!(to, "the {organ} was divided unclamped"),
            Self::NotWhole => to.write_str("cystic duct or artery is no longer whole"),
            Self::TooLong { seconds } => write!(to, "it took longer than {seconds:.0} s"),
            Self::TooLittle {
                metric,
                value,
                limit,
            } => {
                let name = name(metric);
                write!(to, "{name} is {value:.1}, at least {limit} is asked")
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

/// As reports have them: in plain English.
pub(crate) fn plainly<S: serde::Serializer>(
    reasons: &[Reason],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(reasons.iter().map(Reason::to_string))
}

/// The same of steps, each with whether it is done.
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
        };
        for (said, told) in [
            (clip().to_string(), "Put 2 clips on the cystic duct"),
            (
                hint(Advice::Take(Instrument::ClipApplier)).to_string(),
                "Put 2 clips on the cystic duct: take the clip applier (4).",
            ),
            (
                hint(Advice::Use(Instrument::ClipApplier)).to_string(),
                "Put 2 clips on the cystic duct: both jaws around it, tips in sight, then close.",
            ),
            (
                Reason::NotDone { step: clip() }.to_string(),
                "not done: Put 2 clips on the cystic duct",
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
                "score is 60.0, at least 70.5 is asked",
            ),
        ] {
            assert_eq!(said, told);
        }
    }

    #[test]
    fn they_come_back_from_json_as_they_were() {
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
