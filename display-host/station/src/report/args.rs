//! Options of `calot report`.

use std::path::PathBuf;

use assess::Task;
use clap::Args;

use crate::args::{LanguageName, parse_task};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
A session is a file that `calot run --record FILE` wrote, or a folder of `calot run --out DIR`; the
page then shows the folder's pictures. Everything is computed from the recording, so other rules can
be applied to it. The command reports data missing from a recording. Its exit code is 1 if a
recording is damaged.

Examples:
  calot run --task clamp --out monday            leaves monday/session.mcap and monday/debrief.html
  calot report monday tuesday --out week.html
  calot report monday --pictures                 with pictures of what went wrong
  calot report monday --rules strict.toml --json")]
pub(crate) struct ReportArgs {
    /// Sessions, oldest first: files, folders, or ids as `calot store list NAME` prints them
    #[arg(value_name = "SESSION", required_unless_present_any = ["metrics", "rules_file"])]
    pub(crate) sessions: Vec<PathBuf>,
    /// File for the page [default: debrief.html, or debrief-2.html, debrief-3.html, … if it is
    /// there]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Draw each alarm as a straight endoscope at that place would have shown it, and the critical
    /// view of safety from both sides. This runs the simulation again, at about three times its
    /// speed
    #[arg(long, conflicts_with = "json")]
    pub(crate) pictures: bool,
    /// Language of the page [default: that of LANG]
    #[arg(long, value_enum, conflicts_with = "json")]
    pub(crate) language: Option<LanguageName>,
    /// Assess by these pass rules (TOML) instead of those of each session
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Assess as this task instead of that of each session, e.g. clamp
    #[arg(long, value_name = "TASK", value_parser = parse_task)]
    pub(crate) task: Option<Task>,
    /// Print a JSON array on standard output instead of writing the page: the result of each
    /// session, and the data missing from its recording
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the definition and unit of each metric
    #[arg(long)]
    pub(crate) metrics: bool,
    /// Print the built-in pass rules, to copy and change
    #[arg(long, conflicts_with = "metrics")]
    pub(crate) rules_file: bool,
}
