//! `calot rt`.

use std::process::ExitCode;

use rt_process::{Realtime, RtConfig};

use crate::children::READY;
use crate::cli::RtArgs;
use crate::say;
use crate::scene::Problem;
use crate::stop;

/// Runs the realtime process until it is told to end.
pub(crate) fn run(args: &RtArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let mut config = RtConfig::new(&args.station, &args.scene);
    config.haptic = args.devices.haptic.clone();
    config.tracker = args.devices.tracker.clone();
    config.pedal = args.devices.pedal.clone();
    config.core = args.realtime.core;
    config.priority = args.realtime.priority;
    config.publisher_priority = config.publisher_priority.min(args.realtime.priority - 1);
    config.spin_ns = args.realtime.spin * 1000;
    if args.realtime.no_realtime {
        config.realtime = Realtime::Never;
    }
    if let Some(seconds) = args.seconds {
        config.periods_max = Some((seconds.max(0.0) * 1e9) as u64 / config.period_ns);
    }
    let summary = rt_process::run(&config, &stop, |ready| {
        let json = serde_json::to_string(ready).unwrap_or_default();
        say::answer(format_args!("{READY} {json}"));
    })?;
    if args.json {
        say::answer(format_args!("{}", serde_json::to_string(&summary)?));
    } else {
        say::note(format_args!(
            "{} ticks, {} missed, {} allocations, {} page faults{}",
            summary.ticks,
            summary.deadline_misses,
            summary.allocations_after_start.unwrap_or(0),
            summary.page_faults_after_start,
            if summary.realtime {
                ""
            } else {
                " (not realtime)"
            },
        ));
    }
    Ok(ExitCode::SUCCESS)
}
