//! Conformance checks of a tracker that speaks the bird protocol.

use std::path::Path;
use std::time::Instant;

use rt_core::port::{Polled, Tracker};

use super::watch::{Arrivals, open, silent_after_close, unplugged, watch};
use super::{Options, Report};
use crate::HardwareError;
use crate::bird::{BAUD, BirdSetup, BirdTracker};

/// Fewest poses per second for a camera that follows the hand.
const RATE_MIN_HZ: f32 = 40.0;

/// Tests the tracker on the serial line `path`.
pub fn tracker(path: &Path, options: &mut Options<'_>) -> Report {
    let attempt = || BirdTracker::open(path, BirdSetup::default());
    tested(&attempt, options, &mut |report| {
        silent_after_close(report, path, BAUD);
    })
}

/// Tests a trakSTAR on the USB: the first one (`usb`) or the one with this serial number.
pub fn trakstar(name: &Path, options: &mut Options<'_>) -> Report {
    tracker_by(
        &|| BirdTracker::open_usb(name, BirdSetup::default()),
        options,
    )
}

/// Tests a tracker opened by `attempt`.
pub fn tracker_by(
    attempt: &dyn Fn() -> Result<BirdTracker, HardwareError>,
    options: &mut Options<'_>,
) -> Report {
    tested(attempt, options, &mut |report| {
        report.skip("close", "packets come only when they are asked for");
    })
}

fn tested(
    attempt: &dyn Fn() -> Result<BirdTracker, HardwareError>,
    options: &mut Options<'_>,
    closed: &mut dyn FnMut(&mut Report),
) -> Report {
    let mut report = Report::new("tracker");
    let Some(mut tracker) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    let full_m = tracker.setup().scale.full_m();
    let mut arrivals = Arrivals::default();
    let mut farthest_m = 0.0f32;
    let mut finite = true;
    let start = Instant::now();
    let host = watch(options.watch, |now_ns| {
        if let Polled::Fresh(sample) = tracker.poll(now_ns) {
            arrivals.add(now_ns);
            let pose = sample.tracker_from_sensor;
            farthest_m = farthest_m.max(pose.translation.vector.amax());
            finite &= pose.translation.vector.iter().all(|part| part.is_finite())
                && (pose.rotation.norm() - 1.0).abs() < 1e-3;
        }
    });
    let hz = arrivals.count() as f32 / start.elapsed().as_secs_f32();
    let counters = tracker.counters();
    report.judge_time(
        "rate",
        hz >= RATE_MIN_HZ,
        format!("{hz:.0} poses/s, allowed are {RATE_MIN_HZ:.0} and more"),
        host,
    );
    report.judge(
        "intervals",
        arrivals.count() > 1,
        format!("between fresh poses {}", arrivals.intervals()),
    );
    let records = counters.frames + counters.bad_frames;
    let share = counters.bad_frames as f32 / records.max(1) as f32;
    report.judge_time(
        "records",
        share < 0.02,
        format!(
            "{} bad of {records} records, allowed is 2 %",
            counters.bad_frames
        ),
        host,
    );
    let words = match finite {
        true => "every pose is finite",
        false => "a pose is not finite, or its quaternion is not of unit length",
    };
    report.judge("finite", finite, words.into());
    report.judge(
        "range",
        farthest_m < 0.99 * full_m,
        format!("farthest {farthest_m:.3} m along an axis, the scale ends at {full_m:.3} m"),
    );
    drop(tracker);
    closed(&mut report);
    if let Some(mut tracker) = open(&mut report, "reopen", attempt) {
        unplugged(&mut report, options, |now_ns| tracker.poll(now_ns));
    }
    report
}
