//! Records of the pictures that a window has shown, and their rate.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::latency::FrameRecord;

/// Largest number of frame records that are kept: nearly two hours at 60 Hz. At this number, the
/// older half is dropped.
const FRAMES_KEPT: usize = 400_000;
/// Time over which the rate is measured.
const RATE_OVER: Duration = Duration::from_secs(2);

/// Least number of intervals between pictures from which a rate is computed.
const FRAMES_MIN: usize = 20;

/// Shown pictures.
#[derive(Default)]
pub(super) struct Frames {
    records: Vec<FrameRecord>,
    /// Number of all records, the dropped ones included.
    drawn: u64,
    times: VecDeque<Instant>,
}

impl Frames {
    /// Takes the record of a picture that is shown now. Returns the number of pictures per second,
    /// once it is known.
    pub(super) fn note(&mut self, frame: FrameRecord) -> Option<f32> {
        if self.records.len() == FRAMES_KEPT {
            self.records.drain(..FRAMES_KEPT / 2);
        }
        self.records.push(frame);
        self.drawn += 1;
        let now = Instant::now();
        self.times.push_back(now);
        while self.times.len() > 2 && (self.times.front()).is_some_and(|old| now - *old > RATE_OVER)
        {
            self.times.pop_front();
        }
        let first = self.times.front()?;
        let span = (now - *first).as_secs_f32().max(1e-3);
        Some((self.times.len() - 1) as f32 / span)
    }

    /// Number of drawn pictures.
    pub(super) const fn drawn(&self) -> u64 {
        self.drawn
    }

    /// The records that are kept.
    pub(super) fn into_records(self) -> Vec<FrameRecord> {
        self.records
    }
}

/// Pictures a second: the median. A hidden window shows none, which does not count. `None`: too few
/// pictures.
pub(super) fn rate(frames: &[FrameRecord]) -> Option<f64> {
    let times = frames.iter().zip(frames.iter().skip(1));
    let mut between: Vec<u64> = times
        .map(|(a, b)| b.shown_ns.saturating_sub(a.shown_ns))
        .collect();
    between.sort_unstable();
    let median = *between.get(between.len() / 2)?;
    (between.len() >= FRAMES_MIN && median > 0).then(|| 1e9 / median as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_the_median_and_a_hidden_window_does_not_count() {
        let shown = |shown_ns| FrameRecord {
            tick: 0,
            sample_ns: 0,
            state_ns: 0,
            submitted_ns: 0,
            shown_ns,
            live: true,
            path: None,
        };
        let mut frames: Vec<FrameRecord> = (0..30).map(|i| shown(i * 250_000_000)).collect();
        frames.push(shown(3_600_000_000_000));
        let found = rate(&frames).unwrap_or_default();
        assert!((found - 4.0).abs() < 1e-9, "{found} pictures a second");
        assert_eq!(rate(&frames[..FRAMES_MIN]), None);
        assert_eq!(rate(&[]), None);
    }

    #[test]
    fn pictures_whose_records_were_dropped_still_count() {
        let mut frames = Frames::default();
        let shown = |tick| FrameRecord {
            tick,
            sample_ns: 0,
            state_ns: 0,
            submitted_ns: 0,
            shown_ns: 0,
            live: true,
            path: None,
        };
        for tick in 0..=FRAMES_KEPT as u64 {
            frames.note(shown(tick));
        }
        assert_eq!(frames.drawn(), FRAMES_KEPT as u64 + 1);
        assert_eq!(frames.into_records().len(), FRAMES_KEPT / 2 + 1);
    }
}
