//! Break-away: a force along one axis grows slowly until the handle moves.

use super::along::AXES;
use super::bench::{Bench, OPENING, Vector};
use super::halt::Halt;
use super::hold::Hold;

/// Growth of the force, N/s: slow enough that a handle of 120 g moves by 0.1 mm before the force
/// has grown by 20 mN, fast enough that a device with 0.3 N of friction takes a second.
const GROWTH_N_S: f64 = 0.3;
/// Movement that counts as broken away, m.
const MOVED_M: f64 = 1.0e-3;
/// Least movement from which the moment of break-away is computed, m: two steps of most encoders.
const SEEN_M: f64 = 0.12e-3;
/// Movement in a wrong direction that ends the measurement, m.
const BACKWARDS_M: f64 = 1.5e-3;
/// Growth of the force above which the direction of the movement is checked, N.
const BACKWARDS_N: f64 = 0.03;
/// Cosine of the largest permitted angle between force and movement: 60°. Where inertia couples the
/// axes, the movement deviates by less.
const COSINE_MIN: f64 = 0.5;

/// Result of a break-away.
#[derive(Debug, Clone, Copy)]
pub(super) struct BreakAway {
    /// Force along the axis at which the handle began to move, N.
    pub(super) force_n: f64,
    /// Rough mass, kg, from the first millimetre of movement.
    pub(super) mass_kg: f64,
}

/// Time over which the force grows to its initial value, s.
const BEGIN_S: f64 = 0.05;

/// Lets a force along `axis` grow in the direction `sign` until the handle moves. The force begins
/// at `begin_n` beyond the force that carries the handle. `None` if the largest force did not move
/// the handle, or if the moment of break-away cannot be computed.
pub(super) fn break_away(
    bench: &mut Bench<'_>,
    hold: &Hold,
    axis: usize,
    sign: f64,
    begin_n: f64,
) -> Result<Option<BreakAway>, Halt> {
    let start = bench.now();
    let most_n = bench.limits().along_n(axis, &hold.carries_n);
    let mut now = start;
    // Times and distances of the movement along the axis.
    let mut axis_record: Vec<(f64, f64)> = Vec::new();
    loop {
        let passed_s = now.at_s - start.at_s;
        let ramp_n = begin_n * (passed_s / BEGIN_S).min(1.0) + GROWTH_N_S * passed_s;
        let along_n = hold.carries_n[axis] + sign * ramp_n;
        if along_n.abs() > most_n && along_n * sign > 0.0 {
            bench.tick(hold.carries_n)?;
            return Ok(None);
        }
        let mut force_n = hold.force_n(&now);
        force_n[axis] = along_n;
        now = bench.tick(force_n)?;
        let moved_m = now.at_m - start.at_m;
        judge_direction(bench, moved_m, axis, sign, ramp_n)?;
        let way_m = moved_m[axis] * sign;
        if way_m >= SEEN_M {
            axis_record.push((now.at_s, way_m));
        } else {
            axis_record.clear();
        }
        if way_m >= MOVED_M {
            let Some((at_s, mass_kg)) = onset(&axis_record) else {
                return Ok(None);
            };
            let ramp_n = begin_n + GROWTH_N_S * (at_s - start.at_s).max(0.0);
            let force_n = hold.carries_n[axis] + sign * ramp_n;
            return Ok(Some(BreakAway { force_n, mass_kg }));
        }
    }
}

fn judge_direction(
    bench: &mut Bench<'_>,
    moved_m: Vector,
    axis: usize,
    sign: f64,
    ramp_n: f64,
) -> Result<(), Halt> {
    let way_m = moved_m.norm();
    if way_m < BACKWARDS_M || ramp_n < BACKWARDS_N || moved_m[axis] * sign >= COSINE_MIN * way_m {
        return Ok(());
    }
    bench.cut();
    let mm = |part: usize| (moved_m[part] * 1e4).round() * 0.1;
    Err(Halt::Backwards {
        force_n: ramp_n,
        axis: AXES[axis][usize::from(sign < 0.0)],
        moved: match axis {
            OPENING => format!("{:.1} mm along its opening", mm(OPENING)),
            _ => format!("{:?} mm (x, y, z)", [0, 1, 2].map(mm)),
        },
    })
}

/// Time at which the movement began, s, and the mass, kg. A force that grows by `g` moves a mass
/// `m` by `g t³ / 6m`, so the cube root of the distance is a straight line in time.
fn onset(axis_record: &[(f64, f64)]) -> Option<(f64, f64)> {
    let count = axis_record.len() as f64;
    let mean_s = axis_record.iter().map(|it| it.0).sum::<f64>() / count;
    let mean = axis_record.iter().map(|it| it.1.cbrt()).sum::<f64>() / count;
    let (mut upper, mut lower) = (0.0, 0.0);
    for (at_s, way_m) in axis_record {
        upper += (at_s - mean_s) * (way_m.cbrt() - mean);
        lower += (at_s - mean_s).powi(2);
    }
    let slope = upper / lower;
    let is_sound = slope.is_finite() && slope > 0.0;
    is_sound.then(|| (mean_s - mean / slope, GROWTH_N_S / (6.0 * slope.powi(3))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_onset_of_motion_is_found_from_the_first_millimetre() {
        let mass_kg = 0.045;
        let way_m = |at_s: f64| GROWTH_N_S * (at_s - 1.0).powi(3) / (6.0 * mass_kg);
        let times = (0..1000).map(|ms| 1.0 + f64::from(ms) * 1e-3);
        let seen = |way_m: f64| (SEEN_M..MOVED_M).contains(&way_m);
        let step_m = 0.055e-3;
        let axis_record: Vec<_> = times
            .map(|at_s| (at_s, (way_m(at_s) / step_m).round() * step_m))
            .filter(|it| seen(it.1))
            .collect();
        let (at_s, found_kg) = onset(&axis_record).unwrap();
        assert!((at_s - 1.0).abs() < 0.006, "{at_s}");
        assert!((found_kg / mass_kg - 1.0).abs() < 0.2, "{found_kg}");
        assert!(onset(&axis_record[..1]).is_none());
    }
}
