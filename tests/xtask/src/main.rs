//! The commands of a fresh machine: `cargo xtask demo`, `cargo xtask test` and others. This program
//! has no dependencies, so that it builds in a second and can name what the other packages need.

mod checked;
mod gpu;
mod packages;
mod steps;
mod timings;

use std::ffi::OsString;
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  demo [ARGS]  set this machine up, build, and run the station for 10 seconds without a window:
               pictures, summary.json and report.html go to target/demo. ARGS go to `calot run`.
  test         set this machine up and pass every test: format, lints, documentation, licences,
               unit, property and system tests, golden replays in debug and release
  jitter [idle|loaded|misses|soak|watched [SECONDS]]
               build, and measure the figures on time in tests/results into target/jitter: 60, 60 and
               300 seconds in turn with other programs, 600 seconds alone, and five times 30 seconds
               beside busy programs, both with remote watchers and without. Leave the machine alone!
  gpu [--built]
               build, and measure drawing, skinning, reading back and the collision kernel on this
               machine's graphics card (or software driver) into target/gpu/gpu.json. --built runs
               what is built already, on a machine without cargo
  setup        only set up: name the missing system packages, and install them if this user may,
               else print the line to type
  deny         install cargo-deny (minutes) and check licences, sources and duplicates

Exit: 0 done, 1 something failed, 2 bad usage.";

fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    // Look for a timed test first, because a test program inherits the compiler's environment.
    if let Some(timed) = timings::run(&words) {
        return timed;
    }
    if let Some(compiled) = checked::compile(&words) {
        return compiled;
    }
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (command, rest) = match args.split_first() {
        Some((command, rest)) => (command.as_str(), rest),
        None => ("help", &[][..]),
    };
    let outcome = match (command, rest) {
        ("demo", args) => packages::set_up(false).and_then(|()| steps::demo(args)),
        ("jitter", args) => packages::set_up(false).and_then(|()| steps::jitter(args)),
        ("gpu", args) => gpu::measure(args),
        ("test", []) => packages::set_up(true).and_then(|()| steps::test()),
        ("setup", []) => packages::set_up(true),
        ("deny", []) => steps::install_and_deny(),
        ("help" | "--help" | "-h", _) => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprintln!("xtask: '{}' is not a command\n\n{HELP}", args.join(" "));
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("\nxtask: {problem}");
            ExitCode::FAILURE
        }
    }
}
