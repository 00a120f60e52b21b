//! Scissors: closing blades cut the links that cross between them.
//!
//! The damage of a link (of a tube, band or suture) between the blades begins when the gap is as
//! narrow as the link is thick, and is complete when the gap is shut. A link that slides out of the
//! blades keeps its damage. The edges grip, so tissue between the blades moves with them. The hand
//! does not feel the cutting force at the shaft, because the forces of the two blades balance. It
//! feels that the severed tissue no longer pulls. Fingers in a handle that opens and shuts feel the
//! cutting force ([`crate::procedure::opening`]). Tetrahedra are not cut yet.

use crate::math::Vec3;
use crate::procedure::clip::clip_blocks;
use crate::procedure::grasp::Jaws;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::damage::{Severed, damage_all, spare_none};

/// Resistance of tissue to closing blades.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CutWork {
    /// True if uncut tissue is between the blades.
    pub(crate) is_cutting: bool,
    /// Energy that a full closing of the blades would take at the present rate, J.
    pub(crate) full_closing_j: f32,
}

/// Cuts the links between these blades, which have closed by the share `closed_share` of their full
/// opening in this tick. Does not cut at clips (`clips`: links and places, world frame, m).
/// `severed` receives each severed link. O(attachments and elastic links of organs that move).
pub(crate) fn cut_all(
    blades: &Jaws<'_>,
    closed_share: f32,
    clips: &[(u32, Vec3)],
    scene: &Scene<'_>,
    bodies: &mut Bodies,
    severed: impl FnMut(Severed),
) -> CutWork {
    let mut work = CutWork::default();
    damage_all(scene, bodies, spare_none, severed, |bar, damage| {
        let Some(crossing) = blades.crossing(&bar.ends_m, bar.radius_m) else {
            return damage;
        };
        let at_m = bar.ends_m[0] + (bar.ends_m[1] - bar.ends_m[0]) * crossing.share;
        if clip_blocks(clips, bar.link, &at_m) {
            return damage;
        }
        let thickness_m = 2.0 * bar.radius_m;
        let full_gap_m = 2.0 * blades.instrument.jaw_opening_m() * crossing.along;
        let gap_m = full_gap_m * blades.jaw;
        if gap_m >= thickness_m {
            work.is_cutting |= damage < 1.0 && blades.meets(&crossing, bar.radius_m);
            return damage;
        }
        let damage =
            (damage + full_gap_m * closed_share / thickness_m).max(1.0 - gap_m / thickness_m);
        if damage < 1.0 {
            work.is_cutting = true;
            work.full_closing_j += bar.tear_j * full_gap_m / thickness_m;
        }
        damage
    });
    work
}
