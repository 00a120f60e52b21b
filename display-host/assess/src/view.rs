//! The critical view of safety. The trainee shows and holds it from both sides of the triangle. The
//! identity images of the recording judge it ([`session::identity`]).
//!
//! | criterion (Strasberg) | visible share |
//! |---|---|
//! | 1 triangle | volume of the triangle's cells that are gone, and whose place nothing hides |
//! | 2 lower bed | volume of the lower bed's cells that are gone, and whose place nothing hides |
//! | 3 two structures | the smaller of the visible shares of cystic duct and cystic artery |
//!
//! Each view also has the model's truth: the shares of tissue that are removed, and of vessels that
//! are whole. A view counts only while the tissue is truly removed, as the task's steps ask. So the
//! shares that must be seen only tell whether the picture shows it.

use session::identity::Seen;

use crate::anatomy::Anatomy;
use crate::hold::{Hold, Lack, Timer};
use crate::rules::{Done, Least, ViewRule};
use crate::steady::Held;

/// Side of the triangle from which the endoscope looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewSide {
    /// The side on which the endoscope's port lies.
    Front,
    /// The other side.
    Behind,
}

impl ViewSide {
    /// Both sides.
    pub const BOTH: [Self; 2] = [Self::Front, Self::Behind];
}

/// A share for each criterion, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Shares {
    /// Calot's triangle, free of tissue.
    pub triangle: f64,
    /// The lower third of the gallbladder's bed, free of tissue.
    pub lower_bed: f64,
    /// Cystic duct and cystic artery.
    pub two: f64,
}

impl Shares {
    const NONE: Self = Self {
        triangle: 0.0,
        lower_bed: 0.0,
        two: 0.0,
    };

    fn all(&self) -> [f64; 3] {
        [self.triangle, self.lower_bed, self.two]
    }
}

/// A view of the triangle at one moment.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Shown {
    /// Counted time since the task began, s.
    pub at_s: f64,
    /// Angle between the line of sight and the plane of duct and artery, degrees; positive on the
    /// front.
    pub side_deg: f64,
    /// Visible share of each criterion.
    #[serde(flatten)]
    pub seen: Shares,
    /// The model's truth at this moment: removed shares of tissue, and the share of the two vessels
    /// that is whole.
    pub truth: Shares,
    /// True if the view was held as long as the rules ask.
    pub held: bool,
}

/// A criterion of the critical view of safety.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// Share achieved in the simulation before duct or artery was first clipped, divided or
    /// damaged: tissue removed, or vessels whole.
    pub achieved: f64,
    /// Largest share that was visible at one moment; `None` for a recording without identity
    /// images.
    pub visible: Option<f64>,
}

/// The critical view of safety: what was achieved, and what the endoscope showed of it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Cvs {
    /// Criterion 1: Calot's triangle is clear.
    pub triangle: Criterion,
    /// Criterion 2: the lower third of the bed is free.
    pub lower_bed: Criterion,
    /// Criterion 3: two structures, and only two, enter the gallbladder.
    pub two: Criterion,
    /// The view from the side of the endoscope's port: the one that was held, or else the best.
    pub front: Option<Shown>,
    /// The view from the other side.
    pub behind: Option<Shown>,
}

/// Views so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Views {
    timers: [Timer; 2],
    shown: [Option<Shown>; 2],
    most: Option<[f64; 3]>,
    truth: [f64; 3],
}

impl Views {
    /// Notes the model's truth, while cystic duct and artery are whole and have no clip of the
    /// trainee.
    pub(crate) fn know(&mut self, truth: [f64; 3]) {
        self.truth = truth;
    }

    /// Takes an identity image, `at_s` after the task began, while cystic duct and artery are whole
    /// and have no clip of the trainee.
    pub(crate) fn look(
        &mut self,
        at_s: f64,
        seen: &Seen,
        held: &Held,
        anatomy: &Anatomy,
        (rule, done): (&ViewRule, &Done),
    ) {
        let shares = shares(seen, anatomy);
        let [triangle, lower_bed, _] = self.truth;
        let is_cleared = triangle >= done.triangle && lower_bed >= done.lower_bed;
        let most = self.most.get_or_insert([0.0; 3]);
        for (most, share) in most.iter_mut().zip(shares.all()) {
            *most = most.max(share);
        }
        let side_deg = f64::from(seen.side_rad).to_degrees();
        for (side, timer) in ViewSide::BOTH.into_iter().zip(&mut self.timers) {
            let Some(best) = self.shown.get_mut(side as usize) else {
                continue;
            };
            let lack = lack(side, side_deg, &shares, rule);
            let lack = lack.or_else(|| (!is_cleared).then_some(Lack::Uncleared));
            let is_held = timer
                .look(lack, held, &rule.steadiness, rule.hold_s)
                .is_some();
            let shown = Shown {
                at_s,
                side_deg,
                seen: shares,
                truth: self.truth.into(),
                held: is_held,
            };
            // A view that was held stays.
            let is_better = |best: &Shown| !best.held && (is_held || rank(&shown) > rank(best));
            let is_there = lack != Some(Lack::Side);
            if is_there && best.as_ref().is_none_or(is_better) {
                *best = Some(shown);
            }
        }
    }

    /// True for each side whose view was held.
    pub(crate) fn held(&self) -> [bool; 2] {
        self.shown.map(|it| it.is_some_and(|it| it.held))
    }

    /// The running hold of a side that is still to be shown: the longer one, or the front's if both
    /// are equal.
    pub(crate) fn hold(&self, rule: &ViewRule) -> Option<Hold> {
        let open = self.held().into_iter().zip(&self.timers);
        let open = open.filter(|(held, _)| !held);
        let holds = open.map(|(_, timer)| timer.hold(rule.hold_s));
        holds.reduce(|a, b| if b.share > a.share { b } else { a })
    }

    /// The views, and the truth that was noted last.
    pub(crate) fn cvs(&self) -> Cvs {
        let criterion = |index: usize| Criterion {
            achieved: self.truth[index],
            visible: self.most.map(|most| most[index]),
        };
        let [front, behind] = self.shown;
        Cvs {
            triangle: criterion(0),
            lower_bed: criterion(1),
            two: criterion(2),
            front,
            behind,
        }
    }
}

impl From<[f64; 3]> for Shares {
    fn from([triangle, lower_bed, two]: [f64; 3]) -> Self {
        Self {
            triangle,
            lower_bed,
            two,
        }
    }
}

/// Visible share of each criterion in an identity image.
fn shares(seen: &Seen, anatomy: &Anatomy) -> Shares {
    let [Some(duct), Some(artery)] = anatomy.two() else {
        return Shares::NONE;
    };
    let of = |organ: usize| seen.organs.get(organ).map_or(0.0, |it| it.visible());
    Shares {
        triangle: seen.triangle.into(),
        lower_bed: seen.lower_bed.into(),
        two: of(duct).min(of(artery)),
    }
}

/// First fault of a view from this side; `None` if it has none.
fn lack(side: ViewSide, side_deg: f64, shares: &Shares, rule: &ViewRule) -> Option<Lack> {
    let (towards_deg, least) = match side {
        ViewSide::Front => (side_deg, &rule.front),
        ViewSide::Behind => (-side_deg, &rule.behind),
    };
    let Least {
        triangle,
        lower_bed,
        two,
    } = *least;
    [
        (towards_deg < rule.side_deg, Lack::Side),
        (shares.two < two, Lack::Two),
        (shares.triangle < triangle, Lack::Triangle),
        (shares.lower_bed < lower_bed, Lack::LowerBed),
    ]
    .into_iter()
    .find_map(|(lacks, what)| lacks.then_some(what))
}

/// Rank of a view: the smallest of its shares, then the sum of its shares.
fn rank(shown: &Shown) -> [f64; 2] {
    let all = shown.seen.all();
    [all.into_iter().fold(1.0, f64::min), all.into_iter().sum()]
}
