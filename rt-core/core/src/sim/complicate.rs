//! Complications that an instructor triggers.
//!
//! A complication makes the same changes as an injury: a hole in a wall, or a missing clip. So a
//! trainee stops the bleeding as after an injury, by a clip between the hole and the aorta or by
//! coagulation, and replaces a clip that slipped. A separate event distinguishes a complication
//! from an injury.

use crate::scene::Inside;
use crate::sim::{Complication, Sim};
use crate::words::{Event, EventKind};

/// Area of the hole, as a share of the artery's lumen: a branch that is torn off.
const HOLE_SHARE: f32 = 0.5;
/// Places along the artery at which it may bleed, from the aorta's end, 0, to the gallbladder's, 1.
const BLEEDS_AT: [f32; 3] = [0.45, 0.3, 0.6];

impl Sim<'_> {
    pub(super) fn complicate(&mut self, complication: Complication) {
        match complication {
            Complication::Bleeding => self.open_artery(),
            Complication::SlippedClip => self.slip_clip(),
        }
    }

    /// Opens a hole in the gallbladder's artery, at the first of the places [`BLEEDS_AT`] that is
    /// under pressure. Nothing happens if no place is under pressure, as after clipping, or if this
    /// place has a hole already.
    fn open_artery(&mut self) {
        let scene = self.scene;
        for (organ, it) in (0u8..).zip(scene.organs) {
            if it.inside != Inside::Blood {
                continue;
            }
            let Some(is_from_low) = self.is_numbered_from_body(organ, it) else {
                continue;
            };
            for share in BLEEDS_AT {
                let Some(segment) = self.segment_at(organ, it, share, is_from_low) else {
                    continue;
                };
                let sphere = u32::from(segment.a);
                if !self.is_fed(sphere) {
                    continue;
                }
                if self.state.vessels.has_hole(sphere) {
                    return;
                }
                let radius_m = scene
                    .spheres
                    .get(sphere as usize)
                    .map_or(0.0, |it| it.radius_m);
                let area_m2 = HOLE_SHARE * core::f32::consts::PI * radius_m * radius_m;
                self.state.vessels.perforate(sphere, area_m2);
                self.journal.raise(Event {
                    kind: EventKind::Opened,
                    organ: Some(organ.into()),
                    at_m: self.state.bodies.nodes.at(sphere).center_m(),
                    value: area_m2,
                });
                return;
            }
        }
    }

    /// True if blood reaches this sphere of a vessel. Before anything was cut or clipped, no
    /// pressure has been computed, and blood reaches every part.
    fn is_fed(&self, sphere: u32) -> bool {
        let vessels = &self.state.vessels;
        let mut all = 0..self.scene.spheres.len() as u32;
        let is_known = all.any(|other| vessels.pressure(other) > 0.0);
        !is_known || vessels.pressure(sphere) > 0.0
    }

    fn slip_clip(&mut self) {
        let (state, journal) = (&mut *self.state, &mut self.journal);
        self.clips.slip(&mut state.bodies, |organ, at_m, number| {
            journal.raise(Event {
                kind: EventKind::Unclipped,
                organ: Some(organ.into()),
                at_m,
                value: number as f32,
            });
        });
        state.vessels.mark_changed();
    }
}
