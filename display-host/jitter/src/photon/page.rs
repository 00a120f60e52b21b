//! Writes `photon.html`: one page that needs no network.

use core::fmt::Write as _;

use figures::html::{STYLE, escape, machine_table};
use figures::times;

use super::pair::Pairs;
use super::report::{Figures, Report, Spread, screen};

/// Returns the page. `pairs` are those of the rows of the report.
#[must_use]
pub fn html(report: &Report, pairs: &[Pairs]) -> String {
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot photon</title><style>{STYLE}</style>\
         <h1>Calot photon: {}</h1><p class=\"{}\">{}</p>",
        escape(&report.scene),
        if report.is_whole() { "good" } else { "bad" },
        escape(&report.sentence()),
    );
    page += &chart(report, pairs);
    page += &table(&report.places);
    let sensor = &report.sensor;
    let within = sensor.within_ms.map_or_else(
        || "It saw no edge.".to_owned(),
        |ms| format!("It tells a time to ±{ms:.2} ms."),
    );
    let inverted = if sensor.inverted {
        " It says dark for bright."
    } else {
        ""
    };
    let _ = write!(
        page,
        "<p class=\"lead\">{}<br>Sensor: {} ({}). {within}{inverted} A delay of {:.1} ms is left \
         out.<br>Screen: {}.<br><code>{}</code></p>",
        escape(&report.program),
        escape(&sensor.name),
        sensor.kind,
        sensor.delay_ms,
        escape(&screen(&report.screen)),
        escape(&report.command),
    );
    for note in &report.notes {
        let _ = write!(page, "<p class=\"lead\">Note: {}.</p>", escape(note));
    }
    page + &machine_table(&report.machine, &[]) + "</html>\n"
}

/// Times to light over the run, by place and cause.
fn chart(report: &Report, pairs: &[Pairs]) -> String {
    let first_ns = pairs.iter().filter_map(|it| it.seen_at_ns.first());
    let first_ns = first_ns.min().copied().unwrap_or(0);
    let mut rows = Vec::new();
    for (row, pairs) in report.places.iter().zip(pairs) {
        let seen = pairs.seen_at_ns.iter().zip(&pairs.to_light_ns);
        let point =
            |(&at_ns, &ns): (&u64, &u64)| ((at_ns - first_ns) as f64 / 1e9, ns as f64 / 1e6);
        let points: Vec<(f64, f64)> = seen.map(point).collect();
        if !points.is_empty() {
            rows.push((format!("{} {}", row.place, row.from), points));
        }
    }
    let lines: Vec<(&str, &[(f64, f64)])> = (rows.iter())
        .map(|(name, points)| (name.as_str(), points.as_slice()))
        .collect();
    match times::courses(&lines, "ms") {
        Some(svg) => format!(
            "<figure>{svg}<figcaption>Time from tick or motion to light, over the run.\
             </figcaption></figure>"
        ),
        None => String::new(),
    }
}

fn table(places: &[Figures]) -> String {
    let mut page = "<table><tr><th>ms<th>changes<th>unseen<th>light p50<th>p90<th>max\
                    <th>picture p50<th>max<th>presented p50<th>max<th>then p50<th>max</tr>"
        .to_owned();
    let cell = |spread: Option<Spread>, of: fn(Spread) -> f64| {
        spread.map_or_else(|| "–".to_owned(), |spread| format!("{:.1}", of(spread)))
    };
    for it in places {
        let cells = [
            cell(it.to_light_ms, |s| s.median),
            cell(it.to_light_ms, |s| s.p90),
            cell(it.to_light_ms, |s| s.max),
            cell(it.to_picture_ms, |s| s.median),
            cell(it.to_picture_ms, |s| s.max),
            cell(it.to_presentation_ms, |s| s.median),
            cell(it.to_presentation_ms, |s| s.max),
            cell(it.picture_to_light_ms, |s| s.median),
            cell(it.picture_to_light_ms, |s| s.max),
        ];
        let _ = write!(
            page,
            "<tr><td>{}, from {}<td>{}<td>{}<td>{}</tr>",
            it.place,
            it.from,
            it.changes,
            it.unseen,
            cells.join("<td>")
        );
    }
    page + "</table><p class=\"lead\">From the tick: from its reading of the devices. From the motion: \
            from the arrival of the sample at this computer. Picture: until the display hands it to the \
            driver. Presented: until the window system presents it; a picture copied into a window may be \
            seen a frame later. Then: from the handing over to the light.</p>"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::report::tests::{pairs, sample};

    #[test]
    fn the_page_needs_no_network_and_lets_nothing_in() {
        let page = html(&sample(), &[pairs(), Pairs::default()]);
        assert!(page.contains("--pin &lt;x&gt;") && !page.contains("<script"));
        assert!(!page.contains("src=") && !page.contains("href="));
        let places = ["A tick was seen", "<svg", "<table>", "<h2>"].map(|it| page.find(it));
        assert!(
            places.iter().all(Option::is_some) && places.is_sorted(),
            "{places:?}"
        );
        assert!(
            page.contains("<td>top, from tick<td>3<td>1<td>34.0"),
            "{page}"
        );
        assert!(page.contains("<td>top, from motion<td>0<td>0<td>–"));
        assert!(page.contains("70 by a copy into the window"));
    }
}
