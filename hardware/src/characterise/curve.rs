//! Friction over speed, computed from the measurement: the force that remains after inertia and
//! weight.

use super::model::{AxisRecord, Model};

/// Number of samples on each side of a position used for speed and acceleration at the position.
/// With 10 samples, encoder steps of 0.055 mm cause an error of 10 mN on 45 g.
const SIDE: usize = 10;
/// Width of a bin of speeds, m/s.
const BIN_M_S: f64 = 0.02;
/// Fewest positions in a bin that becomes a point of the curve.
const BIN_MIN: usize = 5;
/// Number of sample intervals at each end over which the handle must move.
const END: usize = 5;
/// Least movement over these intervals, m.
const END_MIN_M: f64 = 0.06e-3;
/// Least speed over these intervals, as a share of the speed in the middle.
const END_SHARE: f64 = 0.25;
/// Largest gap between samples, s.
const GAP_S: f64 = 0.003;

/// Points of the curve: mean speed, m/s, and mean friction, N, of each bin.
pub(super) fn friction_curve(axis_records: &[AxisRecord], model: &Model) -> Vec<[f64; 2]> {
    let mut bins: std::collections::BTreeMap<i64, Vec<[f64; 2]>> = Default::default();
    for axis_record in axis_records {
        for around in axis_record.samples.windows(2 * SIDE + 1) {
            let Some([at_s, v_m_s, a_m_s2]) = motion(around) else {
                continue;
            };
            let half_s = 0.5 * (around[2 * SIDE].0 - around[0].0);
            if !moves_throughout(around, v_m_s) {
                continue;
            }
            let force_n = mean_force_n(axis_record, at_s - model.delay_s, half_s);
            let friction_n = force_n - model.carries_n - model.mass_kg * a_m_s2;
            let bin = (v_m_s / BIN_M_S).floor() as i64;
            bins.entry(bin).or_default().push([v_m_s, friction_n]);
        }
    }
    let full = bins.into_values().filter(|bin| bin.len() >= BIN_MIN);
    full.map(|bin| {
        let count = bin.len() as f64;
        [0, 1].map(|part| bin.iter().map(|it| it[part]).sum::<f64>() / count)
    })
    .collect()
}

/// True if the handle moves in the same direction at both ends. Near a stop or a reversal, friction
/// has no single value.
fn moves_throughout(around: &[(f64, f64)], v_m_s: f64) -> bool {
    let ends = [&around[..=END], &around[around.len() - 1 - END..]];
    ends.iter().all(|end| {
        let (from, to) = (end[0], end[END]);
        let way_m = (to.1 - from.1) * v_m_s.signum();
        way_m > END_MIN_M.max(END_SHARE * v_m_s.abs() * (to.0 - from.0))
    })
}

/// Time, speed and acceleration in the middle of the samples, from a parabola fitted by least
/// squares.
fn motion(around: &[(f64, f64)]) -> Option<[f64; 3]> {
    let middle = around.get(SIDE)?;
    let has_gap = around.windows(2).any(|pair| pair[1].0 - pair[0].0 > GAP_S);
    if has_gap {
        return None;
    }
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (at_s, at_m) in around {
        let t = at_s - middle.0;
        let row = nalgebra::Vector3::new(1.0, t, 0.5 * t * t);
        normal += row * row.transpose();
        right += row * (at_m - middle.1);
    }
    let found = normal.try_inverse()? * right;
    Some([middle.0, found[1], found[2]])
}

/// Mean force around a time, weighted in the same way as the parabola weights accelerations.
fn mean_force_n(axis_record: &AxisRecord, at_s: f64, half_s: f64) -> f64 {
    const PARTS: i32 = 40;
    let (mut sum_n, mut weights) = (0.0, 0.0);
    for part in -PARTS..=PARTS {
        let u = f64::from(part) / f64::from(PARTS);
        let weight = (1.0 - u * u).powi(2);
        sum_n += weight * axis_record.force_n(at_s + u * half_s);
        weights += weight;
    }
    sum_n / weights
}
