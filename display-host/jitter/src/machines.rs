//! Puts runs of several machines into one table.

use core::fmt::Write as _;

use figures::Quantiles;

pub use crate::part::Part;
use crate::report::Report;

impl Part {
    /// Line of a run.
    pub fn of(report: &Report, name: &str) -> Self {
        let about = &report.about;
        let wake = report.times.get("wake_latency_ns");
        let q = wake.map_or_else(Quantiles::default, figures::Distribution::quantiles);
        let ratio = report
            .ratios()
            .into_iter()
            .find(|it| it.program == "station");
        let first = report.causes.first();
        Self {
            name: name.to_owned(),
            processor: about.machine.processor.clone(),
            kernel: about.machine.kernel.clone(),
            load: match about.load.is_empty() {
                true => "none".to_owned(),
                false => about.load.join(", "),
            },
            seconds: about.seconds,
            realtime: about.realtime,
            ticks: report.counts.get("ticks").copied().unwrap_or(0),
            p50: q.p50,
            p99: q.p99,
            p999: q.p999,
            max: q.max,
            interval_max_median: report.intervals.median_ns(),
            misses_per_million: report.misses_per_million(),
            to_cyclictest: ratio.map(|it| [it.p50, it.p99]),
            first_cause: first.map(|cause| format!("{} {}", cause.what.name(), cause.name)),
        }
    }

    /// Cells of the line, in the order of [`HEADINGS`].
    pub fn cells(&self) -> [String; HEADINGS.len()] {
        let us = |ns: u64| format!("{:.1}", ns as f64 / 1e3);
        let dash = || "–".to_owned();
        let ratio = |i: usize| {
            let pair = self.to_cyclictest.as_ref().and_then(|pair| pair.get(i));
            pair.map_or_else(dash, |ratio| format!("{ratio:.2}"))
        };
        [
            self.name.clone(),
            self.processor.clone(),
            self.kernel.clone(),
            self.load.clone(),
            if self.realtime { "yes" } else { "NO" }.to_owned(),
            self.ticks.to_string(),
            us(self.p50),
            us(self.p99),
            us(self.p999),
            us(self.max),
            self.interval_max_median
                .map_or_else(dash, |ns| format!("{:.1}", ns / 1e3)),
            format!("{:.1}", self.misses_per_million),
            ratio(0),
            ratio(1),
            self.first_cause.clone().unwrap_or_else(dash),
        ]
    }
}

/// Headings of the table. Times are wake-up latencies.
pub const HEADINGS: [&str; 15] = [
    "run",
    "processor",
    "kernel",
    "load",
    "realtime",
    "ticks",
    "p50, µs",
    "p99, µs",
    "p99.9, µs",
    "max, µs",
    "median of 5 min maxima, µs",
    "missed in a million",
    "p50 ÷ cyclictest's",
    "p99 ÷ cyclictest's",
    "first cause",
];

/// The table for standard output, one value a line, because fifteen columns fit no terminal.
pub fn text(parts: &[Part]) -> String {
    let mut text = String::new();
    for part in parts {
        for (heading, cell) in HEADINGS.iter().zip(part.cells()) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{heading:28} {cell}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn a_line_tells_machine_load_and_figures() {
        let report = sample();
        let part = Part::of(&report, "bench-1");
        assert_eq!((part.ticks, part.load.as_str()), (1990, "cpu"));
        assert!(part.p50 < part.p99 && part.p99 < part.max && part.realtime);
        assert!(
            part.to_cyclictest
                .is_some_and(|pair| (pair[0] - 1.2).abs() < 1e-9)
        );
        let cells = part.cells();
        assert_eq!((cells[0].as_str(), cells[12].as_str()), ("bench-1", "1.20"));
        assert_eq!((cells[10].as_str(), cells[14].as_str()), ("200.0", "–"));
        let text = text(&[part.clone(), part]);
        assert_eq!(text.matches("bench-1").count(), 2);
        assert!(
            text.contains("missed in a million          5000.0"),
            "{text}"
        );
    }
}
