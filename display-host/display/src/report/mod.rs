//! What a run leaves behind: `summary.json` for programs and `report.html` for people.
//!
//! A [`Recorder`] is shown everything that the display sees; it keeps histograms and one value a
//! second, so its memory does not grow with the run but by about 40 bytes a second.

mod page;
mod recorder;

pub use recorder::{Course, Recorder};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use figures::{Machine, Quantiles};

use crate::DisplayError;
use crate::headless::{Ended, Outcome};

/// `summary.json`. The keys are a contract: add, do not rename.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Summary {
    /// Program and version that made it.
    pub program: String,
    /// Scene's name.
    pub scene: String,
    /// First 16 bytes of the scene's identity, hexadecimal.
    pub scene_id: String,
    /// Ticks of the controller.
    pub ticks: u64,
    /// Periods that the controller skipped.
    pub deadline_misses: u64,
    /// Ticks that ended after their deadline.
    pub overruns: u64,
    /// Actual − scheduled start of a tick.
    pub wake_latency_ns: Quantiles,
    /// Start to end of a tick.
    pub tick_ns: Quantiles,
    /// Device sample arrived at the host → force written.
    pub motion_to_force_ns: Quantiles,
    /// Time of each stage of a tick.
    pub stage_ns: BTreeMap<&'static str, Quantiles>,
    /// State published → frame submitted, of frames drawn from the newest state.
    pub publish_to_frame_ns: Quantiles,
    /// Device sample → picture, of frames drawn from the newest state.
    pub motion_to_photon_ns: Quantiles,
    /// Force on the hand, as seen in the published tool states (every fourth tick).
    pub force_n: Range,
    /// Pictures drawn.
    pub frames: usize,
    /// Heap allocations of the realtime thread after its start; `None`: not counted.
    pub allocations_after_start: Option<u64>,
    /// Page faults of the realtime thread after its start.
    pub page_faults_after_start: u64,
    /// Involuntary context switches of the realtime thread after its start.
    pub involuntary_switches: u64,
    /// Whether the controller ran with SCHED_FIFO, locked memory and on one core.
    pub realtime: bool,
    /// What it lacked, if anything.
    pub not_realtime: Vec<String>,
    /// Timing records seen, and batches lost on the way here.
    pub timing_records: u64,
    /// See [`Summary::timing_records`].
    pub timing_batches_lost: u64,
    /// Events by kind.
    pub events: BTreeMap<&'static str, u64>,
    /// Events lost on the way here.
    pub events_lost: u64,
    /// Ticks that each fault happened in, by its name, where not zero.
    pub faults: BTreeMap<String, u64>,
    /// How the run ended.
    pub ended: Ended,
    /// The session that `calot replay` runs again; none: not recorded.
    pub recording: Option<session::Recorded>,
    /// What the task came to; its keys are not there when the run had none.
    #[serde(flatten)]
    pub task: Option<TaskSummary>,
    /// Graphics adapter.
    pub adapter: Option<String>,
    /// What the user was warned of.
    pub warnings: Vec<String>,
    /// The machine.
    pub machine: Machine,
}

/// What a task came to, in `summary.json`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct TaskSummary {
    /// The task's name.
    pub task: String,
    /// How much help was given.
    pub difficulty: String,
    /// `passed`, `failed`, `aborted`, or `practised` (free practice).
    pub outcome: String,
    /// Why.
    pub reasons: Vec<String>,
    /// The same by kind and values, for those who say it in another language.
    pub reason_kinds: Vec<assess::Reason>,
    /// 0 to 100.
    pub score: f64,
    /// What was wrong.
    pub alarms: Vec<TaskAlarm>,
    /// All metrics by name; `null` where there is none.
    pub metrics: serde_json::Value,
    /// Version of the metrics' definitions.
    pub metrics_version: u32,
    /// The session's name in the store, if it is there.
    pub session: String,
}

/// An alarm, in `summary.json`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct TaskAlarm {
    /// When, s since the task began.
    pub at_s: f64,
    /// What.
    pub kind: String,
    /// On what.
    pub organ: Option<String>,
}

/// Least and greatest.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Range {
    /// Least.
    pub min: f32,
    /// Greatest.
    pub max: f32,
}

/// Where a run's results lie.
#[derive(Debug, Clone)]
pub struct Written {
    /// `summary.json`.
    pub summary: PathBuf,
    /// `report.html`.
    pub report: PathBuf,
}

/// Writes `summary.json` and `report.html` into a folder, which is made if it is not there.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    folder: &Path,
    summary: &Summary,
    recorder: &Recorder,
    outcome: &Outcome,
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
    let json = serde_json::to_string_pretty(summary).map_err(|e| failed(&written.summary, &e))?;
    write_private(&written.summary, &(json + "\n")).map_err(|e| failed(&written.summary, &e))?;
    let html = page::render(summary, recorder, outcome, folder);
    write_private(&written.report, &html).map_err(|e| failed(&written.report, &e))?;
    Ok(written)
}

fn write_private(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = session::create_private(path)?;
    std::io::Write::write_all(&mut file, text.as_bytes())
}
