//! Adds up runs, or compares two.

use core::fmt::Write as _;

use serde_json::{Map, Value, json};

use crate::blackbox;
use crate::budgets;
use crate::report::Report;
use crate::table::{self, Row};
use crate::why;

/// Adds up runs. The sums of histograms and counts are exact. The numbers of the rounds go on from
/// run to run.
pub fn merge(runs: Vec<Report>) -> Option<Report> {
    let mut runs = runs.into_iter();
    let mut sum = runs.next()?;
    for run in runs {
        let rounds = sum.rounds.iter().map(|r| r.round + 1).max().unwrap_or(0);
        sum.timeline.append(sum.about.seconds, &run.timeline);
        let shift_ms = (sum.about.seconds * 1e3) as u64;
        for (name, times) in &run.times {
            sum.times(name).add(times);
        }
        for (name, &count) in &run.counts {
            sum.count(name, count);
        }
        sum.rounds.extend(run.rounds.into_iter().map(|mut round| {
            round.round += rounds;
            round
        }));
        sum.incidents
            .extend(run.incidents.into_iter().map(|mut incident| {
                incident.at_ms += shift_ms;
                incident
            }));
        sum.incidents = blackbox::worst(sum.incidents);
        sum.intervals.append(&run.intervals);
        sum.budgets = budgets::sum(sum.budgets, run.budgets);
        sum.causes = why::sum(sum.causes, run.causes);
        sum.why = match (sum.why, run.why) {
            (Some(all), Some(one)) => Some(all.and(one)),
            (all, one) => all.or(one),
        };
        sum.parts.extend(run.parts);
        let (all, one) = (&mut sum.about, run.about);
        all.seconds += one.seconds;
        all.complete &= one.complete;
        all.memory_kib = None;
        all.realtime &= one.realtime;
        let mut note = |differs: bool, text: String| {
            if differs && !all.notes.contains(&text) {
                all.notes.push(text);
            }
        };
        note(
            all.load != one.load,
            format!("a part ran under another load: {}", one.load.join(", ")),
        );
        note(
            all.scene != one.scene,
            format!("a part ran another scene: {}", one.scene),
        );
        let (a, b) = (&all.machine, &one.machine);
        note(
            (&a.processor, &a.kernel) != (&b.processor, &b.kernel),
            format!(
                "a part ran on another machine: {}, {}",
                b.processor, b.kernel
            ),
        );
        for text in one.notes {
            note(true, text);
        }
    }
    Some(sum)
}

/// Ratios of two runs.
#[derive(Debug, Clone)]
pub struct RunRatios {
    /// Table to read.
    pub text: String,
    /// Figures of the table as JSON.
    pub json: Value,
}

/// Divides each figure of the second run by that of the first. Skips figures that only one run has.
pub fn ratios(first: &Report, second: &Report) -> RunRatios {
    let mut text = String::new();
    let mut json = Map::new();
    let _ = writeln!(
        text,
        "{:72}{:>11}{:>11}{:>8}{:>11}{:>11}{:>8}{:>8}",
        "µs: first, second, second ÷ first", "p50", "p50", "÷", "p99", "p99", "÷", "max ÷"
    );
    let theirs = table::rows(second);
    for Row {
        name,
        label,
        quantiles: a,
    } in table::rows(first)
    {
        let Some(row) = theirs.iter().find(|row| row.name == name) else {
            continue;
        };
        let b = row.quantiles;
        let us = |ns: u64| ns as f64 / 1e3;
        let ratio = |b: u64, a: u64| b as f64 / a.max(1) as f64;
        let _ = writeln!(
            text,
            "{label:72}{:11.1}{:11.1}{:8.2}{:11.1}{:11.1}{:8.2}{:8.2}",
            us(a.p50),
            us(b.p50),
            ratio(b.p50, a.p50),
            us(a.p99),
            us(b.p99),
            ratio(b.p99, a.p99),
            ratio(b.max, a.max),
        );
        let ratios = json!({
            "p50": ratio(b.p50, a.p50),
            "p90": ratio(b.p90, a.p90),
            "p99": ratio(b.p99, a.p99),
            "p999": ratio(b.p999, a.p999),
            "p9999": ratio(b.p9999, a.p9999),
            "max": ratio(b.max, a.max),
        });
        json.insert(
            name.clone(),
            json!({"first": a, "second": b, "ratio": ratios}),
        );
    }
    let misses = [first.misses_per_million(), second.misses_per_million()];
    let _ = writeln!(
        text,
        "missed in a million periods: {:.1}, {:.1}",
        misses[0], misses[1]
    );
    json.insert(
        "misses_per_million".into(),
        json!({"first": misses[0], "second": misses[1]}),
    );
    if first.about.load != second.about.load {
        let _ = writeln!(
            text,
            "loads: {:?}, {:?}",
            first.about.load, second.about.load
        );
    }
    if first.about.machine.processor != second.about.machine.processor {
        let _ = writeln!(
            text,
            "machines: {}, {}",
            first.about.machine.processor, second.about.machine.processor
        );
    }
    let _ = writeln!(
        text,
        "The runs did not share the same minutes: the machine may cause a difference."
    );
    RunRatios {
        text,
        json: Value::Object(json),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn a_run_added_to_itself_has_twice_the_counts_and_the_same_quantiles() {
        let one = sample();
        let both = merge(vec![one.clone(), one.clone()]).unwrap();
        let (a, b) = (
            one.times["wake_latency_ns"].quantiles(),
            both.times["wake_latency_ns"].quantiles(),
        );
        assert_eq!((b.count, b.p50, b.max), (2 * a.count, a.p50, a.max));
        assert_eq!(both.counts["ticks"], 2 * one.counts["ticks"]);
        assert_eq!(both.rounds.len(), 2 * one.rounds.len());
        assert_eq!(both.rounds.iter().map(|r| r.round).max(), Some(5));
        assert_eq!(both.ratios(), one.ratios());
        assert!(both.about.notes.is_empty());
        assert_eq!(both.intervals.max_ns, [200_000, 200_000]);
        let mut other = sample();
        other.about.load.clear();
        other.about.realtime = false;
        let mixed = merge(vec![one, other]).unwrap();
        assert!(!mixed.about.realtime && mixed.about.notes[0].contains("another load"));
        assert!(merge(Vec::new()).is_none());
    }

    #[test]
    fn the_ratios_of_a_run_to_itself_are_one() {
        let one = sample();
        let RunRatios { text, json } = ratios(&one, &one);
        assert_eq!(json["wake_latency_ns"]["ratio"]["p99"], 1.0);
        assert!(text.contains("1.00") && !text.contains("loads"));
        let mut slow = sample();
        let mut twice = figures::Distribution::new();
        for i in 1..=2000u64 {
            twice.record(i * 200);
        }
        slow.times.insert("wake_latency_ns".into(), twice);
        let ratio = ratios(&one, &slow).json["wake_latency_ns"]["ratio"]["p50"].clone();
        assert!((ratio.as_f64().unwrap() - 2.0).abs() < 0.01);
    }
}
