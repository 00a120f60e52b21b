//! The separation of a tool and tissue, filtered so that the contact force has no steps.
//!
//! A persistent contact adds an offset to its measured separation. A contact that is first found
//! deep begins with an offset of its whole depth. If the measured separation jumps, the offset
//! takes up the jump. The offset decays, so the force comes to its true value within a few tenths
//! of a second.

/// Share of a positive offset that remains after a tick. A positive offset hides overlap; about a
/// third of it remains after 0.1 s. With a larger share, a contact that is found deep takes longer
/// to reach its force.
const POSITIVE_OFFSET_REMAINDER: f32 = 0.99;
/// Share of a negative offset that remains after a tick. A negative offset hides an opening. The
/// share is smaller than that of a positive offset, so that a contact that has opened soon stops
/// pushing.
const NEGATIVE_OFFSET_REMAINDER: f32 = 0.95;
/// Upper bound of the decay of a negative offset, m a tick. A larger bound ends the push sooner,
/// with a larger step of force.
const NEGATIVE_OFFSET_DECAY_MAX_M: f32 = 0.000_025;
/// Largest change of the filtered separation in a tick, beyond twice the tool's travel and the
/// decay of the offset, m. The offset takes up the rest of a larger jump. Where a shaft lies on a
/// liver, this change makes a step of force of 2 mN. With a larger value the force follows the skin
/// faster, in larger steps.
const CHANGE_MAX_M: f32 = 0.000_02;

/// Separation of a tool's point and the tissue under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilteredSeparation {
    /// The measured separation plus the offset, m; negative: overlap.
    pub(crate) separation_m: f32,
    /// Offset added to the measured separation, m: positive after a contact is found deep or jumps
    /// inwards, negative after a jump outwards.
    offset_m: f32,
}

impl FilteredSeparation {
    /// Placeholder before a contact is found.
    pub(crate) const NONE: Self = Self {
        separation_m: 0.0,
        offset_m: 0.0,
    };

    /// Separation of a new contact: the offset cancels its overlap.
    pub(crate) fn first(separation_m: f32) -> Self {
        let offset_m = (-separation_m).max(0.0);
        Self {
            separation_m: separation_m + offset_m,
            offset_m,
        }
    }

    /// The measured separation, m.
    pub(crate) fn measured_m(&self) -> f32 {
        self.separation_m - self.offset_m
    }

    /// Separation after this contact has moved to another place, where `separation_m` is measured.
    /// A positive offset is kept, a negative one dropped.
    pub(crate) fn moved_to(&self, separation_m: f32) -> Self {
        let offset_m = self.offset_m.max(0.0);
        Self {
            separation_m: separation_m + offset_m,
            offset_m,
        }
    }

    /// The separation a tick later: `separation_m` is measured, and the tool has travelled by
    /// `travel_m`. A negative offset is at least −`opening_max_m`, so a contact that is open by
    /// more than `opening_max_m` does not push.
    pub(crate) fn next(&self, separation_m: f32, travel_m: f32, opening_max_m: f32) -> Self {
        let change_max_m = 2.0 * travel_m + CHANGE_MAX_M;
        let change_m = separation_m - self.measured_m();
        let change_m = change_m.max(-change_max_m).min(change_max_m);
        let remainder = if self.offset_m < 0.0 {
            NEGATIVE_OFFSET_REMAINDER
        } else {
            POSITIVE_OFFSET_REMAINDER
        };
        // A positive offset decays by a hundredth of itself, however large; a negative one by at
        // most `NEGATIVE_OFFSET_DECAY_MAX_M`.
        let decay_m = ((1.0 - remainder) * self.offset_m).max(-NEGATIVE_OFFSET_DECAY_MAX_M);
        let offset_m = self.separation_m + change_m - decay_m - separation_m;
        let offset_m = offset_m.max(-opening_max_m);
        // If neither the measured nor the filtered separation is negative, there is no offset.
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
    fn deep_contact_begins_at_zero_depth_and_reaches_its_depth() {
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
    fn separation_takes_jumps_gradually_and_follows_a_fast_tool() {
        let touching = FilteredSeparation::first(0.0).next(-0.0001, 0.0001, OPENING_MAX_M);
        assert!((touching.separation_m + 0.0001).abs() < 1.0e-8);
        assert!((touching.next(-0.001, 0.001, OPENING_MAX_M).separation_m + 0.001).abs() < 1.0e-8);
        // A jump inwards, one outwards and one to an open contact. While the contact pushes, the
        // separation changes in a tick by at most the permitted jump and the decay of the offset.
        // In the end the separation reaches its measured value.
        for to_m in [-0.003f32, -0.0002, 0.001] {
            let mut separation = FilteredSeparation::first(0.0).next(-0.001, 0.001, OPENING_MAX_M);
            for _ in 0..1000 {
                let next = separation.next(to_m, 0.0, OPENING_MAX_M);
                let change_m = (next.separation_m - separation.separation_m).abs();
                assert!(
                    next.separation_m > 0.0
                        || change_m < CHANGE_MAX_M + NEGATIVE_OFFSET_DECAY_MAX_M + 1.0e-8,
                    "{separation:?} {next:?}"
                );
                separation = next;
            }
            assert!(
                (separation.separation_m - to_m).abs() < 1.0e-6,
                "{separation:?}"
            );
        }
        // If tissue jumps away from a tool at rest, the tissue still pushes at first. It stops as
        // soon as the tool is drawn out.
        let opened = FilteredSeparation::first(0.0)
            .next(-0.001, 0.001, OPENING_MAX_M)
            .next(0.0005, 0.0, OPENING_MAX_M);
        assert!(
            opened.separation_m < 0.0
                && opened.next(0.0025, 0.002, OPENING_MAX_M).separation_m > 0.0,
            "{opened:?}"
        );
    }

    #[test]
    fn open_contact_does_not_push() {
        let deep = FilteredSeparation::first(0.0).next(-0.005, 0.005, OPENING_MAX_M);
        let open = deep.next(0.004, 0.0, 0.000_5);
        assert!(open.separation_m > 0.003, "{open:?}");
        // A contact that is open by less than `opening_max_m` pushes at first, but no longer after
        // 0.1 s.
        let mut opened = deep.next(0.000_2, 0.0, 0.000_5);
        assert!(opened.separation_m < 0.0, "{opened:?}");
        for _ in 0..100 {
            opened = opened.next(0.000_2, 0.0, 0.000_5);
        }
        assert!(opened.separation_m > 0.0, "{opened:?}");
    }
}
