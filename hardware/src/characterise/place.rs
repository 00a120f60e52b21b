//! Places of the virtual walls, and the instructions to the person at each.

use super::bench::{HandleState, OPENING, Vector};

/// Place of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Across the middle of the workspace, facing up.
    Workspace,
    /// Half open, felt by fingers that shut the handle.
    Opening,
}

impl Place {
    pub(super) const fn axis(self) -> usize {
        match self {
            Self::Workspace => 1,
            Self::Opening => OPENING,
        }
    }

    pub(super) const fn lift_instruction(self) -> &'static str {
        match self {
            Self::Workspace => "  Lift the handle above the middle of the workspace.",
            Self::Opening => "  Open the handle to more than a half.",
        }
    }

    pub(super) const fn tap_instruction(self) -> &'static str {
        match self {
            Self::Workspace => {
                "  Tap the wall in the middle of the workspace from above, and press it gently."
            }
            Self::Opening => "  Shut the handle to its half, and squeeze the wall there gently.",
        }
    }

    /// Distance of the handle from the wall, m; negative inside the wall.
    pub(super) fn distance_m(self, now: &HandleState) -> f64 {
        now.at_m[self.axis()]
    }

    /// Force of the wall, N.
    pub(super) fn wall_force_n(self, now: &HandleState, stiffness_n_m: f64) -> Vector {
        let mut force_n = Vector::zeros();
        force_n[self.axis()] = stiffness_n_m * (-self.distance_m(now)).max(0.0);
        force_n
    }
}
