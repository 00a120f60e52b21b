//! One person's learning from session to session.
//!
//! An inverse curve, `a + b / session`, is fitted by least squares. Its asymptote `a` is the
//! plateau, and the learning rate is the number of sessions until the curve is within a tenth of
//! it: L. S. Feldman, J. Cao, A. Andalib, S. Fraser, G. M. Fried, Surgery 146 (2009) 381–386.

/// Least number of sessions for a curve: with fewer, two parameters fit almost anything.
const SESSIONS_MIN: usize = 5;

/// A fitted course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learning {
    /// Value that the curve tends to.
    pub plateau: f64,
    /// Value of the curve at the first session.
    pub first: f64,
    /// First session at which the curve is within a tenth of the plateau, at least 1; `None`: the
    /// plateau is zero.
    pub sessions: Option<f64>,
    /// Share of the variance that the curve explains, 0 to 1.
    pub explained: f64,
}

/// Fits the curve to the values of a person's sessions, oldest first. `None` with fewer than five
/// sessions, or if nothing varies.
#[must_use]
pub fn learning(values: &[f64]) -> Option<Learning> {
    if values.len() < SESSIONS_MIN || values.iter().any(|it| !it.is_finite()) {
        return None;
    }
    let count = values.len() as f64;
    let inverse = |index: usize| 1.0 / (index + 1) as f64;
    let mean_x = (0..values.len()).map(inverse).sum::<f64>() / count;
    let mean_y = values.iter().sum::<f64>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let (x, y) = (inverse(index) - mean_x, value - mean_y);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    if yy <= 0.0 {
        return None;
    }
    let slope = xy / xx;
    let plateau = mean_y - slope * mean_x;
    let sessions = (plateau.abs() > 0.0).then(|| (slope / (0.1 * plateau)).abs().max(1.0));
    Some(Learning {
        plateau,
        first: plateau + slope,
        sessions,
        explained: xy * xy / (xx * yy),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_curve_is_found() {
        let values: Vec<f64> = (1..9).map(|it| 60.0 + 90.0 / f64::from(it)).collect();
        let found = learning(&values).unwrap();
        assert!((found.plateau - 60.0).abs() < 1e-9 && (found.first - 150.0).abs() < 1e-9);
        assert!((found.sessions.unwrap() - 15.0).abs() < 1e-9);
        assert!((found.explained - 1.0).abs() < 1e-9);
    }

    /// Against NumPy 2.4.6: `polyfit(1 / arange(1, 8), [120, 95, 80, 84, 71, 70, 72], 1)` and the
    /// square of `corrcoef`.
    #[test]
    fn a_noisy_curve_is_that_of_numpy() {
        let found = learning(&[120.0, 95.0, 80.0, 84.0, 71.0, 70.0, 72.0]).unwrap();
        assert!(
            (found.plateau - 63.04927399147529).abs() < 1e-8,
            "{found:?}"
        );
        assert!((found.first - found.plateau - 58.10388839767005).abs() < 1e-8);
        assert!((found.explained - 0.959676586105067).abs() < 1e-9);
    }

    #[test]
    fn few_sessions_and_a_constant_have_no_curve() {
        assert_eq!(learning(&[5.0, 4.0, 3.0, 2.0]), None);
        assert_eq!(learning(&[5.0; 9]), None);
        assert_eq!(learning(&[5.0, 4.0, 3.0, 2.0, f64::NAN]), None);
    }
}
