//! A change of the light, as every sensor tells it.

use rt_core::time::TimeNs;

/// A change of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Time of the change (`CLOCK_MONOTONIC`), ns: the middle of the span in which it came.
    pub at_ns: TimeNs,
    /// True if light came, false if it went. An inverting sensor tells the opposite.
    pub bright: bool,
    /// Half of the span in which the change came, ns.
    pub within_ns: u64,
}
