//! One run, as a line in a table of several runs.

use serde::{Deserialize, Serialize};

/// A run in a table of several runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Folder or file that held the run.
    pub name: String,
    /// Model of the processor.
    pub processor: String,
    /// Release of the kernel.
    pub kernel: String,
    /// Added loads.
    pub load: String,
    /// Time measured, s.
    pub seconds: f64,
    /// True if every tick was realtime.
    pub realtime: bool,
    /// Ticks.
    pub ticks: u64,
    /// Median wake-up latency, ns.
    pub p50: u64,
    /// 99 % quantile of the wake-up latency, ns.
    pub p99: u64,
    /// 99.9 % quantile of the wake-up latency, ns.
    pub p999: u64,
    /// Largest wake-up latency, ns.
    pub max: u64,
    /// Median of the maxima of the five-minute intervals, ns.
    pub interval_max_median: Option<f64>,
    /// Missed periods in a million.
    pub misses_per_million: f64,
    /// Wake-up latency divided by cyclictest's: p50 and p99.
    pub to_cyclictest: Option<[f64; 2]>,
    /// Cause to which late ticks lost most time.
    pub first_cause: Option<String>,
}
