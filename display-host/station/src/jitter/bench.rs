//! Settings of a measurement.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use assess::Task;
use surgeon::Surgeon;

use crate::run::args::RunArgs;

/// Settings that all turns share.
pub(crate) struct Bench<'a> {
    pub(crate) station: &'a RunArgs,
    pub(crate) scene: &'a Path,
    /// Folder of the station.
    pub(crate) folder: &'a Path,
    /// Folder for results.
    pub(crate) out: &'a Path,
    /// Core of the tick.
    pub(crate) core: usize,
    pub(crate) others: Vec<usize>,
    /// True if a display draws.
    pub(crate) draws: bool,
    /// The scripted surgeon that works during the measurement, and the task.
    pub(crate) hand: Option<(Surgeon, Task)>,
    /// True if the causes of late ticks are searched.
    pub(crate) why: bool,
    /// Time of all turns of the station, s.
    pub(crate) total_s: f64,
    pub(crate) stop: &'a Arc<AtomicBool>,
}
