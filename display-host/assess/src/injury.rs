//! Injuries: structures that the trainee opened, or whose wall took more heat than it survives.
//!
//! Scissors, current or traction open a tube. It counts as opened if it is divided, if its wall is
//! burnt through, or if half of the wall is torn, cut or burnt. Less heat only coagulates the wall.
//! For scale: 1 J heats 10 mm³ of tissue to 63 °C. Heat from beside counts as soon as it has
//! destroyed tissue of the wall (event `Seared`).

use core::fmt;

use shared_mem::scene::OrganKind;

/// Kind of an injury.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InjuryKind {
    /// A tube was divided.
    Divided,
    /// A wall was burnt through, or a tube was torn, cut or burnt half through.
    Perforated,
    /// A wall took more heat than it survives.
    Burnt,
}

impl fmt::Display for InjuryKind {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Divided => "divided",
            Self::Perforated => "perforated",
            Self::Burnt => "burnt more than its wall survives",
        })
    }
}

/// Cause of an injury.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// Scissors.
    Cut,
    /// Traction.
    Torn,
    /// Current.
    Burnt,
}

impl fmt::Display for Cause {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Cut => "scissors",
            Self::Torn => "traction",
            Self::Burnt => "current",
        })
    }
}

/// Consequence of an injury for the task.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// It costs points.
    Minor,
    /// It rules out a pass.
    Serious,
    /// It ends the task.
    Grave,
}

/// An injury to a structure that the rules name.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Injury {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// Kind of the injury.
    pub kind: InjuryKind,
    /// Its cause.
    pub cause: Cause,
    /// Its consequence.
    pub severity: Severity,
    /// The structure's name in the scene.
    pub organ: String,
    /// True if the injury ends the task.
    pub ends_task: bool,
    /// Source on which the rule is based.
    pub source: String,
}

/// Rule for the injuries of a kind of structure.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InjuryRule {
    pub(crate) organ: OrganKind,
    /// Severity of an opened structure.
    pub(crate) open: Severity,
    /// Heat, J, at which a wall without a hole counts as injured. It is infinite if the rule has no
    /// limit.
    pub(crate) burn_j: f64,
    pub(crate) source: String,
}

/// Injuries of a running task. An organ has at most one injury of each kind.
#[derive(Debug, Clone, Default)]
pub(crate) struct Injuries {
    /// Index of the organ, and the injury.
    found: Vec<(u32, Injury)>,
    /// Heat that each organ has taken, J.
    heat_j: Vec<(u32, f64)>,
}

impl Injuries {
    /// Notes that the organ with this index and name was opened.
    pub(crate) fn open(
        &mut self,
        at_s: f64,
        (kind, cause): (InjuryKind, Cause),
        (index, organ): (u32, &str),
        rule: &InjuryRule,
    ) {
        let injury = Injury {
            at_s,
            kind,
            cause,
            severity: rule.open,
            organ: organ.to_owned(),
            ends_task: rule.open == Severity::Grave,
            source: rule.source.clone(),
        };
        self.note(index, injury);
    }

    /// Adds heat to the organ with this index and name. Notes a burn if the sum reaches the rule's
    /// limit.
    pub(crate) fn heat(
        &mut self,
        at_s: f64,
        heat_j: f64,
        (index, organ): (u32, &str),
        rule: &InjuryRule,
    ) {
        let known = self.heat_j.iter().position(|it| it.0 == index);
        let place = known.unwrap_or_else(|| {
            self.heat_j.push((index, 0.0));
            self.heat_j.len() - 1
        });
        let Some((_, sum_j)) = self.heat_j.get_mut(place) else {
            return;
        };
        *sum_j += heat_j;
        if *sum_j >= rule.burn_j {
            self.burn(at_s, (index, organ), rule);
        }
    }

    /// Notes a burn of the organ with this index and name, because heat has destroyed some of it.
    /// Organs without a limit of heat may be burnt.
    pub(crate) fn sear(&mut self, at_s: f64, (index, organ): (u32, &str), rule: &InjuryRule) {
        if rule.burn_j.is_finite() {
            self.burn(at_s, (index, organ), rule);
        }
    }

    fn burn(&mut self, at_s: f64, (index, organ): (u32, &str), rule: &InjuryRule) {
        let injury = Injury {
            at_s,
            kind: InjuryKind::Burnt,
            cause: Cause::Burnt,
            severity: rule.open.min(Severity::Serious),
            organ: organ.to_owned(),
            ends_task: false,
            source: rule.source.clone(),
        };
        self.note(index, injury);
    }

    /// Keeps an injury, unless the organ already has one of its kind.
    fn note(&mut self, index: u32, injury: Injury) {
        let mut found = self.found.iter();
        if !found.any(|(organ, it)| *organ == index && it.kind == injury.kind) {
            self.found.push((index, injury));
        }
    }

    /// All injuries, the oldest first.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Injury> {
        self.found.iter().map(|(_, injury)| injury)
    }
}
