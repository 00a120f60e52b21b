//! Injuries: structures that the trainee opened, or whose wall took more heat than it survives.
//!
//! Scissors, current or traction open a tube. It counts as opened if it is divided, if its wall is
//! burnt through, or if half of the wall is torn, cut or burnt. Less heat only coagulates the wall.
//! For scale: 1 J heats 10 mm³ of tissue to 63 °C. Bile duct and hepatic artery are also injured by
//! a clip, and by traction that tears a part of them or of what holds them.
//!
//! A burn without a hole is judged by its energy, the heat that the organ has taken anywhere, and
//! by its depth, from the heat at one place. A place is a disc of 1.5 mm radius, as for the
//! controller's holes (`rt_core::procedure`), and its whole heat coagulates the wall from outside:
//! 0.7 J go 1 mm deep. Heat from beside counts as soon as it has destroyed tissue of the wall
//! (event `Seared`).

use core::fmt;

use shared_mem::scene::OrganKind;

use crate::vector::{Vec3, distance};

/// Radius of a burnt place, m.
const PLACE_M: f64 = 1.5e-3;
/// Heat that coagulates a wall to a depth of 1 mm at one place, J: 0.1 J for each cubic millimetre.
const DEEP_J_MM: f64 = 0.1 * std::f64::consts::PI * 1.5 * 1.5;
/// Largest number of burnt places of an organ that are kept: those of 70 cm².
const PLACES_MAX: usize = 1024;

/// Kind of an injury.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InjuryKind {
    /// A tube was divided.
    Divided,
    /// A wall was burnt through, or a tube was torn, cut or burnt half through.
    Perforated,
    /// A part of a tube was torn, or torn off its bed or another organ.
    Torn,
    /// A clip was closed on a tube.
    Clipped,
    /// A wall took more heat than it survives.
    Burnt,
}

impl fmt::Display for InjuryKind {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Divided => "divided",
            Self::Perforated => "perforated",
            Self::Torn => "torn in part",
            Self::Clipped => "clipped",
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
    /// A clip.
    Clipped,
}

impl fmt::Display for Cause {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Cut => "scissors",
            Self::Torn => "traction",
            Self::Burnt => "current",
            Self::Clipped => "clip",
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
    /// Heat that the structure had taken by then, J; `None` for an injury without a burn.
    pub heat_j: Option<f64>,
    /// Depth of the coagulated wall at the deepest place, mm; `None` for an injury without a burn.
    pub depth_mm: Option<f64>,
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
    /// Depth, mm, to which a wall may be coagulated at one place before it counts as injured. It is
    /// infinite if the rule has no limit.
    pub(crate) burn_mm: f64,
    pub(crate) source: String,
}

/// Injuries of a running task. An organ has at most one injury of each kind.
#[derive(Debug, Clone, Default)]
pub(crate) struct Injuries {
    /// Index of the organ, and the injury.
    found: Vec<(u32, Injury)>,
    /// Heat that each organ has taken, J.
    heat_j: Vec<(u32, f64)>,
    /// Burnt places: organ, middle, and heat, J.
    places: Vec<(u32, Vec3, f64)>,
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
            heat_j: None,
            depth_mm: None,
            source: rule.source.clone(),
        };
        self.note(index, injury);
    }

    /// Notes that the organ with this index and name was harmed and stays closed: torn in part, or
    /// clipped. It counts where an opened organ ends the task, and rules out a pass.
    pub(crate) fn harm(
        &mut self,
        at_s: f64,
        what: (InjuryKind, Cause),
        organ: (u32, &str),
        rule: &InjuryRule,
    ) {
        if rule.open == Severity::Grave {
            let serious = InjuryRule {
                open: Severity::Serious,
                ..rule.clone()
            };
            self.open(at_s, what, organ, &serious);
        }
    }

    /// Adds heat, at a place, to the organ with this index and name. Notes a burn if the organ's
    /// heat or the depth at one place reaches the rule's limit. Returns true if this place is now
    /// coagulated as deep as the limit, or deeper.
    pub(crate) fn heat(
        &mut self,
        at_s: f64,
        (heat_j, at_m): (f64, Vec3),
        (index, organ): (u32, &str),
        rule: &InjuryRule,
    ) -> bool {
        let known = self.heat_j.iter().position(|it| it.0 == index);
        let place = known.unwrap_or_else(|| {
            self.heat_j.push((index, 0.0));
            self.heat_j.len() - 1
        });
        let Some((_, sum_j)) = self.heat_j.get_mut(place) else {
            return false;
        };
        *sum_j += heat_j;
        let sum_j = *sum_j;
        let deepened = self.deepen(index, heat_j, at_m);
        let [here_mm, depth_mm] = deepened.map(|heat_j| heat_j / DEEP_J_MM);
        if sum_j >= rule.burn_j || depth_mm >= rule.burn_mm {
            self.burn(at_s, (index, organ), rule, Some([sum_j, depth_mm]));
        }
        here_mm >= rule.burn_mm
    }

    /// Notes a burn of the organ with this index and name, because heat from beside has destroyed
    /// some of it. Organs without a limit of heat may be burnt.
    pub(crate) fn sear(&mut self, at_s: f64, organ: (u32, &str), rule: &InjuryRule) {
        if rule.burn_j.is_finite() {
            self.burn(at_s, organ, rule, None);
        }
    }

    /// Notes a burn, with heat, J, and depth, mm, if they are known.
    fn burn(
        &mut self,
        at_s: f64,
        (index, organ): (u32, &str),
        rule: &InjuryRule,
        heat: Option<[f64; 2]>,
    ) {
        let injury = Injury {
            at_s,
            kind: InjuryKind::Burnt,
            cause: Cause::Burnt,
            severity: rule.open.min(Severity::Serious),
            organ: organ.to_owned(),
            ends_task: false,
            heat_j: heat.map(|[heat_j, _]| heat_j),
            depth_mm: heat.map(|[_, depth_mm]| depth_mm),
            source: rule.source.clone(),
        };
        self.note(index, injury);
    }

    /// Adds heat to the burnt place of an organ that lies within its radius, or begins a new place.
    /// Returns the heat of this place and that of the organ's hottest place, J.
    fn deepen(&mut self, index: u32, heat_j: f64, at_m: Vec3) -> [f64; 2] {
        let is_there = |it: &(u32, Vec3, f64)| it.0 == index && distance(it.1, at_m) < PLACE_M;
        let known = self.places.iter().position(is_there);
        let own = |it: &&(u32, Vec3, f64)| it.0 == index;
        let mut here_j = heat_j;
        if let Some(place) = known.and_then(|known| self.places.get_mut(known)) {
            place.2 += heat_j;
            here_j = place.2;
        } else if self.places.iter().filter(own).count() < PLACES_MAX {
            self.places.push((index, at_m, heat_j));
        }
        let places = self.places.iter().filter(own);
        [here_j, places.map(|it| it.2).fold(0.0, f64::max)]
    }

    /// Keeps an injury, unless the organ already has one of its kind. An organ that tears and then
    /// opens has one injury, the opening.
    fn note(&mut self, index: u32, injury: Injury) {
        if injury.kind != InjuryKind::Torn && injury.cause == Cause::Torn {
            self.found
                .retain(|(organ, it)| *organ != index || it.kind != InjuryKind::Torn);
        }
        let opens = [InjuryKind::Divided, InjuryKind::Perforated];
        let is_known = |(organ, it): &(u32, Injury)| {
            // What tears after it was opened is open already.
            let is_open = injury.kind == InjuryKind::Torn && opens.contains(&it.kind);
            *organ == index && (it.kind == injury.kind || is_open)
        };
        if !self.found.iter().any(is_known) {
            self.found.push((index, injury));
        }
    }

    /// All injuries, the oldest first.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Injury> {
        self.found.iter().map(|(_, injury)| injury)
    }
}
