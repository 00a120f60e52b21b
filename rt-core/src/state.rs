//! What changes while the simulation runs, in storage of fixed size.

use crate::capacity::MAX_SPHERES;

/// Everything per sphere. Large: build it in a `static` ([`State::new`] is `const`) or a box.
#[derive(Debug)]
pub struct State {
    pub(crate) displacement_m: [[f32; 3]; MAX_SPHERES],
    pub(crate) bits: [u8; MAX_SPHERES],
}

impl State {
    /// Empty storage. [`crate::sim::Sim::new`] puts a scene into it.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            displacement_m: [[0.0; 3]; MAX_SPHERES],
            bits: [0; MAX_SPHERES],
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

    /// Whether every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}
