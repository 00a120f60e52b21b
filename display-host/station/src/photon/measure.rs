//! Measures the delay of light at one place of the screen after the other, while the window draws.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use display_host::patch::{By, Patch, Place};
use jitter::photon::{Arrived, Change, Pairs, pair};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use shared_mem::inputs::{InputBatch, InputRecord};
use shared_mem::message::PoseMsg;
use shared_mem::service::{Station, Tap};

use super::sensor::Eye;
use crate::problem::Problem;
use crate::say;

/// Interval between two looks at the services.
const LOOK: Duration = Duration::from_millis(2);
/// Number of latest changes of the square that decide if the sensor sees it.
const LATEST: usize = 6;
/// A place is measured once the sensor has seen this many of the [`LATEST`] changes.
const SEEN_FIRST: usize = 3;
/// Time without measurement after each change of place or cause. Pictures on their way to the
/// screen still show the square as before.
const SETTLE: Duration = Duration::from_millis(1000);
/// The measurement fails after this time without inputs from the controller.
const SILENCE: Duration = Duration::from_secs(20);

/// Result for one place and one cause of changes: a row of the report.
pub(super) struct Row {
    pub(super) place: Place,
    pub(super) by: By,
    pub(super) pairs: Pairs,
}

/// A measurement under way.
pub(super) struct Measure<'a> {
    pub(super) station: &'a Station,
    pub(super) patch: &'a Patch,
    pub(super) eye: &'a mut Eye,
    pub(super) places: &'a [Place],
    /// Measuring time of each place: half by the tick, half by motion.
    pub(super) time: Duration,
    /// Longest time from a change to its light, ns.
    pub(super) longest_ns: u64,
    /// Longest wait at each place until the sensor sees the square.
    pub(super) patience: Duration,
    pub(super) stop: &'a AtomicBool,
}

/// Changes of the square since the last change of place or cause, at four stages of their way to
/// the sensor.
#[derive(Default)]
struct Course {
    /// Changes that the inputs of ticks asked for.
    asked: Vec<Change>,
    /// Changes in pictures that the display handed to the driver.
    handed: Vec<Change>,
    /// Changes in pictures that the window system presented.
    arrived: Vec<Arrived>,
    /// Changes that the sensor saw.
    light: Vec<Change>,
    /// True if the last inputs asked for a bright square.
    was_bright: Option<bool>,
}

impl Measure<'_> {
    /// Measures all places. Returns the rows, and false if the measurement was stopped before its
    /// end.
    pub(super) fn run(mut self) -> Result<(Vec<Row>, bool), Problem> {
        let tap = Tap::open(self.station)?;
        let mut rows = Vec::new();
        let places = self.places;
        for &place in places {
            if !self.wait_for_sensor(&tap, place)? {
                return Ok((rows, false));
            }
            for by in [By::Tick, By::Motion] {
                self.patch.set(place, by);
                say::note(format_args!(
                    "photon: {}, {}: {:.0} s",
                    place.name(),
                    match by {
                        By::Tick => "by the tick",
                        By::Motion => "by motion; move the handle back and forth by some cm",
                    },
                    self.time.as_secs_f64() / 2.0
                ));
                self.settle(&tap, by)?;
                let course = self.watch(&tap, by, self.time / 2, |_| false)?;
                rows.push(Row {
                    place,
                    by,
                    pairs: course.pairs(self.longest_ns),
                });
                if self.stop.load(Ordering::Relaxed) {
                    return Ok((rows, false));
                }
            }
        }
        Ok((rows, true))
    }

    /// Waits until the sensor sees the square in its place. Returns false if the measurement was
    /// stopped before.
    fn wait_for_sensor(&mut self, tap: &Tap, place: Place) -> Result<bool, Problem> {
        self.patch.set(place, By::Tick);
        say::note(format_args!(
            "photon: hold the sensor on the square that blinks at the left edge: {}",
            place.name()
        ));
        self.settle(tap, By::Tick)?;
        let patience = self.patience;
        let longest_ns = self.longest_ns;
        let is_seen = |course: &Course| {
            let latest = course.asked.len().saturating_sub(LATEST);
            let asked = course.asked.get(latest..).unwrap_or_default();
            let pairs = pair(asked, &[], &[], &course.light, longest_ns);
            pairs.to_light_ns.len() >= SEEN_FIRST
        };
        let course = self.watch(tap, By::Tick, patience, is_seen)?;
        if is_seen(&course) {
            return Ok(true);
        }
        if self.stop.load(Ordering::Relaxed) {
            return Ok(false);
        }
        Err(format!(
            "the sensor did not see the square ({}): it reported {} changes of light in {:.0} s. In this time \
             the square had to change {} times, and pictures with {} of these changes were handed to the \
             screen. Put the sensor on the square, bring the window to the front, and make sure that the \
             sensor switches fully; or try `--place {}` alone",
            place.name(),
            course.light.len(),
            patience.as_secs_f64(),
            course.asked.len(),
            course.handed.len(),
            place.name(),
        )
        .into())
    }

    /// Waits until the screen shows the new setting, and drops the changes seen until then.
    fn settle(&mut self, tap: &Tap, by: By) -> Result<(), Problem> {
        self.watch(tap, by, SETTLE, |_| false).map(drop)
    }

    /// Collects changes for `time`, and their light for `longest_ns` longer. Ends early once
    /// `is_enough` is true.
    fn watch(
        &mut self,
        tap: &Tap,
        by: By,
        time: Duration,
        is_enough: impl Fn(&Course) -> bool,
    ) -> Result<Course, Problem> {
        let mut course = Course::default();
        let begun = Instant::now();
        let light_after = Duration::from_nanos(self.longest_ns);
        let mut heard = begun;
        let mut seen_before = 0;
        loop {
            let is_over = begun.elapsed() >= time;
            tap.drain_inputs(|batch| {
                heard = Instant::now();
                for record in batch.records().unwrap_or_default() {
                    self.eye.take_tick(record, &mut course.light);
                    if !is_over {
                        course.take(self.patch, by, batch, record);
                    }
                }
            });
            self.eye.take_edges(&mut course.light)?;
            let handed = self.patch.take_changed().into_iter();
            course.handed.extend(handed.map(|it| Change {
                at_ns: it.handed_ns,
                bright: it.bright,
            }));
            let arrived = self.patch.take_arrived().into_iter();
            course.arrived.extend(arrived.map(|it| Arrived {
                change: Change {
                    at_ns: it.at_ns,
                    bright: it.bright,
                },
                handed_ns: it.handed_ns,
            }));
            if heard.elapsed() > SILENCE {
                return Err(format!(
                    "no inputs came from the controller for {} s: does it still run?",
                    SILENCE.as_secs()
                )
                .into());
            }
            let seen = course.light.len();
            if self.stop.load(Ordering::Relaxed) || (seen != seen_before && is_enough(&course)) {
                return Ok(course);
            }
            seen_before = seen;
            if begun.elapsed() >= time + light_after {
                return Ok(course);
            }
            std::thread::sleep(LOOK);
        }
    }
}

impl Course {
    fn pairs(&self, longest_ns: u64) -> Pairs {
        pair(
            &self.asked,
            &self.handed,
            &self.arrived,
            &self.light,
            longest_ns,
        )
    }

    /// Takes the inputs of a tick. Adds a change if they ask for the other brightness than before.
    fn take(&mut self, patch: &Patch, by: By, batch: &InputBatch, record: &InputRecord) {
        if by == By::Motion && record.bits & InputRecord::DEVICE_FRESH == 0 {
            return;
        }
        let handle_m = placed(&batch.setup.world_from_device, &record.device_from_handle);
        let bright = patch.is_bright(by, record.tick, handle_m);
        if self
            .was_bright
            .replace(bright)
            .is_some_and(|was| was != bright)
        {
            let at_ns = match by {
                By::Tick => record.now_ns,
                By::Motion => record.device_at_ns,
            };
            self.asked.push(Change { at_ns, bright });
        }
    }
}

/// Position of `inner` in the outer frame, m. `inner` is relative to `outer`, and `outer` is given
/// in the outer frame.
fn placed(outer: &PoseMsg, inner: &PoseMsg) -> [f32; 3] {
    let [x, y, z, w] = outer.orientation;
    let turned = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let place = turned * Vector3::from(inner.position_m) + Vector3::from(outer.position_m);
    place.into()
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    /// A quarter turn about z, and a shift along y.
    const TURNED: PoseMsg = PoseMsg {
        position_m: [0.0, 0.101, 0.0],
        orientation: [
            0.0,
            0.0,
            core::f32::consts::FRAC_1_SQRT_2,
            core::f32::consts::FRAC_1_SQRT_2,
        ],
    };

    #[test]
    fn a_motion_counts_from_the_arrival_of_its_sample() {
        let mut batch: Box<InputBatch> = bytemuck::allocation::zeroed_box();
        batch.setup.world_from_device = TURNED;
        let (patch, mut course) = (Patch::new(false, 499), Course::default());
        let mut record = InputRecord::zeroed();
        for (x_m, fresh) in [(0.012, true), (0.03, false), (0.03, true), (0.031, true)] {
            record.tick += 1;
            record.now_ns += 1_000_000;
            record.device_at_ns = record.now_ns - 300_000;
            record.device_from_handle = PoseMsg {
                position_m: [x_m, 0.001, 0.001],
                ..PoseMsg::IDENTITY
            };
            record.bits = if fresh { InputRecord::DEVICE_FRESH } else { 0 };
            course.take(&patch, By::Motion, &batch, &record);
        }
        let at_ns: Vec<u64> = course.asked.iter().map(|it| it.at_ns).collect();
        assert_eq!(at_ns, [2_700_000]);
    }

    #[test]
    fn a_tick_counts_from_its_reading_of_the_devices() {
        let batch: Box<InputBatch> = bytemuck::allocation::zeroed_box();
        let (patch, mut course) = (Patch::new(false, 499), Course::default());
        let mut record = InputRecord::zeroed();
        for tick in 490..1010 {
            record.tick = tick;
            record.now_ns = tick * 1_000_000 + 70;
            course.take(&patch, By::Tick, &batch, &record);
        }
        let told: Vec<(u64, bool)> = course
            .asked
            .iter()
            .map(|it| (it.at_ns, it.bright))
            .collect();
        assert_eq!(told, [(499_000_070, true), (998_000_070, false)]);
    }

    #[test]
    fn a_position_is_turned_and_moved_into_the_world() {
        let inner = PoseMsg {
            position_m: [0.02, 0.0, 0.03],
            ..PoseMsg::IDENTITY
        };
        let place = placed(&TURNED, &inner);
        for (is, expected) in place.into_iter().zip([0.0, 0.121, 0.03]) {
            assert!((is - expected).abs() < 1e-6, "{place:?}");
        }
    }
}
