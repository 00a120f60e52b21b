//! What `calot report` understands.

use std::path::PathBuf;

use assess::Task;
use clap::Args;

use crate::args::parse_task;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
A session is a file that `calot run --record FILE` left, or a folder of `calot run --out DIR`, whose
pictures are then in the page. Everything is computed from the recording, so that other rules can be
asked of it. What is not in a recording is said; the exit code is 1 where one is damaged.

Examples:
  calot run --task clamp --out monday            leaves monday/session.mcap and monday/debrief.html
  calot report monday tuesday --out week.html
  calot report monday --pictures                 with pictures of what went wrong
  calot report monday --rules strict.toml --json")]
pub(crate) struct ReportArgs {
    /// Sessions, oldest first
    #[arg(value_name = "SESSION", required_unless_present_any = ["metrics", "rules_file"])]
    pub(crate) sessions: Vec<PathBuf>,
    /// Where the page goes
    #[arg(long, value_name = "FILE", default_value = "debrief.html")]
    pub(crate) out: PathBuf,
    /// Draw each alarm as a straight endoscope there would have shown it, and the critical view of
    /// safety from two sides: the simulation runs again for it, some three times as fast as it was
    #[arg(long, conflicts_with = "json")]
    pub(crate) pictures: bool,
    /// Assess by these pass rules instead of those of each session
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Assess as this task instead of that of each session
    #[arg(long, value_name = "TASK", value_parser = parse_task)]
    pub(crate) task: Option<Task>,
    /// One JSON object on standard output, an array of what each session came to, and of what is
    /// not in its recording; no page
    #[arg(long)]
    pub(crate) json: bool,
    /// Print what each metric is
    #[arg(long)]
    pub(crate) metrics: bool,
    /// Print the built-in pass rules, a file to be copied and changed
    #[arg(long, conflicts_with = "metrics")]
    pub(crate) rules_file: bool,
}
