//! Sources of blood and bile, and the spread of pressure.
//!
//! | fluid | source |
//! |---|---|
//! | blood | held spheres of a vessel (the body's own vessels lie beyond), attached vessels |
//! | bile | bags (organs with tetrahedra) full of bile; the liver, where a duct is attached to it |

use crate::procedure::clip::Clips;
use crate::procedure::vessel::Vessels;
use crate::scene::{Anchor, Attachment, Inside, Scene};
use crate::tissue::Bodies;

impl Vessels {
    /// Sets the pressure at the sources, and zero elsewhere.
    pub(super) fn begin(&mut self, scene: &Scene<'_>) {
        for organ in scene.organs {
            let is_bag = organ.inside == Inside::Bile && !organ.is_tube();
            let own = self
                .pressure
                .range_mut(organ.sphere_start, organ.sphere_count);
            for (pressure, rest) in own.iter_mut().zip(scene.spheres_of(organ)) {
                let is_source = is_bag || (organ.inside == Inside::Blood && rest.held);
                *pressure = f32::from(is_source);
            }
        }
        for tie in scene.attachments {
            let (own, other) = insides(tie, scene);
            let fed_sphere = match (own, other, tie.to) {
                (Inside::Bile, Inside::Liver, _) => Some(tie.sphere),
                (Inside::Liver, Inside::Bile, Anchor::Sphere(other)) => Some(other),
                _ => None,
            };
            if let Some(sphere) = fed_sphere {
                *self.pressure.at_mut(sphere) = 1.0;
            }
        }
    }

    /// Spreads pressure once across every link of every tube, in the order of the links, and across
    /// every attachment. Returns true if any pressure changed.
    pub(super) fn spread(&mut self, scene: &Scene<'_>, clips: &Clips, bodies: &Bodies) -> bool {
        let mut has_spread = false;
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !matches!(it.inside, Inside::Blood | Inside::Bile) {
                continue;
            }
            for segment in bodies.beads.segments_of(organ) {
                if bodies.damage.intact_of_link(segment.link) > 0.0 {
                    let ends = [u32::from(segment.a), u32::from(segment.b)];
                    let open_share = clips.open_share(segment.link);
                    has_spread |= self.pass_pressure(ends, open_share, scene, bodies);
                }
            }
        }
        for (i, tie) in scene.attachments.iter().enumerate() {
            if let (Anchor::Sphere(other), true) = (tie.to, bodies.damage.intact_of_tie(i) > 0.0) {
                let (own_inside, other_inside) = insides(tie, scene);
                if own_inside == other_inside && matches!(own_inside, Inside::Blood | Inside::Bile)
                {
                    has_spread |= self.pass_pressure([tie.sphere, other], 1.0, scene, bodies);
                }
            }
        }
        has_spread
    }

    /// Raises the lower pressure of two spheres to the pressure that passes from the other sphere.
    /// `open_share` is the open share of the passage between them. Returns true if the pressure
    /// rose.
    fn pass_pressure(
        &mut self,
        [a, b]: [u32; 2],
        open_share: f32,
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) -> bool {
        let (at_a, at_b) = (*self.pressure.at(a), *self.pressure.at(b));
        let open_share_at = |sphere| self.open_share(sphere, scene, bodies);
        let passed = at_a
            .max(at_b)
            .min(open_share)
            .min(open_share_at(a))
            .min(open_share_at(b));
        if passed <= at_a.min(at_b) {
            return false;
        }
        *self.pressure.at_mut(a) = at_a.max(passed);
        *self.pressure.at_mut(b) = at_b.max(passed);
        true
    }
}

/// Contents of the two organs that an attachment joins.
pub(super) fn insides(tie: &Attachment, scene: &Scene<'_>) -> (Inside, Inside) {
    let inside = |sphere: u32| {
        let holds =
            |it: &&crate::scene::Organ| sphere.wrapping_sub(it.sphere_start) < it.sphere_count;
        let organ = scene.organs.iter().find(holds);
        organ.map_or(Inside::Solid, |organ| organ.inside)
    };
    let other = match tie.to {
        Anchor::Sphere(other) => inside(other),
        Anchor::World(_) => Inside::Solid,
    };
    (inside(tie.sphere), other)
}
