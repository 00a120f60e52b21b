//! Prints the figures as a table and as CSV.

use core::fmt::Write as _;

use figures::Quantiles;

use shared_mem::message::STAGE_NAMES;

use crate::report::{Ratio, Report};
use crate::{certainty, machines, misses, verdict, why};

/// Names and labels of the rows, in the order of a tick. Other rows follow sorted by name.
const ROWS: [(&str, &str); 11] = [
    ("wake_latency_ns", "wake-up latency: begun − due"),
    ("period_ns", "period: begun − the one before"),
    ("tick_ns", "whole tick"),
    ("stage_ns.", "  stage "),
    (
        "motion_to_force_ns",
        "motion to force: sample arrived → force written",
    ),
    (
        "motion_to_tick_ns",
        "  of it before the tick: the sample's wait, wake-up included",
    ),
    (
        "hand_to_force_ns",
        "hand to force: sample taken → first sample with the force, by the device's clock",
    ),
    (
        "hand_to_force_more_ns",
        "  more than motion to force: line, device, and the wait for that sample",
    ),
    (
        "force_to_publish_ns",
        "force to publish: written → frame handed over",
    ),
    (
        "publish_to_display_ns",
        "publish to display: frame filled → a host that looks every ms has it",
    ),
    (
        "publish_to_frame_ns",
        "publish to frame: frame filled → picture submitted",
    ),
];

/// Largest number of causes printed.
const CAUSES_SHOWN: usize = 8;

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Dotted name.
    pub name: String,
    /// Label.
    pub label: String,
    /// Quantiles, ns.
    pub quantiles: Quantiles,
}

/// Rows of the recorded figures, in order.
pub fn rows(report: &Report) -> Vec<Row> {
    let mut rows: Vec<(usize, usize, String, String)> = Vec::new();
    for name in report.times.keys() {
        let place = ROWS
            .iter()
            .position(|(row, _)| name == row || (row.ends_with('.') && name.starts_with(row)));
        let within = |stage: &str| {
            let mut stages = STAGE_NAMES.iter();
            stages.position(|&s| s == stage).unwrap_or(0)
        };
        let (order, label) = match place {
            Some(i) => match (name.strip_prefix("stage_ns."), ROWS.get(i)) {
                (Some(stage), Some((_, label))) => (within(stage), format!("{label}{stage}")),
                (None, Some((_, label))) => (0, (*label).to_owned()),
                (_, None) => (0, name.clone()),
            },
            None => (0, label(name)),
        };
        rows.push((place.unwrap_or(ROWS.len()), order, name.clone(), label));
    }
    rows.sort();
    rows.into_iter()
        .filter_map(|(_, _, name, label)| {
            let quantiles = report.times.get(&name)?.quantiles();
            (quantiles.count > 0).then_some(Row {
                name,
                label,
                quantiles,
            })
        })
        .collect()
}

fn label(name: &str) -> String {
    match name {
        "frame_ns" => "frame time: picture submitted → there".to_owned(),
        _ => match name.strip_suffix(".wake_latency_ns") {
            Some(program) => format!("wake-up latency of {program}"),
            None => match name.strip_suffix(".tick_ns") {
                Some(program) => format!("work of {program} in each period"),
                None => name.to_owned(),
            },
        },
    }
}

/// Returns the table for standard output.
pub fn text(report: &Report) -> String {
    let mut text = String::new();
    let mut line = |words: core::fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{words}");
    };
    let about = &report.about;
    let load = match about.load.is_empty() {
        true => "no added load".to_owned(),
        false => format!("load {}", about.load.join(", ")),
    };
    let m = &about.machine;
    line(format_args!("{}", verdict::sentence(report)));
    line(format_args!(
        "{}: {}, {:.0} s, {load}",
        about.program, about.scene, about.seconds
    ));
    line(format_args!(
        "{}, {} cores, {} {}{}, load average before {}",
        m.processor,
        m.cores,
        m.kernel,
        m.kernel_version,
        if m.virtual_machine {
            ", virtual machine"
        } else {
            ""
        },
        m.load_average,
    ));
    if !about.realtime {
        line(format_args!("NOT REALTIME: `calot check` names the remedy"));
    }
    for note in &about.notes {
        line(format_args!("{note}"));
    }
    if let Some([first, last]) = about.memory_kib {
        line(format_args!(
            "this program held {first} KiB after its first minute, {last} KiB at the end"
        ));
    }
    line(format_args!(
        "{:72}{:>9}{:>9}{:>9}{:>9}{:>9}{:>10}{:>10}",
        "µs", "p50", "p90", "p99", "p99.9", "p99.99", "max", "count"
    ));
    for Row {
        label,
        quantiles: q,
        ..
    } in rows(report)
    {
        let us = |ns: u64| ns as f64 / 1e3;
        line(format_args!(
            "{label:72}{:9.1}{:9.1}{:9.1}{:9.1}{:9.1}{:10.1}{:10}",
            us(q.p50),
            us(q.p90),
            us(q.p99),
            us(q.p999),
            us(q.p9999),
            us(q.max),
            q.count
        ));
    }
    line(format_args!(
        "missed in a million periods: {:.1}",
        report.misses_per_million()
    ));
    let counts = report.counts.iter();
    let (interrupts, counts): (Vec<_>, Vec<_>) =
        counts.partition(|(name, _)| name.starts_with("interrupts."));
    for group in [counts, interrupts] {
        let words: Vec<String> = group
            .iter()
            .map(|(name, n)| format!("{name} {n}"))
            .collect();
        line(format_args!("{}", words.join(", ")));
    }
    let against_burn = misses::compare(&report.rounds);
    if !against_burn.is_empty() {
        line(format_args!(
            "{:48}{:>11}{:>11}   95 % of station − burn",
            "in a million periods", "station", "burn"
        ));
    }
    for found in &against_burn {
        let [low, high] = found.difference;
        line(format_args!(
            "{:48}{:11.1}{:11.1}   {low:.1} to {high:.1}: {}",
            found.words,
            found.station,
            found.burn,
            misses::verdict(found),
        ));
    }
    for Ratio { program, p50, p99 } in report.ratios() {
        let [_, of_p99] = certainty::ratio(&report.rounds, &program);
        let of_p99 = of_p99.map_or(String::new(), |[low, high]| {
            format!(" (95 %: {low:.2} to {high:.2})")
        });
        line(format_args!(
            "wake-up latency ÷ cyclictest's, median of the rounds: {program} p50 {p50:.2}, p99 \
             {p99:.2}{of_p99}"
        ));
    }
    text + &causes(report) + &machines::text(&report.parts)
}

/// Causes of late ticks: what ran instead, and the stages that made ticks late.
fn causes(report: &Report) -> String {
    let mut text = String::new();
    if let Some(why) = &report.why {
        let _ = writeln!(
            text,
            "{} ticks lost more than {} µs each{}",
            why.late_ticks,
            why::LATE_NS / 1000,
            match why.is_coarse {
                true => format!("; COARSE, from counters, because {}", why.missing),
                false if why.missing.is_empty() => String::new(),
                false => format!("; threads alone, because {}", why.missing),
            }
        );
    }
    if !report.causes.is_empty() {
        let _ = writeln!(text, "{:48}{:>12}{:>11}", "lost to", "µs", "late ticks");
    }
    for cause in report.causes.iter().take(CAUSES_SHOWN) {
        let name = format!("{} {}", cause.what.name(), cause.name);
        let _ = writeln!(text, "{name:48}{:12}{:11}", cause.lost_us, cause.ticks);
    }
    for row in report.budgets.iter().filter(|row| row.late_ticks > 0) {
        let _ = writeln!(
            text,
            "ticks past their period, laid to {}: {} ({:.0} %)",
            row.stage,
            row.late_ticks,
            100.0 * row.late_share
        );
    }
    text
}

/// Returns `jitter.csv`: a row per figure, times in ns.
pub fn csv(report: &Report) -> String {
    let mut text = String::from("name,count,p50,p90,p99,p999,p9999,max\n");
    for Row {
        name, quantiles: q, ..
    } in rows(report)
    {
        let _ = writeln!(
            text,
            "{name},{},{},{},{},{},{},{}",
            q.count, q.p50, q.p90, q.p99, q.p999, q.p9999, q.max
        );
    }
    for (name, count) in &report.counts {
        let _ = writeln!(text, "{name},{count},,,,,,");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn rows_are_in_the_order_of_a_tick_and_csv_has_them_all() {
        let mut report = sample();
        report.times("tick_ns").record(5);
        report.times("stage_ns.sample").record(5);
        report.times("period_ns");
        let names: Vec<String> = rows(&report).into_iter().map(|row| row.name).collect();
        let expected = [
            "wake_latency_ns",
            "tick_ns",
            "stage_ns.sample",
            "stage_ns.solve",
            "cyclictest.wake_latency_ns",
        ];
        assert_eq!(names, expected, "only recorded times have a row");
        let csv = csv(&report);
        let columns: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
        assert!(columns.iter().all(|&n| n == 8), "{csv}");
        assert_eq!(columns.len(), 1 + expected.len() + report.counts.len());
    }

    #[test]
    fn causes_and_stages_are_told_and_a_guess_is_called_coarse() {
        let mut report = sample();
        report.causes.push(why::Cause {
            what: why::What::Softirq,
            name: "NET_RX".to_owned(),
            lost_us: 1234,
            ticks: 5,
        });
        report.why = Some(why::Source {
            name: "counters".to_owned(),
            is_coarse: true,
            missing: "tracefs is not mounted".to_owned(),
            events: 0,
            lost_events: 0,
            late_ticks: 5,
        });
        let mut solve = crate::budgets::Budget::default();
        "solve".clone_into(&mut solve.stage);
        (solve.late_ticks, solve.late_share) = (3, 0.75);
        report.budgets.push(solve);
        let table = text(&report);
        assert!(
            table.contains(
                "5 ticks lost more than 100 µs each; COARSE, from counters, because tracefs"
            ),
            "{table}"
        );
        assert!(
            table.contains("softirq NET_RX") && table.contains("1234"),
            "{table}"
        );
        assert!(
            table.contains("ticks past their period, laid to solve: 3 (75 %)"),
            "{table}"
        );
    }

    #[test]
    fn the_table_says_what_it_was_and_when_it_was_not_realtime() {
        let mut report = sample();
        let table = text(&report);
        assert!(
            table.contains("load cpu") && table.contains("5000.0"),
            "{table}"
        );
        assert!(table.contains("station p50 1.20"), "{table}");
        assert!(table.starts_with("Late: 10 of 2000"), "{table}");
        assert!(table.contains("(95 %: "), "{table}");
        assert!(!table.contains("NOT REALTIME"));
        report.about.realtime = false;
        assert!(text(&report).contains("NOT REALTIME"));
    }
}
