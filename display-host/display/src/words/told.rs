//! Texts of the assessment (steps, hints, reasons) from their kinds and values, in the user's
//! language.

use assess::{Advice, Hint, Hold, InjuryKind, Instrument, Lack, Metric, Reason, Step, ViewSide};

use super::Words;

/// Name of the phantom's tube in its recipe.
const PHANTOM_TUBE: &str = "tube";

impl Words {
    /// Text of a step.
    #[must_use]
    pub fn step(&self, step: &Step) -> String {
        let with_organ =
            |id, organ: &str| self.say_with(id, &[("organ", self.organ(organ).into())]);
        match step {
            Step::Hang { count } => {
                self.say_with("step-hang", &[("count", count.to_string().into())])
            }
            Step::Triangle => self.say("step-triangle"),
            Step::LowerBed => self.say("step-lower-bed"),
            Step::ShowView { side } => self.say(match side {
                ViewSide::Front => "step-view-front",
                ViewSide::Behind => "step-view-behind",
            }),
            Step::LeaveWhole => self.say("step-leave-whole"),
            Step::Clip { organ, count: 1 } => with_organ("step-clip-one", organ),
            Step::Clip { organ, count } => {
                let organ = self.organ(organ).into();
                let values = [("count", count.to_string().into()), ("organ", organ)];
                self.say_with("step-clip", &values)
            }
            Step::Divide { organ } => with_organ("step-divide", organ),
            Step::Free => self.say("step-free"),
            Step::Show { organ } => with_organ("step-show", organ),
            Step::Meet => self.say("step-meet"),
            Step::Grasp { organ } => with_organ("step-grasp", organ),
            Step::Coagulate => self.say("step-coagulate"),
            Step::Touch { organ } => with_organ("step-touch", organ),
            Step::Carry { organ, to } => {
                let [organ, goal] = [organ, to].map(|it| self.organ(it).into());
                self.say_with("step-carry", &[("organ", organ), ("goal", goal)])
            }
            Step::Clear { organ } => with_organ("step-clear", organ),
            Step::Collect { left } => {
                self.say_with("step-collect", &[("left", left.to_string().into())])
            }
        }
    }

    /// The place where a step begins, and the plane in which it goes on.
    #[must_use]
    pub fn place(&self, step: &Step) -> String {
        self.say(match step {
            Step::Hang { .. } => "place-hang",
            Step::Triangle => "place-triangle",
            Step::LowerBed => "place-lower-bed",
            Step::LeaveWhole => "place-leave-whole",
            Step::Clip { organ, .. } if organ == PHANTOM_TUBE => "place-clip-phantom",
            Step::Divide { organ } if organ == PHANTOM_TUBE => "place-divide-phantom",
            Step::Clip { .. } => "place-clip",
            Step::Divide { .. } => "place-divide",
            Step::Free => "place-free",
            Step::ShowView { .. } => "place-show-view",
            Step::Show { .. } => "place-show",
            Step::Meet => "place-meet",
            Step::Grasp { .. } => "place-grasp",
            Step::Coagulate => "place-coagulate",
            Step::Touch { .. } => "place-touch",
            Step::Carry { .. } => "place-carry",
            Step::Clear { .. } => "place-clear",
            Step::Collect { .. } => "place-collect",
        })
    }

    /// Share of a step that is left. `None` if it cannot be measured.
    #[must_use]
    pub fn left(&self, hint: &Hint) -> Option<String> {
        let left = 100 - hint.percent?.min(100);
        Some(self.say_with("hint-left", &[("percent", left.to_string().into())]))
    }

    /// Text of a running hold. It names the thing that the picture lacks, or asks to hold still.
    #[must_use]
    pub fn hold(&self, hold: &Hold) -> String {
        self.say(match hold.lack {
            None => "hold-on",
            Some(Lack::Side) => "hold-lacks-side",
            Some(Lack::Uncleared) => "hold-lacks-uncleared",
            Some(Lack::Triangle) => "hold-lacks-triangle",
            Some(Lack::LowerBed) => "hold-lacks-lower-bed",
            Some(Lack::Two) => "hold-lacks-two",
            Some(Lack::OutOfView) => "hold-lacks-out-of-view",
            Some(Lack::Hidden) => "hold-lacks-hidden",
            Some(Lack::Aside) => "hold-lacks-aside",
            Some(Lack::Small) => "hold-lacks-small",
            Some(Lack::Sway) => "hold-lacks-sway",
            Some(Lack::Tilt) => "hold-lacks-tilt",
            Some(Lack::Unled) => "hold-lacks-unled",
        })
    }

    /// Keys and buttons that mend the thing that the picture of a hold lacks. `None` if no key
    /// does.
    #[must_use]
    pub fn hold_keys(&self, hold: &Hold) -> Option<String> {
        let id = match hold.lack? {
            Lack::Small => "hold-keys-near",
            Lack::OutOfView | Lack::Aside | Lack::Side | Lack::Unled => "hold-keys-turn",
            _ => return None,
        };
        Some(self.say(id))
    }

    /// Text of a hint.
    #[must_use]
    pub fn hint(&self, hint: &Hint) -> String {
        let step = ("step", self.step(&hint.step).into());
        let id = match hint.advice {
            Advice::Take(instrument) => {
                let name = match instrument {
                    Instrument::Grasper => "hint-instrument-grasper",
                    Instrument::Hook => "hint-instrument-hook",
                    Instrument::Scissors => "hint-instrument-scissors",
                    Instrument::ClipApplier => "hint-instrument-clip-applier",
                    Instrument::Irrigator => "hint-instrument-irrigator",
                };
                let key = (instrument.number() + 1).to_string().into();
                let values = [step, ("instrument", self.say(name).into()), ("key", key)];
                return self.say_with("hint-take", &values);
            }
            Advice::Use(_) if matches!(hint.step, Step::Grasp { .. }) => "hint-grasp",
            Advice::Use(_) if hint.step == Step::Coagulate => "hint-coagulate",
            Advice::Use(_) if matches!(hint.step, Step::Touch { .. }) => "hint-touch",
            Advice::Use(_) if matches!(hint.step, Step::Carry { .. }) => "hint-carry",
            Advice::Use(_) if matches!(hint.step, Step::Collect { .. }) => "hint-collect",
            Advice::Use(Instrument::Grasper) => "hint-grasper",
            Advice::Use(Instrument::Hook) => "hint-hook",
            Advice::Use(Instrument::Scissors) => "hint-scissors",
            Advice::Use(Instrument::ClipApplier) => "hint-clip-applier",
            Advice::Use(Instrument::Irrigator) => "hint-irrigator",
            Advice::Hold if hint.step == Step::Meet => "hint-meet",
            Advice::Hold => "hint-hold",
        };
        self.say_with(id, &[step])
    }

    /// Text of a reason.
    #[must_use]
    pub fn reason(&self, reason: &Reason) -> String {
        match reason {
            Reason::NotDone { step } => {
                self.say_with("reason-not-done", &[("step", self.step(step).into())])
            }
            Reason::Unclamped { organ } => {
                self.say_with("reason-unclamped", &[("organ", self.organ(organ).into())])
            }
            Reason::Injured { organ, injury } => {
                let id = match injury {
                    InjuryKind::Divided => "reason-injured-divided",
                    InjuryKind::Perforated => "reason-injured-perforated",
                    InjuryKind::Torn => "reason-injured-torn",
                    InjuryKind::Clipped => "reason-injured-clipped",
                    InjuryKind::Burnt => "reason-injured-burnt",
                };
                self.say_with(id, &[("organ", self.organ(organ).into())])
            }
            Reason::NotWhole => self.say("reason-not-whole"),
            Reason::TooLong { seconds } => {
                let limit = self.exact(*seconds, "s").into();
                self.say_with("reason-too-long", &[("limit", limit)])
            }
            Reason::TooLittle {
                metric,
                value,
                limit,
            } => self.beyond("reason-too-little", *metric, [*value, *limit]),
            Reason::TooMuch {
                metric,
                value,
                limit,
            } => self.beyond("reason-too-much", *metric, [*value, *limit]),
        }
    }

    fn beyond(&self, id: &str, metric: Option<Metric>, [value, limit]: [f64; 2]) -> String {
        let (name, unit) = metric.map_or(("score", "n"), |it| (it.name(), it.unit()));
        let value = self.apart(value, limit, unit).into();
        let limit = self.exact(limit, unit).into();
        let metric = self.metric(name).into();
        self.say_with(
            id,
            &[("metric", metric), ("value", value), ("limit", limit)],
        )
    }

    /// Displayed name of the metric with this report key.
    #[must_use]
    pub fn metric(&self, name: &str) -> String {
        self.say(&format!("metric-{}", name.replace('_', "-")))
    }

    /// Name of an organ, from its name in the scene; unknown names stay as they are.
    #[must_use]
    pub fn organ(&self, name: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let id: String = name.to_lowercase().chars().map(plain).collect();
        let id = format!("organ-{id}");
        let said = self.say(&id);
        if said == id { name.to_owned() } else { said }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Language;
    use super::*;

    fn clip(organ: &str) -> Step {
        let organ = organ.to_owned();
        Step::Clip { organ, count: 3 }
    }

    /// Steps, hints and reasons of every kind.
    fn all() -> (Vec<Step>, Vec<Hint>, Vec<Reason>) {
        let organ = || "cystic artery".to_owned();
        let steps = vec![
            Step::Hang { count: 2 },
            Step::Triangle,
            Step::LowerBed,
            Step::ShowView {
                side: ViewSide::Front,
            },
            Step::ShowView {
                side: ViewSide::Behind,
            },
            Step::LeaveWhole,
            clip("cystic duct"),
            Step::Divide { organ: organ() },
            Step::Free,
            Step::Show { organ: organ() },
            Step::Meet,
            Step::Grasp { organ: organ() },
            Step::Coagulate,
            Step::Clip {
                organ: organ(),
                count: 1,
            },
            clip(PHANTOM_TUBE),
            Step::Divide {
                organ: PHANTOM_TUBE.to_owned(),
            },
            Step::Touch { organ: organ() },
            Step::Carry {
                organ: organ(),
                to: organ(),
            },
            Step::Clear { organ: organ() },
            Step::Collect { left: 3 },
        ];
        let tools = [
            Instrument::Grasper,
            Instrument::Hook,
            Instrument::Scissors,
            Instrument::ClipApplier,
        ];
        let advice = tools.map(|it| [Advice::Take(it), Advice::Use(it)]);
        let advice = advice.into_iter().flatten().chain([Advice::Hold]);
        let hints = advice.map(|advice| Hint {
            step: Step::Free,
            advice,
            percent: None,
        });
        let special = [
            (Step::Meet, Advice::Hold),
            (Step::Grasp { organ: organ() }, Advice::Use(tools[0])),
            (Step::Coagulate, Advice::Use(tools[1])),
            (Step::Touch { organ: organ() }, Advice::Use(tools[0])),
            (
                Step::Carry {
                    organ: organ(),
                    to: organ(),
                },
                Advice::Use(tools[0]),
            ),
        ];
        let hints = hints.chain(special.map(|(step, advice)| Hint {
            step,
            advice,
            percent: Some(30),
        }));
        let beyond = (Some(Metric::Blood), 30.0, 20.0);
        let (metric, value, limit) = beyond;
        let reasons = vec![
            Reason::NotDone { step: Step::Free },
            Reason::Unclamped { organ: organ() },
            Reason::Injured {
                organ: organ(),
                injury: InjuryKind::Divided,
            },
            Reason::Injured {
                organ: organ(),
                injury: InjuryKind::Perforated,
            },
            Reason::Injured {
                organ: organ(),
                injury: InjuryKind::Burnt,
            },
            Reason::NotWhole,
            Reason::TooLong { seconds: 900.0 },
            Reason::TooLittle {
                metric: None,
                value,
                limit,
            },
            Reason::TooMuch {
                metric,
                value,
                limit,
            },
        ];
        (steps, hints.collect(), reasons)
    }

    #[test]
    fn every_message_is_said_in_every_language() {
        let said = |language| {
            let words = Words::new(language);
            let (steps, hints, reasons) = all();
            let steps = steps.iter().map(|it| words.step(it));
            let hints = hints.iter().map(|it| words.hint(it));
            let reasons = reasons.iter().map(|it| words.reason(it));
            let places = all().0;
            let places: std::collections::BTreeSet<_> =
                places.iter().map(|it| words.place(it)).collect();
            steps
                .chain(places)
                .chain(hints)
                .chain(reasons)
                .collect::<Vec<_>>()
        };
        let english = said(Language::English);
        for (english, german) in english.iter().zip(said(Language::German)) {
            assert_ne!(*english, german);
            // A missing message is shown as its id.
            for id in ["step-", "hint-", "reason-", "metric-", "organ-", "place-"] {
                assert!(
                    !english.contains(id) && !german.contains(id),
                    "{english} {german}"
                );
            }
        }
        let mut once = english.clone();
        once.sort();
        once.dedup();
        assert_eq!(once.len(), english.len(), "{english:?}");
    }

    #[test]
    fn values_stand_where_they_belong() {
        let german = Words::new(Language::German);
        let take = Hint {
            percent: Some(30),
            step: clip("cystic artery"),
            advice: Advice::Take(Instrument::ClipApplier),
        };
        assert_eq!(
            german.hint(&take),
            "3 Clips setzen: Arteria cystica. Dazu: Clipzange (4)."
        );
        let score = Reason::TooLittle {
            metric: None,
            value: 69.75,
            limit: 70.0,
        };
        assert_eq!(
            german.reason(&score),
            "Punkte: 69,8, mindestens 70 erforderlich"
        );
        // A user's scene may name its organs freely.
        let spleen = Step::Show {
            organ: "spleen".to_owned(),
        };
        assert_eq!(german.step(&spleen), "Zeigen: spleen");
    }
}
