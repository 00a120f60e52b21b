//! Writes histograms in the formats of other latency tools: HdrHistogram's percentile text
//! (`.hgrm`), and the text of `cyclictest -h`.

use core::fmt::Write as _;

use figures::Distribution;

/// Lines of the percentile text for each halving of the distance to 100 %: the default of
/// HdrHistogram's `outputPercentileDistribution`.
const TICKS_PER_HALF: f64 = 5.0;
/// Buckets and sub-buckets of a histogram of 1 ns to 60 s with three digits. 2048 sub-buckets
/// resolve three digits. 2048 · 2²⁵ is the first power above 60 · 10⁹.
const BUCKETS: [u32; 2] = [26, 2048];
/// Longest time of a line in cyclictest's text, µs: its `-h100000`.
const LONGEST_US: usize = 100_000;

/// Returns the percentile text, times in µs. Programs that plot `.hgrm` files read it.
pub fn hgrm(times: &Distribution) -> String {
    let counts = times.counts();
    let total = times.count();
    let mut text = String::from("       Value     Percentile TotalCount 1/(1-Percentile)\n\n");
    let us = |ns: u64| ns as f64 / 1e3;
    let (mut so_far, mut level) = (0, 0.0);
    for &(ns, count) in &counts {
        so_far += count;
        let share = 100.0 * so_far as f64 / total as f64;
        while share >= level && level < 100.0 {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{:12.3} {:2.12} {so_far:10} {:14.2}",
                us(ns),
                level / 100.0,
                100.0 / (100.0 - level)
            );
            let halvings = (100.0 / (100.0 - level)).log2().floor() + 1.0;
            level += 100.0 / (TICKS_PER_HALF * halvings.exp2());
            if so_far == total {
                break;
            }
        }
    }
    let longest = counts.last().map_or(0, |last| last.0);
    if total > 0 {
        let _ = writeln!(text, "{:12.3} {:2.12} {total:10}", us(longest), 1.0);
    }
    let [mean, deviation] = moments_ns(&counts, total).map(|ns| ns / 1e3);
    let [buckets, parts] = BUCKETS;
    let _ = write!(
        text,
        "#[Mean    = {mean:12.3}, StdDeviation   = {deviation:12.3}]\n\
         #[Max     = {:12.3}, Total count    = {total:12}]\n\
         #[Buckets = {buckets:12}, SubBuckets     = {parts:12}]\n",
        us(longest)
    );
    text
}

/// Returns the text of `cyclictest -h100000 -q`: a line for each µs up to the longest time.
pub fn cyclictest(times: &Distribution) -> String {
    let counts = times.counts();
    let total = times.count();
    let longest_us = counts.last().map_or(0, |last| last.0 / 1000);
    let lines = usize::try_from(longest_us).map_or(LONGEST_US, |us| us.min(LONGEST_US - 1) + 1);
    let mut bins = vec![0u64; lines];
    let mut over = 0;
    for &(ns, count) in &counts {
        let bin = usize::try_from(ns / 1000).unwrap_or(usize::MAX);
        match bins.get_mut(bin) {
            Some(sum) => *sum += count,
            None => over += count,
        }
    }
    let mut text = String::from("# Histogram\n");
    for (us, count) in bins.iter().enumerate() {
        let _ = writeln!(text, "{us:06} {count:06}");
    }
    let [mean_ns, _] = moments_ns(&counts, total);
    let _ = write!(
        text,
        "# Total: {total:09}\n# Min Latencies: {:05}\n# Avg Latencies: {:05}\n\
         # Max Latencies: {longest_us:05}\n# Histogram Overflows: {over:05}\n\
         # Histogram Overflow at cycle number:\n# Thread 0:\n",
        counts.first().map_or(0, |first| first.0 / 1000),
        (mean_ns / 1e3) as u64,
    );
    text
}

/// Mean and standard deviation, ns.
fn moments_ns(counts: &[(u64, u64)], total: u64) -> [f64; 2] {
    let all = total.max(1) as f64;
    let sum = |of: &dyn Fn(f64) -> f64| {
        let each = counts.iter().map(|&(ns, n)| of(ns as f64) * n as f64);
        each.sum::<f64>()
    };
    let mean = sum(&|ns| ns) / all;
    let variance = sum(&|ns| (ns - mean) * (ns - mean)) / all;
    [mean, variance.sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn up_to(last_us: u64) -> Distribution {
        let mut times = Distribution::new();
        for us in 1..=last_us {
            times.record(us * 1000);
        }
        times
    }

    #[test]
    fn percentiles_go_from_the_shortest_to_the_longest_and_halve_the_distance_to_all() {
        let text = hgrm(&up_to(1000));
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(2)
            .take_while(|line| !line.starts_with('#'))
            .map(|line| {
                let words = line.split_whitespace();
                words.map(|word| word.parse().unwrap()).collect()
            })
            .collect();
        assert!(text.starts_with("       Value     Percentile TotalCount 1/(1-Percentile)\n\n"));
        for pair in rows.windows(2) {
            assert!(
                pair[0][0] <= pair[1][0] && pair[0][1] < pair[1][1],
                "{pair:?}"
            );
        }
        // Five lines from 0 to 50 %, five more to 75 %.
        let levels: Vec<f64> = rows.iter().map(|row| row[1]).take(11).collect();
        for (level, wanted) in levels
            .iter()
            .zip([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75])
        {
            assert!((level - wanted).abs() < 1e-9, "{levels:?}");
        }
        let median = rows.iter().find(|row| (row[1] - 0.5).abs() < 1e-9).unwrap();
        assert!((median[0] - 500.0).abs() < 1.0 && (median[3] - 2.0).abs() < 1e-9);
        let last = rows.last().unwrap();
        assert_eq!(last.len(), 3, "100 % has no last column");
        assert!((last[0] - 1000.0).abs() < 1.0 && (last[2] - 1000.0).abs() < 1e-9);
        assert!(
            text.contains("#[Mean    =      500.")
                && text.contains("Total count    =         1000]")
        );
        assert!(text.contains("#[Buckets =           26, SubBuckets     =         2048]"));
    }

    #[test]
    fn one_time_gives_one_line_and_the_last() {
        let text = hgrm(&up_to(1));
        assert_eq!(
            text.lines().filter(|line| line.contains("1.000 ")).count(),
            2
        );
        assert!(!hgrm(&Distribution::new()).contains("NaN"));
    }

    #[test]
    fn cyclictests_text_has_a_line_for_each_us_and_counts_all() {
        let mut times = up_to(3);
        times.record(2_000_000_000);
        let text = cyclictest(&times);
        let bins: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(bins.len(), LONGEST_US);
        assert_eq!(
            bins[..4],
            [
                "000000 000000",
                "000001 000001",
                "000002 000001",
                "000003 000001"
            ]
        );
        assert!(text.contains("# Total: 000000004\n# Min Latencies: 00001\n"));
        assert!(
            text.contains("# Histogram Overflows: 00001\n"),
            "two seconds fit no line"
        );
        let again = crate::baselines::parse(&text).wake_latency;
        assert_eq!(again.count(), 4, "what reads cyclictest reads this");
        let short = cyclictest(&up_to(3));
        assert_eq!(
            short.lines().filter(|line| !line.starts_with('#')).count(),
            4
        );
    }
}
