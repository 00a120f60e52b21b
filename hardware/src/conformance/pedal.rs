//! The checks of a pedal that speaks the rig protocol.

use std::path::Path;

use rt_core::port::{Pedal, PedalSample, Polled};

use super::watch::{Arrivals, open, silent_after_close, unplugged, until};
use super::{Options, Report};
use crate::rig::{BAUD, RigPedal};

/// Tests the pedal behind `path`. Nobody's foot should be on it.
pub fn pedal(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("foot pedal");
    let Some(mut pedal) = open(&mut report, "handshake", || RigPedal::open(path)) else {
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
        format!("{}: {}", arrivals.count(), arrivals.intervals()),
    );
    report.judge(
        "released",
        !pressed,
        "no switch is closed while nobody presses".into(),
    );
    let counters = pedal.counters();
    let all = counters.frames + counters.bad_frames + counters.lost_frames;
    let spoilt = counters.bad_frames + counters.lost_frames;
    report.judge(
        "frames",
        spoilt as f32 <= 0.01 * all as f32,
        format!("{spoilt} of {all} bad or lost, allowed is 1 %"),
    );
    drop(pedal);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut pedal) = open(&mut report, "reopen", || RigPedal::open(path)) {
        unplugged(&mut report, options, |now_ns| pedal.poll(now_ns));
    }
    report
}
