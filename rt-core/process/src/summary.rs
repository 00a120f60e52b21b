//! Summary of a run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;

use crate::admission::Admission;

/// Reason for the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The caller's flag (a signal, a closed station).
    Asked,
    /// A host's command.
    Commanded,
    /// The configured number of periods has passed.
    Finished,
    /// A realtime thread ran for 200 ms without a sleep. The tick was then taken off the realtime
    /// scheduler, and ended.
    Runaway,
}

/// Summary of a run. Counts start at the first tick.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RtSummary {
    /// Name of the station.
    pub station: String,
    /// Name of the scene.
    pub scene: String,
    /// Identity of the scene, hexadecimal.
    pub scene_id: String,
    /// Reason for the end of the run.
    pub ended: Ended,
    /// Number of ticks that ran.
    pub ticks: u64,
    /// Periods skipped because the tick before them, or the machine, was late.
    #[serde(rename = "deadline_misses")]
    pub missed_periods: u64,
    /// Ticks that ended after their deadline.
    #[serde(rename = "overruns")]
    pub late_ticks: u64,
    /// Heap calls of the tick's thread; `None` when the program does not count them.
    pub allocations_after_start: Option<u64>,
    /// Page faults of the tick's thread.
    pub page_faults_after_start: u64,
    /// Number of times that the kernel took the core away from the tick's thread.
    pub involuntary_switches: u64,
    /// Number of times that the tick's thread waited for anything other than its next tick.
    pub blocks: u64,
    /// True if the tick ran in locked memory, and either pinned under `SCHED_FIFO` or under
    /// `SCHED_DEADLINE`.
    pub realtime: bool,
    /// Refusals of Linux, each with its remedy.
    pub refused: Vec<String>,
    /// Cost of the scene on this machine; `None`: not measured.
    pub admission: Option<Admission>,
    /// Core of the tick.
    pub core: usize,
    /// Number of ticks with each fault that occurred, by the fault's name.
    pub faults: BTreeMap<String, u64>,
    /// Largest force sent, N.
    pub force_max_n: f32,
    /// Frames skipped because the publishing thread was behind.
    pub frames_skipped: u64,
    /// Ticks that left out self-collision for lack of time.
    pub self_collisions_dropped: u64,
    /// Ticks that left out far organs for lack of time ([`crate::budget`]).
    pub far_organs_dropped: u64,
    /// Frames that a late tick dropped.
    pub frames_dropped: u64,
    /// Ticks in which a stage took longer than its budget ([`crate::budget`]), by stage.
    pub stages_over: BTreeMap<String, u64>,
    /// Events that did not fit their queue.
    pub events_lost: u64,
    /// Timing records that did not fit their queue.
    pub records_lost: u64,
    /// Ticks whose inputs did not fit their queue. A recording has a gap there.
    pub inputs_lost: u64,
    /// Number of times that the watch found the tick standing still.
    pub stalls_seen: u64,
}

/// State of a run when its first ticks have run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ready {
    /// Name of the station.
    pub station: String,
    /// Name of the scene.
    pub scene: String,
    /// Identity of the scene, hexadecimal.
    pub scene_id: String,
    /// Number of spheres.
    pub spheres: usize,
    /// Core of the tick.
    pub core: usize,
    /// True if the tick is realtime, as in `RtSummary`.
    pub realtime: bool,
    /// Refusals of Linux, each with its remedy.
    pub refused: Vec<String>,
    /// Cost of the scene on this machine; `None`: not measured.
    pub admission: Option<Admission>,
    /// Devices that are open.
    pub devices: Vec<DeviceReport>,
}

/// A device of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceReport {
    /// `haptic`, `tracker` or `pedal`.
    pub kind: &'static str,
    /// Path of the device's line, as the user gave it.
    pub path: PathBuf,
    /// Name that the device gives itself; empty if it gives none.
    pub name: String,
    /// Serial number; 0 if the device reports none.
    pub serial: u32,
    /// Declared capabilities of a haptic device by name, SI; empty for other devices.
    pub capabilities: BTreeMap<&'static str, f32>,
}
