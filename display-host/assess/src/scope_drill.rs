//! The endoscope drill: organs to be held in the middle of the picture, one after the other. While
//! one is held, the picture should not sway.

use session::Movement;
use shared_mem::scene::OrganKind;

use crate::anatomy::Anatomy;
use crate::step::Step;
use crate::tally::{Sight, VIEW_HALF_RAD};
use crate::vector::{axis, off_sight, sub, wide};

/// Organs to show in the endoscope drill, in this order; those missing from a scene are left out.
pub const DRILL_ORGANS: [OrganKind; 6] = [
    OrganKind::Gallbladder,
    OrganKind::CysticDuct,
    OrganKind::Liver,
    OrganKind::Stomach,
    OrganKind::Intestine,
    OrganKind::CysticArtery,
];
/// Largest angle between the axis of view and an organ that counts as shown, as a share of the
/// view's half angle.
pub(crate) const MIDDLE: f64 = 0.5;
/// Least distance between the lens and an organ that counts as shown, m.
pub(crate) const NEAR_M: f64 = 0.01;
/// Largest distance between the lens and an organ that counts as shown, m.
pub(crate) const FAR_M: f64 = 0.25;
/// Distance before the lens at which the sway of the picture is measured, m: a usual distance of
/// work, from which a picture of 70° is 14 cm wide.
const WORK_M: f64 = 0.1;

/// Progress of the drill.
#[derive(Debug, Clone, Default)]
pub(crate) struct ScopeDrill {
    targets: Vec<usize>,
    shown: usize,
    held_s: f64,
    sight: Sight,
    /// The sight's path at which the present organ came into the middle, m.
    held_from_m: f64,
    /// Path of the picture's middle while the shown organs were held, m, and that time, s.
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

    pub(crate) fn moved(&mut self, moved: &Movement, seconds: f64, anatomy: &Anatomy, look_s: f64) {
        let target = self.targets.get(self.shown);
        let Some(organ) = target.and_then(|index| anatomy.organs.get(*index)) else {
            return;
        };
        let camera = &moved.world_from_camera;
        let ahead = axis(camera, 2).map(|x| x * WORK_M);
        let before_m = self.sight.path_m();
        let middle = sub(wide(camera.position_m), ahead);
        self.sight.step(middle, seconds);
        let (angle, distance_m) = off_sight(camera, organ.middle_m);
        let seen = angle <= MIDDLE * VIEW_HALF_RAD && (NEAR_M..=FAR_M).contains(&distance_m);
        if self.held_s <= 0.0 {
            self.held_from_m = before_m;
        }
        self.held_s = if seen { self.held_s + seconds } else { 0.0 };
        if self.held_s >= look_s {
            let [path_m, time_s] = &mut self.swayed;
            *path_m += self.sight.path_m() - self.held_from_m;
            *time_s += self.held_s;
            self.shown += 1;
            self.held_s = 0.0;
        }
    }

    /// Share of the time for which the present organ has been held.
    pub(crate) fn share(&self, look_s: f64) -> f64 {
        self.held_s / look_s
    }

    /// Mean speed of the picture's middle while the shown organs were held, mm/s; NaN before one is
    /// shown.
    pub(crate) fn sway_mm_s(&self) -> f64 {
        let [path_m, time_s] = self.swayed;
        path_m / time_s * 1e3
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
