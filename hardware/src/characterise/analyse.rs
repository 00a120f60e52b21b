//! Computes the parameters of an axis, their errors, and the curves for charts from the records of
//! the axis.

use super::along::{Axis, Estimate, Trace};
use super::bench::TickRecord;
use super::curve::friction_curve;
use super::excite::{Push, RoughEstimate};
use super::fit::{Fit, fit, refine, with_best_start};
use super::friction::BreakAway;
use super::model::{AxisRecord, COUNT, Model, Window};

/// Damping with which the fit begins, N s/m.
const GUESS_N_S_M: f64 = 0.1;
/// Parts of a chirp that charts show: first and last time, s.
const SHOWN_S: [[f64; 2]; 2] = [[0.2, 1.0], [1.6, 1.8]];

/// One repetition: a chirp and two pushes.
#[derive(Debug, Clone)]
pub(super) struct Repetition {
    axis_records: Vec<AxisRecord>,
    /// Times at which the pushes ended, s.
    released_s: Vec<f64>,
}

impl Repetition {
    pub(super) fn new(chirp: &[TickRecord], pushes: &[Push], axis: usize) -> Self {
        let records = [chirp].into_iter();
        let records = records.chain(pushes.iter().map(|push| push.steps.as_slice()));
        Self {
            axis_records: records.map(|steps| AxisRecord::new(steps, axis)).collect(),
            released_s: pushes.iter().map(|push| push.released_s).collect(),
        }
    }

    /// Records of the chirp and the pushes.
    pub(super) fn axis_records(&self) -> &[AxisRecord] {
        &self.axis_records
    }
}

/// Parameters of an axis. `None` if the handle moved too little.
pub(super) fn axis_of(
    rough: &RoughEstimate,
    break_aways: &[[BreakAway; 2]],
    repetitions: &[Repetition],
) -> Option<Axis> {
    let axis_records: Vec<AxisRecord> = repetitions
        .iter()
        .flat_map(|it| it.axis_records.clone())
        .collect();
    let middle = |[up, down]: &[BreakAway; 2]| 0.5 * (up.force_n + down.force_n);
    let half = |[up, down]: &[BreakAway; 2]| 0.5 * (up.force_n - down.force_n);
    let carries_n = spread(&break_aways.iter().map(middle).collect::<Vec<_>>());
    let guess = Model {
        mass_kg: rough.mass_kg,
        damping_n_s_m: GUESS_N_S_M,
        friction_n: rough.friction_n,
        carries_n: carries_n.value,
        delay_s: 0.0,
    };
    let all = fit(&axis_records, guess)?;
    let single: Vec<[f64; COUNT]> = repetitions
        .iter()
        .filter_map(|it| refine(&it.axis_records, all.model))
        .map(|fit| fit.model.parameters())
        .collect();
    let values = all.model.parameters();
    let estimate = |at: usize| Estimate {
        value: values[at],
        error: all.errors[at]
            .max(spread(&single.iter().map(|it| it[at]).collect::<Vec<_>>()).error),
    };
    let chirp = axis_records.first()?;
    Some(Axis {
        mass_kg: estimate(0),
        damping_n_s_m: estimate(1),
        friction_n: estimate(2),
        break_away_n: spread(&break_aways.iter().map(half).collect::<Vec<_>>()),
        carries_n: estimate(3),
        delay_s: estimate(4),
        rms_m: all.rms_m,
        friction_curve: friction_curve(&axis_records, &all.model),
        chirp: SHOWN_S.map(|shown_s| shown(&all, chirp, shown_s)),
        run_out: run_out(&all.model, repetitions).unwrap_or_default(),
    })
}

/// Mean of the values and its standard error, which follows from their spread.
fn spread(values: &[f64]) -> Estimate {
    let count = values.len().max(1) as f64;
    let value = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|it| (it - value).powi(2)).sum();
    let error = (squares / (count - 1.0).max(1.0) / count).sqrt();
    Estimate { value, error }
}

/// The part of the first record between two times after its start.
fn shown(fit: &Fit, axis_record: &AxisRecord, [from_s, to_s]: [f64; 2]) -> Trace {
    let mut trace = Trace::default();
    let mut positions_m = Vec::new();
    let Some((begun_s, _)) = axis_record.samples.first() else {
        return trace;
    };
    for (at, window) in &fit.windows {
        let samples = window.of(axis_record);
        let start_s = samples.first().map_or(f64::MAX, |it| it.0 - begun_s);
        if *at != 0 || !(from_s..to_s).contains(&start_s) {
            continue;
        }
        fit.model.run(axis_record, window, &mut positions_m);
        append(&mut trace, samples, &positions_m, *begun_s);
    }
    trace
}

/// The first run-out as measured, and as computed by the model from the same position and speed.
fn run_out(model: &Model, repetitions: &[Repetition]) -> Option<Trace> {
    let first = repetitions.first()?;
    let (axis_record, released_s) = (first.axis_records.get(1)?, *first.released_s.first()?);
    let window = with_best_start(axis_record, Window::since(axis_record, released_s)?, model);
    let mut positions_m = Vec::new();
    model.run(axis_record, &window, &mut positions_m);
    let mut trace = Trace::default();
    append(&mut trace, window.of(axis_record), &positions_m, released_s);
    Some(trace)
}

fn append(trace: &mut Trace, samples: &[(f64, f64)], fitted_m: &[f64], begun_s: f64) {
    trace.at_s.extend(samples.iter().map(|it| it.0 - begun_s));
    trace.measured_m.extend(samples.iter().map(|it| it.1));
    trace.fitted_m.extend(fitted_m);
}
