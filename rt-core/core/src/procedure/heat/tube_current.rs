//! Progress of the computation of the current in tubes (`current`).

/// Computation of the current in tubes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TubeCurrent {
    /// Step of the next tick in its round.
    pub(super) step: u32,
    /// Sum over all paths, m: section over length, weighted by the squared difference of potential.
    pub(super) sum_m: f32,
    /// Energy that is to become heat at the end of the round, J.
    pub(super) due_j: f32,
}

impl TubeCurrent {
    pub(super) const NONE: Self = Self {
        step: 0,
        sum_m: 0.0,
        due_j: 0.0,
    };
}
