//! Prepared states: the operation up to the start of a task.

use crate::capacity::MAX_ORGANS;
use crate::math;
use crate::scene::{Anchor, Inside, Organ};
use crate::sim::{Sim, Task};
use crate::tissue::Node;
use crate::tissue::tubes::TubeSegment;

/// Positions of the clips along a prepared tube, from the body's end, 0, to the gallbladder's, 1.
/// Two clips stay with the body, one leaves with the gallbladder.
const CLIPS_AT: [f32; 3] = [0.35, 0.5, 0.8];
/// Distance from the middle of duct and artery within which tissue is dissected before clipping, m.
const CLEARED_M: f32 = 0.008;
/// Position at which a prepared tube is divided, from the body's end.
const DIVIDED_AT: f32 = 0.65;

impl Sim<'_> {
    /// Resets the simulation, then prepares the start of `task`. The prepared work raises no
    /// events, because the trainee did not do it.
    pub(super) fn start(&mut self, task: Task) {
        self.reset();
        if task == Task::Hang {
            self.state.bodies.sutures.take_down();
            return;
        }
        if task == Task::Identify {
            return;
        }
        self.clear_triangle();
        if task == Task::Clamp {
            return;
        }
        for (organ, organ_record) in (0u8..).zip(self.scene.organs) {
            let Some(is_from_first) = self.is_numbered_from_body(organ, organ_record) else {
                continue;
            };
            self.unrest.mark_freed(organ.into());
            for share in CLIPS_AT {
                if let Some(segment) = self.segment_at(organ, organ_record, share, is_from_first) {
                    self.clips.close_on(&segment, &mut self.state.bodies);
                }
            }
            if let (Task::Disconnect, Some(segment)) = (
                task,
                self.segment_at(organ, organ_record, DIVIDED_AT, is_from_first),
            ) {
                let (a, b) = (u32::from(segment.a), u32::from(segment.b));
                let links =
                    (organ_record.link_start..).zip(self.scene.elastic_links_of(organ_record));
                for (link, ends) in links {
                    // The longer links across this segment, which resist bending, are severed too.
                    let (low, high) = (ends.a.min(ends.b), ends.a.max(ends.b));
                    if low <= a.min(b) && high >= a.max(b) {
                        self.state.bodies.damage.sever_link(link);
                    }
                }
            }
        }
        let state = &mut *self.state;
        state.vessels.mark_prepared(&self.scene, &state.bodies);
    }

    /// Removes the cells around the cystic duct and artery.
    fn clear_triangle(&mut self) {
        let is_cystic = |organ| {
            let organ_record = self.scene.organs.get(usize::from(organ));
            organ_record.is_some_and(|organ_record| {
                self.is_numbered_from_body(organ, organ_record).is_some()
            })
        };
        let cystic = core::array::from_fn::<bool, MAX_ORGANS, _>(|organ| is_cystic(organ as u8));
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let tubes = || {
            scene
                .organs
                .iter()
                .zip(cystic)
                .filter(|(_, cystic)| *cystic)
        };
        bodies.clear_cells(scene, |bodies, at_m| {
            tubes().any(|(tube, _)| {
                let spheres = bodies.nodes.range(tube.sphere_start, tube.sphere_count);
                let near = |node: &Node| math::norm(&(node.center_m() - at_m)) < CLEARED_M;
                spheres.iter().any(near)
            })
        });
    }

    /// For a duct or vessel that is attached to the gallbladder: true if its first sphere is at the
    /// other end. `None` for other organs.
    pub(super) fn is_numbered_from_body(&self, organ: u8, organ_record: &Organ) -> Option<bool> {
        if !organ_record.is_tube() || !matches!(organ_record.inside, Inside::Blood | Inside::Bile) {
            return None;
        }
        let bodies = &self.state.bodies;
        let is_bag = |sphere: u32| {
            let other = self.scene.organs.get(usize::from(*bodies.organ.at(sphere)));
            other.is_some_and(|other| other.inside == Inside::Bile && !other.is_tube())
        };
        let ends = self
            .scene
            .attachments
            .iter()
            .filter_map(|tie| match tie.to {
                Anchor::Sphere(other) => Some([(tie.sphere, other), (other, tie.sphere)]),
                Anchor::World(_) => None,
            });
        let mut own = ends.flatten();
        let (sphere, _) =
            own.find(|(own, other)| *bodies.organ.at(*own) == organ && is_bag(*other))?;
        Some(sphere.saturating_sub(organ_record.sphere_start) * 2 > organ_record.sphere_count)
    }

    /// Segment at this share of the length of a tube whose spheres are numbered along it. The share
    /// counts from the first sphere if `is_from_first`, else from the last.
    pub(super) fn segment_at(
        &self,
        organ: u8,
        organ_record: &Organ,
        share: f32,
        is_from_first: bool,
    ) -> Option<TubeSegment> {
        // The result is symmetric, because preparation may number the spheres from either end.
        let last = organ_record.sphere_count.saturating_sub(2);
        let from_end = ((share * (last + 1) as f32) as u32).min(last);
        let place = if is_from_first {
            from_end
        } else {
            last - from_end
        };
        let sphere = organ_record.sphere_start + place;
        let distance = |segment: &TubeSegment| u32::from(segment.a.min(segment.b)).abs_diff(sphere);
        let segments = self.state.bodies.beads.segments_of(organ);
        segments.min_by_key(distance)
    }
}
