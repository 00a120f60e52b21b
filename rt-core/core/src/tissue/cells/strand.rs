//! Strands of a layered sheet: the cells of one sphere. When all attachments of the sphere to
//! another organ have torn, its cells hang on nothing and are removed.

use super::Removed;
use crate::math::Vec3;
use crate::scene::{Anchor, Attachment, Scene};
use crate::tissue::Bodies;
use crate::words::SphereBits;

/// Share of the difference from a neighbour's displacement by which a sphere without cells moves in
/// a tick.
const FOLLOW_SHARE: f32 = 0.25;
/// Largest number of cells removed in one tick, so that their events find room; the rest follow in
/// later ticks.
const REMOVALS_PER_TICK_MAX: usize = 8;

impl Bodies {
    /// Removes the cells of a torn strand, one strand at a time. O(attachments); O(attachments +
    /// cells) when a strand has torn.
    pub(crate) fn tear_cells(&mut self, scene: &Scene<'_>, mut removed: impl FnMut(Removed)) {
        if scene.layers.cells.is_empty() {
            return;
        }
        let Some(sphere) = self.torn_strand(scene) else {
            return;
        };
        let mut count = 0;
        for (index, cell) in (0u16..).zip(scene.layers.cells) {
            if cell.sphere() == sphere
                && let Some(cell) = self.remove_cell(index, scene)
            {
                removed(cell);
                count += 1;
                if count >= REMOVALS_PER_TICK_MAX {
                    break;
                }
            }
        }
    }

    /// Moves each sphere without cells with its neighbours. Such a sphere is attached to nothing
    /// and would fall, and with it the neighbouring cells and the drawn skin, which it still
    /// carries in part. In organs with tetrahedra, the tetrahedra hold the sphere. O(links of
    /// organs without tetrahedra).
    pub(crate) fn move_spheres_without_cells(&mut self, scene: &Scene<'_>) {
        if self.cells.removed == 0 {
            return;
        }
        let organs = scene.organs.iter();
        for organ in organs.filter(|organ| scene.batches_of(organ).is_empty()) {
            for link in scene.links_of(organ) {
                let removed = |sphere: u32| self.bits.at(sphere).contains(SphereBits::REMOVED);
                let (a_removed, b_removed) = (removed(link.a), removed(link.b));
                if !a_removed && !b_removed {
                    continue;
                }
                let [a_m, b_m] = [link.a, link.b].map(|i| self.nodes.at(i).moved_m());
                let travel_m = (b_m - a_m) * FOLLOW_SHARE;
                if a_removed {
                    self.nodes
                        .at_mut(link.a)
                        .put(&(a_m + travel_m), &Vec3::zeros());
                }
                if b_removed {
                    self.nodes
                        .at_mut(link.b)
                        .put(&(b_m - travel_m), &Vec3::zeros());
                }
            }
        }
    }

    /// A sphere with cells whose attachments to another organ are all severed. The scene lists
    /// attachments of one sphere to one organ together.
    fn torn_strand(&self, scene: &Scene<'_>) -> Option<u32> {
        let other_organ = |tie: &Attachment| match tie.to {
            Anchor::Sphere(sphere) => Some(*self.organ.at(sphere)),
            Anchor::World(_) => None,
        };
        let mut run: Option<(u32, Option<u8>, bool)> = None;
        for (i, tie) in scene.attachments.iter().enumerate() {
            let damage = self.damage.intact_of_tie(i) <= 0.0;
            run = match run {
                Some((sphere, organ, torn))
                    if sphere == tie.sphere && organ == other_organ(tie) =>
                {
                    Some((sphere, organ, torn && damage))
                }
                last => {
                    if let Some(sphere) = self.detached_sphere(last) {
                        return Some(sphere);
                    }
                    Some((tie.sphere, other_organ(tie), damage))
                }
            };
        }
        self.detached_sphere(run)
    }

    fn detached_sphere(&self, run: Option<(u32, Option<u8>, bool)>) -> Option<u32> {
        let (sphere, _, _) = run.filter(|(_, _, torn)| *torn)?;
        let has_cells = self.cells.has_cells(sphere);
        let removed = self.bits.at(sphere).contains(SphereBits::REMOVED);
        (has_cells && !removed).then_some(sphere)
    }
}
