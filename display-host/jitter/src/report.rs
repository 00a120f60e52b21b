//! The report of a `calot jitter` run, and its file `jitter.json`.
//!
//! Every figure has a dotted name, as in `summary.json`: `wake_latency_ns`, `stage_ns.solve`,
//! `cyclictest.wake_latency_ns`. The file holds all bins of each histogram, so that the sum of
//! several runs is exact.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use figures::{Distribution, Machine};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::blackbox::Incident;
use crate::budgets::Budget;
use crate::cause::{self, Cause, Source};
use crate::certainty::{self, median};
use crate::intervals::Intervals;
use crate::misses::{self, Round, paired, per_million};
use crate::part::Part;
use crate::problem::Problem;
use crate::timeline::Timeline;

/// Name of the file in the folder of a run.
pub const FILE: &str = "jitter.json";

/// Description of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Program and version.
    pub program: String,
    /// Command line of the run.
    pub command: String,
    /// Name of the scene.
    pub scene: String,
    /// True if the run lasted its full time; false if it was stopped or killed, or still runs.
    pub complete: bool,
    /// Time that the station was measured, s.
    pub seconds: f64,
    /// Names of the added loads. Programs that this run did not start may load the machine too; see
    /// `machine.load_average`.
    pub load: Vec<String>,
    /// True if every tick ran under SCHED_FIFO, in locked memory, pinned to a core.
    pub realtime: bool,
    /// Missing realtime properties and other remarks for the reader.
    pub notes: Vec<String>,
    /// Memory that the measuring program held, KiB: after its first minute, and at the end. A run
    /// of a day is possible only if this memory does not grow.
    #[serde(default)]
    pub memory_kib: Option<[u64; 2]>,
    /// The machine at the start of the run.
    pub machine: Machine,
}

/// Figures and description of a run.
#[derive(Debug, Clone)]
pub struct Report {
    /// Description.
    pub about: About,
    /// Times by dotted name.
    pub times: BTreeMap<String, Distribution>,
    /// Counts by dotted name.
    pub counts: BTreeMap<String, u64>,
    /// Turns of all programs, in order.
    pub rounds: Vec<Round>,
    /// Worst times over the run.
    pub timeline: Timeline,
    /// Ticks around the worst moments, worst first.
    pub incidents: Vec<Incident>,
    /// Largest wake-up latency of each five minutes.
    pub intervals: Intervals,
    /// Time that late ticks lost, by cause; empty unless `--why` asked.
    pub causes: Vec<Cause>,
    /// Source of the causes; `None` unless `--why` asked.
    pub why: Option<Source>,
    /// Late ticks by the stage that caused them.
    pub budgets: Vec<Budget>,
    /// The runs of which this one is the sum; empty if it is one run.
    pub parts: Vec<Part>,
}

/// A program's wake-up latency divided by cyclictest's of the same round: median over the rounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio {
    /// Program that took turns with cyclictest.
    pub program: String,
    /// Ratio of the medians.
    pub p50: f64,
    /// Ratio of the 99 % quantiles.
    pub p99: f64,
}

/// Part of the file from which `Report::read` restores a report.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    #[serde(flatten)]
    about: About,
    rounds: Vec<Round>,
    timeline: Timeline,
    incidents: Vec<Incident>,
    #[serde(flatten)]
    intervals: Intervals,
    #[serde(default)]
    causes: Vec<Cause>,
    #[serde(default)]
    why: Option<Source>,
    #[serde(default)]
    budgets: Vec<Budget>,
    #[serde(default)]
    parts: Vec<Part>,
    counts: BTreeMap<String, u64>,
    histograms: BTreeMap<String, Vec<(u64, u64)>>,
}

impl Report {
    /// Periods that the station missed per million.
    pub fn misses_per_million(&self) -> f64 {
        let count = |name: &str| self.counts.get(name).copied().unwrap_or(0);
        per_million(count("deadline_misses"), count("ticks"))
    }

    /// Ratios of each program that took turns with cyclictest.
    pub fn ratios(&self) -> Vec<Ratio> {
        let mut programs: Vec<&str> = self.rounds.iter().map(|r| r.program.as_str()).collect();
        programs.sort_unstable();
        programs.dedup();
        let mut ratios = Vec::new();
        for program in programs.into_iter().filter(|&p| p != "cyclictest") {
            let pairs = paired(&self.rounds, program);
            let middle = |of: fn(&Round) -> u64| {
                let ratio = |(a, b): &(&Round, &Round)| of(a) as f64 / of(b).max(1) as f64;
                median(pairs.iter().map(ratio).collect())
            };
            if let (Some(p50), Some(p99)) = (middle(|r| r.p50), middle(|r| r.p99)) {
                let program = program.to_owned();
                ratios.push(Ratio { program, p50, p99 });
            }
        }
        ratios
    }

    /// Returns `jitter.json`: all that `read` needs, then quantiles under the names of
    /// `summary.json`.
    pub fn to_json(&self) -> Value {
        let kept = Kept {
            about: self.about.clone(),
            rounds: self.rounds.clone(),
            timeline: self.timeline.clone(),
            incidents: self.incidents.clone(),
            intervals: self.intervals.clone(),
            causes: self.causes.clone(),
            why: self.why.clone(),
            budgets: self.budgets.clone(),
            parts: self.parts.clone(),
            counts: self.counts.clone(),
            histograms: self
                .times
                .iter()
                .map(|(name, times)| (name.clone(), times.counts()))
                .collect(),
        };
        // Plain data always converts to JSON.
        let mut root = serde_json::to_value(kept).unwrap_or_default();
        if let Some(root) = root.as_object_mut() {
            root.insert(
                "misses_per_million".into(),
                json!(self.misses_per_million()),
            );
            let ratios = self.ratios().into_iter();
            let ratios: Map<String, Value> = ratios
                .map(|it| (it.program, json!({"p50": it.p50, "p99": it.p99})))
                .collect();
            root.insert("wake_latency_to_cyclictest".into(), ratios.into());
            root.insert("ci95".into(), certainty::to_json(&self.rounds));
            let against_burn = misses::compare(&self.rounds);
            root.insert("misses_to_burn".into(), misses::to_json(&against_burn));
            for (name, times) in &self.times {
                put(root, name, json!(times.quantiles()));
            }
            for (name, count) in &self.counts {
                put(root, name, json!(count));
            }
        }
        root
    }

    /// Reads a run from its folder or its `jitter.json`.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        let file: PathBuf = match path.is_dir() {
            true => path.join(FILE),
            false => path.to_owned(),
        };
        let text = std::fs::read_to_string(&file).map_err(|error| {
            format!(
                "{}: {error}; name a folder that `calot jitter --out` wrote",
                file.display()
            )
        })?;
        let kept: Kept = serde_json::from_str(&text)
            .map_err(|error| format!("{}: not a run of calot jitter: {error}", file.display()))?;
        let times = kept.histograms.into_iter().map(|(name, counts)| {
            let mut times = Distribution::new();
            for (ns, count) in counts {
                times.record_n(ns, count);
            }
            (name, times)
        });
        Ok(Self {
            times: times.collect(),
            about: kept.about,
            counts: kept.counts,
            rounds: kept.rounds,
            timeline: kept.timeline,
            incidents: kept.incidents,
            intervals: kept.intervals,
            causes: kept.causes,
            why: kept.why,
            budgets: kept.budgets,
            parts: kept.parts,
        })
    }

    /// Adds the causes that a turn found.
    pub fn explained(&mut self, source: Source, causes: Vec<Cause>) {
        self.causes = cause::sum(core::mem::take(&mut self.causes), causes);
        self.why = Some(match self.why.take() {
            Some(before) => before.and(source),
            None => source,
        });
    }

    /// Returns the distribution called `name`. Creates an empty one if the report has none.
    pub fn times(&mut self, name: &str) -> &mut Distribution {
        if !self.times.contains_key(name) {
            self.times.insert(name.to_owned(), Distribution::new());
        }
        self.times.entry(name.to_owned()).or_default()
    }

    /// Adds to a count.
    pub fn count(&mut self, name: &str, more: u64) {
        let count = self.counts.entry(name.to_owned()).or_default();
        *count = count.saturating_add(more);
    }
}

/// Inserts a value under a dotted name. Each dot leads into a nested object.
fn put(root: &mut Map<String, Value>, name: &str, value: Value) {
    match name.split_once('.') {
        None => {
            root.insert(name.to_owned(), value);
        }
        Some((first, rest)) => {
            let inner = root.entry(first).or_insert_with(|| json!({}));
            if let Some(inner) = inner.as_object_mut() {
                put(inner, rest, value);
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn sample() -> Report {
        let mut report = Report {
            about: About {
                program: "calot 0".into(),
                command: "calot jitter".into(),
                scene: "s".into(),
                complete: true,
                seconds: 2.0,
                load: vec!["cpu".into()],
                realtime: true,
                notes: Vec::new(),
                memory_kib: Some([9000, 9100]),
                machine: Machine::read(),
            },
            times: BTreeMap::new(),
            counts: BTreeMap::new(),
            rounds: Vec::new(),
            timeline: Timeline::default(),
            incidents: Vec::new(),
            intervals: Intervals::default(),
            causes: Vec::new(),
            why: None,
            budgets: Vec::new(),
            parts: Vec::new(),
        };
        report.intervals.note(2.0, 200_000);
        for i in 1..=2000u64 {
            report.times("wake_latency_ns").record(i * 100);
            report.times("stage_ns.solve").record(i * 50);
            report.times("cyclictest.wake_latency_ns").record(i * 90);
        }
        report.count("ticks", 1990);
        report.count("deadline_misses", 10);
        for round in 0..3 {
            for (program, p50) in [
                ("station", 110 + 10 * u64::from(round)),
                ("cyclictest", 100),
            ] {
                report.rounds.push(Round {
                    round,
                    program: program.into(),
                    p50,
                    p99: 2 * p50,
                    max: 3 * p50,
                    missed: None,
                    stolen_ms: None,
                });
            }
        }
        report
    }

    #[test]
    fn keys_are_those_of_summary_json_and_cyclictest_has_the_same() {
        let json = sample().to_json();
        assert_eq!(json["wake_latency_ns"]["count"], 2000);
        for times in [
            &json["wake_latency_ns"],
            &json["cyclictest"]["wake_latency_ns"],
            &json["stage_ns"]["solve"],
        ] {
            let keys = ["p50", "p90", "p99", "p999", "p9999", "max"];
            let values: Vec<u64> = keys.iter().map(|k| times[k].as_u64().unwrap()).collect();
            assert!(values.is_sorted() && values[0] > 0, "{values:?}");
        }
        assert_eq!(json["ticks"], 1990);
        assert_eq!(json["misses_per_million"], 5000.0);
        assert_eq!(json["wake_latency_to_cyclictest"]["station"]["p50"], 1.2);
        assert_eq!(json["intervals_max_ns"], json!([200_000]));
        assert_eq!(
            (&json["interval_s"], &json["causes"]),
            (&json!(2.0), &json!([]))
        );
        let [low, high] =
            [0, 1].map(|i| json["ci95"]["wake_latency_ns"]["station"]["p50"][i].as_f64());
        assert!(
            low.zip(high)
                .is_some_and(|(low, high)| low < 120.0 && 120.0 < high)
        );
    }

    #[test]
    fn a_run_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let report = sample();
        let text = report.to_json().to_string();
        std::fs::write(folder.path().join(FILE), &text).unwrap();
        let again = Report::read(folder.path()).unwrap();
        assert_eq!(again.to_json().to_string(), text);
        let error = Report::read(&folder.path().join("none")).unwrap_err();
        assert!(error.to_string().contains("calot jitter --out"), "{error}");
        std::fs::write(folder.path().join(FILE), "{}").unwrap();
        let error = Report::read(folder.path()).unwrap_err();
        assert!(error.to_string().contains("not a run"), "{error}");
    }
}
