//! Ratio of the force that the motors render to the commanded force, as a function of the commanded
//! force.
//!
//! Movements alone cannot show the size of a force: a handle of half the mass under half the force
//! moves in the same way. They can show whether the ratio is the same for large and small forces.
//! So the ratios are relative to the model that fits all of the movements.

use nalgebra::{Matrix3, Vector3};

use super::along::Axis;
use super::fit::with_best_start;
use super::model::{AxisRecord, Model, Window};

/// Number of groups into which the windows are sorted by their force.
const GROUPS: usize = 4;
/// Fewest windows of a group that counts.
const GROUP_MIN: usize = 2;
/// Least force of a window that is used, in multiples of the dry friction, and as a share of the
/// largest force. In windows with less force, the friction decides the movement.
const FORCE_MIN: [f64; 2] = [2.0, 0.2];
/// Change of the ratio for numerical derivatives.
const CHANGE: f64 = 1e-3;
/// Change of a window's initial speed for numerical derivatives, m/s.
const CHANGE_M_S: f64 = 1e-4;
/// Largest number of steps of a fit.
const STEPS: u32 = 12;
/// Relative decrease of the cost below which a fit ends.
const CONVERGED: f64 = 1e-4;

/// Pairs of commanded force, N, and ratio, from small to large forces. Empty if too little was
/// recorded.
pub(super) fn given_shares<'a>(
    axis_records: impl Iterator<Item = &'a AxisRecord>,
    axis: &Axis,
) -> Vec<[f64; 2]> {
    let model = Model {
        mass_kg: axis.mass_kg.value,
        damping_n_s_m: axis.damping_n_s_m.value,
        friction_n: axis.friction_n.value,
        carries_n: axis.carries_n.value,
        delay_s: axis.delay_s.value,
    };
    let windows = axis_records.flat_map(|axis_record| {
        let all = Window::all(axis_record).into_iter();
        all.map(move |window| {
            (
                strongest_n(axis_record, &window, &model),
                axis_record,
                window,
            )
        })
    });
    let windows: Vec<_> = windows.collect();
    let most_n = windows.iter().map(|it| it.0).fold(0.0, f64::max);
    let least_n = (FORCE_MIN[0] * model.friction_n).max(FORCE_MIN[1] * most_n);
    let shares = windows.into_iter().filter(|it| it.0 >= least_n);
    let shares: Vec<[f64; 2]> = shares
        .filter_map(|(asked_n, axis_record, window)| {
            Some([asked_n, share(axis_record, window, &model)?])
        })
        .collect();
    let forces = || shares.iter().map(|it| it[0]);
    let (weakest_n, strongest_n) = (
        forces().fold(f64::MAX, f64::min),
        forces().fold(0.0, f64::max),
    );
    let group = |it: &[f64; 2]| {
        let share = (it[0] - weakest_n) / (strongest_n - weakest_n).max(f64::MIN_POSITIVE);
        ((share * GROUPS as f64) as usize).min(GROUPS - 1)
    };
    let of_group = |at: usize| shares.iter().filter(move |it| group(it) == at);
    let full = (0..GROUPS).filter(|at| of_group(*at).count() >= GROUP_MIN);
    full.map(|at| [0, 1].map(|part| median(of_group(at).map(|it| it[part]))))
        .collect()
}

/// Largest force in a window, N, without the force that carries the handle.
fn strongest_n(axis_record: &AxisRecord, window: &Window, model: &Model) -> f64 {
    let samples = window.of(axis_record).iter();
    let forces =
        samples.map(|it| (axis_record.force_n(it.0 - model.delay_s) - model.carries_n).abs());
    forces.fold(0.0, f64::max)
}

/// Factor by which the commanded forces must be multiplied so that the model moves as the handle
/// did in a window.
fn share(axis_record: &AxisRecord, window: Window, model: &Model) -> Option<f64> {
    let mut window = with_best_start(axis_record, window, model);
    let mut share = 1.0;
    let samples = window.of(axis_record);
    let run = |window: &Window, share: f64| {
        let mut positions_m = Vec::new();
        model.run(
            &axis_record.scaled(model.carries_n, share),
            window,
            &mut positions_m,
        );
        positions_m
    };
    let cost = |positions_m: &[f64]| -> f64 {
        let pairs = samples.iter().zip(positions_m);
        pairs.map(|(seen, is)| (seen.1 - is).powi(2)).sum()
    };
    let mut base = run(&window, share);
    for _ in 0..STEPS {
        let mut faster = window;
        faster.speed_m_s += CHANGE_M_S;
        let (faster, stronger) = (run(&faster, share), run(&window, share + CHANGE));
        let (mut normal, mut gradient) = (Matrix3::<f64>::zeros(), Vector3::zeros());
        for (at, seen) in samples.iter().enumerate() {
            let row = Vector3::new(
                1.0,
                (faster[at] - base[at]) / CHANGE_M_S,
                (stronger[at] - base[at]) / CHANGE,
            );
            normal += row * row.transpose();
            gradient += row * (seen.1 - base[at]);
        }
        let mut step = normal.try_inverse()? * gradient;
        let mut gain = 0.0;
        // A step across a reversal may go too far, so shorter ones are tried.
        for _ in 0..4 {
            let mut tried = window;
            tried.from_m += step[0];
            tried.speed_m_s += step[1];
            let next = run(&tried, share + step[2]);
            if cost(&next) < cost(&base) {
                gain = 1.0 - cost(&next) / cost(&base);
                (window, share, base) = (tried, share + step[2], next);
                break;
            }
            step *= 0.4;
        }
        if gain < CONVERGED {
            break;
        }
    }
    share.is_finite().then_some(share)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
