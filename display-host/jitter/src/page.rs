//! Writes `jitter.html`: one page that needs no network.

use core::fmt::Write as _;

use figures::html::{STYLE, escape, machine_table};
use figures::times;

use crate::misses::{self, Missed};
use crate::report::{Ratio, Report};
use crate::table::{self, Row};

/// Rows in the table of the worst ticks.
const WORST_SHOWN: usize = 12;
/// Style that makes the page wider than other reports, because one table has eleven columns.
const WIDER: &str = "body{max-width:76rem}.two{display:grid;grid-template-columns:repeat(auto-fit,\
minmax(28rem,1fr));gap:0 1.5rem}td{white-space:nowrap}td:first-child{white-space:normal}";

/// Returns the page.
pub fn html(report: &Report) -> String {
    let mut page = String::new();
    // Writing to a string cannot fail.
    let mut add = |text: core::fmt::Arguments<'_>| {
        let _ = page.write_fmt(text);
    };
    let about = &report.about;
    let load = match about.load.is_empty() {
        true => "no added load".to_owned(),
        false => format!("load: {}", about.load.join(", ")),
    };
    add(format_args!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot jitter: {load}</title>\
         <style>{STYLE}{WIDER}</style><h1>Calot jitter: {scene}</h1>\
         <p class=\"lead\">{program}, {seconds:.0} s measured, {load}. {complete}<br><code>{command}</code></p>",
        scene = escape(&about.scene),
        program = escape(&about.program),
        seconds = about.seconds,
        complete = match about.complete {
            true => "It ran for its full time.",
            false => "<b>The run has not finished; these are the figures so far.</b>",
        },
        command = escape(&about.command),
    ));
    match about.realtime {
        true => add(format_args!(
            "<p class=\"good\">Every tick ran under SCHED_FIFO, in locked memory, on a core of its own. \
             Missed in a million periods: <b>{:.1}</b>.</p>",
            report.misses_per_million()
        )),
        false => add(format_args!(
            "<p class=\"bad\"><b>Not realtime.</b> These figures say little about a realtime \
             station. <code>calot check</code> names the remedy. Missed in a million periods: {:.1}.</p>",
            report.misses_per_million()
        )),
    }
    if about.machine.virtual_machine {
        add(format_args!(
            "<p class=\"lead\">This is a virtual machine: its host adds delays that no setting of the \
             guest removes. Read the ratios, not the tails.</p>"
        ));
    }
    for note in &about.notes {
        add(format_args!(
            "<p class=\"lead\">Note: {}.</p>",
            escape(note)
        ));
    }
    add(format_args!(
        "<h2>Times</h2><table><tr><th>µs<th>p50<th>p90<th>p99<th>p99.9<th>p99.99<th>max<th>count</tr>"
    ));
    for Row {
        label,
        quantiles: q,
        ..
    } in table::rows(report)
    {
        add(format_args!(
            "<tr><td>{}",
            escape(&label).replace("  ", "&emsp;")
        ));
        for ns in [q.p50, q.p90, q.p99, q.p999, q.p9999, q.max] {
            add(format_args!("<td>{:.1}", ns as f64 / 1e3));
        }
        add(format_args!("<td>{}</tr>", q.count));
    }
    add(format_args!("</table>"));
    page + &rounds(report) + &charts(report) + &worst(report) + &counts(report) + "</html>\n"
}

/// Tables of the programs that took turns with the station.
fn rounds(report: &Report) -> String {
    let ratios = report.ratios();
    let several = report.rounds.iter().any(|round| round.program != "station");
    if !several {
        return String::new();
    }
    let mut page = String::from("<h2>Compared, in turns</h2>");
    if !ratios.is_empty() {
        page += "<table><tr><th>wake-up latency ÷ cyclictest's, median of the rounds<th>p50<th>p99</tr>";
        for Ratio { program, p50, p99 } in &ratios {
            let _ = write!(page, "<tr><td>{program}<td>{p50:.2}<td>{p99:.2}</tr>");
        }
        page += "</table>";
    }
    let against_burn = misses::compare(&report.rounds);
    if !against_burn.is_empty() {
        page += "<table><tr><th>in a million periods<th>station<th>burn<th>station − burn: 95 % of \
                 draws of the rounds<th></tr>";
        for line in &against_burn {
            let [low, high] = line.difference;
            let _ = write!(
                page,
                "<tr><td>{}<td>{:.1}<td>{:.1}<td>{low:.1} to {high:.1}<td>{}</tr>",
                line.words.replace("  ", "&emsp;"),
                line.station,
                line.burn,
                misses::verdict(line),
            );
        }
        page += "</table><p class=\"lead\"><b>burn</b> is a bare loop of <code>clock_nanosleep</code> at the same \
                 priority on the same core. In each period it works as long as the corresponding tick \
                 of the station's previous turn.</p>";
    }
    page += "<table><tr><th>program<th>round<th>p50, µs<th>p99, µs<th>max, µs<th>periods missed in a million\
             <th>periods missed: program woken too late<th>periods missed: its last tick still at work\
             <th>occasions of missed periods<th>ticks that ended late\
             <th>stolen by the hypervisor, ms</tr>";
    for r in &report.rounds {
        let us = |ns: u64| ns as f64 / 1e3;
        let known = |value: Option<u64>| value.map_or("–".to_owned(), |n| n.to_string());
        let count = |of: fn(Missed) -> u64| known(r.missed.map(of));
        let share = r.misses_per_million();
        let missed = share.map_or("–".to_owned(), |m| format!("{m:.1}"));
        let causes = [
            count(|m| m.woken_late),
            count(|m| m.at_work),
            count(|m| m.occasions),
            count(|m| m.late_ticks),
            known(r.stolen_ms),
        ];
        let causes = causes.join("<td>");
        let _ = write!(
            page,
            "<tr><td>{}<td>{}<td>{:.1}<td>{:.1}<td>{:.1}<td>{missed}<td>{causes}</tr>",
            escape(&r.program),
            r.round + 1,
            us(r.p50),
            us(r.p99),
            us(r.max)
        );
    }
    page + "</table>"
}

fn charts(report: &Report) -> String {
    let mut page = String::new();
    let mut figure = |svg: Option<String>, caption: &str| {
        if let Some(svg) = svg {
            let _ = write!(
                page,
                "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
            );
        }
    };
    let station = report.times.get("wake_latency_ns");
    let mut lines: Vec<_> = station
        .map(|t| ("station".to_owned(), t))
        .into_iter()
        .collect();
    for (name, times) in &report.times {
        if let Some(program) = name.strip_suffix(".wake_latency_ns") {
            lines.push((program.to_owned(), times));
        }
    }
    figure(
        times::exceedance(&lines),
        "How often a wake-up is later than so many µs. Further left and lower is better; both axes \
         are logarithmic, so the right end is the rarest.",
    );
    figure(
        times::course(&report.timeline.course(|worst| worst.wake_ns), "µs"),
        &format!("Latest wake-up of each {} s.", report.timeline.step_s),
    );
    figure(
        times::course(&report.timeline.course(|worst| worst.tick_ns), "µs"),
        &format!("Longest tick of each {} s.", report.timeline.step_s),
    );
    for Row { name, label, .. } in table::rows(report) {
        let limit_us = matches!(name.as_str(), "tick_ns" | "period_ns").then_some(1000.0);
        if let Some(times) = report.times.get(&name) {
            let line = if limit_us.is_some() {
                " The blue line is the period."
            } else {
                ""
            };
            figure(
                times::histogram(times, limit_us),
                &format!("{}.{line}", escape(label.trim())),
            );
        }
    }
    format!("<h2>Charts</h2><div class=\"two\">{page}</div>")
}

fn worst(report: &Report) -> String {
    let mut page = String::from(
        "<h2>Worst ticks</h2><p class=\"lead\"><code>jitter.trace.json</code> \
         holds the ticks around each of these. Open it in ui.perfetto.dev or chrome://tracing.</p>\
         <table><tr><th>at, s<th>tick<th>woken late, µs<th>tick took, µs<th>longest stage<th>periods missed before it</tr>",
    );
    for incident in report.incidents.iter().take(WORST_SHOWN) {
        let Some(tick) = incident.peak() else {
            continue;
        };
        let stages = crate::tally::STAGE_NAMES.iter().zip(&tick.stage_ns);
        let (stage, ns) = stages
            .max_by_key(|(_, ns)| **ns)
            .map_or(("", 0), |(s, ns)| (*s, *ns));
        let us = |ns: u32| f64::from(ns) / 1e3;
        let _ = write!(
            page,
            "<tr><td>{:.3}<td>{}<td>{:.1}<td>{:.1}<td>{stage} {:.1}<td>{}</tr>",
            incident.at_ms as f64 / 1e3,
            tick.tick,
            us(tick.wake_latency_ns),
            us(tick.tick_ns),
            us(ns),
            tick.missed
        );
    }
    page + "</table>"
}

fn counts(report: &Report) -> String {
    let mut page = String::from("<h2>Counters</h2><table>");
    for (name, count) in &report.counts {
        let _ = write!(page, "<tr><td>{}<td>{count}</tr>", escape(name));
    }
    if let Some([first, last]) = report.about.memory_kib {
        let _ = write!(
            page,
            "<tr><td>memory of calot jitter after its first minute, at its end<td>{first} KiB, {last} KiB</tr>"
        );
    }
    page + "</table>" + &machine_table(&report.about.machine, &[])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    #[test]
    fn the_page_needs_no_network_and_lets_nothing_in() {
        let mut report = sample();
        report.about.scene = "<script>x</script>".into();
        report.about.realtime = false;
        let page = html(&report);
        assert!(page.contains("&lt;script&gt;") && !page.contains("<script"));
        assert!(!page.contains("src=") && !page.contains("href="));
        assert!(page.contains("Not realtime") && page.contains("<svg"));
        assert!(page.contains("cyclictest"));
    }
}
