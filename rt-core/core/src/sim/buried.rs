//! An instrument that is inside tissue when its device begins.

use crate::sim::Sim;
use crate::words::{Event, EventKind};

/// Overlap with a sphere beyond which the instrument counts as inside, m. The skin lies above the
/// sphere, so that the instrument is at least this deep. A hand that enters tissue at 1 m/s is 1 mm
/// deep after its first tick.
const BURIED_M: f32 = 0.002;

impl Sim<'_> {
    /// Raises the event of an instrument that did not come into tissue through its surface, because
    /// no tick has seen it outside: the device has just begun, or has returned.
    pub(super) fn note_buried(&mut self) {
        if !self.inputs.takes_up() {
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
