//! HTML page about a test by hand: its checks, and the device's response to forces along x.

use core::fmt::Write as _;

use figures::html::{STYLE, escape};
use figures::times;
use hardware::conformance::CheckOutcome;
use hardware::feel::{Felt, Point};

/// The page as text.
pub(super) fn page(felt: &Felt) -> String {
    let device = escape(&felt.report.device);
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: {device}</title><style>{STYLE}</style>\
         <h1>Test by hand</h1><p class=\"lead\">{device}. {}</p><table>",
        match felt.report.passed() {
            true => "It passed.",
            false => "<b>It did not pass.</b>",
        }
    );
    for check in &felt.report.checks {
        let (class, result) = match check.outcome {
            CheckOutcome::Pass => ("good", "ok"),
            CheckOutcome::Fail => ("bad", "FAIL"),
            CheckOutcome::NotJudged => ("bad", "not judged"),
            CheckOutcome::Skipped => ("lead", "skipped"),
        };
        // Writing to a string cannot fail.
        let _ = write!(
            page,
            "<tr><td style=\"white-space:nowrap\">{}<td class=\"{class}\">{result}<td style=\"text-align:left\">{}</tr>",
            escape(check.name),
            escape(&check.detail)
        );
    }
    page += "</table>";
    let curve = |of: fn(&Point) -> f32| -> Vec<(f64, f64)> {
        let points = felt.response.iter();
        points.map(|it| (it.at_s.into(), of(it).into())).collect()
    };
    let force = curve(|it| it.force_n);
    let first_m = felt.response.first().map_or(0.0, |it| it.position_m);
    let mut travel = curve(|it| it.position_m * 1e3);
    for (_, mm) in &mut travel {
        *mm -= f64::from(first_m) * 1e3;
    }
    if felt.response.is_empty() {
        page += "<p class=\"lead\">There are no charts: the test ended before its force along x (steps, a sine, \
                 a chirp).</p>";
    }
    for (line, unit, caption) in [
        (
            force,
            "force along x, N",
            "Commanded force along x: steps, a sine, a chirp to 30 Hz.",
        ),
        (
            travel,
            "position along x, mm",
            "Position along x, relative to the first sample.",
        ),
    ] {
        if let Some(svg) = times::courses(&[("", &line)], unit) {
            let _ = write!(
                page,
                "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
            );
        }
    }
    page + "</html>\n"
}
