//! State of the simulation: all per-sphere data that changes, in storage of fixed size.

use crate::organs::between::Between;
use crate::organs::pairs::Pairs;
use crate::procedure::heat::Heat;
use crate::procedure::stones::StoneState;
use crate::procedure::vessel::Vessels;
use crate::tissue::Bodies;

/// State of all spheres, about 4 MB: build it in a `static` ([`State::new`] is `const`) or on the
/// heap.
#[derive(Debug, Clone)]
pub struct State {
    pub(crate) bodies: Bodies,
    pub(crate) pairs: Pairs,
    pub(crate) between: Between,
    pub(crate) vessels: Vessels,
    pub(crate) heat: Heat,
    pub(crate) stones: StoneState,
}

impl State {
    /// Empty storage. [`crate::sim::Sim::new`] puts a scene into it.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bodies: Bodies::new(),
            pairs: Pairs::new(),
            between: Between::new(),
            vessels: Vessels::new(),
            heat: Heat::new(),
            stones: StoneState::new(),
        }
    }
}

impl Default for State {
    fn default() -> Self {
        Self::new()
    }
}
