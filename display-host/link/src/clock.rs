//! Another computer's clock in terms of this one's.

/// What the other computer's monotonic clock shows, learnt from questions and answers: the answer
/// was made at about the middle of the time that it took. The quickest says most.
#[derive(Debug, Clone, Copy, Default)]
pub struct RemoteClock {
    /// Ours less theirs, ns.
    offset_ns: i64,
    /// An answer that took longer says less than what is known, ns.
    limit_ns: Option<u64>,
}

impl RemoteClock {
    /// An answer stamped `theirs_ns` came at `arrived_ns` to a question of `asked_ns`.
    pub fn learn(&mut self, asked_ns: u64, theirs_ns: u64, arrived_ns: u64) {
        let took_ns = arrived_ns.saturating_sub(asked_ns);
        // Clocks drift, and computers restart: what is known counts less and less.
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

    /// A stamp of theirs on our clock. 0 stays 0: it stands for none.
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
            // What is known counts less with time: by a share and a microsecond for each answer.
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
