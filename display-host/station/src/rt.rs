//! `calot rt`.

use std::process::ExitCode;

use rt_process::scope_line::{ModemLine, ScopeLine};
use rt_process::{AdmissionPolicy, Realtime, RtConfig, RtError, Scheduler};

use crate::children::READY;
use crate::cli::{RtArgs, SchedulerName, ScopeLineName};
use crate::say;
use crate::scene::Problem;
use crate::stop;

/// Exit code for a scene that `--strict` refuses: the station then tries a coarser one.
pub(crate) const DOES_NOT_FIT: u8 = 3;

/// Runs the realtime process until it is told to end.
pub(crate) fn run(args: &RtArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let mut config = RtConfig::new(&args.station, &args.scene);
    config.haptic = args.controller.devices.haptic.clone();
    config.tracker = args.controller.devices.tracker.clone();
    config.pedal = args.controller.devices.pedal.clone();
    config.station_file = args.controller.devices.station_file.clone();
    config.core = args.controller.realtime.core;
    config.priority = args.controller.realtime.priority;
    config.publisher_priority = config
        .publisher_priority
        .min(args.controller.realtime.priority - 1);
    config.spin_ns = args.controller.realtime.spin * 1000;
    config.scheduler = match args.controller.realtime.scheduler {
        SchedulerName::Fifo => Scheduler::Fifo,
        SchedulerName::Deadline => Scheduler::Deadline,
    };
    config.coarser = args.controller.realtime.coarser.clone();
    if args.controller.realtime.strict {
        config.admission = AdmissionPolicy::Strict;
    }
    if let (Some(line), Some(tty)) = (
        args.controller.realtime.scope_line,
        &args.controller.realtime.scope_tty,
    ) {
        config.scope_line = Some(ScopeLine {
            tty: tty.clone(),
            line: match line {
                ScopeLineName::Rts => ModemLine::Rts,
                ScopeLineName::Dtr => ModemLine::Dtr,
            },
        });
    }
    if args.controller.realtime.no_realtime {
        config.realtime = Realtime::Never;
    }
    if let Some(seconds) = args.seconds {
        config.periods_max = Some((seconds.max(0.0) * 1e9) as u64 / config.period_ns);
    }
    let outcome = rt_process::run(&config, &stop, |ready| {
        let json = serde_json::to_string(ready).unwrap_or_default();
        say::answer(format_args!("{READY} {json}"));
    });
    if let Err(error @ RtError::DoesNotFit(_)) = &outcome {
        say::note(format_args!("calot: {error}"));
        return Ok(ExitCode::from(DOES_NOT_FIT));
    }
    let summary = outcome?;
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
