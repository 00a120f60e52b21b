//! Conformance checks of a pedal.

use std::path::Path;

use rt_core::port::{Pedal, PedalSample, Polled};

use super::watch::{Arrivals, open, silent_after_close, unplugged, until};
use super::{Options, Report};
use crate::HardwareError;
use crate::rig::{BAUD, RigPedal};

/// Tests the rig pedal at `path`. Nobody may press the pedal during the test.
pub fn pedal(path: &Path, options: &mut Options<'_>) -> Report {
    tested(&|| RigPedal::open(path), options, &mut |report| {
        silent_after_close(report, path, BAUD);
    })
}

/// Tests a pedal with any driver, opened by `attempt`: a USB pedal, or switches on a serial line's
/// control wires. Nobody may press the pedal during the test.
pub fn pedal_by<P: Pedal>(
    attempt: &dyn Fn() -> Result<P, HardwareError>,
    options: &mut Options<'_>,
) -> Report {
    tested(attempt, options, &mut |report| {
        report.skip("close", "this pedal has no protocol that closing must end");
    })
}

fn tested<P: Pedal>(
    attempt: &dyn Fn() -> Result<P, HardwareError>,
    options: &mut Options<'_>,
    closed: &mut dyn FnMut(&mut Report),
) -> Report {
    let mut report = Report::new("foot pedal");
    let Some(mut pedal) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    let mut arrivals = Arrivals::default();
    let mut pressed = false;
    until(options.watch, |now_ns| {
        if let Polled::Fresh(sample) = pedal.poll(now_ns) {
            arrivals.add(now_ns);
            pressed |= sample
                != PedalSample {
                    at_ns: sample.at_ns,
                    ..PedalSample::default()
                };
        }
        true
    });
    report.judge(
        "reports",
        arrivals.count() > 1,
        format!(
            "{} reports, between them {}",
            arrivals.count(),
            arrivals.intervals()
        ),
    );
    let words = match pressed {
        false => "no switch was closed",
        true => "a switch was closed: take the foot off the pedal and test again",
    };
    report.judge("released", !pressed, words.into());
    let counters = pedal.counters();
    let all = counters.frames + counters.bad_frames + counters.lost_frames;
    let spoilt = counters.bad_frames + counters.lost_frames;
    report.judge(
        "frames",
        spoilt as f32 <= 0.01 * all as f32,
        format!("{spoilt} of {all} bad or lost, allowed is 1 %"),
    );
    drop(pedal);
    closed(&mut report);
    if let Some(mut pedal) = open(&mut report, "reopen", attempt) {
        unplugged(&mut report, options, |now_ns| pedal.poll(now_ns));
    }
    report
}
