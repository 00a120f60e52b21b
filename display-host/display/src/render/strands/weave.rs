//! Fibre content of tissues.

/// Fibre content of a tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::render) enum Weave {
    /// No fibres.
    Plain,
    /// Some: septa of fat.
    Loose,
    /// Many: connective tissue.
    Dense,
}

impl Weave {
    /// Number of possible fibres along a cell's side, and the share of them that exists.
    pub(super) fn fibres(self) -> (u32, f32) {
        match self {
            Self::Plain => (0, 0.0),
            Self::Loose => (2, 0.3),
            Self::Dense => (5, 0.62),
        }
    }

    /// Share of the possible fibres across a gap that exist. It is halved for a gap of two cells.
    pub(super) fn spans(self) -> f32 {
        match self {
            Self::Plain => 0.0,
            Self::Loose => 0.5,
            Self::Dense => 0.4,
        }
    }
}
