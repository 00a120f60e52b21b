//! A gap between a tool and tissue that does not jump.

/// What is left of a forgiven gap after a tick: a third after 0.1 s.
const OFFSET_KEEP: f32 = 0.99;
/// The same of what is owed: a push lasts no longer than is needed to feel no knock.
const OPENING_KEEP: f32 = 0.95;
/// The most of what is owed that is paid in a tick, m.
const OPENING_STEP_M: f32 = 0.000_025;
/// A gap changes in a tick by twice what the tool has gone and this at the most, m: what leaps farther is
/// forgiven, or owed where it opens, and comes bit by bit. Two mN where a shaft lies on a liver.
const JUMP_M: f32 = 0.000_02;

/// The gap between a place of a tool and the tissue under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilteredSeparation {
    /// What is forgiven included, m; negative: how deep one is in the other.
    pub(crate) separation_m: f32,
    /// Added to the gap, and dying away: what a contact that is found deep in the tissue, or that
    /// jumps to another place of it, would else change at once, m; negative after a jump outwards.
    offset_m: f32,
}

impl FilteredSeparation {
    /// Of no place.
    pub(crate) const NONE: Self = Self {
        separation_m: 0.0,
        offset_m: 0.0,
    };

    /// Seen for the first time: no overlap counts.
    pub(crate) fn first(separation_m: f32) -> Self {
        let offset_m = (-separation_m).max(0.0);
        Self {
            separation_m: separation_m + offset_m,
            offset_m,
        }
    }

    /// As it was found, m.
    pub(crate) fn measured_m(&self) -> f32 {
        self.separation_m - self.offset_m
    }

    /// Of another place of the same contact, of which as much is forgiven.
    pub(crate) fn at(&self, separation_m: f32) -> Self {
        let offset_m = self.offset_m.max(0.0);
        Self {
            separation_m: separation_m + offset_m,
            offset_m,
        }
    }

    /// A tick later, when the tool has gone `travel_m`. No more than `opening_max_m` is owed where it opens: what is apart by
    /// more does not push.
    pub(crate) fn next(&self, separation_m: f32, travel_m: f32, opening_max_m: f32) -> Self {
        let most_m = 2.0 * travel_m + JUMP_M;
        let goes_m = separation_m - self.measured_m();
        let goes_m = goes_m.max(-most_m).min(most_m);
        let keep = if self.offset_m < 0.0 {
            OPENING_KEEP
        } else {
            OFFSET_KEEP
        };
        // What is forgiven goes by its hundredth however much it is: so far tissue may come ahead of what counts.
        let decay_m = ((1.0 - keep) * self.offset_m).max(-OPENING_STEP_M);
        let offset_m = self.separation_m + goes_m - decay_m - separation_m;
        let offset_m = offset_m.max(-opening_max_m);
        // Where nothing overlaps and nothing is owed, nothing is forgiven.
        let offset_m = if separation_m < 0.0 || separation_m + offset_m < 0.0 {
            offset_m
        } else {
            0.0
        };
        Self {
            separation_m: separation_m + offset_m,
            offset_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPENING_MAX_M: f32 = 0.003;

    #[test]
    fn what_is_found_deep_comes_to_count() {
        let mut separation = FilteredSeparation::first(-0.002);
        assert!(separation.separation_m.abs() < 1.0e-9);
        separation = separation.next(-0.002, 0.0, OPENING_MAX_M);
        assert!(
            (separation.separation_m + 0.000_02).abs() < 1.0e-7,
            "{separation:?}"
        );
        for _ in 0..1000 {
            separation = separation.next(-0.002, 0.0, OPENING_MAX_M);
        }
        assert!(
            (separation.separation_m + 0.002).abs() < 1.0e-6,
            "{separation:?}"
        );
    }

    #[test]
    fn a_jump_comes_bit_by_bit_and_a_fast_tool_is_not_held_back() {
        let touching = FilteredSeparation::first(0.0).next(-0.0001, 0.0001, OPENING_MAX_M);
        assert!((touching.separation_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.001, 0.001, OPENING_MAX_M).separation_m + 0.001).abs() < 1.0e-8);
        // Inwards, outwards, and open: by no more than is allowed, and in the end all of it.
        for to_m in [-0.003f32, -0.0002, 0.001] {
            let mut separation = FilteredSeparation::first(0.0).next(-0.001, 0.001, OPENING_MAX_M);
            for _ in 0..1000 {
                let next = separation.next(to_m, 0.0, OPENING_MAX_M);
                let goes_m = (next.separation_m - separation.separation_m).abs();
                assert!(
                    next.separation_m > 0.0 || goes_m < JUMP_M + OPENING_STEP_M + 1.0e-8,
                    "{separation:?} {next:?}"
                );
                separation = next;
            }
            assert!(
                (separation.separation_m - to_m).abs() < 1.0e-6,
                "{separation:?}"
            );
        }
        // A tool that is drawn out lets go at once.
        let owed = FilteredSeparation::first(0.0)
            .next(-0.001, 0.001, OPENING_MAX_M)
            .next(0.0005, 0.0, OPENING_MAX_M);
        assert!(
            owed.separation_m < 0.0 && owed.next(0.0025, 0.002, OPENING_MAX_M).separation_m > 0.0,
            "{owed:?}"
        );
    }

    #[test]
    fn what_is_far_apart_does_not_push() {
        let deep = FilteredSeparation::first(0.0).next(-0.005, 0.005, OPENING_MAX_M);
        let open = deep.next(0.004, 0.0, 0.000_5);
        assert!(open.separation_m > 0.003, "{open:?}");
        // What is owed is paid within a tenth of a second.
        let mut owed = deep.next(0.000_2, 0.0, 0.000_5);
        assert!(owed.separation_m < 0.0, "{owed:?}");
        for _ in 0..100 {
            owed = owed.next(0.000_2, 0.0, 0.000_5);
        }
        assert!(owed.separation_m > 0.0, "{owed:?}");
    }
}
