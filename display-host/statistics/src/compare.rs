//! Two groups compared: medians, effect size, and the test of Mann and Whitney.
//!
//! The test is exact, with ties, for up to [`EXACT_MAX`] values: all ways to draw the first group
//! from the ranks are counted, by the sum of their ranks. A tie has the mean of its ranks, so ranks
//! are counted doubled, as whole numbers (H. B. Mann, D. R. Whitney, Ann. Math. Stat. 18, 1947;
//! E. L. Lehmann, Nonparametrics, 1975, for ties). More values take the normal approximation with
//! Lehmann's correction for ties, and one for continuity.

use statrs::distribution::{ContinuousCDF as _, Normal};

/// Largest number of values in both groups for which the test is exact.
const EXACT_MAX: usize = 100;

/// Two groups compared.
#[derive(Debug, Clone, Copy)]
pub struct Compared {
    /// Number of values in each group.
    pub n: [usize; 2],
    /// Median of each group.
    pub medians: [f64; 2],
    /// Rank-biserial correlation, which is Cliff's delta: share of pairs in which the first group
    /// has more, minus that in which it has less. −1 and 1: the groups do not overlap.
    pub delta: f64,
    /// Two-sided probability of a rank sum that is at least as far off its mean, if there is no
    /// difference; NaN if a group is empty.
    pub p: f64,
}

/// Compares two groups. Values that are no numbers are left out.
#[must_use]
pub fn compare(groups: &[Vec<f64>; 2]) -> Compared {
    let groups = groups.each_ref().map(|group| {
        let finite = group.iter().copied().filter(|it| it.is_finite());
        finite.collect::<Vec<f64>>()
    });
    let [first, second] = &groups;
    let pairs = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| (a, b)));
    let sign = |(a, b): (&f64, &f64)| f64::from(i8::from(a > b) - i8::from(a < b));
    Compared {
        n: groups.each_ref().map(Vec::len),
        medians: groups.each_ref().map(|it| median(it)),
        delta: pairs.map(sign).sum::<f64>() / (first.len() * second.len()) as f64,
        p: mann_whitney(first, second),
    }
}

/// Median of the finite values; NaN without one.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// Quantile of the finite values, linear between two of them (type 7 of R. J. Hyndman and Y. Fan,
/// American Statistician 50, 1996: the usual one of R and NumPy); NaN without a value.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|it| it.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |index: usize| sorted.get(index).copied();
    let place = share.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64;
    let below = place.floor() as usize;
    let Some(low) = at(below) else {
        return f64::NAN;
    };
    let high = at(below + 1).unwrap_or(low);
    low + (high - low) * (place - place.floor())
}

/// Probabilities of several tests, each raised so that all hold together (S. Holm, Scandinavian
/// Journal of Statistics 6, 1979). Values that are no numbers are left as they are.
#[must_use]
pub fn holm(probabilities: &[f64]) -> Vec<f64> {
    let is_number = |it: &usize| probabilities.get(*it).is_some_and(|p| p.is_finite());
    let mut order: Vec<usize> = (0..probabilities.len()).filter(is_number).collect();
    order.sort_by(|a, b| f64::total_cmp(&probabilities[*a], &probabilities[*b]));
    let mut raised = probabilities.to_vec();
    let (mut least, count) = (0.0f64, order.len());
    for (rank, index) in order.into_iter().enumerate() {
        least = least
            .max(probabilities[index] * (count - rank) as f64)
            .min(1.0);
        raised[index] = least;
    }
    raised
}

/// Two-sided probability; NaN if a group is empty.
fn mann_whitney(first: &[f64], second: &[f64]) -> f64 {
    if first.is_empty() || second.is_empty() {
        return f64::NAN;
    }
    match first.len() + second.len() <= EXACT_MAX {
        true => exact(first, second),
        false => approximate(first, second),
    }
}

/// Probability by the normal distribution, with corrections for ties and continuity.
fn approximate(first: &[f64], second: &[f64]) -> f64 {
    let [n, m] = [first, second].map(|it| it.len() as f64);
    let mut all: Vec<f64> = first.iter().chain(second).copied().collect();
    all.sort_by(f64::total_cmp);
    let ties = all.chunk_by(|a, b| a.total_cmp(b).is_eq());
    let ties: f64 = ties
        .map(|it| (it.len() as f64).powi(3) - it.len() as f64)
        .sum();
    let pairs = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| (a, b)));
    let won =
        |(a, b): (&f64, &f64)| 0.5 * (f64::from(u8::from(a > b)) + f64::from(u8::from(a >= b)));
    let u: f64 = pairs.map(won).sum();
    let total = n + m;
    let sd = (n * m / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)))).sqrt();
    let off = ((u - 0.5 * n * m).abs() - 0.5).max(0.0);
    if sd <= 0.0 {
        return 1.0;
    }
    (2.0 * Normal::standard().sf(off / sd)).min(1.0)
}

/// Exact probability, by counting.
fn exact(first: &[f64], second: &[f64]) -> f64 {
    let all: Vec<f64> = first.iter().chain(second).copied().collect();
    let doubled = |value: &f64| {
        let less = all.iter().filter(|it| *it < value).count();
        let more = all.iter().filter(|it| *it > value).count();
        less + all.len() - more + 1
    };
    let ranks: Vec<usize> = all.iter().map(doubled).collect();
    // ways[k][s]: number of ways to draw k ranks with the sum s.
    let sum: usize = ranks.iter().sum();
    let mut ways = vec![vec![0.0; sum + 1]; first.len() + 1];
    ways[0][0] = 1.0;
    for rank in &ranks {
        for k in (1..=first.len()).rev() {
            for s in (*rank..=sum).rev() {
                ways[k][s] += ways[k - 1][s - rank];
            }
        }
    }
    // Distances from the mean, times the number of values, are whole numbers.
    let off = |s: usize| (s * all.len()).abs_diff(sum * first.len());
    let found = off(ranks.iter().take(first.len()).sum());
    let drawn = ways[first.len()].iter().enumerate();
    let (far, total) = drawn.fold((0.0, 0.0), |(far, total), (s, ways)| {
        let is_far = off(s) >= found;
        (far + if is_far { *ways } else { 0.0 }, total + ways)
    });
    far / total
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two groups without ties whose statistic U is as wanted.
    fn groups(sizes: [usize; 2], u: usize) -> [Vec<f64>; 2] {
        // Of the first group's values, in order, each has `below` values of the second under it.
        let mut below = vec![0; sizes[0]];
        let mut left = u;
        for place in below.iter_mut().rev() {
            *place = left.min(sizes[1]);
            left -= *place;
        }
        assert_eq!(left, 0);
        let own = |(i, below): (usize, &usize)| *below as f64 - 0.5 + 0.01 * i as f64;
        let first = below.iter().enumerate().map(own).collect();
        [first, (0..sizes[1]).map(|it| it as f64).collect()]
    }

    /// Greatest U that is significant at 0.05, two-sided, in the published tables (S. Siegel,
    /// Nonparametric Statistics, 1956, table K).
    #[test]
    fn critical_values_are_those_of_the_tables() {
        for (sizes, critical) in [
            ([3, 8], 2),
            ([4, 6], 2),
            ([5, 5], 2),
            ([6, 9], 10),
            ([8, 8], 13),
            ([10, 10], 23),
            ([9, 20], 48),
            ([15, 15], 64),
            ([20, 20], 127),
        ] {
            let p = |u| compare(&groups(sizes, u)).p;
            assert!(p(critical) <= 0.05, "{sizes:?}: {}", p(critical));
            assert!(p(critical + 1) > 0.05, "{sizes:?}: {}", p(critical + 1));
        }
    }

    #[test]
    fn small_cases_are_those_counted_by_hand() {
        let p = |first: &[f64], second: &[f64]| compare(&[first.to_vec(), second.to_vec()]).p;
        // Of 165 ways to draw three of eleven, one is this far off on each side.
        let above: Vec<f64> = (4..12).map(f64::from).collect();
        assert!((p(&[1.0, 2.0, 3.0], &above) - 2.0 / 165.0).abs() < 1e-12);
        // Ranks 1.5, 1.5, 3.5, 3.5, 5. Of the ten ways to draw two, one gives the least sum (3),
        // and two give the greatest (8.5).
        let sums = p(&[1.0, 1.0], &[2.0, 2.0, 3.0]);
        assert!((sums - 0.1).abs() < 1e-12, "{sums}");
        assert!((p(&[1.0], &[1.0]) - 1.0).abs() < 1e-12);
        assert!(p(&[], &[1.0]).is_nan());
    }

    #[test]
    fn delta_and_medians_are_those_of_the_values_that_are_numbers() {
        let found = compare(&[vec![1.0, f64::NAN, 2.0], vec![2.0, 3.0, 0.0, 4.0]]);
        assert_eq!(found.n, [2, 4]);
        assert!((found.medians[0] - 1.5).abs() < 1e-12);
        assert!((found.medians[1] - 2.5).abs() < 1e-12);
        // Of eight pairs: more in 2, less in 5, equal in 1.
        assert!((found.delta + 3.0 / 8.0).abs() < 1e-12, "{}", found.delta);
    }

    /// Against SciPy 1.17.1: `mannwhitneyu(x, y, method='asymptotic')` with
    /// `x = [(i * 7) % 23 + 3 for i in range(60)]` and `y = [(i * 5) % 19 for i in range(50)]`.
    #[test]
    fn large_groups_take_the_normal_distribution_with_ties() {
        let x: Vec<f64> = (0..60).map(|i| f64::from((i * 7) % 23 + 3)).collect();
        let y: Vec<f64> = (0..50).map(|i| f64::from((i * 5) % 19)).collect();
        let p = compare(&[x, y]).p;
        assert!((p - 0.00016500166012930329).abs() < 1e-9, "{p}");
    }

    /// Against NumPy 2.4.6: `quantile([3, 1, 4, 1, 5, 9, 2, 6], [0.25, 0.5, 0.75])`.
    #[test]
    fn quartiles_are_those_of_numpy() {
        let values = [3.0, 1.0, 4.0, f64::NAN, 1.0, 5.0, 9.0, 2.0, 6.0];
        for (share, found) in [(0.25, 1.75), (0.5, 3.5), (0.75, 5.25)] {
            assert!((quantile(&values, share) - found).abs() < 1e-12);
        }
        assert!(quantile(&[], 0.5).is_nan());
    }

    /// Against statsmodels 0.14: `multipletests([0.01, 0.04, 0.03, 0.005], method='holm')`.
    #[test]
    fn holm_raises_each_probability_by_the_number_that_is_left() {
        let raised = holm(&[0.01, 0.04, f64::NAN, 0.03, 0.005]);
        for (raised, wanted) in [(raised[0], 0.03), (raised[1], 0.06), (raised[3], 0.06)] {
            assert!((raised - wanted).abs() < 1e-12, "{raised}");
        }
        assert!((raised[4] - 0.02).abs() < 1e-12 && raised[2].is_nan());
    }
}
