//! Options of `calot export`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(
    group(ArgGroup::new("format").args(["csv", "parquet", "surfaces"]).required(true).multiple(true)),
    after_help = "\
Tables:
  ticks     every tick: poses, tip, force, torque, jaw, contacts, switches, stage times
  events    every event of the operation: contact, grasp, tear, cut, clip, fault, …
  metrics   what `calot report` computes of the session
  columns   each column of the others: type, and meaning with the unit

Times: time_s counts from the session's first tick, time_unix_ns from 1970. Debrief, metrics and the
store count otherwise: from the trainee's first movement, without pauses, gaps and lost devices. The
column debrief_s of ticks and events has that time, so that any row converts one to the other.

The session is run again tick by tick, as `calot replay` does, and must come out equal; otherwise
the exit code is 1, and the command names the first tick that differs. Numbers keep every bit.

Examples:
  calot run --headless --seconds 10 --out out    leaves out/session.mcap
  calot export out/session.mcap --csv tables
  calot export out/session.mcap --parquet tables
  calot export out/session.mcap --surfaces organs.mcap --surfaces-hz 5
  calot export out --surfaces organs.mcap --pictures
  python3 -c \"import pandas; print(pandas.read_csv('tables/ticks.csv').force_x_n.describe())\""
)]
pub(crate) struct ExportArgs {
    /// Recorded session (.mcap), the folder of `calot run --out DIR`, or a session's id as `calot
    /// store list NAME` prints it
    #[arg(value_name = "SESSION")]
    pub(crate) session: PathBuf,
    /// Folder for the tables as CSV (comma, point, one line a row, header in line 1)
    #[arg(long, value_name = "DIR")]
    pub(crate) csv: Option<PathBuf>,
    /// Folder for the tables as Parquet, without compression
    #[arg(long, value_name = "DIR")]
    pub(crate) parquet: Option<PathBuf>,
    /// File (.mcap) for the organs' surfaces over time, for Foxglove or Rerun. A second of the
    /// built-in scene takes a few megabytes
    #[arg(long, value_name = "FILE")]
    pub(crate) surfaces: Option<PathBuf>,
    /// Surfaces a second
    #[arg(long, value_name = "HZ", default_value_t = 2.0, value_parser = parse_hz, requires = "surfaces")]
    pub(crate) surfaces_hz: f64,
    /// Add a picture of each alarm, and of the critical view of safety, to the file of surfaces:
    /// the picture that the run kept, or one that is drawn as by `calot report --pictures`
    #[arg(long, requires = "surfaces")]
    pub(crate) pictures: bool,
    /// Run the session on this compiled scene (.calot) instead of its own; both must be equal
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

fn parse_hz(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if (0.01..=100.0).contains(&hz) => Ok(hz),
        _ => Err("a rate is 0.01 to 100 Hz".into()),
    }
}
