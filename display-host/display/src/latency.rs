//! How old a picture is when it reaches the eye, frame by frame.

use std::path::PathBuf;

/// One picture and when it happened. All times are `CLOCK_MONOTONIC`, ns.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct FrameRecord {
    /// Tick that it shows.
    pub tick: u64,
    /// The device sample behind that tick was read.
    pub sample_ns: u64,
    /// The controller filled the state.
    pub state_ns: u64,
    /// The display submitted the frame's work to the graphics device.
    pub submitted_ns: u64,
    /// The picture was there: handed to the screen (window), or read back (headless).
    pub shown_ns: u64,
    /// Drawn from the newest state at that moment. Others were drawn from a kept state, later:
    /// their latencies mean nothing.
    pub live: bool,
    /// File, if it went into one.
    pub path: Option<PathBuf>,
}

impl FrameRecord {
    /// Device sample to picture.
    #[must_use]
    pub fn motion_to_photon_ns(&self) -> u64 {
        self.shown_ns.saturating_sub(self.sample_ns)
    }

    /// State published to frame submitted.
    #[must_use]
    pub fn publish_to_frame_ns(&self) -> u64 {
        self.submitted_ns.saturating_sub(self.state_ns)
    }
}

/// Now, on the clock that the controller uses (`CLOCK_MONOTONIC`).
#[must_use]
pub fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}
