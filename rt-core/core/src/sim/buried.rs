//! An instrument that is inside tissue when its device starts or returns.

use crate::sim::Sim;
use crate::words::{Event, EventKind};

/// Overlap with a sphere beyond which the instrument counts as inside, m. The skin lies above the
/// sphere, so the instrument is at least as deep in the tissue. A hand that enters tissue at 1 m/s
/// is 1 mm deep after its first tick.
const BURIED_M: f32 = 0.002;

impl Sim<'_> {
    /// Raises an event if the instrument is inside tissue at the first sample of its device, or at
    /// the first sample after a gap.
    pub(super) fn note_buried(&mut self) {
        if !self.inputs.is_first_after_gap() {
            return;
        }
        let bodies = &self.state.bodies;
        let deepest = self.contacts.deepest_overlap(&self.tool.capsules, bodies);
        let deepest = deepest.filter(|(_, depth_m)| *depth_m > BURIED_M);
        if let Some((sphere, depth_m)) = deepest {
            self.journal.raise(Event {
                kind: EventKind::Buried,
                organ: Some((*bodies.organ.at(sphere)).into()),
                at_m: self.tool.tip_m,
                value: depth_m,
            });
        }
    }
}
