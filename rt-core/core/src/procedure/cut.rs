//! Scissors: what runs from one side of their blades to the other is cut as they close.
//!
//! Links of tubes, bands and sutures are cut by as much as the blades close on them, from where they
//! are as thick as the gap of the blades; what blades push out of themselves is cut by as much as
//! they had closed on it. Their edges dig in: what they meet goes with them. Of the cutting force the hand feels nothing: handles close by a button,
//! and between the blades it is in balance. What it feels is what the tissue no longer bears.
//! Tetrahedra are not cut yet.

use crate::math::Vec3;
use crate::procedure::clip::guards;
use crate::procedure::grasp::Jaws;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::part::{Apart, part_all, sparing_none};

/// Cuts what is between these blades, which have closed by `closed` of their opening, but no clip and
/// nothing under one (`clips`: links and places, world frame, m); `cut` hears
/// of what they have severed. Returns whether something is left between their edges. O(attachments and
/// elastic links of organs that move).
pub(crate) fn cut_all(
    blades: &Jaws<'_>,
    closed: f32,
    clips: &[(u32, Vec3)],
    scene: &Scene<'_>,
    bodies: &mut Bodies,
    cut: impl FnMut(Apart),
) -> bool {
    let mut is_cutting = false;
    part_all(scene, bodies, sparing_none, cut, |bar, parted| {
        let Some(crossing) = blades.crossing(&bar.ends_m, bar.radius_m) else {
            return parted;
        };
        let at_m = bar.ends_m[0] + (bar.ends_m[1] - bar.ends_m[0]) * crossing.share;
        if guards(clips, bar.link, &at_m) {
            return parted;
        }
        let thick_m = 2.0 * bar.radius_m;
        let open_m = 2.0 * blades.instrument.jaw_opening_m() * crossing.along;
        let gap_m = open_m * blades.jaw;
        if gap_m >= thick_m {
            is_cutting |= parted < 1.0 && blades.meets(&crossing, bar.radius_m);
            return parted;
        }
        let parted = (parted + open_m * closed / thick_m).max(1.0 - gap_m / thick_m);
        is_cutting |= parted < 1.0;
        parted
    });
    is_cutting
}
