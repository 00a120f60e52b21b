//! Remarks about a run while it is measured: realtime, memory, progress.

use jitter::tally::Tally;
use jitter::{Report, kernel};
use shared_mem::message::TimingBatch;

use crate::say;

/// Time after which the program has done everything once, including drawing, s. From then on, its
/// memory should not grow.
const WARM_UP_S: f64 = 60.0;

/// Notes the memory of this program after its warm-up, and now.
pub(super) fn note_memory(report: &mut Report) {
    if let Some(now) = kernel::resident_kib() {
        let [first, last] = report.about.memory_kib.get_or_insert([now; 2]);
        if report.about.seconds < WARM_UP_S {
            *first = now;
        }
        *last = now;
    }
}

/// Notes if the run is realtime so far, and otherwise what the tick lacks.
pub(super) fn note_standing(tally: &Tally, report: &mut Report) {
    let Some(bits) = tally.realtime_bits else {
        return;
    };
    let all = [
        (TimingBatch::FIFO, "the tick lacked SCHED_FIFO"),
        (TimingBatch::LOCKED, "the tick lacked locked memory"),
        (TimingBatch::PINNED, "the tick lacked a core of its own"),
    ];
    report.about.realtime = all.iter().all(|(bit, _)| bits & bit != 0);
    for (bit, lacks) in all {
        if bits & bit == 0 && !report.about.notes.iter().any(|note| note == lacks) {
            report.about.notes.push(lacks.to_owned());
        }
    }
}

pub(super) fn progress(report: &mut Report, total_s: f64) {
    let seconds = report.about.seconds;
    let not = if report.about.realtime || seconds <= 0.0 {
        ""
    } else {
        " NOT REALTIME"
    };
    let wake = report.times("wake_latency_ns").quantiles();
    let us = |ns: u64| ns as f64 / 1e3;
    say::note(format_args!(
        "jitter: {seconds:.0} of {total_s:.0} s, wake-up p50 {:.1} p99 {:.1} max {:.1} µs, {:.1} missed \
         in a million{not}",
        us(wake.p50),
        us(wake.p99),
        us(wake.max),
        report.misses_per_million(),
    ));
}
