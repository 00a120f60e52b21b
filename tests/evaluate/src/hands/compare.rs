//! Experts beside novices: medians, Cliff's delta, and the test of Mann and Whitney.
//!
//! The test is exact, with ties: all ways to draw the experts from the ranks are counted, by the
//! sum of their ranks. A tie has the mean of its ranks, so ranks are counted doubled, as whole
//! numbers (H. B. Mann, D. R. Whitney, Ann. Math. Stat. 18, 1947; E. L. Lehmann, Nonparametrics,
//! 1975, for ties).

/// Two groups compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compared {
    /// Number of values in each group.
    pub(super) n: [usize; 2],
    /// Median of each group.
    pub(super) medians: [f64; 2],
    /// Cliff's delta: share of pairs in which the first group has more, minus that in which it has
    /// less. −1 and 1: the groups do not overlap.
    pub(super) delta: f64,
    /// Two-sided probability of a rank sum that is at least as far off its mean, if there is no
    /// difference.
    pub(super) p: f64,
}

/// Compares two groups. Values that are no numbers are left out.
pub(super) fn compare(groups: &[Vec<f64>; 2]) -> Compared {
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
pub(super) fn median(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|it| it.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    0.5 * (at(sorted.len().saturating_sub(1) / 2) + at(sorted.len() / 2))
}

/// Exact two-sided probability; NaN if a group is empty.
fn mann_whitney(first: &[f64], second: &[f64]) -> f64 {
    if first.is_empty() || second.is_empty() {
        return f64::NAN;
    }
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
        // Ranks 1.5, 1.5, 3.5, 3.5, 5: of ten ways to draw two, these sums are the least (3) and
        // greatest (8.5): one way and two.
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
}
