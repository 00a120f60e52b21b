//! The checks of a tracker that speaks the bird protocol.

use std::path::Path;
use std::time::Instant;

use rt_core::port::{Polled, Tracker};

use super::watch::{Arrivals, open, silent_after_close, unplugged, until};
use super::{Options, Report};
use crate::bird::wire::FULL_SCALE_M;
use crate::bird::{BAUD, BirdTracker};

/// A camera that follows the hand needs so many poses per second.
const RATE_MIN_HZ: f32 = 40.0;

/// Tests the tracker behind `path`.
pub fn tracker(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("tracker");
    let Some(mut tracker) = open(&mut report, "handshake", || BirdTracker::open(path)) else {
        return report;
    };
    let mut arrivals = Arrivals::default();
    let mut farthest_m = 0.0f32;
    let mut finite = true;
    let start = Instant::now();
    until(options.watch, |now_ns| {
        if let Polled::Fresh(sample) = tracker.poll(now_ns) {
            arrivals.add(now_ns);
            let pose = sample.tracker_from_sensor;
            farthest_m = farthest_m.max(pose.translation.vector.amax());
            finite &= pose.translation.vector.iter().all(|part| part.is_finite())
                && (pose.rotation.norm() - 1.0).abs() < 1e-3;
        }
        true
    });
    let hz = arrivals.count() as f32 / start.elapsed().as_secs_f32();
    let counters = tracker.counters();
    report.judge(
        "rate",
        hz >= RATE_MIN_HZ,
        format!("{hz:.0} poses/s, allowed are {RATE_MIN_HZ:.0} and more"),
    );
    report.judge(
        "intervals",
        arrivals.count() > 1,
        format!("between fresh poses {}", arrivals.intervals()),
    );
    let share = counters.bad_frames as f32 / (counters.frames + counters.bad_frames).max(1) as f32;
    report.judge(
        "records",
        share < 0.02,
        format!(
            "{} bad of {} records, allowed is 2 %",
            counters.bad_frames, counters.frames
        ),
    );
    report.judge("finite", finite, "every pose is finite".into());
    report.judge(
        "range",
        farthest_m < 0.99 * FULL_SCALE_M,
        format!("farthest {farthest_m:.3} m along an axis, the scale ends at {FULL_SCALE_M:.3} m"),
    );
    drop(tracker);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut tracker) = open(&mut report, "reopen", || BirdTracker::open(path)) {
        unplugged(&mut report, options, |now_ns| tracker.poll(now_ns));
    }
    report
}
