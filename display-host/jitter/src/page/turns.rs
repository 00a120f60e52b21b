//! Tables of the programs that took turns with the station.

use core::fmt::Write as _;

use figures::html::escape;

use crate::certainty;
use crate::misses::{self, Missed};
use crate::report::{Ratio, Report};

/// The section; empty if the station ran alone.
pub(super) fn section(report: &Report) -> String {
    let several = report.rounds.iter().any(|round| round.program != "station");
    if !several {
        return String::new();
    }
    String::from("<h2>Compared, in turns</h2>") + &ratios(report) + &misses(report) + &turns(report)
}

fn ratios(report: &Report) -> String {
    let ratios = report.ratios();
    if ratios.is_empty() {
        return String::new();
    }
    let mut page = String::from(
        "<table><tr><th>wake-up latency ÷ cyclictest's<th>p50, median of the turns<th>95 % interval\
         <th>p99, median of the turns<th>95 % interval</tr>",
    );
    for Ratio { program, p50, p99 } in &ratios {
        let [of_p50, of_p99] = certainty::ratio(&report.rounds, program).map(interval);
        let _ = write!(
            page,
            "<tr><td>{program}<td>{p50:.2}<td>{of_p50}<td>{p99:.2}<td>{of_p99}</tr>"
        );
    }
    page + "</table><p class=\"lead\">The interval holds the geometric mean over the turns with 95 % \
            confidence.</p>"
}

/// An interval in words.
fn interval(found: Option<[f64; 2]>) -> String {
    found.map_or("fewer than 3 turns".to_owned(), |[low, high]| {
        format!("{low:.2} to {high:.2}")
    })
}

fn misses(report: &Report) -> String {
    let against_burn = misses::compare(&report.rounds);
    if against_burn.is_empty() {
        return String::new();
    }
    let mut page = String::from(
        "<table><tr><th>in a million periods<th>station<th>burn<th>station − burn: 95 % bootstrap \
         interval over the rounds<th></tr>",
    );
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
    page + "</table><p class=\"lead\"><b>burn</b> is a bare loop of <code>clock_nanosleep</code> at the same \
            priority on the same core. In each period it works as long as the corresponding tick of the \
            station's previous turn.</p>"
}

fn turns(report: &Report) -> String {
    let mut page = String::from(
        "<table class=\"narrow\"><tr><th>program<th>round<th>p50, µs<th>p99, µs<th>max, µs\
         <th>periods missed in a million<th>missed: woken too late<th>missed: last tick still at work\
         <th>occasions of one missed period or more<th>ticks that ended late<th>stolen by the host, ms</tr>",
    );
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
