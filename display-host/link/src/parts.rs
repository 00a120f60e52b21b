//! Length of a scene's parts: small at first, then as long as the line bears. The newest data wait
//! behind a part, so a part may take only little longer than the quickest one did. On a long line
//! every part waits for an answer, so few long parts are quicker than many short ones.

use std::time::Duration;

use crate::wire::SCENE_PART;

/// Length of the first part, bytes.
pub(crate) const FIRST: usize = 32 << 10;
/// A part that took this much longer than the quickest is followed by longer ones.
const QUICK: Duration = Duration::from_millis(150);
/// A part that took this much longer than the quickest is followed by shorter ones.
const SLOW: Duration = Duration::from_millis(400);

/// Length of the next part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parts {
    bytes: usize,
    quickest: Option<Duration>,
}

impl Parts {
    pub(crate) const fn new() -> Self {
        Self {
            bytes: FIRST,
            quickest: None,
        }
    }

    /// Length of the next part, bytes.
    pub(crate) const fn bytes(&self) -> usize {
        self.bytes
    }

    /// A part took this time from its question to its arrival.
    pub(crate) fn took(&mut self, time: Duration) {
        let quickest = self.quickest.map_or(time, |it| it.min(time));
        self.quickest = Some(quickest);
        let longer = time.saturating_sub(quickest);
        if longer < QUICK {
            self.bytes = (self.bytes * 2).min(SCENE_PART);
        } else if longer > SLOW {
            self.bytes = (self.bytes / 2).max(FIRST);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time for a scene over a line with this delay for question and answer, and this rate. Also
    /// the longest time that newer data waited behind a part.
    fn over(round_s: f64, bytes_s: f64, scene: usize) -> [f64; 2] {
        let (mut parts, mut left, mut time_s, mut waited_s) = (Parts::new(), scene, 0.0, 0.0_f64);
        while left > 0 {
            let part = parts.bytes().min(left);
            let behind_s = part as f64 / bytes_s;
            left -= part;
            time_s += round_s + behind_s;
            waited_s = waited_s.max(behind_s);
            parts.took(Duration::from_secs_f64(round_s + behind_s));
        }
        [time_s, waited_s]
    }

    #[test]
    fn a_long_line_brings_a_scene_soon() {
        let [time_s, _] = over(0.6, 12.5e6, 1_700_000);
        // In parts of the first length: 32 s.
        assert!(time_s < 6.0, "{time_s} s");
    }

    #[test]
    fn on_a_slow_line_the_picture_goes_on() {
        for megabit_s in [1.0, 2.0, 4.0, 20.0] {
            let [_, waited_s] = over(0.02, megabit_s * 125e3, 4_600_000);
            assert!(waited_s < 0.6, "{megabit_s} Mbit/s: {waited_s} s");
        }
    }

    #[test]
    fn parts_shrink_when_the_line_becomes_slow() {
        let mut parts = Parts::new();
        for _ in 0..9 {
            parts.took(Duration::from_millis(20));
        }
        assert_eq!(parts.bytes(), SCENE_PART);
        for _ in 0..9 {
            parts.took(Duration::from_secs(3));
        }
        assert_eq!(parts.bytes(), FIRST);
    }
}
