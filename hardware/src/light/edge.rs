//! A change of the light, as every sensor reports it.

use rt_core::time::TimeNs;

/// A change of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Time of the change (`CLOCK_MONOTONIC`), ns: the middle of the interval in which it happened.
    pub at_ns: TimeNs,
    /// True if light came, false if it went. An inverting sensor reports the opposite.
    pub bright: bool,
    /// Half of the interval in which the change happened, ns.
    pub within_ns: u64,
}
