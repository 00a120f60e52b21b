//! Flow in vessels and ducts, and leaks.
//!
//! Pressure spreads from its sources ([`flow`]) along intact links, and across attachments between
//! organs of equal content. Clips and desiccated walls reduce it. A change restarts the
//! computation: each tick makes one pass over all tubes and attachments, until a pass changes
//! nothing. Then every divided end and every hole leaks at the pressure that reaches it. Changes of
//! a leak raise events.

mod flow;
mod hole;
mod slit;

use heapless::Vec;

use crate::capacity::{MAX_HOLES, MAX_ORGANS};
use crate::procedure::clip::Clips;
use crate::procedure::journal::Journal;
use crate::scene::{Inside, Organ, Scene};
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind};
use hole::{Hole, Opening, open_lumen};

/// Shortening of a divided artery, as a share of its length. It is about the stretch of an artery
/// in the body: the aorta of old people is stretched by 5 %, the aorta of young people by far more
/// (10.1007/s00414-011-0549-9).
const ARTERY_SHORTENING: f32 = 0.1;
/// Shortening of a divided duct, as a share of its length. Assumed: half the artery's.
const DUCT_SHORTENING: f32 = 0.05;
/// Shortening of a divided tube in a tick, as a share of its length. An artery has shortened fully
/// after 0.3 s.
const SHORTENING_STEP: f32 = ARTERY_SHORTENING / 300.0;
/// Change of flow below which no event is raised.
const REPORTED_CHANGE: f32 = 0.01;
/// Largest radius of a vessel that desiccation can close, m. In larger vessels blood carries the
/// heat away. The clinical limit with one electrode is 1 mm; 0.5 mm are added to allow for the
/// radii of spheres.
const DRIED_RADIUS_M: f32 = 0.001_5;
/// Energy that seals a wall, J/m³: it heats the tissue to 100 °C and boils a third of its water,
/// `1060 kg/m³ (3600 J/kg K · 63 K + 0.25 · 2.26 MJ/kg)`.
const SEAL_J_M3: f32 = 8.4e8;

/// A hole of a bag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mouth {
    /// Sphere at the hole.
    pub(crate) sphere: u32,
    /// Area of the hole, m².
    pub(crate) area_m2: f32,
    /// Flow as the last event of the leak reported it, as a share of the full flow.
    pub(crate) flow: f32,
}

/// Progress of the flow computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Progress {
    /// Nothing has changed.
    Settled,
    /// Pressure must be recomputed.
    Changed,
    /// Pressure is spreading.
    Spreading,
}

/// Flow in all vessels and ducts.
#[derive(Debug, Clone)]
pub(crate) struct Vessels {
    /// Pressure at each sphere, as a share of the full pressure.
    pressure: PerSphere<f32>,
    /// Energy that has desiccated each sphere's piece of vessel, J.
    desiccation_j: PerSphere<f32>,
    holes: Vec<Hole, MAX_HOLES>,
    /// True if a leak has found no room in `holes` since `take_lost_leak` was last called.
    has_lost_leak: bool,
    /// Slits that found no room in `holes` in the last tick.
    slits_without_room: usize,
    /// True for organs that are divided somewhere.
    divided: [bool; MAX_ORGANS],
    progress: Progress,
}

impl Vessels {
    pub(crate) const fn new() -> Self {
        Self {
            pressure: PerSphere::new(0.0),
            desiccation_j: PerSphere::new(0.0),
            holes: Vec::new(),
            has_lost_leak: false,
            slits_without_room: 0,
            divided: [false; MAX_ORGANS],
            progress: Progress::Settled,
        }
    }

    /// Forgets pressure, desiccation and leaks. `Bodies::reset` restores divided links.
    pub(crate) fn reset(&mut self) {
        *self = Self::new();
    }

    /// Marks present divisions as part of the task's start: they raise no event `Divided`, but
    /// their leaks raise events.
    pub(crate) fn mark_prepared(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        self.find_holes(scene, bodies, |_| true);
        self.mark_changed();
    }

    /// Restarts the flow computation, because something was divided, clipped or burnt.
    pub(crate) fn mark_changed(&mut self) {
        self.progress = Progress::Changed;
    }

    /// Desiccates the tube at this sphere with `energy_j`.
    pub(crate) fn desiccate(
        &mut self,
        sphere: u32,
        energy_j: f32,
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) {
        let before = self.open_share(sphere, scene, bodies);
        *self.desiccation_j.at_mut(sphere) += energy_j;
        if self.open_share(sphere, scene, bodies) < before {
            self.mark_changed();
        }
    }

    /// Opens a hole of `area_m2` in the wall at this sphere.
    pub(crate) fn perforate(&mut self, sphere: u32, area_m2: f32) {
        let wall = Opening::Wall { sphere, area_m2 };
        self.has_lost_leak |= self.holes.push(Hole::new(wall)).is_err();
        self.mark_changed();
    }

    /// True if the wall has a hole at this sphere.
    pub(crate) fn has_hole(&self, sphere: u32) -> bool {
        let is_hole =
            |it: &Hole| matches!(it.opening, Opening::Wall { sphere: at, .. } if at == sphere);
        self.holes.iter().any(is_hole)
    }

    /// Holes of this bag.
    pub(crate) fn mouths(&self, bag: &Organ) -> impl Iterator<Item = Mouth> + use<'_> {
        let (start, count) = (bag.sphere_start, bag.sphere_count);
        let own = move |it: &&Hole| it.opening.sphere().wrapping_sub(start) < count;
        self.holes.iter().filter(own).map(|it| Mouth {
            sphere: it.opening.sphere(),
            area_m2: it.opening.bag_area_m2(),
            flow: it.reported,
        })
    }

    /// Pressure at this sphere, as a share of the full pressure.
    pub(crate) fn pressure(&self, sphere: u32) -> f32 {
        *self.pressure.at(sphere)
    }

    /// Advances a tick: spreads pressure, reports leaks, shortens divided tubes.
    pub(crate) fn flow(
        &mut self,
        scene: &Scene<'_>,
        clips: &Clips,
        bodies: &mut Bodies,
        journal: &mut Journal,
    ) {
        for ((organ, it), divided) in (0u8..).zip(scene.organs).zip(self.divided) {
            if divided {
                let shortening = match it.inside {
                    Inside::Blood => ARTERY_SHORTENING,
                    _ => DUCT_SHORTENING,
                };
                bodies
                    .damage
                    .shorten_links(organ, 1.0 - shortening, SHORTENING_STEP);
            }
        }
        self.find_slits(scene, bodies);
        match self.progress {
            Progress::Settled => {}
            Progress::Changed => {
                self.begin(scene);
                self.progress = Progress::Spreading;
            }
            Progress::Spreading => {
                if !self.spread(scene, clips, bodies) {
                    let all_accepted = self.find_holes(scene, bodies, |opening| {
                        let sphere = opening.sphere();
                        if !journal.has_room() {
                            return false;
                        }
                        journal.raise(Event {
                            kind: EventKind::Divided,
                            organ: Some(u32::from(*bodies.organ.at(sphere))),
                            at_m: bodies.nodes.at(sphere).center_m(),
                            value: open_lumen(opening, scene, clips, bodies),
                        });
                        true
                    });
                    // An event without room in this tick is raised in the next.
                    if self.report_leaks(scene, clips, bodies, journal) && all_accepted {
                        self.progress = Progress::Settled;
                    }
                }
            }
        }
    }

    /// True if a leak found no room since the last call.
    pub(crate) fn take_lost_leak(&mut self) -> bool {
        core::mem::take(&mut self.has_lost_leak)
    }

    /// Share of the tube's lumen at this sphere that desiccation has left open, in steps of a
    /// quarter.
    fn open_share(&self, sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
        let organ = scene.organs.get(usize::from(*bodies.organ.at(sphere)));
        let radius_m = scene
            .spheres
            .get(sphere as usize)
            .map_or(0.0, |it| it.radius_m);
        let is_vessel = organ.is_some_and(|it| it.inside == Inside::Blood && it.is_tube());
        if !is_vessel || radius_m > DRIED_RADIUS_M {
            return 1.0;
        }
        // The sphere's piece of vessel is taken to be as long as it is thick.
        let seal_j = SEAL_J_M3 * core::f32::consts::TAU * radius_m * radius_m * radius_m;
        let quarters = (4.0 * self.desiccation_j.at(sphere) / seal_j).min(4.0);
        // `as` saturates and truncates.
        1.0 - f32::from(quarters as u8) * 0.25
    }

    /// Raises events for changed leaks. Returns true if there was room for all.
    fn report_leaks(
        &mut self,
        scene: &Scene<'_>,
        clips: &Clips,
        bodies: &Bodies,
        journal: &mut Journal,
    ) -> bool {
        let mut has_room_for_all = true;
        let mut holes = core::mem::take(&mut self.holes);
        for hole in &mut holes {
            let sphere = hole.opening.sphere();
            let arriving = self
                .pressure
                .at(sphere)
                .min(self.open_share(sphere, scene, bodies));
            let flow = match hole.delay_ticks {
                0 => arriving * hole.opening.share(scene, clips, bodies),
                _ => 0.0,
            };
            if (flow - hole.reported).abs() <= REPORTED_CHANGE {
                continue;
            }
            let organ = Some(u32::from(*bodies.organ.at(sphere)));
            let place_m = bodies.nodes.at(sphere).center_m();
            // A perforation is reported with the first leak of a slit. A tube between clips is dry,
            // so no slit in it is reported.
            let is_new_slit = matches!(hole.opening, Opening::Slit { .. }) && hole.at_m.is_none();
            if is_new_slit && journal.has_room() {
                hole.at_m = Some(place_m);
                journal.raise(Event {
                    kind: EventKind::Perforation,
                    organ,
                    at_m: place_m,
                    value: 0.0,
                });
            }
            has_room_for_all &= journal.has_room();
            if journal.has_room() {
                hole.reported = flow;
                journal.raise(Event {
                    kind: EventKind::Leak,
                    organ,
                    at_m: *hole.at_m.get_or_insert(place_m),
                    value: flow,
                });
            }
        }
        self.holes = holes;
        has_room_for_all
    }
}
