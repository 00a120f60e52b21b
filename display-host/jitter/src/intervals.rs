//! Keeps the largest wake-up latency of each five minutes, as OSADL's test farm does. The maximum
//! of a whole run grows with the run's length. Maxima of equal intervals can be compared.

use serde::{Deserialize, Serialize};

use crate::certainty::median;

/// Length of an interval, s, as in OSADL's plots.
pub const INTERVAL_S: u32 = 300;
/// Largest number of intervals kept: those of 30 days. The last interval also takes all later
/// wake-ups.
const INTERVALS_MAX: usize = 8640;

/// Maxima of consecutive intervals.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Intervals {
    /// Largest wake-up latency of each interval, ns.
    #[serde(default, rename = "intervals_max_ns")]
    pub max_ns: Vec<u64>,
    /// Length of an interval, s. A run shorter than five minutes has one interval of its length.
    #[serde(default)]
    pub interval_s: f64,
}

impl Intervals {
    /// Notes a wake-up that was `ns` late, at `at_s` seconds of measured time.
    pub fn note(&mut self, at_s: f64, ns: u64) {
        self.interval_s = self.interval_s.max(at_s.min(f64::from(INTERVAL_S)));
        // The clamp keeps the conversion in range.
        let place = (at_s.clamp(0.0, 1e9) / f64::from(INTERVAL_S)) as usize;
        let place = place.min(INTERVALS_MAX - 1);
        if self.max_ns.len() <= place {
            self.max_ns.resize(place + 1, 0);
        }
        if let Some(max_ns) = self.max_ns.get_mut(place) {
            *max_ns = (*max_ns).max(ns);
        }
    }

    /// Appends the intervals of another run, up to the largest number kept.
    pub fn append(&mut self, next: &Self) {
        self.interval_s = self.interval_s.max(next.interval_s);
        self.max_ns.extend(&next.max_ns);
        self.max_ns.truncate(INTERVALS_MAX);
    }

    /// Median of the maxima, ns; `None` if there are none.
    pub fn median_ns(&self) -> Option<f64> {
        let all = self.max_ns.iter().map(|&ns| ns as f64).collect();
        median(all)
    }

    /// The maxima as a curve: start of each interval, s, and its maximum, µs.
    pub fn course(&self) -> Vec<(f64, f64)> {
        let all = self.max_ns.iter().enumerate();
        let at_s = |i: usize| i as f64 * f64::from(INTERVAL_S);
        all.map(|(i, &ns)| (at_s(i), ns as f64 / 1e3)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_has_twelve_maxima_and_a_short_run_has_one_of_its_length() {
        let mut hour = Intervals::default();
        for second in 0..3600u32 {
            hour.note(second.into(), u64::from(second));
        }
        assert_eq!(hour.max_ns.len(), 12);
        assert_eq!(hour.max_ns[..2], [299, 599]);
        assert!((hour.interval_s - 300.0).abs() < 1e-9);
        let mut short = Intervals::default();
        for (at_s, ns) in [(0.5, 7), (59.9, 5)] {
            short.note(at_s, ns);
        }
        assert_eq!(short.max_ns, [7]);
        assert!((short.interval_s - 59.9).abs() < 1e-9);
        hour.append(&short);
        assert_eq!((hour.max_ns.len(), hour.max_ns[12]), (13, 7));
        assert_eq!(hour.median_ns(), Some(1799.0));
        assert!((hour.course()[2].0 - 600.0).abs() < 1e-9);
    }

    #[test]
    fn a_year_takes_no_more_than_a_month() {
        let mut year = Intervals::default();
        year.note(365.0 * 86_400.0, 9);
        assert_eq!(year.max_ns.len(), INTERVALS_MAX);
        assert_eq!(year.max_ns.last(), Some(&9));
        let twice = year.clone();
        year.append(&twice);
        assert_eq!(year.max_ns.len(), INTERVALS_MAX);
        assert_eq!(Intervals::default().median_ns(), None);
    }
}
