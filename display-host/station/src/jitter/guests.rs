//! Programs that take turns with the station in a comparison.

use std::sync::atomic::AtomicBool;

use assess::Task;
use clap::ValueEnum as _;
use jitter::baselines::{self, Terms};
use jitter::misses::Round;
use jitter::{Baseline, Report, kernel, timerlat};

use super::args::JitterArgs;
use crate::problem::Problem;

/// Adds `rtla timerlat` to a comparison if this machine has it. Notes what is missing, and the
/// scripted surgeon.
pub(super) fn with_timerlat(args: &JitterArgs, notes: &mut Vec<String>) -> JitterArgs {
    let mut args = args.clone();
    if !args.compare.is_empty() && !args.compare.contains(&Baseline::Timerlat) {
        match timerlat::check() {
            Ok(()) => args.compare.push(Baseline::Timerlat),
            Err(missing) => notes.push(missing),
        }
    }
    if let Some(hand) = args.hand {
        let task = args.task.unwrap_or(Task::Full);
        let hand = hand.to_possible_value();
        let hand = hand.map_or_else(String::new, |value| value.get_name().to_owned());
        let task = task.name();
        notes.push(format!(
            "the scripted surgeon '{hand}' worked the task '{task}'"
        ));
    }
    args
}

/// Runs one turn of a program and adds its figures to the report.
pub(super) fn baseline_turn(
    baseline: Baseline,
    terms: Terms<'_>,
    seconds: f64,
    round: u32,
    stop: &AtomicBool,
    report: &mut Report,
) -> Result<(), Problem> {
    let stolen_before_ms = kernel::stolen_ms(terms.core);
    if let Some(turn) = baselines::turn(baseline, terms, seconds, stop)? {
        let stolen_ms = kernel::stolen_ms(terms.core).zip(stolen_before_ms);
        let stolen_ms = stolen_ms.map(|(now, then)| now.saturating_sub(then));
        note_turn(report, baseline, round, &turn, stolen_ms);
    }
    Ok(())
}

fn note_turn(
    report: &mut Report,
    baseline: Baseline,
    round: u32,
    turn: &baselines::Turn,
    stolen_ms: Option<u64>,
) {
    let name = baseline.name();
    let q = turn.wake_latency.quantiles();
    report
        .times(&format!("{name}.wake_latency_ns"))
        .add(&turn.wake_latency);
    if let Some(missed) = turn.missed {
        report.count(&format!("{name}.deadline_misses"), missed.periods());
        report.count(&format!("{name}.ticks"), q.count);
    }
    if turn.burnt.count() > 0 {
        report.times(&format!("{name}.tick_ns")).add(&turn.burnt);
    }
    if turn.realtime == Some(false) {
        let note = format!("{name} did not run realtime");
        if !report.about.notes.contains(&note) {
            report.about.notes.push(note);
        }
    }
    report.rounds.push(Round {
        round,
        program: name.to_owned(),
        p50: q.p50,
        p99: q.p99,
        max: q.max,
        missed: turn.missed,
        stolen_ms,
    });
}
