//! Steps of `cargo xtask test`, `demo`, `jitter` and `deny`. Each step runs cargo once.

use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use crate::beside::Beside;
use crate::checked;
use crate::packages::on_path;
use crate::program::BESIDE;
use crate::timings::Timings;

struct Step {
    name: &'static str,
    args: &'static [&'static str],
    /// True if clippy and rustdoc also check our packages that this step compiles.
    is_checked: bool,
    /// True if each test program's time goes into the table at the end.
    is_timed: bool,
    /// True if the programs that compute run beside the others.
    has_programs_beside: bool,
}

/// Arguments of cargo that build `hardware` without `std`, as a rig's firmware uses it.
const FIRMWARE: &[&str] = &[
    "build",
    "--locked",
    "-p",
    "hardware",
    "--no-default-features",
];
/// A target without an operating system: Cortex-M4F and M7F, as on a Teensy or an STM32.
const BOARD: &str = "thumbv7em-none-eabihf";

/// The workspace of the centre's program.
const CENTRE: &str = "display-host/centre/Cargo.toml";

/// Steps that every `cargo xtask test` runs. `test_in` adds two that need a further target or tool.
const TESTS: [Step; 9] = [
    Step {
        name: "format",
        args: &["fmt", "--all", "--check"],
        is_checked: false,
        is_timed: false,
        has_programs_beside: false,
    },
    Step {
        name: "firmware library, no_std",
        args: FIRMWARE,
        is_checked: false,
        is_timed: false,
        has_programs_beside: false,
    },
    Step {
        name: "build, lints, documentation",
        args: &[
            "test",
            "--locked",
            "--workspace",
            "--all-targets",
            "--no-run",
        ],
        is_checked: true,
        is_timed: false,
        has_programs_beside: false,
    },
    // A workspace of its own. `calot centre` needs its program in the tests below.
    Step {
        name: "format of the centre",
        args: &["fmt", "--check", "--manifest-path", CENTRE],
        is_checked: false,
        is_timed: false,
        has_programs_beside: false,
    },
    Step {
        name: "build of the centre",
        args: &["test", "--locked", "--manifest-path", CENTRE, "--no-run"],
        is_checked: true,
        is_timed: false,
        has_programs_beside: false,
    },
    // Benches run once each. `--no-fail-fast`: the run goes on after a failure, and shows all
    // failures.
    Step {
        name: "tests",
        args: &[
            "test",
            "--locked",
            "--workspace",
            "--all-targets",
            "--no-fail-fast",
        ],
        is_checked: true,
        is_timed: true,
        has_programs_beside: true,
    },
    Step {
        name: "the documentation's examples",
        args: &["test", "--locked", "--workspace", "--doc"],
        is_checked: true,
        is_timed: false,
        has_programs_beside: false,
    },
    // Its tests start `calot`, which the steps above built.
    Step {
        name: "tests of the centre",
        args: &[
            "test",
            "--locked",
            "--manifest-path",
            CENTRE,
            "--no-fail-fast",
        ],
        is_checked: true,
        is_timed: true,
        has_programs_beside: false,
    },
    // Optimised code must give identical bits, so the golden replays run again in release.
    Step {
        name: "golden replays, release",
        args: &[
            "test",
            "--locked",
            "--release",
            "-p",
            "rt-core",
            "--test",
            "replay",
        ],
        is_checked: false,
        is_timed: false,
        has_programs_beside: false,
    },
];

pub(crate) fn test() -> Result<(), String> {
    let start = Instant::now();
    let (checked, mut timings) = checked::environment()
        .and_then(|checked| {
            let timings = Timings::new(&checked[0].1)?;
            Ok((checked, timings))
        })
        .map_err(|error| format!("cannot put the checking compiler and the test runner into the target folder: {error}"))?;
    let outcome = test_in(&checked, &mut timings);
    timings.print();
    outcome?;
    println!("\nall passed in {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

fn test_in(checked: &[(&str, PathBuf)], timings: &mut Timings) -> Result<(), String> {
    for it in TESTS {
        let environment = if it.is_checked { checked } else { &[] };
        let runner = timings.runner();
        let timed = ["--config", &runner];
        let timed = if it.is_timed { &timed[..] } else { &[] };
        let start = Instant::now();
        let args = [timed, it.args].concat();
        let outcome = if it.has_programs_beside {
            let beside = Beside::start(&["--config", &runner], environment)?;
            let marked = [environment, &[(BESIDE, PathBuf::new())]].concat();
            let outcome = step_in(it.name, &args, &marked);
            // Both run to their ends, so that all failures are seen.
            beside.finish().and(outcome)
        } else {
            step_in(it.name, &args, environment)
        };
        timings.add(it.name, start.elapsed().as_secs_f64());
        outcome?;
    }
    build_for_the_board()?;
    if on_path("cargo-deny") {
        deny()
    } else {
        println!(
            "skipped: licences and sources (`cargo xtask deny` installs cargo-deny and runs this step)"
        );
        Ok(())
    }
}

/// Builds the firmware library for a board, if this machine has that target's `core`. A build for
/// this machine does not notice a dependency that needs `std`.
fn build_for_the_board() -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let found = Command::new(rustc)
        .args(["--print", "target-libdir", "--target", BOARD])
        .output()
        .map_err(|error| format!("cannot run rustc: {error}"))?;
    let folder = PathBuf::from(String::from_utf8_lossy(&found.stdout).trim());
    if !found.status.success() || !folder.is_dir() {
        println!("skipped: firmware library for a board (`rustup target add {BOARD}`)");
        return Ok(());
    }
    step(
        "firmware library for a board",
        &[FIRMWARE, &["--target", BOARD]].concat(),
    )
}

pub(crate) fn install_and_deny() -> Result<(), String> {
    if !on_path("cargo-deny") {
        step(
            "installing cargo-deny",
            &["install", "--locked", "cargo-deny"],
        )?;
    }
    deny()
}

/// Checks licences, bans and sources. Advisories are left out, because they need a database from
/// the network.
fn deny() -> Result<(), String> {
    let checks = ["check", "bans", "licenses", "sources"];
    let deny = ["deny", "--offline"];
    step("licences and sources", &[&deny[..], &checks].concat())?;
    let centre = [&deny[..], &["--manifest-path", CENTRE], &checks];
    step("licences and sources of the centre", &centre.concat())
}

pub(crate) fn demo(args: &[String]) -> Result<(), String> {
    let profile = ["--locked", "--profile", "quick"];
    step(
        "build",
        &[&["build"], &profile[..], &["-p", "calot"]].concat(),
    )?;
    let folder = "target/demo";
    let mut words = [&["run", "-q"], &profile[..], &["-p", "calot", "--", "run"]].concat();
    words.extend([
        "--headless",
        "--seconds",
        "10",
        "--overwrite",
        "--out",
        folder,
    ]);
    words.extend(args.iter().map(String::as_str));
    step("demo", &words)
}

/// Measures a centre with many stations and instructors, for this many seconds.
pub(crate) fn crowd(args: &[String]) -> Result<(), String> {
    let seconds = args.first().map_or("600", String::as_str);
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    let target =
        std::path::absolute(target).map_err(|error| format!("the target folder: {error}"))?;
    let wanted = [
        ("CALOT_SECONDS", seconds.into()),
        ("CARGO_TARGET_DIR", target),
    ];
    let words = ["test", "--locked", "--release", "--manifest-path", CENTRE];
    let more = [
        "--test",
        "centre",
        "--",
        "--ignored",
        "--nocapture",
        "crowd",
    ];
    step_in("crowd", &[&words[..], &more].concat(), &wanted)
}

/// Measurements of jitter: name, seconds, background load, and the programs to compare with.
const FIGURES: [(&str, &str, &str, &str); 4] = [
    ("idle", "60", "", LOOPS),
    ("loaded", "60", "cpu,memory,io,join", LOOPS),
    ("misses", "300", "join", "burn"),
    ("soak", "600", "display", ""),
];
const LOOPS: &str = "cyclictest,executor,sleep,embassy-std";

/// Name of the measurement that runs with remote watchers and without them, alternately.
const WATCHED: &str = "watched";

/// Lets scripted hands work tasks through the real processes: the table, or those named `HAND` or
/// `HAND:TASK`. With `--again`, judges their kept sessions once more instead.
pub(crate) fn hands(args: &[String]) -> Result<(), String> {
    let (again, named): (Vec<_>, Vec<_>) = args.iter().partition(|it| *it == "--again");
    let named: Vec<&str> = named.into_iter().map(String::as_str).collect();
    let mut wanted = vec![("CALOT_HANDS", PathBuf::from(named.join(" ")))];
    wanted.extend(
        again
            .first()
            .map(|_| ("CALOT_HANDS_AGAIN", PathBuf::from("1"))),
    );
    let test = "every_hand_works_every_task";
    // The features are those of all tests.
    let words = ["test", "--locked", "--workspace", "--test", "end_to_end"];
    let more = ["--", "--ignored", "--nocapture", test];
    step_in("hands", &[&words[..], &more].concat(), &wanted)
}

pub(crate) fn jitter(args: &[String]) -> Result<(), String> {
    let wanted = args.first().map(String::as_str);
    if let Some(name) = wanted
        && name != WATCHED
        && !FIGURES.iter().any(|figure| figure.0 == name)
    {
        return Err(format!(
            "'{name}' is unknown; write one of idle, loaded, misses, soak, watched"
        ));
    }
    let baseline = "tests/embassy-std/Cargo.toml";
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
    let build = ["build", "--locked", "--release"];
    step("build", &[&build[..], &["-p", "calot"]].concat())?;
    let beside = ["--manifest-path", baseline, "--target-dir", &target];
    step("build embassy's driver", &[&build[..], &beside].concat())?;
    if wanted.is_none_or(|wanted| wanted == WATCHED) {
        watched(args.get(1).map_or("30", String::as_str))?;
    }
    for (name, seconds, load, baselines) in FIGURES {
        if wanted.is_some_and(|wanted| wanted != name) {
            continue;
        }
        let (folder, station) = (format!("target/jitter/{name}"), format!("jitter-{name}"));
        let seconds = args.get(1).map_or(seconds, String::as_str);
        let mut words = vec!["run", "--locked", "--release", "-q", "-p", "calot", "--"];
        words.extend(["jitter", "--scene", "triangle", "--seconds", seconds]);
        words.extend(["--station", &station, "--overwrite", "--out", &folder]);
        if !baselines.is_empty() {
            words.extend(["--compare", baselines]);
        }
        if !load.is_empty() {
            words.extend(["--load", load]);
        }
        step(name, &words)?;
    }
    Ok(())
}

/// Measures how much remote watchers delay the tick: runs with and without them alternate. Both
/// kinds of run load all cores. Otherwise idle cores of a virtual machine would sleep, and waking
/// them delays ticks more than watchers do.
fn watched(seconds: &str) -> Result<(), String> {
    const TURNS: usize = 5;
    const KINDS: [(&str, &str); 2] = [("busy", "cpu,memory"), ("watched", "cpu,memory,watch")];
    let folder = format!("target/jitter/{WATCHED}");
    let calot = ["run", "--locked", "--release", "-q", "-p", "calot", "--"];
    let jitter =
        |name: &str, words: &[&str]| step(name, &[&calot[..], &["jitter"], words].concat());
    for turn in 0..TURNS {
        for (kind, load) in KINDS {
            let out = format!("{folder}/{kind}-{turn}");
            let words = ["--scene", "triangle", "--seconds", seconds, "--out", &out];
            let station = ["--station", "jitter-watched", "--overwrite"];
            jitter(kind, &[&words[..], &station, &["--load", load]].concat())?;
        }
    }
    let sums = KINDS.map(|(kind, _)| format!("{folder}/{kind}"));
    for sum in &sums {
        let turns: Vec<String> = (0..TURNS).map(|turn| format!("{sum}-{turn}")).collect();
        let turns: Vec<&str> = turns.iter().map(String::as_str).collect();
        jitter(
            "sum",
            &[&["--merge"], &turns[..], &["--overwrite", "--out", sum]].concat(),
        )?;
    }
    let [busy, watched] = &sums;
    jitter("watched against busy", &["--diff", busy, watched])
}

/// Runs cargo with these arguments.
pub(crate) fn step(name: &str, args: &[&str]) -> Result<(), String> {
    step_in(name, args, &[])
}

fn step_in(name: &str, args: &[&str], environment: &[(&str, PathBuf)]) -> Result<(), String> {
    println!("\n== {name}: cargo {}", args.join(" "));
    let start = Instant::now();
    // Use the cargo that runs this program, so that a pinned toolchain stays pinned.
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(args)
        .env("RUSTDOCFLAGS", "-D warnings")
        .envs(environment.iter().map(|(name, value)| (name, value)))
        .status()
        .map_err(|error| format!("cannot run cargo: {error}"))?;
    if !status.success() {
        return Err(format!("{name} failed ({status})"));
    }
    println!("== {name}: {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}
