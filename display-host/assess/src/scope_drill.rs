//! The endoscope drill. The trainee shows organs one after the other, and holds each in the
//! picture. An organ counts as shown if enough of it is in the picture and not hidden, and if it is
//! large enough and near the middle. Identity images of the recording ([`session::identity`])
//! measure this. While the organ is held, the picture must not sway, and its horizon must be level.

use session::identity::{OrganSeen, Seen};
use shared_mem::scene::OrganKind;

use crate::anatomy::Anatomy;
use crate::hold::{Hold, Lack, Timer};
use crate::rules::ShowRule;
use crate::steady::Held;
use crate::step::Step;

/// Organs to show in the endoscope drill, in this order; those missing from a scene are left out.
pub const DRILL_ORGANS: [OrganKind; 6] = [
    OrganKind::Gallbladder,
    OrganKind::CysticDuct,
    OrganKind::Liver,
    OrganKind::Stomach,
    OrganKind::Intestine,
    OrganKind::CysticArtery,
];

/// Progress of the drill.
#[derive(Debug, Clone, Default)]
pub(crate) struct ScopeDrill {
    targets: Vec<usize>,
    shown: usize,
    timer: Timer,
    /// Path of the picture's middle while the shown organs were held, m, and duration of these
    /// holds, s.
    swayed: [f64; 2],
}

impl ScopeDrill {
    pub(crate) fn new(anatomy: &Anatomy) -> Self {
        let find = |kind: OrganKind| {
            let mut organs = anatomy.organs.iter();
            organs.position(|organ| organ.kind == Some(kind))
        };
        Self {
            targets: DRILL_ORGANS.into_iter().filter_map(find).collect(),
            ..Self::default()
        }
    }

    pub(crate) fn look(&mut self, seen: &Seen, held: &Held, rule: &ShowRule, look_s: f64) {
        let Some(organ) = self.targets.get(self.shown) else {
            return;
        };
        let lack = match seen.organs.get(*organ) {
            Some(organ) => lack(organ, rule),
            None => Some(Lack::OutOfView),
        };
        if let Some([path_m, time_s]) = self.timer.look(lack, held, &rule.steadiness, look_s) {
            let [path_sum, time_sum] = &mut self.swayed;
            *path_sum += path_m;
            *time_sum += time_s;
            self.shown += 1;
        }
    }

    /// Share of the required time for which the present organ has been held.
    pub(crate) fn share(&self, look_s: f64) -> f64 {
        self.timer.hold(look_s).share
    }

    /// Mean speed of the picture's middle while the shown organs were held, mm/s; NaN before one is
    /// shown.
    pub(crate) fn sway_mm_s(&self) -> f64 {
        let [path_m, time_s] = self.swayed;
        path_m / time_s * 1e3
    }

    /// The running hold; `None` at the end.
    pub(crate) fn hold(&self, look_s: f64) -> Option<Hold> {
        (self.shown < self.targets.len()).then(|| self.timer.hold(look_s))
    }

    /// The organs as steps, and whether each has been shown.
    pub(crate) fn steps(&self, anatomy: &Anatomy) -> Vec<(Step, bool)> {
        let targets = self.targets.iter().enumerate();
        let step = |(number, index): (usize, &usize)| {
            let organ = anatomy.organs.get(*index).map(|organ| organ.name.clone());
            let organ = organ.unwrap_or_default();
            (Step::Show { organ }, number < self.shown)
        };
        targets.map(step).collect()
    }
}

/// First fault of an organ's picture; `None` if it has none. An organ that fills enough of the
/// picture may be partly outside or hidden.
pub(crate) fn lack(organ: &OrganSeen, rule: &ShowRule) -> Option<Lack> {
    let is_large = organ.size() >= rule.large;
    [
        (!is_large && organ.in_view() < rule.visible, Lack::OutOfView),
        (!is_large && organ.visible() < rule.visible, Lack::Hidden),
        (organ.size() < rule.small, Lack::Small),
        (organ.off() > rule.off, Lack::Aside),
    ]
    .into_iter()
    .find_map(|(lacks, what)| lacks.then_some(what))
}
