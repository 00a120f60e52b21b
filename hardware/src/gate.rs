//! Holds back implausible jumps of values from a protocol without a checksum. In such a protocol a
//! damaged number still parses as a number.

use rt_core::time::TimeNs;

/// Number of consecutive samples that must agree with each other before a jump is admitted. Damage
/// does not move so many samples to the same place.
const AGREEING: u32 = 8;
/// Time without an admitted sample that counts as a gap, ns. During a gap the device may have moved
/// anywhere.
const FORGET_NS: u64 = 100_000_000;
/// Number of consecutive samples that must agree with each other after a gap.
const AGREEING_AFTER_GAP: u32 = 2;

/// Plausibility check of `N` numbers that move together.
#[derive(Debug, Clone)]
pub(crate) struct Gate<const N: usize> {
    /// Fastest plausible change, units per second.
    speed: f32,
    /// Noise allowed on top of that change, units.
    noise: f32,
    admitted: Option<([f32; N], TimeNs)>,
    /// Newest values that were held back since the last admitted ones.
    held_back: Option<([f32; N], TimeNs)>,
    /// Number of consecutive held-back samples that agree with each other.
    agreeing: u32,
}

impl<const N: usize> Gate<N> {
    pub(crate) const fn new(speed: f32, noise: f32) -> Self {
        Self {
            speed,
            noise,
            admitted: None,
            held_back: None,
            agreeing: 0,
        }
    }

    /// Last admitted values.
    pub(crate) fn last(&self) -> Option<[f32; N]> {
        self.admitted.map(|(values, _)| values)
    }

    /// Admits values without a check.
    pub(crate) fn begin(&mut self, values: [f32; N], at_ns: TimeNs) {
        self.admitted = Some((values, at_ns));
        self.held_back = None;
    }

    /// True if nothing was admitted in the last [`FORGET_NS`], so that a jump is plausible.
    pub(crate) fn is_gap(&self, at_ns: TimeNs) -> bool {
        self.admitted
            .is_none_or(|(_, then_ns)| at_ns.saturating_sub(then_ns) > FORGET_NS)
    }

    /// Returns true, and admits the values, if they are plausible.
    pub(crate) fn admit(&mut self, values: [f32; N], at_ns: TimeNs) -> bool {
        let near = |(last, then_ns): ([f32; N], TimeNs)| {
            let reach = self.noise + self.speed * at_ns.saturating_sub(then_ns) as f32 * 1e-9;
            // The comparison is false for NaN, so NaN is never near.
            let is_near = |(a, b): (&f32, &f32)| (a - b).abs() <= reach;
            values.iter().zip(&last).all(is_near)
        };
        let is_gap = self.is_gap(at_ns);
        let good = if !is_gap && self.admitted.is_some_and(near) {
            true
        } else {
            let agrees = self.held_back.is_some_and(near);
            self.agreeing = if agrees { self.agreeing + 1 } else { 1 };
            let enough = if is_gap { AGREEING_AFTER_GAP } else { AGREEING };
            self.agreeing >= enough
        };
        if good {
            self.begin(values, at_ns);
        } else {
            self.held_back = Some((values, at_ns));
        }
        good
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_jump_is_dropped_until_enough_samples_agree() {
        let mut gate = Gate::new(3000.0, 0.3);
        gate.begin([180.0, 0.0], 0);
        assert!(gate.admit([179.0, 1.0], MS));
        for ms in 2..6 {
            assert!(!gate.admit([0.0, 1.0], ms * MS), "the same damage again");
        }
        assert!(gate.admit([178.0, 2.0], 6 * MS), "back where it was");
        let admitted: Vec<_> = (7..16).map(|ms| gate.admit([80.0, 2.0], ms * MS)).collect();
        assert_eq!(admitted.iter().filter(|good| !**good).count(), 7);
        assert!(!gate.admit([0.0, 50.0], 200 * MS), "after a long silence");
        assert!(
            gate.admit([1.0, 50.0], 201 * MS),
            "after a silence two suffice"
        );
        assert!(!gate.admit([f32::NAN, 50.0], 202 * MS));
    }

    proptest! {
        /// For any damage among true samples, every admitted value is near the truth.
        #[test]
        fn damaged_samples_are_never_admitted(
            damage in prop::collection::vec((0u8..3, -1e4..1e4f32), 1..300),
        ) {
            let mut gate = Gate::new(10.0, 0.01);
            gate.begin([0.0], 0);
            for (at, (kind, wrong)) in damage.into_iter().enumerate() {
                let now_ns = (at as u64 + 1) * MS;
                // At most seven damaged samples in a row.
                let value = if kind == 0 && at % 8 != 0 { wrong } else { 0.0 };
                if gate.admit([value], now_ns) {
                    prop_assert!(value.abs() <= 0.3, "{value}");
                }
            }
        }
    }
}
