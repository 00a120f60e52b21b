//! The debrief: one page that needs neither network nor other files.

mod case;
mod close;
mod drawing;
mod lesson;
mod outline;
mod page;
mod paths;
#[cfg(test)]
mod tests;
mod words;

pub use case::Case;
pub use close::{CLOSE_SIZE, close_picture};
pub use drawing::{LANES, learning_curve};
pub use lesson::{Lesson, advice};
pub use outline::Outlines;
pub use page::{html, in_shell};
pub use words::Words;

use crate::assessment::Assessed;
use crate::rules::Rules;

/// Largest number of lessons with a close picture.
pub const CLOSE_MAX: usize = 8;

/// One session in a report.
#[derive(Debug)]
pub struct Chapter {
    /// Name: the session's path.
    pub name: String,
    /// Name that the trainee chose, if the session is a trainee's.
    pub trainee: Option<String>,
    /// The scene's name.
    pub scene: String,
    /// The patient's case, if the scene is a patient.
    pub case: Option<Case>,
    /// Version of the program that recorded the session.
    pub build: String,
    /// Start, UTC, as text.
    pub when: String,
    /// Result of the assessment.
    pub assessed: Assessed,
    /// Rules of the assessment.
    pub rules: Rules,
    /// The organs, behind the paths.
    pub outlines: Outlines,
    /// Captions and pictures (PNG).
    pub pictures: Vec<(String, Vec<u8>)>,
    /// Durations of the simulation's ticks, if they are stored next to the session.
    pub ticks: Option<Ticks>,
    /// True if a scripted hand worked the session.
    pub is_scripted: bool,
    /// Reason why the recording ends early, if it does.
    pub cut_short: Option<String>,
    /// File beside the page that is about the station, if there is one.
    pub technical: Option<String>,
    /// The trainee's earlier sessions of the same task, oldest first.
    pub past: Vec<Past>,
    /// The instructor's rating sheet: each item with 1 to 5 points.
    pub sheet: Vec<(String, u8)>,
}

/// Fewest pictures a second with which a trainee can train. With fewer the eye cannot follow a
/// hand.
pub const PICTURES_MIN: f64 = 10.0;

/// Durations of ticks, as in a run's `summary.json`.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct Ticks {
    /// Duration of the whole tick, ns.
    pub tick_ns: Spread,
    /// Durations of the tick's stages, ns.
    pub stage_ns: std::collections::BTreeMap<String, Spread>,
    /// Periods skipped because the tick before them, or the machine, was late.
    #[serde(rename = "deadline_misses")]
    pub missed_periods: u64,
    /// Ticks that ended after their deadline.
    #[serde(rename = "overruns")]
    pub late_ticks: u64,
    /// True if the controller had realtime privileges.
    pub realtime: bool,
    /// Pictures a second that the window showed, if there was one.
    #[serde(default)]
    pub pictures_per_second: Option<f64>,
    /// Blood, bile and water by their place, if pictures were drawn.
    #[serde(default)]
    pub fluids: Option<Fluids>,
}

/// Blood, bile and water by their place.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Fluids {
    /// Blood.
    pub blood: Whereabouts,
    /// Bile.
    pub bile: Whereabouts,
    /// Water of the irrigator.
    pub water: Whereabouts,
}

/// Volumes of one fluid, ml.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Whereabouts {
    /// Lies on tissue, or falls.
    pub on_tissue_ml: f64,
    /// In the suction's jar.
    pub jar_ml: f64,
}

/// Quantiles of many durations, ns.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Spread {
    /// Number of durations.
    pub count: u64,
    /// Median.
    pub p50: u64,
    /// 99th percentile.
    pub p99: u64,
    /// The longest.
    pub max: u64,
}

/// An earlier session.
#[derive(Debug, Clone, PartialEq)]
pub struct Past {
    /// Start, UTC, as text.
    pub when: String,
    /// Outcome of the session.
    pub outcome: String,
    /// Score.
    pub score: f64,
    /// Metrics of the session by name, without those that had no value.
    pub metrics: std::collections::BTreeMap<String, f64>,
}
