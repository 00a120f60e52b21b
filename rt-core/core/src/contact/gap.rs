//! A gap between a tool and tissue that does not jump.

/// What is left of a forgiven gap after a tick: a third after 0.1 s.
const KEEP: f32 = 0.99;
/// The same of what is owed: a push lasts no longer than is needed to feel no knock.
const KEEP_OWED: f32 = 0.95;
/// The most of what is owed that is paid in a tick, m.
const PAID_M: f32 = 0.000_025;
/// A gap changes in a tick by twice what the tool has gone and this at the most, m: what leaps farther is
/// forgiven, or owed where it opens, and comes bit by bit. Two mN where a shaft lies on a liver.
const JUMP_M: f32 = 0.000_02;

/// The gap between a place of a tool and the tissue under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// What is forgiven included, m; negative: how deep one is in the other.
    pub(crate) gap_m: f32,
    /// Added to the gap, and dying away: what a contact that is found deep in the tissue, or that
    /// jumps to another place of it, would else change at once, m; negative after a jump outwards.
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

    /// As it was found, m.
    pub(crate) fn found_m(&self) -> f32 {
        self.gap_m - self.forgiven_m
    }

    /// Of another place of the same contact, of which as much is forgiven.
    pub(crate) fn at(&self, gap_m: f32) -> Self {
        let forgiven_m = self.forgiven_m.max(0.0);
        Self {
            gap_m: gap_m + forgiven_m,
            forgiven_m,
        }
    }

    /// A tick later, when the tool has gone `way_m`. No more than `owed_m` is owed where it opens: what is apart by
    /// more does not push.
    pub(crate) fn next(&self, gap_m: f32, way_m: f32, owed_m: f32) -> Self {
        let most_m = 2.0 * way_m + JUMP_M;
        let goes_m = gap_m - self.found_m();
        let goes_m = goes_m.max(-most_m).min(most_m);
        let keep = if self.forgiven_m < 0.0 {
            KEEP_OWED
        } else {
            KEEP
        };
        // What is forgiven goes by its hundredth however much it is: so far tissue may come ahead of what counts.
        let paid_m = ((1.0 - keep) * self.forgiven_m).max(-PAID_M);
        let forgiven_m = self.gap_m + goes_m - paid_m - gap_m;
        let forgiven_m = forgiven_m.max(-owed_m);
        // Where nothing overlaps and nothing is owed, nothing is forgiven.
        let forgiven_m = if gap_m < 0.0 || gap_m + forgiven_m < 0.0 {
            forgiven_m
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

    const OWED_M: f32 = 0.003;

    #[test]
    fn what_is_found_deep_comes_to_count() {
        let mut gap = Gap::first(-0.002);
        assert!(gap.gap_m.abs() < 1.0e-9);
        gap = gap.next(-0.002, 0.0, OWED_M);
        assert!((gap.gap_m + 0.000_02).abs() < 1.0e-7, "{gap:?}");
        for _ in 0..1000 {
            gap = gap.next(-0.002, 0.0, OWED_M);
        }
        assert!((gap.gap_m + 0.002).abs() < 1.0e-6, "{gap:?}");
    }

    #[test]
    fn a_jump_comes_bit_by_bit_and_a_fast_tool_is_not_held_back() {
        let touching = Gap::first(0.0).next(-0.0001, 0.0001, OWED_M);
        assert!((touching.gap_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.001, 0.001, OWED_M).gap_m + 0.001).abs() < 1.0e-8);
        // Inwards, outwards, and open: by no more than is allowed, and in the end all of it.
        for to_m in [-0.003f32, -0.0002, 0.001] {
            let mut gap = Gap::first(0.0).next(-0.001, 0.001, OWED_M);
            for _ in 0..1000 {
                let next = gap.next(to_m, 0.0, OWED_M);
                let goes_m = (next.gap_m - gap.gap_m).abs();
                assert!(
                    next.gap_m > 0.0 || goes_m < JUMP_M + PAID_M + 1.0e-8,
                    "{gap:?} {next:?}"
                );
                gap = next;
            }
            assert!((gap.gap_m - to_m).abs() < 1.0e-6, "{gap:?}");
        }
        // A tool that is drawn out lets go at once.
        let owed = Gap::first(0.0)
            .next(-0.001, 0.001, OWED_M)
            .next(0.0005, 0.0, OWED_M);
        assert!(
            owed.gap_m < 0.0 && owed.next(0.0025, 0.002, OWED_M).gap_m > 0.0,
            "{owed:?}"
        );
    }

    #[test]
    fn what_is_far_apart_does_not_push() {
        let deep = Gap::first(0.0).next(-0.005, 0.005, OWED_M);
        let open = deep.next(0.004, 0.0, 0.000_5);
        assert!(open.gap_m > 0.003, "{open:?}");
        // What is owed is paid within a tenth of a second.
        let mut owed = deep.next(0.000_2, 0.0, 0.000_5);
        assert!(owed.gap_m < 0.0, "{owed:?}");
        for _ in 0..100 {
            owed = owed.next(0.000_2, 0.0, 0.000_5);
        }
        assert!(owed.gap_m > 0.0, "{owed:?}");
    }
}
