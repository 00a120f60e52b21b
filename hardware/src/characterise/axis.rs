//! The experiments along one axis, with nobody at the handle.

use super::along::Axis;
use super::analyse::{Repetition, axis_of};
use super::bench::{Bench, Vector};
use super::excite::{RoughEstimate, chirp, is_movable, push};
use super::friction::{BreakAway, break_away};
use super::halt::Halt;
use super::hold::Hold;

/// Records of one axis.
#[derive(Debug, Clone)]
pub(super) struct Recorded {
    rough: RoughEstimate,
    break_aways: Vec<[BreakAway; 2]>,
    pub(super) repetitions: Vec<Repetition>,
}

impl Recorded {
    /// Fits the model.
    pub(super) fn fitted(&self) -> Result<Axis, String> {
        let axis = axis_of(&self.rough, &self.break_aways, &self.repetitions);
        axis.ok_or_else(|| "the handle moved too little for a fit".to_owned())
    }
}

/// Runs all experiments along one axis. The inner error is the reason for which the axis cannot be
/// measured.
pub(super) fn one_axis(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    (axis, begin_n): (usize, f64),
    repetitions: u32,
) -> Result<Result<Recorded, String>, Halt> {
    let mut break_aways = Vec::new();
    for _ in 0..repetitions.max(2) {
        let Some(pair) = both_ways(bench, hold, goal_m, axis, begin_n)? else {
            return Ok(Err(format!(
                "{:.2} N do not move the handle: no motor acts along this axis, or its friction is higher",
                bench.limits().of(axis)
            )));
        };
        break_aways.push(pair);
    }
    let rough = rough_estimate(&break_aways);
    let middle_n = mean(&break_aways, |[up, down]| 0.5 * (up.force_n + down.force_n));
    hold.set_holding(axis, middle_n);
    if !is_movable(bench, hold, axis, &rough) {
        return Ok(Err(format!(
            "weight and friction leave too little of {:.2} N to move the handle well: allow more with --force",
            bench.limits().of(axis)
        )));
    }
    let mut records = Vec::new();
    for number in 0..repetitions.max(2) {
        let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
        let chirp = chirp(bench, hold, axis, &rough, sign)?;
        hold.settle(bench, goal_m)?;
        let there = push(bench, hold, axis, &rough, sign)?;
        hold.settle(bench, goal_m)?;
        let back = push(bench, hold, axis, &rough, -sign)?;
        hold.settle(bench, goal_m)?;
        let pushes = [there, back];
        records.push(Repetition::new(&chirp, &pushes, axis));
    }
    Ok(Ok(Recorded {
        rough,
        break_aways,
        repetitions: records,
    }))
}

/// Break-away in both directions. `None` if the largest force does not move the handle.
pub(super) fn both_ways(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    axis: usize,
    begin_n: f64,
) -> Result<Option<[BreakAway; 2]>, Halt> {
    let mut pair = [None; 2];
    for (found, sign) in pair.iter_mut().zip([1.0, -1.0]) {
        *found = break_away(bench, hold, axis, sign, begin_n)?;
        hold.settle(bench, goal_m)?;
    }
    Ok(match pair {
        [Some(up), Some(down)] => Some([up, down]),
        _ => None,
    })
}

fn rough_estimate(break_aways: &[[BreakAway; 2]]) -> RoughEstimate {
    RoughEstimate {
        mass_kg: mean(break_aways, |[up, down]| 0.5 * (up.mass_kg + down.mass_kg)),
        friction_n: mean(break_aways, |[up, down]| 0.5 * (up.force_n - down.force_n)).max(0.0),
    }
}

fn mean(break_aways: &[[BreakAway; 2]], of: fn(&[BreakAway; 2]) -> f64) -> f64 {
    break_aways.iter().map(of).sum::<f64>() / break_aways.len().max(1) as f64
}
