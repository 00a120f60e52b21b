//! What changes while the simulation runs, in storage of fixed size.

use crate::collision::between::Between;
use crate::collision::pairs::Pairs;
use crate::soft_body::Bodies;
use crate::vessel::Vessels;

/// Everything per sphere. More than a megabyte: build it in a `static`
/// ([`State::new`] is `const`) or on the heap.
#[derive(Debug, Clone)]
pub struct State {
    pub(crate) bodies: Bodies,
    pub(crate) pairs: Pairs,
    pub(crate) between: Between,
    pub(crate) vessels: Vessels,
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
        }
    }
}

impl Default for State {
    fn default() -> Self {
        Self::new()
    }
}

/// What a sphere is doing: bits as in the shared-memory message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SphereBits(pub u8);

impl SphereBits {
    /// Its organ is simulated this tick.
    pub const AWAKE: Self = Self(1);
    /// The instrument touches it.
    pub const CONTACT: Self = Self(2);
    /// Between closed jaws.
    pub const GRASPED: Self = Self(4);
    /// Layered tissue of which nothing is left: nobody meets it.
    pub const GONE: Self = Self(8);

    /// Whether every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` as well.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without the bits of `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}
