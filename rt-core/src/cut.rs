//! Scissors: what runs from one side of their blades to the other is cut as they close.
//!
//! Links of tubes, bands and sutures are cut by as much as the blades close on them, from where they
//! are as thick as the gap of the blades; what blades push out of themselves is cut by as much as
//! they had closed on it. Their edges dig in: what is being cut goes with them. Of the cutting force the hand feels nothing: handles close by a button,
//! and between the blades it is in balance. What it feels is what the tissue no longer bears.
//! Tetrahedra are not cut yet.

use crate::grasp::Jaws;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::soft_body::Bodies;
use crate::soft_body::part::{Apart, BarView, part_all};

/// Cuts what is between these blades, which have closed by `closed` of their opening; `cut` hears
/// of what they have severed. Returns whether something is left between their edges. O(attachments and
/// elastic links of organs that move).
pub(crate) fn cut_all(
    blades: &Jaws<'_>,
    closed: f32,
    scene: &Scene<'_>,
    bodies: &mut Bodies,
    cut: impl FnMut(Apart),
) -> bool {
    let mut is_cutting = false;
    let instrument_from_world = blades.world_from_instrument.inverse();
    part_all(scene, bodies, cut, |bar, parted| {
        let local = |end: Vec3| (instrument_from_world * nalgebra::Point3::from(end)).coords;
        let Some(along) = along_blades(&bar.ends_m.map(local), bar, blades) else {
            return parted;
        };
        let thick_m = 2.0 * bar.radius_m;
        let open_m = 2.0 * blades.instrument.jaw_opening_m() * along;
        let gap_m = open_m * blades.jaw;
        if gap_m >= thick_m {
            return parted;
        }
        let parted = (parted + open_m * closed / thick_m).max(1.0 - gap_m / thick_m);
        is_cutting |= parted < 1.0;
        parted
    });
    is_cutting
}

/// Where a bar with these ends in the instrument's frame crosses between the blades: from the joint, 0,
/// to their tips, 1.
fn along_blades([a, b]: &[Vec3; 2], bar: &BarView, blades: &Jaws<'_>) -> Option<f32> {
    if (a.x < 0.0) == (b.x < 0.0) {
        return None;
    }
    let at_m = a + (b - a) * (a.x / (a.x - b.x));
    let along = -at_m.z / blades.instrument.jaw_length_m();
    let half_gap_m = blades.instrument.jaw_opening_m() * blades.jaw * along;
    let is_between = (0.0..=1.0).contains(&along) && at_m.y.abs() <= half_gap_m + bar.radius_m;
    is_between.then_some(along)
}
