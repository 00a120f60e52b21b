//! A gap between a tool and tissue that does not jump.

/// What is left of a forgiven gap after a tick: it dies away within 0.1 s.
const KEEP: f32 = 0.99;
/// A place of the tissue, or the gap, that goes this much farther in a tick than twice the tool has
/// jumped, m.
const JUMP_M: f32 = 0.0002;

/// The gap between a place of a tool and the tissue under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// What is forgiven included, m; negative: how deep one is in the other.
    pub(crate) gap_m: f32,
    /// Added to the gap, and dying away: what a contact that is found deep in the tissue, or that
    /// jumps to another place of it, would else change at once, m.
    forgiven_m: f32,
}

impl Gap {
    /// Of no place.
    pub(crate) const NONE: Self = Self {
        gap_m: 0.0,
        forgiven_m: 0.0,
    };

    /// Seen for the first time: no overlap counts.
    pub(crate) fn first(gap_m: f32) -> Self {
        let forgiven_m = (-gap_m).max(0.0);
        Self {
            gap_m: gap_m + forgiven_m,
            forgiven_m,
        }
    }

    /// A tick later, when the tool has gone `way_m` and the place of the tissue `moved_m`.
    pub(crate) fn next(&self, gap_m: f32, way_m: f32, moved_m: f32) -> Self {
        let closed_m = (self.gap_m - self.forgiven_m - gap_m).abs();
        let has_jumped = moved_m.max(closed_m) > 2.0 * way_m + JUMP_M;
        let forgiven_m = if has_jumped {
            self.gap_m - gap_m
        } else {
            KEEP * self.forgiven_m
        };
        // Nothing that does not overlap is forgiven, nor owed.
        let forgiven_m = if gap_m < 0.0 {
            forgiven_m.max(gap_m)
        } else {
            0.0
        };
        Self {
            gap_m: gap_m + forgiven_m,
            forgiven_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_deep_comes_to_count() {
        let mut gap = Gap::first(-0.002);
        assert!(gap.gap_m.abs() < 1.0e-9);
        gap = gap.next(-0.002, 0.0, 0.0);
        assert!((gap.gap_m + 0.000_02).abs() < 1.0e-7, "{gap:?}");
        for _ in 0..1000 {
            gap = gap.next(-0.002, 0.0, 0.0);
        }
        assert!((gap.gap_m + 0.002).abs() < 1.0e-6, "{gap:?}");
    }

    #[test]
    fn a_jump_is_forgiven_and_a_fast_tool_is_not() {
        let touching = Gap::first(0.0).next(-0.0001, 0.0001, 0.0);
        assert!((touching.gap_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.001, 0.0, 0.0).gap_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.0001, 0.0, 0.01).gap_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.001, 0.001, 0.0).gap_m + 0.001).abs() < 1.0e-8);
        // Open again, nothing is owed.
        let jumped = touching.next(-0.001, 0.0, 0.0);
        assert!((jumped.next(0.001, 0.002, 0.0).gap_m - 0.001).abs() < 1.0e-8);
    }
}
