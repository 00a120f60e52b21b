//! Results of a run: `summary.json` for programs and `report.html` for people.
//!
//! A [`Recorder`] receives everything that the display observes. It keeps histograms and one value
//! a second, so its memory grows by only about 40 bytes per second of the run.

mod page;
mod recorder;
mod standstill;
mod unrest;

pub use recorder::{Recorder, TimeSeries};
pub use unrest::UnrestFinding;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use figures::{Machine, PresentationSummary, Quantiles};

use crate::DisplayError;
use crate::effects::fluid::{Balance, Whereabouts};
use crate::headless::{Ended, RunOutcome};

/// Content of `summary.json`. The keys are a contract: add, do not rename.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Summary {
    /// Program and version that wrote the summary.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// The patient's case. `None` if the scene is no patient.
    pub case: Option<assess::report::Case>,
    /// First 16 bytes of the scene's identity, hexadecimal.
    pub scene_id: String,
    /// Ticks of the controller.
    pub ticks: u64,
    /// Periods that the controller skipped.
    #[serde(rename = "deadline_misses")]
    pub missed_periods: u64,
    /// Ticks that ended after their deadline.
    #[serde(rename = "overruns")]
    pub late_ticks: u64,
    /// Delay of a tick's start.
    pub wake_latency_ns: Quantiles,
    /// Duration of a tick.
    pub tick_ns: Quantiles,
    /// Time from the arrival of the device's sample at this computer to the written force.
    pub motion_to_force_ns: Quantiles,
    /// Duration of each stage of a tick.
    pub stage_ns: BTreeMap<&'static str, Quantiles>,
    /// Time from published state to submitted frame, for frames drawn from the newest state.
    pub publish_to_frame_ns: Quantiles,
    /// Time from device sample to the picture that is handed to the screen, for frames drawn from
    /// the newest state. The key keeps its first name, although the time ends before any light.
    #[serde(rename = "motion_to_photon_ns")]
    pub motion_to_picture_ns: Quantiles,
    /// Time from device sample to the picture's presentation by the window system.
    pub motion_to_presentation_ns: Quantiles,
    /// Way of the window's pictures to the screen.
    pub presentation: PresentationSummary,
    /// Force on the hand in the published tool states (every fourth tick).
    pub force_n: Range,
    /// Number of drawn pictures.
    pub frames: usize,
    /// Pictures a second that the window showed: the median. `None` without a window, or after few
    /// pictures.
    pub pictures_per_second: Option<f64>,
    /// Blood, bile and water since the last reset, by their place. `None` if no picture was drawn.
    pub fluids: Option<FluidsSummary>,
    /// Heap allocations of the realtime thread after its start. `None` if they were not counted.
    pub allocations_after_start: Option<u64>,
    /// Page faults of the realtime thread after its start.
    pub page_faults_after_start: u64,
    /// Involuntary context switches of the realtime thread after its start.
    pub involuntary_switches: u64,
    /// True if the controller ran with SCHED_FIFO, locked memory and on one core.
    pub realtime: bool,
    /// Conditions of real time that the system did not grant to the controller.
    pub not_realtime: Vec<String>,
    /// Number of timing records received.
    pub timing_records: u64,
    /// Number of timing batches lost.
    pub timing_batches_lost: u64,
    /// Number of events by kind.
    pub events: BTreeMap<&'static str, u64>,
    /// Number of events lost.
    pub events_lost: u64,
    /// Number of ticks with each fault, by its name; zero counts are left out.
    pub faults: BTreeMap<String, u64>,
    /// Number of ticks in which contact asked for a force.
    pub contact_ticks: u64,
    /// Ticks of contact in which less or none of the force was rendered, by reason.
    pub force_held_back: Vec<HeldBack>,
    /// Devices, with their declared capabilities and the counters of their lines.
    pub devices: Vec<DeviceSummary>,
    /// Reason for the end of the run.
    pub ended: Ended,
    /// The recorded session for `calot replay`. `None` if the run was not recorded.
    pub recording: Option<session::Recorded>,
    /// Result of the task. Its keys are missing if the run had no task.
    #[serde(flatten)]
    pub task: Option<TaskSummary>,
    /// Graphics adapter.
    pub adapter: Option<String>,
    /// Warnings to the user.
    pub warnings: Vec<String>,
    /// Organs that fell or shook; the warnings name them too.
    pub unrest: Vec<UnrestFinding>,
    /// The machine.
    pub machine: Machine,
}

/// Force that was held back for one reason, in `summary.json`.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct HeldBack {
    /// Name of the fault that is the reason.
    pub fault: String,
    /// Ticks of contact in which force was held back.
    pub ticks: u64,
    /// Number of times that holding back began.
    pub times: u64,
}

/// A device, in `summary.json`.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DeviceSummary {
    /// `haptic`, `tracker` or `pedal`.
    pub kind: String,
    /// Path of the line that connects the device.
    pub path: PathBuf,
    /// Name that the device gives itself; empty if it gives none.
    pub name: String,
    /// Driver of a haptic device as in a station file, or `emulated`; empty for other devices.
    #[serde(default)]
    pub driver: String,
    /// Serial number; 0 if the device reports none.
    pub serial: u32,
    /// Declared capabilities of a haptic device by name, SI.
    pub capabilities: BTreeMap<String, f32>,
    /// Counters of the device's line.
    #[serde(flatten, skip_deserializing)]
    pub line: LineSummary,
}

/// Counters of a device's line, in `summary.json`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct LineSummary {
    /// Good frames.
    pub frames: u64,
    /// Rejected frames.
    pub bad_frames: u64,
    /// Frames that are missing in the sequence numbers.
    pub lost_frames: u64,
    /// Commands that the line refused.
    pub dropped_writes: u64,
    /// Bytes that this computer did not read in time.
    pub unread_bytes: u64,
}

/// Result of a task, in `summary.json`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct TaskSummary {
    /// The task's name.
    pub task: String,
    /// Degree of help.
    pub difficulty: String,
    /// Hand that worked the session: `person`, or `scripted` at emulated devices.
    pub hand: String,
    /// `passed`, `failed`, `aborted`, or `practised` (free practice).
    pub outcome: String,
    /// Reasons for the outcome.
    pub reasons: Vec<String>,
    /// The reasons by kind and values, for other languages.
    pub reason_kinds: Vec<assess::Reason>,
    /// Score, 0 to 100.
    pub score: f64,
    /// All alarms.
    pub alarms: Vec<TaskAlarm>,
    /// Lost points, by metric.
    pub lost: Vec<TaskLost>,
    /// Acts of an instructor: pointing, pauses, remarks, complications.
    pub acts: Vec<assess::Act>,
    /// All injuries: structure, kind, cause, severity, time.
    pub injuries: Vec<assess::Injury>,
    /// The critical view of safety, with the visible share of each criterion.
    pub cvs: Option<assess::Cvs>,
    /// All metrics by name; `null` for one without a value.
    pub metrics: serde_json::Value,
    /// Version of the metrics' definitions.
    pub metrics_version: u32,
    /// Name of the session in the store, if stored.
    pub session: String,
}

/// An alarm, in `summary.json`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct TaskAlarm {
    /// Time since the task began, s.
    pub at_s: f64,
    /// Time since the recording began, s, at which a replay shows the error.
    pub session_s: f64,
    /// Kind of error.
    pub kind: String,
    /// The organ concerned, if any.
    pub organ: Option<String>,
}

/// Points lost by a metric, in `summary.json`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct TaskLost {
    /// The metric.
    pub metric: String,
    /// Value of the metric.
    pub value: f64,
    /// Lost points.
    pub points: f64,
}

/// Blood, bile and water by their place.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FluidsSummary {
    /// Blood.
    pub blood: Whereabouts,
    /// Bile.
    pub bile: Whereabouts,
    /// Water of the irrigator.
    pub water: Whereabouts,
}

impl From<Balance> for FluidsSummary {
    fn from(balance: Balance) -> Self {
        let [blood, bile, water] = balance.by_fluid();
        Self { blood, bile, water }
    }
}

/// Range of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Range {
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

/// Files of a run's results.
#[derive(Debug, Clone)]
pub struct Written {
    /// Path of `summary.json`.
    pub summary: PathBuf,
    /// Path of `report.html`.
    pub report: PathBuf,
}

/// Writes `summary.json` and `report.html` into a folder, which is created if missing. `json` is
/// the summary with the name of its schema.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    json: &str,
    summary: &Summary,
    recorder: &Recorder,
    outcome: &RunOutcome,
) -> Result<Written, DisplayError> {
    let failed = |path: &Path, error: &dyn core::fmt::Display| DisplayError::Write {
        path: path.to_owned(),
        detail: error.to_string(),
    };
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
    let written = Written {
        summary: folder.join("summary.json"),
        report: folder.join("report.html"),
    };
    write_private(&written.summary, &format!("{json}\n"))
        .map_err(|e| failed(&written.summary, &e))?;
    let html = page::render(summary, recorder, outcome, folder);
    write_private(&written.report, &html).map_err(|e| failed(&written.report, &e))?;
    Ok(written)
}

fn write_private(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = session::create_private(path)?;
    std::io::Write::write_all(&mut file, text.as_bytes())
}
