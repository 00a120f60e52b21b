//! An instrument that is inside tissue when its device begins.

use crate::sim::Sim;
use crate::tool::Tool;
use crate::words::{Event, EventKind};

/// Depth beyond which the instrument counts as inside, m. A hand that enters tissue at 1 m/s, the
/// fastest that the force allows, is 1 mm deep after its first tick.
const BURIED_M: f32 = 0.002;

impl Sim<'_> {
    /// Raises the event of an instrument that did not come into tissue through its surface, because
    /// no tick has seen it outside: the device has just begun, or has returned.
    pub(super) fn note_buried(&mut self) {
        if !self.inputs.takes_up() {
            return;
        }
        let deepest_m = self.contacts.deepest_m().filter(|deep| *deep > BURIED_M);
        let mut touched = self.contacts.forces.iter();
        let organ = touched.find_map(|it| it.organ.filter(|_| it.tool == Tool::Instrument));
        if let (Some(depth_m), Some(organ)) = (deepest_m, organ) {
            self.journal.raise(Event {
                kind: EventKind::Buried,
                organ: Some(organ.into()),
                at_m: self.tool.tip_m,
                value: depth_m,
            });
        }
    }
}
