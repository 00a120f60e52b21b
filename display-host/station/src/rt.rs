//! `calot rt`: runs the realtime process.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use rt_process::scope_line::{Mark, ModemLine, ScopeLine};
use rt_process::{AdmissionPolicy, Realtime, RtConfig, RtError, Scheduler};

use crate::args::{
    ControllerArgs, SchedulerName, ScopeLineName, ScopeMarkName, parse_seconds, parse_station,
};
use crate::children::{READY, REFUSED};
use crate::document;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Exit code for a scene that `--must-fit` refuses. The station tries a coarser scene only if it
/// also reads [`REFUSED`], because a device's library may end the process with the same code.
pub(crate) const DOES_NOT_FIT: u8 = 3;

#[derive(Debug, Clone, Args)]
pub(crate) struct RtArgs {
    /// Compiled scene (`calot prepare` makes one), e.g. built-in.calot
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// End after this time, s [default: on Ctrl-C, SIGTERM or a host's command]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
    /// Print one JSON object when it ticks, and one when it ends
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

/// Runs the realtime process until a signal, a command or `--seconds` ends it.
pub(crate) fn run(args: &RtArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    say::keep_answers_apart()?;
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
    config.follows_device = args.controller.realtime.follow_device;
    config.scheduler = match args.controller.realtime.scheduler {
        SchedulerName::Fifo => Scheduler::Fifo,
        SchedulerName::Deadline => Scheduler::Deadline,
    };
    config.coarser = args.controller.realtime.coarser.clone();
    config.must_be_realtime = args.controller.realtime.strict;
    if args.controller.realtime.strict || args.controller.realtime.must_fit {
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
            mark: match args.controller.realtime.scope_mark {
                ScopeMarkName::Tick => Mark::Tick,
                ScopeMarkName::Force => Mark::Force,
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
        if args.with_parent.is_some() {
            say::answer(REFUSED);
        }
        return Ok(ExitCode::from(DOES_NOT_FIT));
    }
    let summary = outcome?;
    if args.json {
        document::CONTROLLER.line(&summary)?;
    } else {
        say::note(format_args!(
            "{} ticks, {} missed, {} allocations, {} page faults{}",
            summary.ticks,
            summary.missed_periods,
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
