//! Confidence intervals over the turns of a run. In each round of a run, every program has one
//! turn.
//!
//! Latencies are positive and skewed, so the interval is that of the geometric mean: Student's t on
//! the logarithms of the turns. It is right even for few turns. An interval from a bootstrap of the
//! turns is not: with three turns it covers the median in 75 % of runs, not in 95 %.

use serde_json::{Map, Value, json};

use crate::misses::{Round, paired};

/// Two-sided 95 % quantiles of Student's t for 1, 2, … degrees of freedom (NIST/SEMATECH e-Handbook
/// of Statistical Methods, table 1.3.6.7.2).
const T_95: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];
/// Fewest turns for an interval. With two turns it would span the 12.7th power of their ratio, and
/// say nothing.
pub const TURNS_MIN: usize = 3;

/// Interval that holds the geometric mean of the turns with 95 % confidence. `None` with fewer than
/// [`TURNS_MIN`] turns.
pub fn interval(turns: &[f64]) -> Option<[f64; 2]> {
    if turns.len() < TURNS_MIN {
        return None;
    }
    let logs: Vec<f64> = turns.iter().map(|x| x.max(1e-9).ln()).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / n;
    let variance = logs.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
    // Beyond the table's end the last entry errs to the wide side.
    let t = T_95.get(logs.len() - 2).or(T_95.last())?;
    let half = t * (variance / n).sqrt();
    Some([(mean - half).exp(), (mean + half).exp()])
}

/// Median; of an even number of values, the mean of the middle two.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(f64::midpoint(values[last / 2], values[last.div_ceil(2)]))
}

/// The value of the key `ci95` in `jitter.json`. Each interval is a pair, or null if the turns are
/// too few.
pub fn to_json(rounds: &[Round]) -> Value {
    let mut programs: Vec<&str> = rounds.iter().map(|r| r.program.as_str()).collect();
    programs.sort_unstable();
    programs.dedup();
    let (mut turns, mut wake, mut ratios) = (Map::new(), Map::new(), Map::new());
    for program in programs {
        let own: Vec<&Round> = rounds.iter().filter(|r| r.program == program).collect();
        let of = |value: fn(&Round) -> u64| {
            let values: Vec<f64> = own.iter().map(|r| value(r) as f64).collect();
            interval(&values)
        };
        turns.insert(program.to_owned(), own.len().into());
        let figures = json!({"p50": of(|r| r.p50), "p99": of(|r| r.p99), "max": of(|r| r.max)});
        wake.insert(program.to_owned(), figures);
        if program != "cyclictest" {
            let [p50, p99] = ratio(rounds, program);
            ratios.insert(program.to_owned(), json!({"p50": p50, "p99": p99}));
        }
    }
    json!({"turns": turns, "wake_latency_ns": wake, "wake_latency_to_cyclictest": ratios})
}

/// Intervals of a program's p50 and p99 of wake-up latency, divided by cyclictest's of the same
/// round.
pub fn ratio(rounds: &[Round], program: &str) -> [Option<[f64; 2]>; 2] {
    let pairs = paired(rounds, program);
    let of = |value: fn(&Round) -> u64| {
        let ratio = |(a, b): &(&Round, &Round)| value(a) as f64 / value(b).max(1) as f64;
        interval(&pairs.iter().map(ratio).collect::<Vec<f64>>())
    };
    [of(|r| r.p50), of(|r| r.p99)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<[f64; 2]>, wanted: [f64; 2]) {
        let [low, high] = found.expect("enough turns");
        assert!((low / wanted[0] - 1.0).abs() < 1e-3, "{low} {wanted:?}");
        assert!((high / wanted[1] - 1.0).abs() < 1e-3, "{high} {wanted:?}");
    }

    #[test]
    fn the_interval_is_students_on_logarithms() {
        // Logarithms 0, 1, 2: mean 1, deviation 1, t 4.303, half width 4.303/√3 = 2.4843.
        let e = core::f64::consts::E;
        let wanted = [(1.0f64 - 2.4843).exp(), (1.0f64 + 2.4843).exp()];
        near(interval(&[1.0, e, e * e]), wanted);
        near(interval(&[5.0; 4]), [5.0, 5.0]);
        assert_eq!(interval(&[1.0, 2.0]), None);
        let many: Vec<f64> = (0..200).map(|i| 10.0 + f64::from(i % 2)).collect();
        let [low, high] = interval(&many).unwrap();
        assert!(low > 10.3 && high < 10.7, "{low} {high}");
    }

    #[test]
    fn it_covers_the_truth_in_about_95_of_100_runs_of_three_turns() {
        // The sum of twelve draws from the uniform distribution is nearly normal. The draws come
        // from a fixed seed.
        let mut state = 1u64;
        let mut even = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| even()).sum::<f64>() - 6.0;
        let covers = |turns: [f64; 3]| {
            let [low, high] = interval(&turns).unwrap();
            low <= 1.0 && 1.0 <= high
        };
        let runs = 4000;
        let covered = (0..runs).filter(|_| covers([normal(), normal(), normal()].map(f64::exp)));
        let share = covered.count() as f64 / f64::from(runs);
        assert!((0.93..0.97).contains(&share), "{share}");
    }

    #[test]
    fn few_turns_are_null_and_ratios_pair_the_rounds() {
        let round = |round, program: &str, p50| Round {
            round,
            program: program.to_owned(),
            p50,
            p99: 2 * p50,
            max: 3 * p50,
            missed: None,
            stolen_ms: None,
        };
        let mut rounds = vec![round(0, "station", 10)];
        let json = to_json(&rounds);
        assert!(json["wake_latency_ns"]["station"]["p50"].is_null());
        assert_eq!(json["turns"]["station"], 1);
        for i in 0..3 {
            rounds.push(round(i + 1, "station", 20 * u64::from(i + 1)));
            rounds.push(round(i + 1, "cyclictest", 10 * u64::from(i + 1)));
        }
        let json = to_json(&rounds);
        assert_eq!(json["turns"]["station"], 4);
        let ratio = &json["wake_latency_to_cyclictest"]["station"]["p50"];
        near(
            Some([ratio[0].as_f64().unwrap(), ratio[1].as_f64().unwrap()]),
            [2.0, 2.0],
        );
        assert!(json["wake_latency_to_cyclictest"]["cyclictest"].is_null());
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![3.0, 1.0]), Some(2.0));
    }
}
