//! `calot loop`: a loop without a station, its latencies as a histogram on standard output in
//! cyclictest's form. A process of its own, because it locks its memory.

use std::collections::BTreeMap;
use std::process::ExitCode;

use rt_process::probe::{Loop, Probe};

use super::args::{LoopArgs, Rival};
use crate::say;
use crate::scene::Problem;
use crate::stop;

/// Measures and prints.
pub(crate) fn run(args: &LoopArgs) -> Result<ExitCode, Problem> {
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let kind = match args.kind {
        Rival::Executor => Loop::Executor {
            spin_ns: args.spin * 1000,
        },
        _ => Loop::Plain,
    };
    let probe = Probe {
        kind,
        periods: (args.seconds * 1000.0) as u64,
        core: args.core,
        priority: args.priority,
        work_ns: args.work_ns,
    };
    let found = probe.run()?;
    for why in &found.standing.refused {
        say::note(format_args!("calot loop: {why}"));
    }
    let mut histogram = BTreeMap::<u32, u64>::new();
    for ns in &found.wake_latency_ns {
        *histogram.entry(*ns).or_default() += 1;
    }
    let mut text = String::from("# Unit: ns\n");
    for (ns, count) in histogram {
        text += &format!("{ns} {count}\n");
    }
    text += &format!("# Missed: {}\n", found.missed);
    text += &format!("# Realtime: {}", found.standing.is_realtime());
    say::answer(text);
    Ok(ExitCode::SUCCESS)
}
