//! Relaxation of a material.

/// Two Prony terms: the share of the stress that each loses, and its time constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    /// Share of the stress of a fast strain that each term loses in the end, 0 to 1.
    pub shares: [f32; 2],
    /// Time constant of each term, s.
    pub times_s: [f32; 2],
}

impl Relaxation {
    /// Tissue that keeps its stress.
    pub const NONE: Self = Self {
        shares: [0.0; 2],
        times_s: [1.0; 2],
    };

    /// True if the tissue loses stress.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.shares.iter().any(|share| *share > 0.0)
    }

    /// Share of its rest that each term covers in `step_s`.
    pub(crate) fn rates(&self, step_s: f32) -> [f32; 2] {
        self.times_s.map(|time_s| step_s / time_s.max(step_s))
    }
}
