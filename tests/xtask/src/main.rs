//! `cargo xtask`: sets a fresh machine up, and runs the demo, the tests and the measurements. This
//! program has no dependencies, so that it builds in a second and can name the system packages that
//! the other programs need.

mod beside;
mod checked;
mod gpu;
mod guide;
mod packages;
mod program;
mod steps;
mod timings;

use std::ffi::OsString;
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  demo [ARGS]  set this machine up, build, and run the station for 10 seconds without a window:
               pictures, summary.json and report.html go to target/demo. ARGS go to `calot run`.
  test         set this machine up and run every test: format, lints, documentation, licences,
               unit, property and system tests, golden replays in debug and release
  hands [--again] [HAND[:TASK] ...]
               let scripted hands work tasks through the real processes, in real time, and keep what
               each came to in tests/results/hands.csv: a table of hands and tasks (an hour and a
               half), or these. Their sessions stay in target/hands. --again judges these sessions
               once more, by the present metrics and rules, and works nothing
  jitter guide [SECONDS [PROGRAM]]
               measure every figure of time in the guide for latency testers, 15 turns of 12 s or
               SECONDS, write tests/results/guide.csv and the tables made from it. PROGRAM is a
               calot that is built already
  jitter [idle|loaded|misses|soak|watched [SECONDS]]
               build, and measure the times in tests/results into target/jitter: all five runs, or
               one of them, for SECONDS instead of the time below. Leave the machine alone!
                 idle     60 s in turn with other programs
                 loaded   60 s in turn with other programs, beside `--load cpu,memory,io,join`
                 misses   300 s in turn with a loop that does as much work, beside `--load join`
                 soak     600 s beside `--load display`
                 watched  five times 30 s with remote watchers and 30 s without, both beside
                          `--load cpu,memory`
  crowd [SECONDS]
               build a centre, and show it fifty stations and five instructors, with stations killed,
               cut off and returning, for 600 s or SECONDS: delay and loss of alarms, pictures, load
  gpu [--built] [--short]
               build, and measure drawing, skinning, reading back and the collision kernel on this
               machine's graphics card (or software driver) into target/gpu/gpu.json. --built runs
               what is built already. --short draws one small size and each picture once: a trial
               of minutes on a software driver, not a measurement.
               To measure on another machine, build here and copy these files there, in the same
               folders: target/debug/xtask, target/release/calot, target/release/evaluate,
               target/release/examples/frame_cost. It needs a Vulkan driver, but no cargo. Start
               `target/debug/xtask gpu --built` there, and bring target/gpu/gpu.json back
  setup        only set up: name the missing system packages, and install them if this user may,
               else print the line to type
  deny         install cargo-deny (minutes) and check licences, sources and duplicates

Exit: 0 done, 1 something failed, 2 bad usage.";

fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    // `cargo xtask test` makes cargo start test programs and the compiler through copies of this
    // program. Look for a test program first, because the variable that marks a compilation is set
    // then, too.
    if let Some(timed) = program::run(&words) {
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
        ("jitter", [name, args @ ..]) if name == "guide" => {
            packages::set_up(false).and_then(|()| guide::measure(args))
        }
        ("hands", args) => packages::set_up(false).and_then(|()| steps::hands(args)),
        ("jitter", args) => packages::set_up(false).and_then(|()| steps::jitter(args)),
        ("crowd", args) => steps::crowd(args),
        ("gpu", args) => gpu::measure(args),
        ("test", []) => packages::set_up(true).and_then(|()| steps::test()),
        ("setup", []) => packages::set_up(true),
        ("deny", []) => steps::install_and_deny(),
        ("help" | "--help" | "-h", _) => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        ("test" | "setup" | "deny", rest) => {
            let rest = rest.join(" ");
            eprintln!("xtask: '{command}' takes no arguments, but got '{rest}'\n\n{HELP}");
            return ExitCode::from(2);
        }
        _ => {
            eprintln!("xtask: '{command}' is not a command\n\n{HELP}");
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
