//! Histograms of durations.

use hdrhistogram::Histogram;

/// Longest duration that a histogram holds, 60 s. Longer ones count as 60 s.
const MAX_NS: u64 = 60_000_000_000;

/// A histogram of durations in ns: three significant digits, constant memory.
#[derive(Debug, Clone)]
pub struct Distribution(Option<Histogram<u64>>);

/// Quantiles of a histogram, ns; all zero if it is empty.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Quantiles {
    /// Number of recorded durations.
    pub count: u64,
    /// Median.
    pub p50: u64,
    /// 90 % are at most this.
    pub p90: u64,
    /// 99 % are at most this.
    pub p99: u64,
    /// 99.9 % are at most this.
    pub p999: u64,
    /// 99.99 % are at most this.
    pub p9999: u64,
    /// Maximum.
    pub max: u64,
}

impl Default for Distribution {
    fn default() -> Self {
        Self::new()
    }
}

impl Distribution {
    /// An empty histogram.
    #[must_use]
    pub fn new() -> Self {
        // hdrhistogram accepts these constant bounds; the tests below prove it.
        Self(Histogram::new_with_bounds(1, MAX_NS, 3).ok())
    }

    /// Records a duration.
    pub fn record(&mut self, ns: u64) {
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record(ns);
        }
    }

    /// Records a duration that occurred `count` times.
    pub fn record_n(&mut self, ns: u64, count: u64) {
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record_n(ns, count);
        }
    }

    /// Adds the counts of another histogram.
    pub fn add(&mut self, other: &Self) {
        for (ns, count) in other.counts() {
            self.record_n(ns, count);
        }
    }

    /// Counts as (duration in ns, number), ascending. Passing each to [`Distribution::record_n`]
    /// gives an equal histogram.
    #[must_use]
    pub fn counts(&self) -> Vec<(u64, u64)> {
        let recorded = self.0.iter().flat_map(Histogram::iter_recorded);
        recorded
            .map(|value| (value.value_iterated_to(), value.count_at_value()))
            .collect()
    }

    /// Number of recorded durations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.as_ref().map_or(0, Histogram::len)
    }

    /// Quantiles of the recorded durations.
    #[must_use]
    pub fn quantiles(&self) -> Quantiles {
        match &self.0 {
            Some(h) if !h.is_empty() => Quantiles {
                count: h.len(),
                p50: h.value_at_quantile(0.5),
                p90: h.value_at_quantile(0.9),
                p99: h.value_at_quantile(0.99),
                p999: h.value_at_quantile(0.999),
                p9999: h.value_at_quantile(0.9999),
                max: h.max(),
            },
            _ => Quantiles::default(),
        }
    }

    /// Counts in bins whose width grows by `2^(1/per_octave)`: (lower bound in ns, count), from the
    /// first to the last non-empty bin.
    #[must_use]
    pub fn log_bins(&self, per_octave: u32) -> Vec<(f64, u64)> {
        let Some(histogram) = &self.0 else {
            return Vec::new();
        };
        let bin = |ns: u64| (f64::from(per_octave) * (ns.max(1) as f64).log2()).floor() as i64;
        let mut bins: Vec<(i64, u64)> = Vec::new();
        for value in histogram.iter_recorded() {
            let at = bin(value.value_iterated_to());
            let count = value.count_at_value();
            match bins.last().map(|&(last, _)| last) {
                Some(last) if last == at => {
                    if let Some((_, sum)) = bins.last_mut() {
                        *sum += count;
                    }
                    continue;
                }
                Some(last) => bins.extend((last + 1..at).map(|empty| (empty, 0))),
                None => {}
            }
            bins.push((at, count));
        }
        let lower = |at: i64| (at as f64 / f64::from(per_octave)).exp2();
        bins.into_iter()
            .map(|(at, count)| (lower(at), count))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_known_sequence() {
        let mut d = Distribution::new();
        assert_eq!(d.quantiles(), Quantiles::default());
        for ns in 1..=1000 {
            d.record(ns);
        }
        let q = d.quantiles();
        assert_eq!(
            (q.count, q.p50, q.p90, q.p99, q.p999, q.p9999, q.max),
            (1000, 500, 900, 990, 999, 1000, 1000)
        );
    }

    #[test]
    fn counts_make_the_same_histogram_again_and_sums_add_up() {
        let (mut a, mut b) = (Distribution::new(), Distribution::new());
        for i in 1..5000u64 {
            a.record(i * i);
            b.record(i * 777);
        }
        let mut again = Distribution::new();
        for (ns, count) in a.counts() {
            again.record_n(ns, count);
        }
        assert_eq!(again.quantiles(), a.quantiles());
        let (mut ab, mut ba) = (a.clone(), b.clone());
        ab.add(&b);
        ba.add(&a);
        assert_eq!(ab.quantiles(), ba.quantiles());
        assert_eq!(ab.count(), a.count() + b.count());
        assert_eq!(ab.quantiles().max, a.quantiles().max.max(b.quantiles().max));
    }

    #[test]
    fn values_out_of_range_are_counted_at_the_edge() {
        let mut d = Distribution::new();
        d.record(0);
        d.record(u64::MAX);
        let q = d.quantiles();
        assert_eq!(q.count, 2);
        assert!(q.max >= MAX_NS, "{q:?}");
    }

    #[test]
    fn bins_hold_every_count_and_leave_no_hole() {
        let mut d = Distribution::new();
        for ns in [100, 110, 3000, 3001, 50_000] {
            d.record(ns);
        }
        let bins = d.log_bins(4);
        assert_eq!(bins.iter().map(|b| b.1).sum::<u64>(), 5);
        for pair in bins.windows(2) {
            assert!((pair[1].0 / pair[0].0 - 2f64.powf(0.25)).abs() < 1e-9);
        }
        assert!(bins[0].0 <= 100.0 && bins[0].1 > 0 && bins[bins.len() - 1].1 > 0);
    }
}
