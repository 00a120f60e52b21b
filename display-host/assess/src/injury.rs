//! Injuries: structures that the trainee opened, or burnt more than their wall survives.
//!
//! A tube is opened when it is divided, by scissors, current or traction, or when its wall is burnt
//! through. Heat coagulates a wall without opening it: 1 J brings 10 mm³ to 63 °C.

use core::fmt;

use shared_mem::scene::OrganKind;

/// Kind of an injury.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InjuryKind {
    /// A tube was divided.
    Divided,
    /// A wall was burnt through or torn open.
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

/// An injury to a structure that the rules name.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Injury {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// Kind of the injury.
    pub kind: InjuryKind,
    /// The structure's name in the scene.
    pub organ: String,
    /// True if the injury ends the task. Any injury rules out a pass.
    pub ends_task: bool,
}

/// Rule for the injuries of a kind of structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InjuryRule {
    pub(crate) organ: OrganKind,
    /// True if opening the structure ends the task.
    pub(crate) open_ends_task: bool,
    /// Heat without a hole that counts as an injury, J; infinite without a limit.
    pub(crate) burn_j: f64,
}

/// Injuries of a running task, each organ at most once with each kind.
#[derive(Debug, Clone, Default)]
pub(crate) struct Injuries {
    found: Vec<(u32, Injury)>,
    /// Heat that each organ has taken, J.
    heat_j: Vec<(u32, f64)>,
}

impl Injuries {
    /// Notes that the organ with this index and name was opened.
    pub(crate) fn open(
        &mut self,
        at_s: f64,
        kind: InjuryKind,
        (index, organ): (u32, &str),
        rule: &InjuryRule,
    ) {
        let ends_task = rule.open_ends_task;
        self.note(
            index,
            Injury {
                at_s,
                kind,
                organ: organ.to_owned(),
                ends_task,
            },
        );
    }

    /// Adds heat to the organ with this index and name.
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
            let (kind, organ) = (InjuryKind::Burnt, organ.to_owned());
            self.note(
                index,
                Injury {
                    at_s,
                    kind,
                    organ,
                    ends_task: false,
                },
            );
        }
    }

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
