//! Means by which a structure was injured: scissors, traction or current.

use session::Movement;
use shared_mem::message::{Event, EventMsg};
use shared_mem::words::{Current, Instrument};

use crate::injury::Cause;

/// Time after a tear in which a division of the same structure counts as torn, s. Pressure spreads
/// through the tube for some ticks before the controller reports the division.
const TORN_S: f64 = 0.5;

/// The instrument in the hand, its current, and the last tear.
#[derive(Debug, Clone, Default)]
pub(crate) struct Means {
    held: Option<Movement>,
    /// Time of the last tear, s, and its organ.
    torn: Option<(f64, u32)>,
}

impl Means {
    pub(crate) fn moved(&mut self, moved: &Movement) {
        self.held = Some(*moved);
    }

    pub(crate) fn event(&mut self, at_s: f64, event: &EventMsg) {
        if let Ok(Event::Tear { .. }) = event.decode() {
            self.torn = Some((at_s, event.organ));
        }
    }

    /// Cause of an injury that this event shows.
    pub(crate) fn cause(&self, at_s: f64, event: &EventMsg) -> Cause {
        let is_burnt_through =
            matches!(event.decode(), Ok(Event::Perforation { energy_j }) if energy_j > 0.0);
        let is_torn = (self.torn)
            .is_some_and(|(when_s, organ)| organ == event.organ && at_s - when_s < TORN_S);
        let held = self.held.as_ref();
        let has_current = held.is_some_and(|it| it.switches().current() != Current::Off);
        match held.and_then(Movement::instrument) {
            _ if is_burnt_through => Cause::Burnt,
            _ if is_torn => Cause::Torn,
            Some(Instrument::Hook) if has_current => Cause::Burnt,
            Some(Instrument::Scissors) => Cause::Cut,
            _ => Cause::Torn,
        }
    }
}
