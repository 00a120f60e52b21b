//! Tests in which a person moves the handle: axes, scale, and the sign of the velocity.

use rt_core::math::Vec3;

use super::bench::{Bench, EndReason, HandleSample};
use super::{Direction, Step};
use crate::conformance::{Motion, Report};

/// Number of moves.
pub const COUNT: usize = 3;
/// Moves, with the names of their checks.
const MOVES: [(Direction, &str); COUNT] = [
    (Direction::Right, "move right"),
    (Direction::Up, "move up"),
    (Direction::Towards, "move towards"),
];
/// Least share of a movement that must lie along its axis. A person who moves to the right deviates
/// from the axis by 35° at most.
const ALONG_MIN: f32 = 0.8;
/// Allowed length of a move as a share of the requested length. The range is wide, because people
/// measure with a ruler.
const SCALE: core::ops::RangeInclusive<f32> = 0.7..=1.4;
/// Length below which a movement may be reported as too small, m. It must also be less than 1/500
/// of the requested length. Its direction is then not judged.
const DISTANCE_MIN_M: f32 = 0.5e-3;
/// Number of samples whose mean is the place at the beginning or the end of a move.
const PLACE_SAMPLES: usize = 50;

/// Judges the moves in three directions, and the velocity during the moves.
pub(super) fn test(
    bench: &mut Bench<'_>,
    report: &mut Report,
    way_m: f32,
) -> Result<(), EndReason> {
    let mut motion = Motion::default();
    let mut says_velocity = false;
    for (direction, name) in MOVES {
        let mut samples: Vec<HandleSample> = Vec::new();
        let step = Step::Move { direction, way_m };
        bench.until_done(&step, Vec3::zeros(), |seen| samples.push(seen))?;
        for pair in samples.windows(2) {
            if let (Some(reported_m_s), [before, now]) = (pair[1].reported_m_s, pair) {
                says_velocity = true;
                motion.take(now.at_m, reported_m_s, passed_s(before, now));
            }
        }
        motion.pause();
        let (good, words) = judged(direction, way_m, &displacement(&samples));
        report.judge(name, good, words);
    }
    if !says_velocity {
        report.skip("velocity", "the device measures none");
    } else if let Some((good, words)) = motion.judged() {
        report.judge("velocity", good, words);
    } else {
        report.mark_not_judged("velocity", "the positions hardly moved");
    }
    Ok(())
}

/// Time between two samples, s: by the device's clock, if it has one. Arrivals jitter.
fn passed_s(before: &HandleSample, now: &HandleSample) -> f32 {
    match (before.device_time_us, now.device_time_us) {
        (Some(before_us), Some(now_us)) => now_us.wrapping_sub(before_us) as f32 * 1.0e-6,
        _ => now.at_ns.saturating_sub(before.at_ns) as f32 * 1.0e-9,
    }
}

/// Vector from the beginning of a move to its end, m.
fn displacement(samples: &[HandleSample]) -> Vec3 {
    let place = |some: &[HandleSample]| {
        let sum: Vec3 = some.iter().map(|it| it.at_m).sum();
        sum / some.len().max(1) as f32
    };
    let count = PLACE_SAMPLES.min(samples.len() / 2);
    let from = place(samples.get(..count).unwrap_or(&[]));
    let to = place(samples.get(samples.len() - count..).unwrap_or(&[]));
    to - from
}

fn judged(asked: Direction, asked_m: f32, moved_m: &Vec3) -> (bool, String) {
    let (is, along) = Direction::nearest(moved_m);
    let length_m = moved_m.norm();
    let times = asked_m / length_m.max(1.0e-9);
    let [x, y, z] = [moved_m.x, moved_m.y, moved_m.z].map(|part| part * 1e3);
    let measured = format!(
        "the device reports ({x:.2}, {y:.2}, {z:.2}) mm for {:.0} mm",
        asked_m * 1e3
    );
    if length_m < DISTANCE_MIN_M && times > 500.0 {
        let words = format!(
            "{measured}: about {times:.0} times too little. Positions are sent in steps of 0.1 µm"
        );
        return (false, words);
    }
    if is != asked || along < ALONG_MIN {
        let words = if is.vector() == -asked.vector() {
            "the axis points the wrong way".to_owned()
        } else if along < ALONG_MIN {
            "the reported move is oblique; is the base frame turned?".to_owned()
        } else {
            format!("axes are exchanged: this is {}", is.words())
        };
        return (false, format!("{measured} {}: {words}", asked.words()));
    }
    if !SCALE.contains(&(length_m / asked_m)) {
        let words = format!(
            "{measured}: {:.2} of the distance, allowed is 0.7 to 1.4. Is the unit right?",
            length_m / asked_m
        );
        return (false, words);
    }
    (true, format!("{measured} {}", asked.words()))
}
