//! The critical view of safety as the endoscope shows it: the visible share of each criterion.
//!
//! An identity image says which structure each of its pixels shows ([`image`]). Structures are
//! drawn where they lie at rest, without the tissue that is removed by now: the record of an
//! operation has the endoscope's poses and the removed cells, and no positions of organs. So the
//! shares judge from where the trainee looked, and what was in front. They do not follow tissue
//! that the instrument holds aside.
//!
//! | criterion (Strasberg) | visible share |
//! |---|---|
//! | 1 triangle | volume of the triangle's cells that are gone, and whose place nothing hides |
//! | 2 lower bed | volume of the lower bed's cells that are gone, and whose place nothing hides |
//! | 3 two structures | share of the spheres of cystic duct or artery, of which less is seen |

mod image;

use shared_mem::message::PoseMsg;
use shared_mem::scene::OrganKind;

use crate::anatomy::{Anatomy, Region};
use crate::vector::{Vec3, dot, sub, wide};
use image::Image;

/// Time between two looks at the identity image, s. A view that is shown is held longer.
const EVERY_S: f64 = 0.5;

/// Side of the triangle from which the endoscope looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The side on which the endoscope's port lies.
    Front,
    Behind,
}

/// Visible share of each criterion at one moment, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Shown {
    /// Counted time since the task began, s.
    pub at_s: f64,
    /// Calot's triangle, free of tissue.
    pub triangle: f64,
    /// The lower third of the gallbladder's bed, free of tissue.
    pub lower_bed: f64,
    /// Cystic duct and cystic artery: the share of the one of which less is seen.
    pub two: f64,
}

impl Shown {
    /// A view is as good as its worst criterion, and among equals by the sum.
    fn rank(&self) -> [f64; 2] {
        let all = [self.triangle, self.lower_bed, self.two];
        [all.into_iter().fold(1.0, f64::min), all.into_iter().sum()]
    }
}

/// A criterion of the critical view of safety.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Criterion {
    /// Share that was achieved in the simulation when the first clip came: tissue removed, or
    /// vessels whole.
    pub achieved: f64,
    /// Largest share that was visible at one moment.
    pub visible: f64,
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
    /// Best view from the side of the endoscope's port.
    pub front: Option<Shown>,
    /// Best view from the other side.
    pub behind: Option<Shown>,
}

/// Best views so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Views {
    looked_s: Option<f64>,
    front: Option<Shown>,
    behind: Option<Shown>,
    most: [f64; 3],
    achieved: [f64; 3],
}

impl Views {
    /// Looks through the endoscope, `at_s` after the task began, while cystic duct and artery are
    /// whole. `is_gone` tells which cells are removed.
    pub(crate) fn look(
        &mut self,
        at_s: f64,
        camera: &PoseMsg,
        anatomy: &Anatomy,
        is_gone: &dyn Fn(usize) -> bool,
    ) {
        if self.looked_s.is_some_and(|last_s| at_s - last_s < EVERY_S) {
            return;
        }
        self.looked_s = Some(at_s);
        let removed = |region| removed(region, anatomy, is_gone);
        self.achieved = [removed(Region::Triangle), removed(Region::LowerBed), 1.0];
        let Some(side) = side(camera, anatomy) else {
            return;
        };
        let image = Image::of(camera, anatomy, is_gone);
        let cells = |region| image.seen_of_cells(region, anatomy, is_gone);
        let tube = |kind| image.seen_of_tube(kind, anatomy);
        let shown = Shown {
            at_s,
            triangle: cells(Region::Triangle),
            lower_bed: cells(Region::LowerBed),
            two: tube(OrganKind::CysticDuct).min(tube(OrganKind::CysticArtery)),
        };
        let now = [shown.triangle, shown.lower_bed, shown.two];
        for (most, share) in self.most.iter_mut().zip(now) {
            *most = most.max(share);
        }
        let best = match side {
            Side::Front => &mut self.front,
            Side::Behind => &mut self.behind,
        };
        if best.is_none_or(|best| shown.rank() > best.rank()) {
            *best = Some(shown);
        }
    }

    /// The views, beside what was achieved at the last look.
    pub(crate) fn cvs(&self) -> Cvs {
        let criterion = |index: usize| Criterion {
            achieved: self.achieved[index],
            visible: self.most[index],
        };
        Cvs {
            triangle: criterion(0),
            lower_bed: criterion(1),
            two: criterion(2),
            front: self.front,
            behind: self.behind,
        }
    }
}

/// Share of a region's tissue that is gone, by volume; 0 for a region without tissue.
fn removed(region: Region, anatomy: &Anatomy, is_gone: &dyn Fn(usize) -> bool) -> f64 {
    let (mut gone, mut all) = (0.0, 0.0);
    for (cell, (own, volume_m3)) in anatomy.cells.iter().enumerate() {
        if *own == region {
            all += volume_m3;
            gone += if is_gone(cell) { *volume_m3 } else { 0.0 };
        }
    }
    if all > 0.0 { gone / all } else { 0.0 }
}

/// Side of the plane through cystic duct and artery on which the lens lies. `None` for a scene
/// without the two.
fn side(camera: &PoseMsg, anatomy: &Anatomy) -> Option<Side> {
    let duct: Vec<Vec3> = anatomy.places_of(OrganKind::CysticDuct).collect();
    let artery: Vec<Vec3> = anatomy.places_of(OrganKind::CysticArtery).collect();
    let (first, last) = (*duct.first()?, *duct.last()?);
    let beside = *artery.get(artery.len() / 2)?;
    let (along, across) = (sub(last, first), sub(beside, first));
    let normal = [
        along[1] * across[2] - along[2] * across[1],
        along[2] * across[0] - along[0] * across[2],
        along[0] * across[1] - along[1] * across[0],
    ];
    let off = |place: Vec3| dot(sub(place, first), normal);
    let is_front = (off(wide(camera.position_m)) >= 0.0) == (off(anatomy.scope_port_m) >= 0.0);
    Some(if is_front { Side::Front } else { Side::Behind })
}

#[cfg(test)]
mod tests;
