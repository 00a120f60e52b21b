//! Driver of one serial bird: the endoscope's tracker.

use std::path::Path;

use rt_core::port::{LineCounters, Polled, TimeNs, Tracker, TrackerSample};

use crate::HardwareError;
use crate::line::Line;

const BAUD: u32 = 115_200;

/// A tracker that streams.
#[derive(Debug)]
pub struct BirdTracker {
    line: Line,
}

impl BirdTracker {
    /// Opens the line, asks who answers, sets hemisphere and record, starts the stream.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        Ok(Self {
            line: Line::open(path, BAUD)?,
        })
    }

    /// Whether the line is gone.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.line.is_lost()
    }
}

impl Tracker for BirdTracker {
    fn poll(&mut self, _now_ns: TimeNs) -> Polled<TrackerSample> {
        Polled::Nothing
    }

    fn counters(&self) -> LineCounters {
        LineCounters::default()
    }
}
