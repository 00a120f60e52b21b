//! Fits a [`Model`] to measured positions by least squares. The positions are split into windows.
//! In each window the model starts anew from a position and a speed that are fitted as well
//! (multiple shooting). So the fit never differentiates positions, because their encoder steps
//! would cause noise of 50 m/s². Reversals need no special treatment.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::model::{AxisRecord, COUNT, DELAY_MAX_S, Model, Window};

/// Changes of the parameters for numerical derivatives: kg, N s/m, N, N, s.
const CHANGES: [f64; COUNT] = [2e-4, 2e-3, 2e-3, 1e-3, 2e-5];
/// Change of a window's initial speed for numerical derivatives, m/s.
const CHANGE_M_S: f64 = 1e-4;
/// Step of the search for the delay, s. The fit then changes the delay by at most half a step,
/// which is a tenth of a period at 50 Hz.
const SEARCH_S: f64 = 4e-3;
/// Largest number of windows that this search uses.
const SEARCH_WINDOWS: usize = 24;
/// Iterations at each delay of the search.
const SEARCH_ITERATIONS: u32 = 4;
/// Largest number of iterations of the fit after the search.
const ITERATIONS: u32 = 25;
/// Largest number of iterations for a window's initial position and speed.
const START_ITERATIONS: u32 = 6;
/// Ratio of a window's rms residual to the median of all windows above which the window is an
/// outlier.
const OUTLIER: f64 = 4.0;
/// Least diagonal element of the normal matrix, m² per squared unit of the parameter.
const DIAGONAL_MIN: f64 = 1e-9;
/// Relative decrease of the cost below which a fit ends.
const CONVERGED: f64 = 1e-4;

type Normal = SMatrix<f64, COUNT, COUNT>;
type Change = SVector<f64, COUNT>;

/// A fitted model.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) model: Model,
    /// Standard errors of the parameters, computed from the residual.
    pub(super) errors: [f64; COUNT],
    /// Root mean square of the residual, m.
    pub(super) rms_m: f64,
    /// Windows, each with the index of the record to which it belongs.
    pub(super) windows: Vec<(usize, Window)>,
}

/// Linearised problem. Each window's initial position and speed are eliminated.
struct Linear {
    cost: f64,
    normal: Normal,
    gradient: Change,
    samples: usize,
}

/// Fits a model to records, beginning from a guess. `None` if the handle moved too little.
pub(super) fn fit(axis_records: &[AxisRecord], guess: Model) -> Option<Fit> {
    let windows = all_windows(axis_records);
    let every = windows.len().div_ceil(SEARCH_WINDOWS).max(1);
    let few: Vec<_> = windows.iter().step_by(every).copied().collect();
    let mut best: Option<(f64, Model)> = None;
    for step in 0..=(DELAY_MAX_S / SEARCH_S).ceil() as u32 {
        let delay_s = f64::from(step) * SEARCH_S;
        let mut model = Model { delay_s, ..guess };
        let mut few = few.clone();
        let cost = descend(axis_records, &mut few, &mut model, SEARCH_ITERATIONS)?;
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, model));
        }
    }
    refine(axis_records, best?.1)
}

/// Fits a model to records from a good start.
pub(super) fn refine(axis_records: &[AxisRecord], start: Model) -> Option<Fit> {
    let mut windows = all_windows(axis_records);
    let mut model = start;
    descend(axis_records, &mut windows, &mut model, ITERATIONS)?;
    if drop_outliers(axis_records, &mut windows, &model) {
        descend(axis_records, &mut windows, &mut model, ITERATIONS)?;
    }
    let linear = linearise(axis_records, &windows, &model);
    let unknowns = COUNT + 2 * windows.len();
    let free = linear.samples.checked_sub(unknowns).filter(|it| *it > 0)?;
    let variance = linear.cost / free as f64;
    let inverse = linear.normal.try_inverse()?;
    Some(Fit {
        model,
        errors: std::array::from_fn(|at| (inverse[(at, at)].max(0.0) * variance).sqrt()),
        rms_m: (linear.cost / linear.samples as f64).sqrt(),
        windows,
    })
}

fn all_windows(axis_records: &[AxisRecord]) -> Vec<(usize, Window)> {
    let of = |(at, axis_record): (usize, &AxisRecord)| {
        Window::all(axis_record).into_iter().map(move |it| (at, it))
    };
    axis_records.iter().enumerate().flat_map(of).collect()
}

/// Descent by the method of Levenberg and Marquardt. Returns the cost; `None` without windows.
fn descend(
    axis_records: &[AxisRecord],
    windows: &mut [(usize, Window)],
    model: &mut Model,
    iterations: u32,
) -> Option<f64> {
    fit_all_starts(axis_records, windows, model);
    let mut linear = linearise(axis_records, windows, model);
    let mut lm_damping = 1e-3;
    for _ in 0..iterations {
        let mut normal = linear.normal;
        for at in 0..COUNT {
            // A parameter at its bound has no effect, and must not make the matrix singular.
            normal[(at, at)] = (normal[(at, at)] * (1.0 + lm_damping)).max(DIAGONAL_MIN);
        }
        let change = normal.try_inverse()? * linear.gradient;
        let parameters = model.parameters();
        let tried = Model::of(std::array::from_fn(|at| parameters[at] + change[at]));
        let mut tried_windows = windows.to_vec();
        fit_all_starts(axis_records, &mut tried_windows, &tried);
        let next = linearise(axis_records, &tried_windows, &tried);
        let gain = 1.0 - next.cost / linear.cost;
        if gain > 0.0 {
            (linear, *model) = (next, tried);
            windows.copy_from_slice(&tried_windows);
            lm_damping *= 0.2;
        } else {
            lm_damping *= 8.0;
        }
        if (0.0..CONVERGED).contains(&gain) || lm_damping > 1e8 {
            break;
        }
    }
    (linear.samples > 0).then_some(linear.cost)
}

/// Drops windows with a far larger residual than most: this computer or the device paused in them.
/// Returns true if any window was dropped.
fn drop_outliers(
    axis_records: &[AxisRecord],
    windows: &mut Vec<(usize, Window)>,
    model: &Model,
) -> bool {
    let mut run = Vec::new();
    let mut mean_m2 = |(at, window): &(usize, Window)| {
        let axis_record = &axis_records[*at];
        model.run(axis_record, window, &mut run);
        let seen = window.of(axis_record);
        let squares = seen.iter().zip(&run).map(|(s, m)| (s.1 - m).powi(2));
        squares.sum::<f64>() / seen.len() as f64
    };
    let all_m2: Vec<f64> = windows.iter().map(&mut mean_m2).collect();
    let mut sorted = all_m2.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let most_m2 = sorted
        .get(sorted.len() / 2)
        .map_or(0.0, |it| it * OUTLIER * OUTLIER);
    let before = windows.len();
    let mut of = all_m2.iter();
    windows.retain(|_| of.next().is_some_and(|it| *it <= most_m2));
    windows.len() < before
}

fn fit_all_starts(axis_records: &[AxisRecord], windows: &mut [(usize, Window)], model: &Model) {
    for (at, window) in windows {
        *window = with_best_start(&axis_records[*at], *window, model);
    }
}

/// The window with the initial position and speed that fit best.
pub(super) fn with_best_start(
    axis_record: &AxisRecord,
    mut window: Window,
    model: &Model,
) -> Window {
    let seen = window.of(axis_record);
    let cost = |run: &[f64]| {
        seen.iter()
            .zip(run)
            .map(|(s, m)| (s.1 - m).powi(2))
            .sum::<f64>()
    };
    let (mut base, mut faster) = (Vec::new(), Vec::new());
    model.run(axis_record, &window, &mut base);
    let mut least = cost(&base);
    for _ in 0..START_ITERATIONS {
        model.run(axis_record, &changed(&window, CHANGE_M_S), &mut faster);
        let mut normal = Matrix2::<f64>::zeros();
        let mut gradient = Vector2::zeros();
        for ((seen, base), faster) in seen.iter().zip(&base).zip(&faster) {
            let row = Vector2::new(1.0, (faster - base) / CHANGE_M_S);
            normal += row * row.transpose();
            gradient += row * (seen.1 - base);
        }
        let Some(inverse) = normal.try_inverse() else {
            break;
        };
        let mut step = inverse * gradient;
        let mut gain = 0.0;
        // A step across a reversal may go too far, so shorter ones are tried.
        for _ in 0..3 {
            let mut tried = window;
            tried.from_m += step[0];
            tried.speed_m_s += step[1];
            model.run(axis_record, &tried, &mut faster);
            let next = cost(&faster);
            if next < least {
                gain = 1.0 - next / least;
                (least, window) = (next, tried);
                std::mem::swap(&mut base, &mut faster);
                break;
            }
            step *= 0.3;
        }
        if gain < CONVERGED {
            break;
        }
    }
    window
}

/// The window with another initial speed.
fn changed(window: &Window, by_m_s: f64) -> Window {
    let mut changed = *window;
    changed.speed_m_s += by_m_s;
    changed
}

/// Residuals and their derivatives.
fn linearise(axis_records: &[AxisRecord], windows: &[(usize, Window)], model: &Model) -> Linear {
    let mut linear = Linear {
        cost: 0.0,
        normal: Normal::zeros(),
        gradient: Change::zeros(),
        samples: 0,
    };
    let parameters = model.parameters();
    let (mut base, mut faster) = (Vec::new(), Vec::new());
    let mut by: [Vec<f64>; COUNT] = std::array::from_fn(|_| Vec::new());
    for (at, window) in windows {
        let axis_record = &axis_records[*at];
        model.run(axis_record, window, &mut base);
        model.run(axis_record, &changed(window, CHANGE_M_S), &mut faster);
        for (part, run) in by.iter_mut().enumerate() {
            let mut changed = parameters;
            changed[part] += CHANGES[part];
            Model::of(changed).run(axis_record, window, run);
        }
        let mut normal = Normal::zeros();
        let mut gradient = Change::zeros();
        let mut own = Matrix2::<f64>::zeros();
        let mut own_gradient = Vector2::zeros();
        let mut coupling = SMatrix::<f64, 2, COUNT>::zeros();
        for (k, (_, seen_m)) in window.of(axis_record).iter().enumerate() {
            let residual = seen_m - base[k];
            let row = Change::from_fn(|part, _| (by[part][k] - base[k]) / CHANGES[part]);
            // Another initial position shifts the whole window, so its derivative is 1.
            let own_row = Vector2::new(1.0, (faster[k] - base[k]) / CHANGE_M_S);
            normal += row * row.transpose();
            gradient += row * residual;
            own += own_row * own_row.transpose();
            own_gradient += own_row * residual;
            coupling += own_row * row.transpose();
            linear.cost += residual * residual;
            linear.samples += 1;
        }
        let inverse = own.try_inverse().unwrap_or_else(Matrix2::zeros);
        linear.normal += normal - coupling.transpose() * inverse * coupling;
        linear.gradient += gradient - coupling.transpose() * inverse * own_gradient;
    }
    linear
}
