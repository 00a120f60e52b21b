//! Writes `jitter.html`: one page that needs no network. It begins with the verdict, one chart and
//! one table; the rest explains them.

mod causes;
mod turns;

use core::fmt::Write as _;

use figures::html::{STYLE, escape, machine_table};
use figures::times;

use crate::machines::{HEADINGS, Part};
use crate::report::Report;
use crate::table::{self, Row};
use crate::verdict;

/// Style that makes the page wider than other reports, because one table has eleven columns.
const WIDER: &str = "body{max-width:76rem}.two{display:grid;grid-template-columns:repeat(auto-fit,\
minmax(28rem,1fr));gap:0 1.5rem}td{white-space:nowrap}td:first-child{white-space:normal}\
.narrow th,.narrow td{padding:.25rem .4rem}.verdict{font-size:1.15rem}\
.machine td{white-space:normal;overflow-wrap:anywhere}.scroll{overflow-x:auto;font-size:.8rem}.scroll td:first-child{white-space:nowrap}\
.scroll th:last-child,.scroll td:last-child{text-align:left}\
.names th:nth-child(2),.names td:nth-child(2),.last th:last-child,.last td:last-child{text-align:left}";
/// Rows of the first table. A name that begins with a dot stands for all names that end with it.
const FIRST: [&str; 5] = [
    "wake_latency_ns",
    "tick_ns",
    "motion_to_force_ns",
    "hand_to_force_ns",
    ".wake_latency_ns",
];

/// Returns the page.
pub fn html(report: &Report) -> String {
    let load = match report.about.load.is_empty() {
        true => "no added load".to_owned(),
        false => format!("load: {}", report.about.load.join(", ")),
    };
    let head = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot jitter: {load}</title>\
         <style>{STYLE}{WIDER}</style><h1>Calot jitter: {}</h1>",
        escape(&report.about.scene)
    );
    [
        head,
        opening(report),
        about(report, &load),
        parts(&report.parts),
        causes::causes(report),
        causes::worst(report),
        causes::budgets(report),
        turns::section(report),
        intervals(report),
        all_times(report),
        charts(report),
        counts(report),
        "</html>\n".to_owned(),
    ]
    .concat()
}

/// Verdict, chart and table.
fn opening(report: &Report) -> String {
    let is_good = report.about.realtime && report.misses_per_million() <= 0.0;
    let mut page = format!(
        "<p class=\"verdict {}\">{}</p>",
        if is_good { "good" } else { "bad" },
        escape(&verdict::sentence(report))
    );
    let station = report.times.get("wake_latency_ns");
    let mut lines: Vec<_> = station
        .map(|times| ("station".to_owned(), times))
        .into_iter()
        .collect();
    for (name, times) in &report.times {
        if let Some(program) = name.strip_suffix(".wake_latency_ns") {
            lines.push((program.to_owned(), times));
        }
    }
    figure(
        &mut page,
        times::exceedance(&lines),
        "How often a wake-up is later than so many µs. Further left and lower is better; both axes \
         are logarithmic, so the right end is the rarest.",
    );
    let is_first = |row: &Row| {
        let name = row.name.as_str();
        let suffix = |first: &str| first.starts_with('.') && name.ends_with(first);
        FIRST.contains(&name) || FIRST.iter().any(|first| suffix(first))
    };
    let rows = table::rows(report);
    page + &quantiles(rows.into_iter().filter(is_first))
}

/// Remarks on the run as a whole.
fn about(report: &Report, load: &str) -> String {
    let about = &report.about;
    let mut page = format!(
        "<p class=\"lead\">{program}, {seconds:.0} s measured, {load}. {complete}<br><code>{command}</code></p>",
        program = escape(&about.program),
        seconds = about.seconds,
        complete = match about.complete {
            true => "It ran for its full time.",
            false => "<b>The run has not finished; these are the figures so far.</b>",
        },
        command = escape(&about.command),
    );
    page += match about.realtime {
        true => {
            "<p class=\"good\">Every tick ran under SCHED_FIFO, in locked memory, on a core of its \
             own.</p>"
        }
        false => {
            "<p class=\"bad\"><b>Not realtime.</b> These figures say little about a realtime \
             station. <code>calot check</code> names the remedy.</p>"
        }
    };
    if about.machine.virtual_machine {
        page += "<p class=\"lead\">This is a virtual machine: its host adds delays that no setting of the \
                 guest removes. Read the ratios, not the tails.</p>";
    }
    for note in &about.notes {
        let _ = write!(page, "<p class=\"lead\">Note: {}.</p>", with_code(note));
    }
    page
}

/// Text as HTML, with the parts between backquotes as code.
fn with_code(text: &str) -> String {
    let parts = text.split('`').enumerate();
    let parts = parts.map(|(i, part)| match i % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    });
    parts.collect()
}

/// Table of the runs of which this one is the sum.
fn parts(parts: &[Part]) -> String {
    if parts.is_empty() {
        return String::new();
    }
    let heads = HEADINGS.map(|heading| format!("<th>{heading}")).concat();
    let mut page = format!(
        "<h2>Runs and machines</h2><div class=\"scroll\"><table class=\"narrow\"><tr>{heads}</tr>"
    );
    for part in parts {
        let cells = part.cells().map(|cell| format!("<td>{}", escape(&cell)));
        let _ = write!(page, "<tr>{}</tr>", cells.concat());
    }
    page + "</table></div><p class=\"lead\">Times are wake-up latencies. Figures of different machines \
            were not taken in the same minutes: compare their ratios to cyclictest's. Everything else on \
            this page is the sum of the runs.</p>"
}

fn quantiles(rows: impl Iterator<Item = Row>) -> String {
    let mut page = String::from(
        "<table><tr><th>µs<th>p50<th>p90<th>p99<th>p99.9<th>p99.99<th>max<th>count</tr>",
    );
    for Row {
        label,
        quantiles: q,
        ..
    } in rows
    {
        page += "<tr><td>";
        page += &escape(&label).replace("  ", "&emsp;");
        for ns in [q.p50, q.p90, q.p99, q.p999, q.p9999, q.max] {
            let _ = write!(page, "<td>{:.1}", ns as f64 / 1e3);
        }
        let _ = write!(page, "<td>{}</tr>", q.count);
    }
    page + "</table>"
}

fn all_times(report: &Report) -> String {
    String::from("<h2>Times</h2>") + &quantiles(table::rows(report).into_iter())
}

/// Section with the maxima of the five-minute intervals.
fn intervals(report: &Report) -> String {
    let maxima = &report.intervals.max_ns;
    let Some(median_ns) = report.intervals.median_ns() else {
        return String::new();
    };
    let (length_s, median_us) = (report.intervals.interval_s, median_ns / 1e3);
    let words = match maxima.len() {
        1 => format!(
            "The run is one interval of {length_s:.0} s. Its latest wake-up came after \
             {median_us:.1} µs. Five minutes and more have an interval for each five minutes."
        ),
        n => format!(
            "{n} intervals of {length_s:.0} s. The latest wake-up of the median interval came after \
             {median_us:.1} µs."
        ),
    };
    let mut page = format!("<h2>Maxima of consecutive intervals</h2><p class=\"lead\">{words}</p>");
    if maxima.len() > 1 {
        figure(
            &mut page,
            times::course(&report.intervals.course(), "µs"),
            "Latest wake-up of each five minutes.",
        );
    }
    page
}

fn figure(page: &mut String, svg: Option<String>, caption: &str) {
    if let Some(svg) = svg {
        let _ = write!(
            page,
            "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
        );
    }
}

fn charts(report: &Report) -> String {
    let mut page = String::from("<h2>Charts</h2><div class=\"two\">");
    let step_s = report.timeline.step_s;
    figure(
        &mut page,
        times::course(&report.timeline.course(|worst| worst.wake_ns), "µs"),
        &format!("Latest wake-up of each {step_s} s."),
    );
    figure(
        &mut page,
        times::course(&report.timeline.course(|worst| worst.tick_ns), "µs"),
        &format!("Longest tick of each {step_s} s."),
    );
    for Row { name, label, .. } in table::rows(report) {
        let limit_us = matches!(name.as_str(), "tick_ns" | "period_ns").then_some(1000.0);
        let line = match limit_us {
            Some(_) => " The blue line is the period.",
            None => "",
        };
        if let Some(times) = report.times.get(&name) {
            let caption = format!("{}.{line}", escape(label.trim()));
            figure(&mut page, times::histogram(times, limit_us), &caption);
        }
    }
    page + "</div>"
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
    let samples = report
        .times
        .get("wake_latency_ns")
        .map_or(0, |it| it.count());
    let smis = match report.counts.get("smis") {
        Some(count) => count.to_string(),
        None => "not readable".to_owned(),
    };
    let load = match report.about.load.is_empty() {
        true => "none".to_owned(),
        false => report.about.load.join(", "),
    };
    let more = [
        ("system management interrupts", smis.as_str()),
        ("added load", &load),
        ("ticks measured", &samples.to_string()),
    ];
    let machine = machine_table(&report.about.machine, &more);
    page + "</table><div class=\"machine\">" + &machine + "</div>"
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
        report.about.notes.push("run `calot <check>`".into());
        let page = html(&report);
        assert!(page.contains("Note: run <code>calot &lt;check&gt;</code>."));
        assert!(page.contains("&lt;script&gt;") && !page.contains("<script"));
        assert!(!page.contains("src=") && !page.contains("href="));
        assert!(page.contains("Not realtime") && page.contains("<svg"));
        assert!(page.contains("cyclictest"));
    }

    #[test]
    fn it_begins_with_a_sentence_a_chart_and_a_table_and_tells_the_machine() {
        let mut report = sample();
        let page = html(&report);
        let places = ["Late: 10 of 2000", "<svg", "<table>", "<h2>"].map(|it| page.find(it));
        assert!(
            places.iter().all(Option::is_some) && places.is_sorted(),
            "{places:?}"
        );
        let first = page.split("</table>").next().unwrap_or_default();
        assert!(first.contains("wake-up latency of cyclictest") && !first.contains("stage"));
        for told in [
            "command line",
            "microcode",
            "governor",
            "system management interrupts<td>not readable",
            "ticks measured<td>2000",
            "The run is one interval of 2 s",
        ] {
            assert!(page.contains(told), "{told}");
        }
        report.parts = vec![Part::of(&report, "bench-1"), Part::of(&report, "bench-2")];
        let sum = html(&report);
        assert!(sum.contains("Runs and machines") && sum.contains("<td>bench-2<td>"));
    }
}
