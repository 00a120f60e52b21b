//! `calot bare-loop`: runs a periodic loop without a station, and prints a histogram of its
//! latencies in cyclictest's format. The loop has its own process, because it locks all memory of
//! its process.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use jitter::Baseline;
use rt_process::probe::{Loop, Probe};

use crate::args::parse_seconds;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Options of `calot bare-loop`.
#[derive(Debug, Clone, Args)]
pub(crate) struct BareLoopArgs {
    /// Kind of loop: executor or sleep
    #[arg(value_name = "KIND")]
    pub(crate) kind: Baseline,
    /// Time to measure, s
    #[arg(long, value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Core of the loop
    #[arg(long)]
    pub(crate) core: usize,
    /// SCHED_FIFO priority of the loop
    #[arg(long)]
    pub(crate) priority: u8,
    /// Time to spin before each period, µs, as in `calot rt`
    #[arg(long, default_value_t = 0)]
    pub(crate) spin: u64,
    /// File with the working time of each period, ns, one per line
    #[arg(long, value_name = "FILE")]
    pub(crate) work: Option<PathBuf>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

pub(crate) fn run(args: &BareLoopArgs) -> Result<ExitCode, Problem> {
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let kind = match args.kind {
        Baseline::Executor => Loop::Executor {
            spin_ns: args.spin * 1000,
        },
        _ => Loop::Plain,
    };
    let work_ns = match &args.work {
        None => Vec::new(),
        Some(file) => read_work(file)?,
    };
    let probe = Probe {
        kind,
        periods: (args.seconds * 1000.0) as u64,
        core: args.core,
        priority: args.priority,
        work_ns,
    };
    let found = probe.run()?;
    for why in &found.standing.refused {
        say::note(format_args!("calot bare-loop: {why}"));
    }
    let mut text = String::from("# Unit: ns\n");
    for (ns, count) in counted(&found.wake_latency_ns) {
        text += &format!("{ns} {count}\n");
    }
    for (ns, count) in counted(&found.burnt_ns) {
        text += &format!("# Work: {ns} {count}\n");
    }
    let misses = found.misses;
    for (name, count) in [
        ("Missed, woken late", misses.woken_late),
        ("Missed, at work", misses.at_work),
        ("Occasions", misses.occasions),
        ("Overruns", misses.late_ticks),
    ] {
        text += &format!("# {name}: {count}\n");
    }
    text += &format!("# Realtime: {}", found.standing.is_realtime());
    say::answer(text);
    Ok(ExitCode::SUCCESS)
}

fn counted(times_ns: &[u32]) -> BTreeMap<u32, u64> {
    let mut histogram = BTreeMap::new();
    for ns in times_ns {
        *histogram.entry(*ns).or_default() += 1;
    }
    histogram
}

/// Reads the times of ticks that [`write_work`] wrote.
fn read_work(file: &Path) -> Result<Vec<u32>, Problem> {
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let times: Result<Vec<u32>, _> = text.lines().map(str::parse).collect();
    times.map_err(|e| format!("{}: expected a time in ns per line: {e}", file.display()).into())
}

/// Writes the durations of these ticks as work for a loop. Durations above their 99.9th percentile
/// are cut to it: the machine caused them, and will delay the loop as well.
pub(crate) fn write_work(file: &Path, ticks_ns: &[u32]) -> Result<(), Problem> {
    let mut sorted = ticks_ns.to_vec();
    sorted.sort_unstable();
    let most = sorted.get(sorted.len() * 999 / 1000).copied().unwrap_or(0);
    let text: String = ticks_ns
        .iter()
        .map(|ns| format!("{}\n", ns.min(&most)))
        .collect();
    std::fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_has_the_durations_of_the_ticks_without_the_longest() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("work");
        let mut ticks: Vec<u32> = (0..3000).collect();
        ticks[7] = 50_000_000;
        write_work(&file, &ticks).unwrap();
        let read = read_work(&file).unwrap();
        assert_eq!((read.len(), read[6], read[7], read[8]), (3000, 6, 2998, 8));
        std::fs::write(&file, "12\nx\n").unwrap();
        assert!(
            read_work(&file)
                .unwrap_err()
                .to_string()
                .contains("work: expected a time")
        );
    }
}
