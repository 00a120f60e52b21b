//! `evaluate ablation`: changes each tuned value of contact, force and tissue, and measures what
//! becomes better or worse.
//!
//! ```text
//! sources ─► copy with variable values ─► its `evaluate`, once per core ─► ablation.csv
//! ```

mod copy;
mod criteria;
mod source;
mod varied;

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use clap::Args;

use criteria::{Bench, Group, Value};

/// Options of `ablation`.
#[derive(Args)]
pub(crate) struct AblationArgs {
    /// Folder for ablation.csv, and for the copy of the sources that is built.
    #[arg(long)]
    out: PathBuf,
    /// Changes only the values whose name contains this ("contact::skin", "DAMPING").
    #[arg(long, value_name = "TEXT", default_value = "")]
    case: String,
    /// Part of the values that this process changes, from 0, and the number of parts. The program
    /// starts itself with this option.
    #[arg(long, num_args = 2, value_names = ["PART", "PARTS"], hide = true)]
    part: Option<Vec<usize>>,
}

/// Name of the change that takes a value away. If a group of criteria does not notice it at all,
/// the smaller changes are not tried there.
const OFF: &str = "off";
/// Smaller and larger by this share.
const SHARE: f32 = 0.3;
/// Factor that takes a limit away.
const UNLIMITED: f32 = 1e6;
const HEADER: &str = "parameter,value,change,criterion,before,after\n";

/// Changes every tuned value and measures the criteria.
///
/// # Errors
/// The reason in words.
pub(crate) fn run(asked: &AblationArgs) -> Result<(), String> {
    std::fs::create_dir_all(&asked.out).map_err(|e| format!("{}: {e}", asked.out.display()))?;
    match asked.part.as_deref() {
        Some(&[part, parts]) => work(asked, part, parts),
        _ => share_out(asked),
    }
}

/// Builds the copy, starts a process of it for each core, and puts their results together.
fn share_out(asked: &AblationArgs) -> Result<(), String> {
    let program = copy::build(&asked.out)?;
    let parts = thread::available_parallelism().map_or(1, usize::from);
    let start = |part: usize| {
        Command::new(&program)
            .args(["ablation", "--case", &asked.case, "--out"])
            .arg(&asked.out)
            .args(["--part", &part.to_string(), &parts.to_string()])
            .spawn()
            .map_err(|e| format!("{}: {e}", program.display()))
    };
    let started: Result<Vec<_>, _> = (0..parts).map(start).collect();
    for mut process in started? {
        let ended = process.wait().map_err(|e| e.to_string())?;
        if !ended.success() {
            return Err(format!("a process of {} failed", program.display()));
        }
    }
    let files = (0..parts).map(|part| part_file(&asked.out, part));
    let texts: Result<Vec<_>, _> = files.map(std::fs::read_to_string).collect();
    let texts = texts.map_err(|e| e.to_string())?;
    let mut lines: Vec<_> = texts.iter().flat_map(|text| text.lines().skip(1)).collect();
    // A part takes every nth value. Lines of one value stay in their order.
    lines.sort_by_key(|line| line.split(',').next());
    let path = asked.out.join("ablation.csv");
    let text = format!("{HEADER}{}\n", lines.join("\n"));
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}

fn part_file(out: &Path, part: usize) -> PathBuf {
    out.join(format!("ablation.{part}.csv"))
}

/// A change of a value: its name in the file, and the factor.
type Change = (&'static str, f32);

/// The changes of a value. Without a limit, the value is out of reach; without anything else, it is
/// zero.
fn changes(name: &str) -> [Change; 3] {
    let is_limit = name.ends_with("_MAX") || name.contains("_MAX_");
    let off = if is_limit { UNLIMITED } else { 0.0 };
    [(OFF, off), ("-30 %", 1.0 - SHARE), ("+30 %", 1.0 + SHARE)]
}

/// Changes every nth value, in this process.
fn work(asked: &AblationArgs, part: usize, parts: usize) -> Result<(), String> {
    let mut bench = Bench::new()?;
    let mut usual: Vec<(Group, Vec<Value>, Vec<bool>)> = Vec::new();
    for group in Group::ALL {
        varied::forget_reads();
        let values = bench.measure(group)?;
        let read = (0..varied::NAMES.len()).map(varied::was_read);
        usual.push((group, values, read.collect()));
    }
    // A changed value may end a run by an assertion; this is a result.
    std::panic::set_hook(Box::new(|_| {}));
    let mine = varied::NAMES.iter().enumerate();
    let mine = mine.filter(|(_, (name, _))| name.contains(&asked.case));
    let mine: Vec<_> = mine.skip(part).step_by(parts.max(1)).collect();
    let mut text = HEADER.to_owned();
    for (done, (index, (name, value))) in mine.iter().enumerate() {
        eprintln!("ablation {}/{}: {name} = {value}", done + 1, mine.len());
        let mut without_effect = Vec::new();
        for (change, factor) in changes(name) {
            varied::vary(*index, factor);
            for (group, before, read) in &usual {
                if read.get(*index) != Some(&true) || without_effect.contains(group) {
                    continue;
                }
                let ran = catch_unwind(AssertUnwindSafe(|| bench.measure(*group)));
                // A run that fails has no values.
                let after = ran.unwrap_or_else(|_| Ok(Vec::new())).unwrap_or_default();
                if change == OFF && after == *before {
                    without_effect.push(*group);
                }
                for (i, (criterion, before)) in before.iter().enumerate() {
                    let after = after.get(i).map_or(f64::NAN, |it| it.1);
                    let _ = writeln!(
                        text,
                        "{name},\"{value}\",{change},\"{criterion}\",{before:.4},{after:.4}"
                    );
                }
            }
        }
        varied::vary(*index, 1.0);
        if !usual
            .iter()
            .any(|(.., read)| read.get(*index) == Some(&true))
        {
            let _ = writeln!(text, "{name},\"{value}\",any,\"not read\",,");
        }
        let path = part_file(&asked.out, part);
        std::fs::write(&path, &text).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}
