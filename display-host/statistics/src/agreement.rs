//! Agreement of raters, and of the items of a sheet.

use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

/// An intraclass correlation with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// ICC(2,1): two-way random effects, absolute agreement, one rater.
    pub icc: f64,
    /// Lower and upper end of the interval.
    pub interval: [f64; 2],
}

/// Agreement of raters who all rated all subjects: a row for each subject, a column for each rater.
/// The coefficient is that of P. E. Shrout and J. L. Fleiss (Psychological Bulletin 86, 1979), the
/// interval that of K. O. McGraw and S. P. Wong (Psychological Methods 1, 1996).
///
/// `None` with fewer than three subjects or two raters, if a row has another length, or if nothing
/// varies.
#[must_use]
pub fn icc(rows: &[Vec<f64>]) -> Option<Agreement> {
    let (n, k) = (rows.len(), rows.first()?.len());
    if n < 3 || k < 2 || rows.iter().any(|row| row.len() != k) {
        return None;
    }
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), it| (sum + it, count + 1.0));
        sum / count
    };
    let (subjects, raters) = (n as f64, k as f64);
    let all = mean(&mut rows.iter().flatten().copied());
    let of_row = |row: &Vec<f64>| mean(&mut row.iter().copied());
    let of_rater: Vec<f64> = (0..k)
        .map(|it| mean(&mut rows.iter().filter_map(|row| row.get(it).copied())))
        .collect();
    let between: f64 = rows.iter().map(|row| (of_row(row) - all).powi(2)).sum();
    let between = between * raters / (subjects - 1.0);
    let columns: f64 = of_rater.iter().map(|it| (it - all).powi(2)).sum();
    let columns = columns * subjects / (raters - 1.0);
    let rest = rows.iter().flat_map(|row| {
        let own = of_row(row);
        let pairs = row.iter().zip(&of_rater);
        pairs.map(move |(value, rater)| (value - own - rater + all).powi(2))
    });
    let rest: f64 = rest.sum::<f64>() / ((subjects - 1.0) * (raters - 1.0));
    let whole = between + (raters - 1.0) * rest + raters * (columns - rest) / subjects;
    if whole <= 0.0 {
        return None;
    }
    let icc = (between - rest) / whole;
    if rest <= 0.0 && columns <= 0.0 {
        return Some(Agreement {
            icc,
            interval: [1.0; 2],
        });
    }
    // Satterthwaite's degrees of freedom of the denominator.
    let a = raters * icc / (subjects * (1.0 - icc));
    let b = 1.0 + raters * icc * (subjects - 1.0) / (subjects * (1.0 - icc));
    let freedom = (a * columns + b * rest).powi(2)
        / ((a * columns).powi(2) / (raters - 1.0)
            + (b * rest).powi(2) / ((subjects - 1.0) * (raters - 1.0)));
    let upper = |first: f64, second: f64| {
        let law = FisherSnedecor::new(first, second).ok()?;
        Some(law.inverse_cdf(0.975))
    };
    let spread = raters * columns + (raters * subjects - raters - subjects) * rest;
    let low = upper(subjects - 1.0, freedom)?;
    let high = upper(freedom, subjects - 1.0)?;
    let lower = subjects * (between - low * rest) / (low * spread + subjects * between);
    let higher = subjects * (high * between - rest) / (spread + subjects * high * between);
    Some(Agreement {
        icc,
        interval: [lower, higher],
    })
}

/// Internal consistency of a sheet's items: a row for each filled sheet, a column for each item
/// (L. J. Cronbach, Psychometrika 16, 1951).
///
/// `None` with fewer than three sheets or two items, if a row has another length, or if the sums do
/// not vary.
#[must_use]
pub fn cronbach_alpha(rows: &[Vec<f64>]) -> Option<f64> {
    let items = rows.first()?.len();
    if rows.len() < 3 || items < 2 || rows.iter().any(|row| row.len() != items) {
        return None;
    }
    let variance = |values: &[f64]| {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        values.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / (count - 1.0)
    };
    let sums: Vec<f64> = rows.iter().map(|row| row.iter().sum()).collect();
    let whole = variance(&sums);
    if whole <= 0.0 {
        return None;
    }
    let column = |item: usize| -> Vec<f64> {
        rows.iter()
            .filter_map(|row| row.get(item).copied())
            .collect()
    };
    let parts: f64 = (0..items).map(|item| variance(&column(item))).sum();
    let count = items as f64;
    Some(count / (count - 1.0) * (1.0 - parts / whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worked example of Shrout and Fleiss 1979, table 2: six subjects, four judges.
    const JUDGES: [[f64; 4]; 6] = [
        [9.0, 2.0, 5.0, 8.0],
        [6.0, 1.0, 3.0, 2.0],
        [8.0, 4.0, 6.0, 8.0],
        [7.0, 1.0, 2.0, 6.0],
        [10.0, 5.0, 6.0, 9.0],
        [6.0, 2.0, 4.0, 7.0],
    ];

    /// Shrout and Fleiss print 0.29. pingouin 0.7.0, `intraclass_corr(…)`, row ICC(A,1), prints
    /// 0.28976378 and [0.02, 0.76].
    #[test]
    fn icc_is_that_of_the_published_example() {
        let found = icc(&JUDGES.map(Vec::from)).unwrap();
        assert!((found.icc - 0.289_763_779_5).abs() < 1e-9, "{found:?}");
        assert!((found.interval[0] - 0.02).abs() < 5e-3, "{found:?}");
        assert!((found.interval[1] - 0.76).abs() < 5e-3, "{found:?}");
    }

    /// Against pingouin 0.7.0: `cronbach_alpha(DataFrame(JUDGES))`, 0.909315.
    #[test]
    fn alpha_is_that_of_pingouin() {
        let found = cronbach_alpha(&JUDGES.map(Vec::from)).unwrap();
        assert!((found - 0.9093155423770694).abs() < 1e-9, "{found}");
    }

    #[test]
    fn too_little_data_has_no_agreement() {
        assert_eq!(icc(&[vec![1.0, 2.0], vec![2.0, 3.0]]), None);
        assert_eq!(icc(&[vec![1.0], vec![2.0], vec![3.0]]), None);
        assert_eq!(icc(&[vec![1.0; 2], vec![1.0; 2], vec![1.0; 2]]), None);
        let same = icc(&[vec![1.0; 2], vec![2.0; 2], vec![3.0; 2]]).unwrap();
        assert!((same.icc - 1.0).abs() < 1e-12);
        assert_eq!(cronbach_alpha(&[vec![1.0, 2.0], vec![2.0, 3.0]]), None);
        assert_eq!(
            cronbach_alpha(&[vec![1.0; 2], vec![1.0; 2], vec![1.0; 2]]),
            None
        );
    }
}
