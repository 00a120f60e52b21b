//! What `calot replay` understands.

use std::path::PathBuf;

use clap::Args;

use crate::args::{parse_seconds, parse_station};

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Exits with 0 if every tick in it came out the same, also if it is cut at its end (its recorder was
killed); with 1 if one did not, ticks are missing, it is damaged, or it has none. It names the first
tick that differs, and the organ.

Examples:
  calot run --headless --seconds 10 --out out    leaves out/session.mcap
  calot replay out/session.mcap
  calot replay out/session.mcap --show --speed 0.25 --from 4
  calot replay out/session.mcap --what-if triangle-variant --out what-if
  calot replay out/session.mcap --what-if-iterations 10 --out what-if   the paper's solver")]
pub(crate) struct ReplayArgs {
    /// The session
    #[arg(value_name = "SESSION")]
    pub(crate) session: PathBuf,
    /// Run it on this compiled scene (.calot) instead of the one it holds; it must be the same
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,
    /// The same hands on another scene, named as for `run` (a recipe with other tissue, a coarser
    /// level `FILE.calot#1`): charts force and tip of both, and what differs
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) what_if: Option<String>,
    /// The same hands on the paper's solver, in so many iterations
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) what_if_iterations: Option<u32>,
    /// Folder that holds the meshes which the recipe of --what-if names [default: the recipe's own]
    #[arg(long, value_name = "DIR", requires = "what_if")]
    pub(crate) meshes: Option<PathBuf>,
    /// Show it in a window: its panel pauses, goes to any moment, slower or faster, and begins
    /// anew; the picture can be turned to be seen from anywhere
    #[arg(long, conflicts_with_all = ["what_if", "what_if_iterations"])]
    pub(crate) show: bool,
    /// Show it without a window: so many pictures, spread over --seconds, in --out
    #[arg(long, value_name = "N", conflicts_with_all = ["show", "what_if", "what_if_iterations"])]
    pub(crate) frames: Option<u32>,
    /// How long --frames shows it
    #[arg(long, value_name = "N", default_value = "10", value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Show it so many times as fast as it was
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_speed)]
    pub(crate) speed: f64,
    /// Show it from this time on, s
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_from)]
    pub(crate) from: f64,
    /// Name that other displays (`calot run --attach`) join the show by
    #[arg(long, value_name = "NAME", default_value = "replay", value_parser = parse_station)]
    pub(crate) station: String,
    /// Where pictures, what_if.html and what_if.csv go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// One JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

fn parse_speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if (0.01..=100.0).contains(&speed) => Ok(speed),
        _ => Err("a speed is 0.01 to 100 times".into()),
    }
}

fn parse_from(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("a time is 0 to 86400 seconds".into()),
    }
}
