//! Limits the number of questions that wait for an answer.

use std::collections::VecDeque;
use std::time::Duration;

/// Largest number of questions that wait for an answer. With four, a line whose round trip takes 60
/// ms still carries 60 pictures a second.
const QUESTIONS_MAX: usize = 4;

/// Asks ahead while answers are quick, and one by one while they are late, because data that wait
/// on a slow line arrive old.
#[derive(Debug)]
pub(crate) struct Pace {
    period_ns: u64,
    /// Times of the open questions, in the order of their answers.
    asked_ns: VecDeque<u64>,
    /// Time of the quickest answer. It grows by 1/64 with every answer, because lines change.
    quickest_ns: u64,
    most: usize,
}

impl Pace {
    pub(crate) fn new(period: Duration) -> Self {
        Self {
            period_ns: u64::try_from(period.as_nanos()).unwrap_or(u64::MAX),
            asked_ns: VecDeque::new(),
            quickest_ns: u64::MAX,
            most: 1,
        }
    }

    pub(crate) fn may_ask(&self) -> bool {
        self.asked_ns.len() < self.most
    }

    pub(crate) fn asked(&mut self, now_ns: u64) {
        self.asked_ns.push_back(now_ns);
    }

    /// Removes the oldest open question, which an answer has just reached. Returns when the
    /// question was asked; `None` if none is open.
    pub(crate) fn answered(&mut self, now_ns: u64) -> Option<u64> {
        let asked_ns = self.asked_ns.pop_front()?;
        let took_ns = now_ns.saturating_sub(asked_ns);
        let known_ns = self.quickest_ns;
        self.quickest_ns = known_ns.saturating_add(known_ns / 64).min(took_ns);
        let is_late = took_ns > known_ns.saturating_mul(2).saturating_add(self.period_ns);
        self.most = match is_late {
            true => 1,
            false => QUESTIONS_MAX.min(self.most + 1),
        };
        Some(asked_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Asks as often as allowed at `now_ns` and returns the number of open questions.
    fn ask_all(pace: &mut Pace, now_ns: u64) -> usize {
        while pace.may_ask() {
            pace.asked(now_ns);
        }
        pace.asked_ns.len()
    }

    #[test]
    fn questions_go_one_by_one_while_answers_are_late() {
        let mut pace = Pace::new(Duration::from_millis(16));
        assert_eq!(pace.answered(MS), None, "nothing was asked");
        let mut now_ns = MS;
        assert_eq!(ask_all(&mut pace, now_ns), 1);
        for _ in 0..QUESTIONS_MAX {
            assert_eq!(pace.answered(now_ns + 10 * MS), Some(now_ns));
            now_ns += 10 * MS;
            pace.asked(now_ns);
        }
        assert_eq!(ask_all(&mut pace, now_ns), QUESTIONS_MAX);
        pace.answered(now_ns + 200 * MS);
        assert!(!pace.may_ask(), "three are on their way, and late");
        while pace.answered(now_ns + 200 * MS).is_some() {}
        now_ns += 200 * MS;
        assert_eq!(ask_all(&mut pace, now_ns), 1);
        pace.answered(now_ns + 12 * MS);
        assert_eq!(ask_all(&mut pace, now_ns + 12 * MS), 2, "answers are quick");
    }

    #[test]
    fn a_line_that_became_longer_is_asked_ahead_again_after_a_while() {
        let mut pace = Pace::new(Duration::from_millis(16));
        pace.asked(0);
        pace.answered(MS);
        for i in 1..400u64 {
            let now_ns = i * 1000 * MS;
            pace.asked(now_ns);
            pace.answered(now_ns + 100 * MS);
        }
        assert_eq!(ask_all(&mut pace, 500_000 * MS), QUESTIONS_MAX);
    }
}
