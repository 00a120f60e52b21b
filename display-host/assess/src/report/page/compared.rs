//! Four parts of the debrief: the pictures, the earlier sessions, the instructor's sheet and the
//! table of all metrics.

use base64::Engine as _;
use figures::html::escape;

use super::{Page, drawing};
use crate::metrics::Metric;
use crate::report::Chapter;

/// Writes the pictures with their captions.
pub(super) fn pictures(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.pictures.is_empty() {
        return;
    }
    page.heading("page-pictures");
    page.add(format_args!("<div class=\"frames\">"));
    for (caption, bytes) in &chapter.pictures {
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        // Captions of known pictures have a translated message. Other captions are shown as they
        // are.
        let id = format!("picture-{}", caption.replace(' ', "-"));
        let frame = caption.strip_prefix("frame ");
        let caption = match frame.and_then(|it| it.parse::<u32>().ok()) {
            Some(number) => {
                let number = number.saturating_add(1).to_string();
                page.say_with("page-frame", &[("number", &number)])
            }
            None if page.words.has(&id) => page.say(&id),
            None => escape(caption),
        };
        page.add(format_args!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}\
             </figcaption></figure>"
        ));
    }
    page.add(format_args!("</div>"));
}

/// Writes the curve of the scores, and the metrics beside those of earlier sessions.
pub(super) fn past(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.past.is_empty() {
        return;
    }
    let it = &chapter.assessed;
    page.heading("page-past");
    let scores = chapter.past.iter().map(|past| past.score);
    let scores: Vec<f64> = scores.chain([it.score]).collect();
    let pass = chapter.rules.pass(it.task, it.difficulty);
    let rule = pass.iter().find(|rule| rule.name == "score");
    let rule = rule.map(|rule| rule.at_least);
    if let Some(curve) = drawing::curve(&scores, rule, "score", page.words) {
        page.add(format_args!("<figure>{curve}</figure>"));
    }
    let compared = [
        Metric::Time,
        Metric::Path,
        Metric::Movements,
        Metric::Economy,
        Metric::ForceMean,
        Metric::Alarms,
    ];
    page.columns(&["<metric", "metric-now", "page-last", "metric-best"]);
    for metric in compared {
        let before = || {
            chapter
                .past
                .iter()
                .filter_map(|it| it.metrics.get(metric.name()))
        };
        let text = |value: Option<f64>| {
            value.map_or("–".to_owned(), |value| page.words.number(value, 2))
        };
        // For each metric compared here the smallest value is the best. Economy is the exception:
        // neither more nor less of it is better.
        let best = match metric {
            Metric::Economy => None,
            _ => before().copied().min_by(f64::total_cmp),
        };
        let [name, now] = [page.named(metric.name()), page.shown(&it.metrics, metric)];
        let [last, best] = [text(before().next_back().copied()), text(best)];
        page.add(format_args!(
            "<tr><td>{name}<td>{now}<td>{last}<td>{best}</tr>"
        ));
    }
    page.add(format_args!("</table>"));
}

/// Writes the instructor's points for each item, and their sum.
pub(super) fn sheet(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.sheet.is_empty() {
        return;
    }
    page.heading("launcher-sheet");
    page.columns(&["<page-item", "page-of-5"]);
    for (item, points) in &chapter.sheet {
        page.add(format_args!("<tr><td>{}<td>{points}</tr>", escape(item)));
    }
    let sum: u32 = chapter
        .sheet
        .iter()
        .map(|(_, points)| u32::from(*points))
        .sum();
    let most = 5 * chapter.sheet.len();
    let [sum, most] = [sum.to_string(), most.to_string()];
    let (name, of) = (
        page.say("page-sum"),
        page.say_with("points-number", &[("number", &sum), ("of", &most)]),
    );
    page.add(format_args!("<tr><td>{name}<td>{of}</tr></table>"));
}

/// Writes the table of all metrics.
pub(super) fn metrics(page: &mut Page<'_>, chapter: &Chapter) {
    page.heading("page-metrics");
    let show = page.say("page-show");
    page.add(format_args!("<details><summary>{show}</summary>"));
    page.columns(&["<metric", "page-value"]);
    for metric in Metric::ALL {
        let [name, value] = [
            page.named(metric.name()),
            page.shown(&chapter.assessed.metrics, metric),
        ];
        page.add(format_args!("<tr><td>{name}<td>{value}</tr>"));
    }
    let version = chapter.assessed.version.to_string();
    let values = [("build", chapter.build.as_str()), ("version", &version)];
    let text = page.say_with("page-recorded-by", &values);
    page.add(format_args!(
        "</table></details><p class=\"lead\">{text}</p>"
    ));
}
