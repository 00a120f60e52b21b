//! `calot check`: finds out if this machine is fit for realtime. It tries the calls that the
//! controller will make, and undoes them. It reads other properties from files and limits. For each
//! property it prints the current state, and for a property that is not good the remedy.

mod files;
mod find;
mod finding;
mod granted;
mod graphics;
mod kernel;
mod processor;
mod removal;
mod serial;
mod system;

use std::path::Path;
use std::process::ExitCode;

use clap::Args;

use self::finding::{Finding, Verdict};
use self::system::System;
use crate::document;
use crate::problem::Problem;
use crate::say;

/// Options of `calot check`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot check                current state, required state, command that fixes it
  calot check --json
  calot check --install      prints a shell script (systemd unit, limits, udev rules); `| sudo sh` runs it

Exit code: 0 if realtime is possible, 1 if something prevents it. Advice (`better`) leaves it at 0.")]
pub(crate) struct CheckArgs {
    /// Core to run the tick on, counted from 0 [default: the last one]
    #[arg(long, value_name = "N")]
    core: Option<usize>,
    /// Print a script that installs a systemd unit, limits and udev rules; run nothing
    #[arg(long, conflicts_with = "json")]
    install: bool,
    /// Print the findings as JSON
    #[arg(long)]
    json: bool,
}

/// Examines the machine and prints the findings.
pub(crate) fn run(args: &CheckArgs) -> Result<ExitCode, Problem> {
    let cores = rt_process::realtime::allowed_cores();
    let core = args.core.or(cores.last().copied()).unwrap_or(0);
    if args.install {
        say::answer(files::script(&std::env::current_exe()?, core));
        return Ok(ExitCode::SUCCESS);
    }
    let mut findings = find::all(&System::this(core), core);
    findings.push(removal::removal(Path::new("/")));
    findings.push(graphics::graphics(&graphics::Adapter::open()));
    let bad = findings.iter().any(|f| f.verdict == Verdict::Bad);
    if args.json {
        let json = serde_json::json!({"core": core, "fit": !bad, "findings": findings});
        document::CHECK.answer(json)?;
    } else {
        for finding in &findings {
            say::answer(in_words(finding));
        }
        say::answer(match bad {
            true => {
                "\nNOT REALTIME on this machine until everything marked BAD is fixed (`calot check --install`)."
            }
            false => "\nThis machine is fit. Measure it: `calot jitter --compare cyclictest`.",
        });
    }
    Ok(if bad {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

/// Lines about a finding: the current state, and if it is not good the required state and remedy.
fn in_words(finding: &Finding) -> String {
    let mark = match finding.verdict {
        Verdict::Good => "good   ",
        Verdict::Better => "better ",
        Verdict::Bad => "BAD    ",
        Verdict::Unknown => "unknown",
    };
    let mut text = format!("{mark}  {:22} {}", finding.name, finding.is);
    if finding.verdict != Verdict::Good {
        text += &format!("\n         {:22} should be: {}", "", finding.should);
        if let Some(mend) = &finding.mend {
            text += &format!("\n         {:22} $ {mend}", "");
        }
    }
    text
}
