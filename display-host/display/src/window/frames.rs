//! Records of the pictures that a window has shown, and their rate.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::latency::FrameRecord;

/// Largest number of frame records kept: nearly two hours at 60 Hz. Then the older half is dropped.
const FRAMES_KEPT: usize = 400_000;
/// Time over which the rate is measured.
const RATE_OVER: Duration = Duration::from_secs(2);

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

#[cfg(test)]
mod tests {
    use super::*;

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
