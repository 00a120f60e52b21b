//! `calot jitter`: measures latency, duration and missed periods of ticks on the real station.
//! Other programs can take turns with the station, so that all are measured in the same minutes.
//!
//! ```text
//! jitter ─┬─ station (calot emulate, calot rt) ─► timing records ─► tally ─► report
//!         ├─ loads     (calot load …)                                  └─► black box
//!         └─ baselines (cyclictest, calot bare-loop, …), a turn each ───────────► report
//! ```
//!
//! The report is written every few seconds, so that a kill loses little. Each new file replaces the
//! old one by a rename.

pub(crate) mod args;
mod bench;
mod drawing;
mod guests;
mod line;
mod save;
mod session;
mod standing;
mod work;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use assess::Task;
use figures::Machine;
use jitter::baselines::{self, Terms};
use jitter::intervals::Intervals;
use jitter::machines::Part;
use jitter::report::{About, Report};
use jitter::tally::Tally;
use jitter::timeline::Timeline;
use jitter::{Baseline, kernel, table, two_runs};
use shared_mem::scene::SceneFile;

use self::args::JitterArgs;
use self::bench::Bench;
use self::guests::{baseline_turn, with_timerlat};
use self::save::{save, save_all};
use crate::bare_loop;
use crate::document;
use crate::folder::Folder;
use crate::load::{Load, Loads};
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::run::args::RunArgs;
use crate::say;
use crate::scene;
use crate::stop;

/// Time at the start of a turn in which motion to force does not count with `--follow-device`, s:
/// the ticks still move to the device's samples. It is twice the time that they need.
const SETTLE_S: f64 = 3.0;
/// Longest turn, s. With short turns, all programs run in the same minutes.
const TURN_MAX_S: f64 = 30.0;
/// Fewest turns in a comparison: a median and a confidence interval need three.
const ROUNDS_MIN: u32 = 3;
/// Scene without tissue on which a scripted surgeon can work.
const SCENE_WITHOUT_TASK: &str = "built-in";
const NO_TISSUE_FOR_HAND: &str = "--hand: the scene 'built-in' has no duct, artery or tissue to dissect; choose \
                       another, e.g. --scene triangle";

/// Measures, adds up or compares runs.
pub(crate) fn run(args: &JitterArgs) -> Result<ExitCode, Problem> {
    if let [first, second] = args.ratio_of.as_slice() {
        let ratios = two_runs::ratios(&Report::read(first)?, &Report::read(second)?);
        match args.json {
            true => document::JITTER_DIFF.answer(&ratios.json)?,
            false => say::answer(ratios.text.trim_end()),
        }
        return Ok(ExitCode::SUCCESS);
    }
    let named = args.out.as_deref();
    let out = output::folder(named, "jitter", Format::of_result, args.overwrite)?;
    let (report, is_whole) = if args.merge.is_empty() {
        measure(args, &out)?
    } else {
        (added_up(&args.merge)?, true)
    };
    save_all(&report, &out)?;
    match args.json {
        true => document::JITTER.answer(report.to_json())?,
        false => say::answer(table::text(&report).trim_end()),
    }
    let out = out.display();
    say::note(format_args!(
        "wrote {out}/jitter.json, .csv, .html, .trace.json and histograms"
    ));
    Ok(if is_whole {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Reads runs, puts them into one table and adds them up.
fn added_up(paths: &[PathBuf]) -> Result<Report, Problem> {
    let mut runs = Vec::new();
    for path in paths {
        let mut run = Report::read(path)?;
        if run.parts.is_empty() {
            let folder = path
                .parent()
                .filter(|_| path.ends_with(jitter::report::FILE));
            let path = folder.unwrap_or(path);
            let name = path.file_name().unwrap_or(path.as_os_str());
            run.parts = vec![Part::of(&run, &name.to_string_lossy())];
        }
        runs.push(run);
    }
    let mut sum = two_runs::merge(runs).ok_or("name two runs or more")?;
    sum.about.command = command();
    Ok(sum)
}

/// Measures a run. Returns the report, and false if a process of the station died.
fn measure(args: &JitterArgs, out: &Path) -> Result<(Report, bool), Problem> {
    let stop = stop::flag()?;
    if args.hand.is_some() && args.scene.scene == SCENE_WITHOUT_TASK {
        return Err(NO_TISSUE_FOR_HAND.into());
    }
    for &baseline in &args.compare {
        baselines::check(baseline)?;
    }
    let folder = Folder::open(&args.station, false)?;
    let scene = scene::compile(&args.scene, &folder.scene())?;
    let loads = Load::each(&args.load);
    let mut report = begin(&scene, &loads)?;
    let args = &with_timerlat(args, &mut report.about.notes);
    let mut running = Loads::start(&loads, out, &args.station)?;
    let outcome = rounds(args, out, &folder, &scene, &loads, &stop, &mut report);
    if let Some(problem) = running.died() {
        report.about.notes.push(problem);
    }
    let displays = running.end();
    if displays.joined > 0 {
        report.count("displays_joined", displays.joined);
    }
    report.about.notes.extend(displays.problem);
    if let Err(problem) = outcome {
        // Write the measurements so far, marked as incomplete.
        save(&report, out)?;
        return Err(problem);
    }
    let died = outcome?;
    report.about.complete = died.is_none() && !stop.load(Ordering::Relaxed);
    let is_whole = died.is_none();
    report.about.notes.extend(died);
    Ok((report, is_whole))
}

/// Report before the first turn: it has the scene, the machine and notes.
fn begin(scene: &Path, loads: &[Load]) -> Result<Report, Problem> {
    let mut notes = Vec::new();
    if !kernel::Counters::read(0, None).knows_smis() {
        notes.push(
            "system management interrupts were not counted: that takes an Intel processor, root, \
             and `modprobe msr`"
                .to_owned(),
        );
    }
    if !loads.contains(&Load::Display) {
        notes.push("no display drew pictures: frame times need `--load display`".to_owned());
    }
    Ok(Report {
        about: About {
            program: concat!("calot ", env!("CARGO_PKG_VERSION")).to_owned(),
            command: command(),
            scene: SceneFile::open(scene)?.name().to_owned(),
            complete: false,
            seconds: 0.0,
            load: loads.iter().map(|load| load.name()).collect(),
            realtime: false,
            notes,
            memory_kib: None,
            machine: Machine::read(),
        },
        times: BTreeMap::new(),
        counts: BTreeMap::new(),
        rounds: Vec::new(),
        timeline: Timeline::default(),
        incidents: Vec::new(),
        intervals: Intervals::default(),
        causes: Vec::new(),
        why: None,
        budgets: Vec::new(),
        parts: Vec::new(),
    })
}

/// Runs all turns of all programs, each round in another order. Returns a message about the process
/// that died, if one did.
fn rounds(
    args: &JitterArgs,
    out: &Path,
    folder: &Folder,
    scene: &Path,
    loads: &[Load],
    stop: &Arc<AtomicBool>,
    report: &mut Report,
) -> Result<Option<String>, Problem> {
    let count = round_count(args);
    let turn_s = args.seconds / f64::from(count);
    let cores = rt_process::realtime::allowed_cores();
    let core = args
        .controller
        .realtime
        .core
        .or(cores.last().copied())
        .unwrap_or(0);
    let station = RunArgs {
        scene: args.scene.clone(),
        station: args.station.clone(),
        controller: args.controller.clone(),
        ..RunArgs::default()
    };
    let bench = Bench {
        station: &station,
        scene,
        folder: folder.path(),
        out,
        core,
        others: cores.into_iter().filter(|&c| c != core).collect(),
        draws: loads.contains(&Load::Display),
        hand: args
            .hand
            .map(|hand| (hand, args.task.unwrap_or(Task::Full))),
        why: args.why,
        total_s: args.seconds,
        stop,
    };
    let settle_s = match args.controller.realtime.follow_device {
        true => SETTLE_S.min(turn_s / 2.0),
        false => 0.0,
    };
    if settle_s > 0.0 {
        report.about.notes.push(format!(
            "motion to force counts from second {settle_s:.1} of each turn on: before this, the ticks still move \
             to the device's samples"
        ));
    }
    let mut tally = Tally::default();
    let work = folder.path().join("work");
    tally.settle_ns = (settle_s * 1e9) as u64;
    let mut programs: Vec<Option<Baseline>> = vec![None];
    programs.extend(args.compare.iter().copied().map(Some));
    for round in 0..count {
        for &program in &programs {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let Some(baseline) = program else {
                let turn = bench.measure(turn_s, round, &mut tally, report)?;
                if turn.died.is_some() {
                    return Ok(turn.died);
                }
                if args.compare.contains(&Baseline::Burn) {
                    bare_loop::write_work(&work, &turn.ticks_ns)?;
                }
                continue;
            };
            let of = args.compare.len() + 1;
            say::note(format_args!(
                "jitter: round {} of {count}, {turn_s:.0} s of {} ({of} programs take turns)",
                round + 1,
                baseline.name()
            ));
            let terms = Terms {
                core,
                priority: args.controller.realtime.priority,
                spin_us: args.controller.realtime.spin,
                work: &work,
            };
            match baseline_turn(baseline, terms, turn_s, round, stop, report) {
                // `with_timerlat` may have added timerlat without a request by the user. If it
                // fails, the other programs are still measured.
                Err(problem) if baseline == Baseline::Timerlat => {
                    let note = problem.to_string();
                    if !report.about.notes.contains(&note) {
                        report.about.notes.push(note);
                    }
                }
                outcome => outcome?,
            }
            save(report, out)?;
        }
        // The station goes first in the first round, because `burn` needs its tick times.
        programs.rotate_left(1);
    }
    Ok(None)
}

/// Number of turns of each program.
fn round_count(args: &JitterArgs) -> u32 {
    match (args.rounds, args.compare.is_empty()) {
        (Some(rounds), _) => rounds,
        (None, true) => 1,
        (None, false) => ((args.seconds / TURN_MAX_S).ceil() as u32).max(ROUNDS_MIN),
    }
}

/// Command line of this process. Of each absolute path it has only the last part, because folders
/// of this machine mean nothing to readers elsewhere.
pub(crate) fn command() -> String {
    let words: Vec<String> = std::env::args().skip(1).map(shortened).collect();
    format!("calot {}", words.join(" "))
}

/// Last part of an absolute path. Paths below /dev and other words stay whole.
fn shortened(word: String) -> String {
    let path = Path::new(&word);
    match path.file_name() {
        Some(name) if path.is_absolute() && !path.starts_with("/dev") => {
            name.to_string_lossy().into_owned()
        }
        _ => word,
    }
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn folders_of_the_machine_are_left_out() {
        for (typed, shown) in [
            ("/home/me/runs/idle", "idle"),
            ("/dev/ttyS0", "/dev/ttyS0"),
            ("target/jitter/idle", "target/jitter/idle"),
            ("--seconds", "--seconds"),
            ("/", "/"),
        ] {
            assert_eq!(shortened(typed.to_owned()), shown);
        }
    }
}
