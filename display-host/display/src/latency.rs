//! Age of each picture when it is shown.

use std::path::PathBuf;

/// A picture and its times. All times are `CLOCK_MONOTONIC`, ns.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct FrameRecord {
    /// Tick of the controller whose state the picture shows.
    pub tick: u64,
    /// Time at which the device sample of that tick was read.
    pub sample_ns: u64,
    /// Time at which the controller published the state.
    pub state_ns: u64,
    /// Time at which the display submitted the frame to the graphics device.
    pub submitted_ns: u64,
    /// Time at which the picture was handed to the screen (window) or read back (headless).
    pub shown_ns: u64,
    /// True if the picture was drawn at once from the newest state. Other pictures were drawn later
    /// from a kept state, so their latencies mean nothing.
    pub live: bool,
    /// File of the picture, if saved.
    pub path: Option<PathBuf>,
}

impl FrameRecord {
    /// Latency from device sample to the picture handed over. The screen lights up later, by a time
    /// that this program cannot know.
    #[must_use]
    pub fn motion_to_picture_ns(&self) -> u64 {
        self.shown_ns.saturating_sub(self.sample_ns)
    }

    /// Latency from published state to submitted frame.
    #[must_use]
    pub fn publish_to_frame_ns(&self) -> u64 {
        self.submitted_ns.saturating_sub(self.state_ns)
    }
}

/// Present time on the controller's clock (`CLOCK_MONOTONIC`).
#[must_use]
pub fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}
