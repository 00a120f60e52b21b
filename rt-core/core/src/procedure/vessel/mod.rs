//! What runs in vessels and ducts, and where it comes out.
//!
//! Pressure spreads from where blood and bile come from ([`flow`]) along links that have not parted and
//! ties between what holds the same, through clips and dried walls as far as those leave it open. It does
//! so only after something has changed, a step along every tube in a tick. Then every divided end and
//! every hole leaks what reaches it, and changes are told.

mod flow;
mod hole;

use heapless::Vec;

use crate::capacity::{MAX_HOLES, MAX_ORGANS};
use crate::procedure::clip::Clips;
use crate::procedure::journal::Journal;
use crate::scene::{Inside, Scene};
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind};
use hole::{Hole, Opening, unclosed};

/// A divided artery shortens by this: vessels lie stretched by a tenth in the body (the aorta of the old
/// by 5 %, of the young by far more; 10.1007/s00414-011-0549-9). For ducts half of it is assumed.
const ARTERY_SHORTENS: f32 = 0.1;
const DUCT_SHORTENS: f32 = 0.05;
/// What of its length it shortens in a tick: the artery is done after 0.3 s.
const SHORTENS_STEP: f32 = ARTERY_SHORTENS / 300.0;
/// Flows that differ by less are told as the same.
const TOLD: f32 = 0.01;
/// Vessels thicker than this do not close by drying, m: blood carries the heat away (2 mm across is
/// what one electrode is trusted with; some room for spheres).
const DRIED_RADIUS_M: f32 = 0.001_5;
/// What closes a volume of vessel, J/m³: heated to 100 °C, collagen has shrunk long before, and a third of
/// its water boiled off, so that the walls stick. `1060 kg/m³ (3600 J/kg K · 63 K + 0.25 · 2.26 MJ/kg)`.
const CLOSES_J_M3: f32 = 8.4e8;

/// Whether what runs is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Progress {
    /// Nothing has changed.
    Known,
    /// Something has.
    Changed,
    /// Pressure spreads.
    Spreading,
}

/// What runs in everything.
#[derive(Debug, Clone)]
pub(crate) struct Vessels {
    /// Share of the whole pressure that reaches each sphere.
    pressure: PerSphere<f32>,
    /// What has dried each sphere's stretch of vessel, J.
    dried_j: PerSphere<f32>,
    holes: Vec<Hole, MAX_HOLES>,
    /// Some place found no room in `holes` in this tick.
    is_overrun: bool,
    /// Which organs are divided somewhere.
    divided: [bool; MAX_ORGANS],
    progress: Progress,
}

impl Vessels {
    pub(crate) const fn new() -> Self {
        Self {
            pressure: PerSphere::new(0.0),
            dried_j: PerSphere::new(0.0),
            holes: Vec::new(),
            is_overrun: false,
            divided: [false; MAX_ORGANS],
            progress: Progress::Known,
        }
    }

    /// Everything is whole again.
    pub(crate) fn rest(&mut self) {
        *self = Self::new();
    }

    /// What is divided now was so before anything that is told.
    pub(crate) fn note_prepared(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        self.find_holes(scene, bodies, |_| true);
        self.note_change();
    }

    /// Something was divided, clipped or burnt.
    pub(crate) fn note_change(&mut self) {
        self.progress = Progress::Changed;
    }

    /// Current has dried the tube at this sphere by so much.
    pub(crate) fn dry(&mut self, sphere: u32, energy_j: f32, scene: &Scene<'_>, bodies: &Bodies) {
        let before = self.open(sphere, scene, bodies);
        *self.dried_j.at_mut(sphere) += energy_j;
        if self.open(sphere, scene, bodies) < before {
            self.note_change();
        }
    }

    /// A wall is burnt through at this sphere: a hole of `area_m2`.
    pub(crate) fn burst(&mut self, sphere: u32, area_m2: f32) {
        let wall = Opening::Wall { sphere, area_m2 };
        self.is_overrun |= self.holes.push(Hole::new(wall)).is_err();
        self.note_change();
    }

    /// A tick: pressure spreads, holes are told of, divided tubes shorten.
    pub(crate) fn flow(
        &mut self,
        scene: &Scene<'_>,
        clips: &Clips,
        bodies: &mut Bodies,
        journal: &mut Journal,
    ) {
        for ((organ, it), divided) in (0u8..).zip(scene.organs).zip(self.divided) {
            if divided {
                let shortens = match it.inside {
                    Inside::Blood => ARTERY_SHORTENS,
                    _ => DUCT_SHORTENS,
                };
                bodies.parted.shrink(organ, 1.0 - shortens, SHORTENS_STEP);
            }
        }
        match self.progress {
            Progress::Known => {}
            Progress::Changed => {
                self.begin(scene);
                self.progress = Progress::Spreading;
            }
            Progress::Spreading => {
                if !self.spread(scene, clips, bodies) {
                    let is_all = self.find_holes(scene, bodies, |opening| {
                        let sphere = opening.sphere();
                        if !journal.has_room() {
                            return false;
                        }
                        journal.raise(Event {
                            kind: EventKind::Divided,
                            organ: Some(u32::from(*bodies.organ.at(sphere))),
                            at_m: bodies.nodes.at(sphere).center_m(),
                            value: unclosed(opening, scene, clips, bodies),
                        });
                        true
                    });
                    // What this tick has no room for the next one tells.
                    if self.tell(scene, clips, bodies, journal) && is_all {
                        self.progress = Progress::Known;
                    }
                }
            }
        }
    }

    /// Whether since the last call some place found no room among those that leak.
    pub(crate) fn is_overrun(&mut self) -> bool {
        core::mem::take(&mut self.is_overrun)
    }

    /// Share of the inside of the tube at this sphere that drying has left open; in quarters.
    fn open(&self, sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
        let organ = scene.organs.get(usize::from(*bodies.organ.at(sphere)));
        let radius_m = scene
            .spheres
            .get(sphere as usize)
            .map_or(0.0, |it| it.radius_m);
        let is_vessel = organ.is_some_and(|it| it.inside == Inside::Blood && it.is_tube());
        if !is_vessel || radius_m > DRIED_RADIUS_M {
            return 1.0;
        }
        // As long as it is thick.
        let whole_j = CLOSES_J_M3 * core::f32::consts::TAU * radius_m * radius_m * radius_m;
        let quarters = (4.0 * self.dried_j.at(sphere) / whole_j).min(4.0);
        // `as` saturates and cuts off.
        1.0 - f32::from(quarters as u8) * 0.25
    }

    /// Tells of what has changed; whether there was room for all of it.
    fn tell(
        &mut self,
        scene: &Scene<'_>,
        clips: &Clips,
        bodies: &Bodies,
        journal: &mut Journal,
    ) -> bool {
        let mut is_told = true;
        let mut holes = core::mem::take(&mut self.holes);
        for hole in &mut holes {
            let sphere = hole.opening.sphere();
            let reaches = self
                .pressure
                .at(sphere)
                .min(self.open(sphere, scene, bodies));
            let flow = reaches * hole.opening.share(scene, clips);
            if (flow - hole.told).abs() <= TOLD {
                continue;
            }
            is_told &= journal.has_room();
            if journal.has_room() {
                hole.told = flow;
                let at_m = *hole.at_m.get_or_insert(bodies.nodes.at(sphere).center_m());
                journal.raise(Event {
                    kind: EventKind::Leak,
                    organ: Some(u32::from(*bodies.organ.at(sphere))),
                    at_m,
                    value: flow,
                });
            }
        }
        self.holes = holes;
        is_told
    }
}
