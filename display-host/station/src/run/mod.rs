//! `calot run`: starts the other processes, runs the display, ends the processes, and reports.
//!
//! ```text
//! Planned ──start──► Started ──show──► Shown ──finish──► Finished
//! folder, scene      processes,        pictures,         summary.json, report.html,
//!                    recorder, task    figures           debrief.html, exit code
//! ```

pub(crate) mod args;
mod desk;
mod finish;
mod free_space;
mod plan;
pub(crate) mod player;
pub(crate) mod processes;
mod show;
mod start;
mod watch;

use std::process::ExitCode;

use self::args::RunArgs;
use self::plan::Planned;
use crate::problem::Problem;

/// Runs the station. The exit code is 0 if the run reached its end and all results are written.
pub(crate) fn run(args: &RunArgs) -> Result<ExitCode, Problem> {
    let finished = Planned::new(args)?.start()?.show()?.finish()?;
    Ok(match finished.whole {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}
