//! Options of `calot jitter`.

use std::path::PathBuf;

use assess::Task;
use clap::Args;
use jitter::Baseline;
use surgeon::Surgeon;

use crate::args::{ControllerArgs, SceneArgs, parse_seconds, parse_station, parse_task};
use crate::load::Load;
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot jitter --seconds 60 --out idle
  calot jitter --seconds 60 --load all --out loaded
  calot jitter --seconds 600 --load join --compare burn
  calot jitter --seconds 60 --compare cyclictest,executor,sleep
  calot jitter --scene triangle --hand careful --seconds 600 --why
  calot jitter --seconds 3600 --scope-line rts --scope-tty /dev/ttyS0
  calot jitter --diff idle loaded
  calot jitter --merge bench-1 bench-2 --out both

Compare programs only over the same minutes: with --compare they take turns. Read ratios and
medians of rounds before absolute tails.")]
pub(crate) struct JitterArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the measured station
    #[arg(long, value_name = "NAME", default_value = "jitter", value_parser = parse_station)]
    pub(crate) station: String,
    /// Time to measure each program, s; a day at most
    #[arg(long, value_name = "N", default_value = "60", value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Load to run during the measurement, e.g. cpu,io or all
    #[arg(long, value_name = "LOAD", value_delimiter = ',')]
    pub(crate) load: Vec<Load>,
    /// Take turns with these programs and report ratios, e.g. cyclictest,burn
    #[arg(long, value_name = "PROGRAM", value_delimiter = ',')]
    pub(crate) compare: Vec<Baseline>,
    /// Turns of each program in a comparison [default: one per 30 s, at least 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) rounds: Option<u32>,
    /// Find out what ran instead of late ticks: interrupt, softirq, thread, or the host. Needs root
    /// and tracefs. Without them it sees threads only (perf_event_open), or guesses from counters,
    /// and says so
    #[arg(long)]
    pub(crate) why: bool,
    /// Let a scripted surgeon work through --task during the measurement, so that real work is
    /// measured instead of a resting scene
    #[arg(long, value_name = "WHO", value_enum, conflicts_with_all = ["merge", "ratio_of"])]
    pub(crate) hand: Option<Surgeon>,
    /// Task of the scripted surgeon, which starts again in each turn [default: full]
    #[arg(long, value_name = "TASK", value_parser = parse_task, requires = "hand")]
    pub(crate) task: Option<Task>,
    /// Folder for jitter.json, .csv, .html and .trace.json, rewritten every 5 s, and for histograms
    /// [default: jitter, or jitter-2, jitter-3, … if it holds a report]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Put these runs (folders or jitter.json files), also of several machines, into one table, and
    /// add them up into --out
    #[arg(long, value_name = "RUN", num_args = 2.., conflicts_with_all = ["ratio_of", "load", "compare"])]
    pub(crate) merge: Vec<PathBuf>,
    /// Print the ratios of two runs: each time of SECOND divided by that of FIRST
    #[arg(long = "diff", value_names = ["FIRST", "SECOND"], num_args = 2, conflicts_with_all = ["load", "compare"])]
    pub(crate) ratio_of: Vec<PathBuf>,
    /// Print jitter.json (or the ratios of --diff) on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}
