//! Conversion of another computer's time stamps to this computer's clock.

/// Offset of another computer's monotonic clock, estimated from questions and answers. An answer is
/// assumed to be made halfway between question and arrival; the quickest answer bounds the error
/// best.
#[derive(Debug, Clone, Copy, Default)]
pub struct RemoteClock {
    /// Our clock minus theirs, ns.
    offset_ns: i64,
    /// Round trip above which an answer does not replace the estimate, ns.
    limit_ns: Option<u64>,
}

impl RemoteClock {
    /// Learns from an answer stamped `theirs_ns` that arrived at `arrived_ns`; its question left at
    /// `asked_ns`.
    pub fn learn(&mut self, asked_ns: u64, theirs_ns: u64, arrived_ns: u64) {
        let took_ns = arrived_ns.saturating_sub(asked_ns);
        // Clocks drift and computers restart. The limit therefore grows with every answer, and a
        // slower answer can replace an old estimate.
        let limit_ns = self
            .limit_ns
            .map(|limit| limit.saturating_add(limit / 64 + 1000));
        if limit_ns.is_none_or(|limit| took_ns <= limit) {
            let middle_ns = asked_ns.saturating_add(took_ns / 2);
            self.offset_ns = middle_ns.wrapping_sub(theirs_ns).cast_signed();
            self.limit_ns = Some(took_ns);
        } else {
            self.limit_ns = limit_ns;
        }
    }

    /// Converts their time stamp to our clock. 0 stays 0, because it means "none".
    #[must_use]
    pub fn ours_ns(&self, theirs_ns: u64) -> u64 {
        match theirs_ns {
            0 => 0,
            theirs_ns => theirs_ns.wrapping_add(self.offset_ns.cast_unsigned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_stamp_is_off_by_half_the_quickest_answer_at_most(
            offset in -1_000_000_000_000i64..1_000_000_000_000,
            ways in prop::collection::vec((0u64..50_000_000, 0u64..50_000_000), 1..50),
        ) {
            let start = 2_000_000_000_000u64;
            let theirs = |ours: u64| ours.wrapping_sub(offset.cast_unsigned());
            let mut clock = RemoteClock::default();
            let mut quickest = u64::MAX;
            for (i, (out, back)) in ways.iter().enumerate() {
                let asked = start + i as u64 * 100_000_000;
                clock.learn(asked, theirs(asked + out), asked + out + back);
                quickest = quickest.min(out + back);
            }
            // The limit grows by 1.6 % and 1 µs per answer.
            let grown = quickest as f64 * 1.016f64.powi(50) + 100_000.0;
            let off = clock.ours_ns(theirs(start)).abs_diff(start);
            prop_assert!(off as f64 <= grown / 2.0 + 1.0, "{off} of {quickest}");
        }

        #[test]
        fn any_stamps_are_survived(stamps in prop::collection::vec(any::<[u64; 4]>(), 0..20)) {
            let mut clock = RemoteClock::default();
            for [asked, theirs, arrived, other] in stamps {
                clock.learn(asked, theirs, arrived);
                let _ = clock.ours_ns(other);
            }
            prop_assert_eq!(clock.ours_ns(0), 0);
        }
    }

    #[test]
    fn a_computer_that_started_again_is_believed_after_a_while() {
        let mut clock = RemoteClock::default();
        clock.learn(1_000_000, 500_000, 1_100_000);
        for i in 0..200u64 {
            let asked = 10_000_000 + i * 16_000_000;
            clock.learn(asked, asked + 7_000_100_000, asked + 200_000);
        }
        assert_eq!(clock.ours_ns(7_000_000_000 + 5_000_000_000), 5_000_000_000);
    }
}
