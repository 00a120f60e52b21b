//! Causes of late ticks: by what ran instead, by stage, and for each of the worst ticks.

use core::fmt::Write as _;

use figures::bands::{self, Band};
use figures::html::escape;

use shared_mem::message::STAGE_NAMES;

use crate::blackbox::Incident;
use crate::report::Report;
use crate::why::{self, What};

/// Largest number of rows in the tables of causes and of the worst ticks.
const SHOWN: usize = 12;
/// Times at which the heat map's colours change, µs: half decades up to the period.
const HEAT_US: [f64; 5] = [10.0, 30.0, 100.0, 300.0, 1000.0];

/// Table of what ran while ticks were late.
pub(super) fn causes(report: &Report) -> String {
    let Some(source) = &report.why else {
        return String::from(
            "<h2>Why ticks were late</h2><p class=\"lead\">This run did not ask: \
             <code>calot jitter --why</code> names what ran instead.</p>",
        );
    };
    let mut page = String::from("<h2>Why ticks were late</h2>");
    if source.is_coarse {
        let _ = write!(
            page,
            "<p class=\"bad\"><b>Coarse.</b> These causes are guessed from counters that rose within \
             50 ms of the late tick. The kernel's events name them exactly, but: {}.</p>",
            escape(&source.missing)
        );
    }
    let _ = write!(
        page,
        "<p class=\"lead\">{} ticks lost more than {} µs each. ",
        source.late_ticks,
        why::LATE_NS / 1000
    );
    if !source.is_coarse {
        let _ = write!(
            page,
            "Read from {} events of the kernel; {} more were lost.",
            source.events, source.lost_events
        );
        if !source.missing.is_empty() {
            let _ = write!(
                page,
                " These are switches of threads alone. Interrupts and softirqs count as the thread that \
                 they broke into, because: {}.",
                escape(&source.missing)
            );
        }
    }
    page += "</p>";
    if report.causes.is_empty() {
        return page;
    }
    page += "<table class=\"names\"><tr><th>what ran instead<th>name<th>time lost, µs<th>share<th>late ticks\
             <th>mean, µs</tr>";
    let all: u64 = report.causes.iter().map(|cause| cause.lost_us).sum();
    for cause in report.causes.iter().take(SHOWN) {
        let _ = write!(
            page,
            "<tr><td>{}<td>{}<td>{}<td>{:.1} %<td>{}<td>{:.1}</tr>",
            cause.what.name(),
            escape(&cause.name),
            cause.lost_us,
            100.0 * cause.lost_us as f64 / all.max(1) as f64,
            cause.ticks,
            cause.lost_us as f64 / cause.ticks.max(1) as f64,
        );
    }
    page += "</table>";
    if let Some(rest) = report.causes.len().checked_sub(SHOWN).filter(|&n| n > 0) {
        let _ = write!(
            page,
            "<p class=\"lead\">{rest} more are in <code>jitter.json</code>.</p>"
        );
    }
    page
}

/// Table of the stages, and their cost over the run.
pub(super) fn budgets(report: &Report) -> String {
    let mut page = String::from("<h2>Cost of the stages</h2>");
    if !report.budgets.is_empty() {
        page += "<table><tr><th>part of a tick<th>admitted, µs<th>worst, µs<th>ticks past their period, laid to it\
                 <th>share</tr>";
    }
    for row in &report.budgets {
        let us = |ns: u64| format!("{:.1}", ns as f64 / 1e3);
        let _ = write!(
            page,
            "<tr><td>{}<td>{}<td>{}<td>{}<td>{:.0} %</tr>",
            escape(&row.stage),
            row.admitted_ns.map_or("–".to_owned(), us),
            us(row.worst_ns),
            row.late_ticks,
            100.0 * row.late_share,
        );
    }
    if !report.budgets.is_empty() {
        page += "</table><p class=\"lead\">Admitted is what the stage took in the worst tick of the \
                 controller's trial before the run. A tick that ended after its period, or came \
                 after missed ones, is laid to the part that exceeded its due most; nothing is due to the \
                 wake-up.</p>";
    }
    let steps = &report.timeline.stages_ns;
    let row = |i: usize| {
        let each = steps.iter().map(|step| step.get(i).copied().unwrap_or(0));
        each.map(|ns| f64::from(ns) / 1e3).collect()
    };
    let bands: Vec<Band<'_>> = STAGE_NAMES
        .iter()
        .enumerate()
        .map(|(i, name)| Band {
            name,
            values: row(i),
        })
        .collect();
    let seconds = steps.len() as f64 * f64::from(report.timeline.step_s);
    if let Some(svg) = bands::bands(&bands, seconds, HEAT_US, "µs") {
        let _ = write!(
            page,
            "<figure>{svg}<figcaption>Longest time of each stage over the run, µs. A cell is {} s or \
             more.</figcaption></figure>",
            report.timeline.step_s
        );
    }
    page
}

/// Table of the worst ticks.
pub(super) fn worst(report: &Report) -> String {
    let mut page = String::from(
        "<h2>Worst ticks</h2><p class=\"lead\"><code>jitter.trace.json</code> \
         holds the ticks around each of these. Open it in ui.perfetto.dev or chrome://tracing.</p>\
         <table class=\"last\"><tr><th>at, s<th>tick<th>woken late, µs<th>tick took, µs<th>longest stage\
         <th>periods missed before it<th>ran instead, µs</tr>",
    );
    for incident in report.incidents.iter().take(SHOWN) {
        let Some(tick) = incident.peak() else {
            continue;
        };
        let stages = STAGE_NAMES.iter().zip(&tick.stage_ns);
        let (stage, ns) = stages
            .max_by_key(|(_, ns)| **ns)
            .map_or(("", 0), |(s, ns)| (*s, *ns));
        let us = |ns: u32| f64::from(ns) / 1e3;
        let _ = write!(
            page,
            "<tr><td>{:.3}<td>{}<td>{:.1}<td>{:.1}<td>{stage} {:.1}<td>{}<td>{}</tr>",
            incident.at_ms as f64 / 1e3,
            tick.tick,
            us(tick.wake_latency_ns),
            us(tick.tick_ns),
            us(ns),
            tick.missed,
            escape(&instead(incident, report.about.machine.virtual_machine)),
        );
    }
    page + "</table>"
}

/// The two things to which the worst tick of an incident lost most time.
fn instead(incident: &Incident, virtual_machine: bool) -> String {
    let Some(tick) = incident.peak().filter(|_| !incident.slices.is_empty()) else {
        return "–".to_owned();
    };
    let losses = why::losses(tick, &incident.slices, virtual_machine);
    let words: Vec<String> = losses
        .iter()
        .take(2)
        .map(|loss| {
            let us = loss.ns as f64 / 1e3;
            match loss.what {
                What::Steal | What::Idle | What::Tick => format!("{} {us:.0}", loss.name),
                what => format!("{} {} {us:.0}", what.name(), loss.name),
            }
        })
        .collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;
    use crate::why::tests::{slice, tick};
    use crate::why::{Cause, Source};

    fn explained() -> Report {
        let mut report = sample();
        report.causes.push(Cause {
            what: What::Thread,
            name: "kworker/<1>".to_owned(),
            lost_us: 750,
            ticks: 3,
        });
        report.why = Some(Source {
            name: "events".to_owned(),
            is_coarse: false,
            missing: String::new(),
            events: 123,
            lost_events: 4,
            late_ticks: 3,
        });
        report.incidents.push(Incident {
            at_ms: 5,
            worst: 0,
            ticks: vec![tick(1_000_000, 250_000, 100_000)],
            slices: vec![slice(What::Thread, "kworker/<1>", 900_000, 350_000)],
        });
        report
    }

    #[test]
    fn causes_are_told_with_their_source_and_a_guess_is_called_coarse() {
        assert!(causes(&sample()).contains("calot jitter --why"));
        let mut report = explained();
        let page = causes(&report);
        assert!(
            page.contains("kworker/&lt;1&gt;<td>750<td>100.0 %<td>3<td>250.0"),
            "{page}"
        );
        assert!(page.contains("123 events") && !page.contains("Coarse"));
        if let Some(source) = &mut report.why {
            source.is_coarse = true;
            source.missing = "tracefs is not mounted".to_owned();
        }
        let coarse = causes(&report);
        assert!(coarse.contains("Coarse") && coarse.contains("tracefs is not mounted"));
    }

    #[test]
    fn the_worst_ticks_name_what_ran_instead_and_stages_their_share() {
        let mut report = explained();
        let page = worst(&report);
        assert!(page.contains("thread kworker/&lt;1&gt; 250"), "{page}");
        report.timeline.stages_ns = vec![[5000, 0, 0, 400_000, 0, 0, 0]; 3];
        report.budgets = crate::budgets::Budgets::default().table();
        let page = budgets(&report);
        assert!(page.contains("wake-up") && page.contains("<svg"), "{page}");
    }
}
