//! The page's HTML.

use core::fmt::Write as _;

use base64::Engine as _;
use figures::html::{STYLE, escape};

use super::{Chapter, drawing, paths};
use crate::assessment::Moment;
use crate::metrics::{Metric, Values};
use crate::task::Outcome;

mod judged;

/// Styles of the debrief besides those of all pages.
const MORE: &str = "h3{margin-top:1.6rem;font-size:1.05rem}td,th{vertical-align:top}.l{text-align:left}\
.open{background:#fdf4dc;border-left:4px solid #b7791f;padding:.5rem 1rem}.score{font-size:2.2rem;\
font-weight:600}";

/// Names of metrics in the reader's language, by their names in JSON.
pub type Names<'a> = &'a dyn Fn(&str) -> String;

struct Page<'a> {
    text: String,
    names: Names<'a>,
}

impl Page<'_> {
    fn add(&mut self, text: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(text);
    }

    /// Name of a metric, or of the score, with its unit.
    fn named(&self, name: &str) -> String {
        let title = escape(&(self.names)(name));
        match Metric::from_name(name).map(Metric::unit) {
            None | Some("1" | "n") => title,
            Some("deg") => format!("{title}, °"),
            Some(unit) => format!("{title}, {unit}"),
        }
    }
}

/// The report of these sessions, in the order given.
#[must_use]
pub fn html(chapters: &[Chapter], names: Names<'_>) -> String {
    let mut page = Page {
        text: String::new(),
        names,
    };
    page.add(format_args!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: debrief</title><style>{STYLE}{MORE}</style>\
         <h1>Debrief</h1>"
    ));
    if chapters.len() > 1 {
        together(&mut page, chapters);
    }
    for chapter in chapters {
        one(&mut page, chapter);
    }
    definitions(&mut page);
    page.text + "</html>\n"
}

fn together(page: &mut Page<'_>, chapters: &[Chapter]) {
    page.add(format_args!(
        "<h2>Sessions</h2><table><tr><th>when<th>task<th>outcome<th>score<th>time, s<th>path, m<th>alarms</tr>"
    ));
    for chapter in chapters {
        let it = &chapter.assessed;
        page.add(format_args!(
            "<tr><td>{}<td>{}<td>{}<td>{:.0}<td>{}<td>{}<td>{}</tr>",
            escape(&chapter.when),
            it.task.name(),
            outcome(chapter),
            it.score,
            shown(&it.metrics, Metric::Time),
            shown(&it.metrics, Metric::Path),
            it.alarms.len()
        ));
    }
    page.add(format_args!("</table>"));
    let persons = chapters.iter().filter(|it| !it.is_scripted);
    let scores: Vec<f64> = persons.map(|it| it.assessed.score).collect();
    if let Some(curve) = drawing::curve(&scores, None, "score") {
        page.add(format_args!("<figure>{curve}</figure>"));
    }
}

/// Outcome of a session, with a mark if no person worked it.
fn outcome(chapter: &Chapter) -> String {
    let outcome = chapter.assessed.outcome.name();
    match chapter.is_scripted {
        true => format!("{outcome}, scripted hand"),
        false => outcome.to_owned(),
    }
}

fn one(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    page.add(format_args!(
        "<h2>{}</h2><p class=\"lead\">{}, {}, scene {}. {}</p>",
        escape(it.task.title()),
        escape(&chapter.when),
        it.difficulty.name(),
        escape(&chapter.scene),
        escape(&chapter.name),
    ));
    if let Some(why) = &chapter.cut_short {
        page.add(format_args!(
            "<p class=\"bad\">The recording ends early ({}): these figures end with it.</p>",
            escape(why)
        ));
    }
    if chapter.is_scripted {
        page.add(format_args!(
            "<p class=\"open\">A scripted hand worked this session at emulated devices. It says nothing about a \
             trainee, and counts in no learning curve.</p>"
        ));
    }
    verdict(page, chapter);
    not_counted(page, &it.metrics);
    page.add(format_args!("<h3>Time line</h3><figure>"));
    let seconds = it.moments.iter().map(|moment| moment.at_s);
    let alarms = it.alarms.iter().map(|alarm| alarm.at_s);
    let end_s = seconds
        .chain(alarms)
        .fold(it.metrics.get(Metric::Time), f64::max);
    page.add(format_args!(
        "{}<figcaption>Triangles are alarms; point at a mark to read its name.</figcaption></figure>",
        drawing::time_line(it, end_s)
    ));
    if !it.alarms.is_empty() {
        page.add(format_args!(
            "<table><tr><th>time<th class=\"l\">alarm</tr>"
        ));
        for alarm in it.alarms.iter().take(50) {
            page.add(format_args!(
                "<tr><td>{:.1} s<td class=\"l\">{}</tr>",
                alarm.at_s,
                escape(&alarm.text())
            ));
        }
        page.add(format_args!("</table>"));
        if it.alarms.len() > 50 {
            page.add(format_args!("<p>and {} more</p>", it.alarms.len() - 50));
        }
    }
    pictures(page, chapter);
    page.add(format_args!(
        "<h3>Paths</h3><figure>{}</figure>",
        paths::projections(&it.paths, &chapter.outlines)
    ));
    if let Some(histogram) = drawing::force_histogram(&it.force_histogram_s) {
        page.add(format_args!(
            "<h3>Force</h3><figure>{histogram}<figcaption>Time at each force on the hand during \
             contact of the instrument.</figcaption></figure>"
        ));
    }
    judged::handling(page, chapter);
    judged::published(page, chapter);
    past(page, chapter);
    sheet(page, chapter);
    metrics(page, chapter);
    ticks(page, chapter);
}

/// Reports if the simulation kept up with real time.
fn ticks(page: &mut Page<'_>, chapter: &Chapter) {
    let Some(ticks) = &chapter.ticks else {
        return;
    };
    page.add(format_args!(
        "<h3>Timing of the simulation</h3><table><tr><th>µs<th>p50<th>p99<th>max</tr>"
    ));
    let stages = ticks.stage_ns.iter().map(|(name, it)| (name.as_str(), it));
    for (name, spread) in [("whole tick", &ticks.tick_ns)].into_iter().chain(stages) {
        let [p50, p99, max] = [spread.p50, spread.p99, spread.max].map(|ns| ns as f64 / 1e3);
        page.add(format_args!(
            "<tr><td>{}<td>{p50:.1}<td>{p99:.1}<td>{max:.1}</tr>",
            escape(name)
        ));
    }
    page.add(format_args!(
        "</table><p class=\"lead\">Of {} ticks of 1000 µs {} ended too late and {} periods were missed; the \
         controller ran {}.</p>",
        ticks.tick_ns.count,
        ticks.late_ticks,
        ticks.missed_periods,
        match ticks.realtime {
            true => "in real time",
            false => "without real-time priority",
        }
    ));
}

fn verdict(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let class = match it.outcome {
        Outcome::Passed => "good",
        Outcome::Failed => "bad",
        Outcome::Running | Outcome::Aborted | Outcome::Practised => "open",
    };
    page.add(format_args!(
        "<p class=\"{class}\"><span class=\"score\">{:.0}</span> of 100 &nbsp; <b>{}</b>",
        it.score,
        it.outcome.name()
    ));
    for reason in &it.reasons {
        page.add(format_args!("<br>{}", escape(&reason.to_string())));
    }
    page.add(format_args!("</p>"));
    judged::injuries(page, &it.injuries);
    unrest(page, &it.moments);
    if !it.steps.is_empty() {
        page.add(format_args!("<table><tr><th>step<th>done</tr>"));
        for (step, done) in &it.steps {
            let mark = if *done { "✓ yes" } else { "✗ no" };
            page.add(format_args!(
                "<tr><td>{}<td>{mark}</tr>",
                escape(&step.to_string())
            ));
        }
        page.add(format_args!("</table>"));
    }
    judged::pass_rules(page, chapter);
    judged::points(page, chapter);
    judged::critical_view(page, chapter);
}

/// Writes which organs fell or shook, because that is no fault of the trainee.
fn unrest(page: &mut Page<'_>, moments: &[Moment]) {
    for moment in moments {
        let what = match moment.what.as_str() {
            "fall" => format!(
                "fell {:.0} mm off its place, and nobody had freed it",
                moment.value * 1e3
            ),
            "shake" => format!(
                "shook at up to {:.0} mm/s without being moved",
                moment.value * 1e3
            ),
            _ => continue,
        };
        let organ = moment.organ.as_deref().unwrap_or("an organ");
        page.add(format_args!(
            "<p class=\"bad\">At {:.0} s the {} {what}: the scene is at fault, and the result may \
             be wrong.</p>",
            moment.at_s,
            escape(organ)
        ));
    }
}

/// Largest noise of the handle that adds less than 5 mm a minute to the path of a resting hand, mm
/// (`tally/hands`; the test `a_resting_hand_with_a_noisy_device_rests_at_every_rate` measures it).
const NOISE_MAX_MM: f64 = 0.7;

/// Writes the times that do not count as the trainee's, and the noise of the handle.
fn not_counted(page: &mut Page<'_>, values: &Values) {
    let times = [
        (Metric::Paused, "The task was paused for"),
        (Metric::Gaps, "The recording has gaps of"),
        (Metric::DeviceLost, "A device was missing for"),
    ];
    let times: Vec<String> = times
        .into_iter()
        .map(|(metric, sentence)| (metric, values.get(metric), sentence))
        .filter(|(metric, seconds, _)| metric.is_worth_mention(*seconds))
        .map(|(_, seconds, sentence)| format!("{sentence} {seconds:.1} s."))
        .collect();
    if !times.is_empty() {
        page.add(format_args!(
            "<p class=\"open\">{} The trainee's time, path and rest do not count that.</p>",
            times.join(" ")
        ));
    }
    let noise_mm = values.get(Metric::Noise);
    if noise_mm > 0.0 {
        let consequence = match noise_mm <= NOISE_MAX_MM {
            true => {
                "Movements of the tip within 1.6 mm do not count, so it adds less than 5 mm of path a minute."
            }
            false => {
                "The smoothing does not remove so much noise: path and movements contain some of it, and \
                 idle time is too short. Mend the device: shield its cables, or smooth its positions in \
                 its firmware."
            }
        };
        page.add(format_args!(
            "<p class=\"lead\">The handle's noise at rest is {noise_mm:.2} mm. {consequence}</p>"
        ));
    }
}

fn pictures(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.pictures.is_empty() {
        return;
    }
    page.add(format_args!("<h3>Pictures</h3><div class=\"frames\">"));
    for (caption, bytes) in &chapter.pictures {
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        let caption = escape(caption);
        page.add(format_args!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}\
             </figcaption></figure>"
        ));
    }
    page.add(format_args!("</div>"));
}

fn past(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.past.is_empty() {
        return;
    }
    let it = &chapter.assessed;
    page.add(format_args!(
        "<h3>Compared with earlier sessions of this task</h3>"
    ));
    let scores = chapter.past.iter().map(|past| past.score);
    let scores: Vec<f64> = scores.chain([it.score]).collect();
    let pass = chapter.rules.pass(it.task, it.difficulty);
    let rule = pass.iter().find(|rule| rule.name == "score");
    let rule = rule.map(|rule| rule.at_least);
    if let Some(curve) = drawing::curve(&scores, rule, "score") {
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
    page.add(format_args!(
        "<table><tr><th>metric<th>now<th>last session<th>best so far</tr>"
    ));
    for metric in compared {
        let before = || {
            chapter
                .past
                .iter()
                .filter_map(|it| it.metrics.get(metric.name()))
        };
        let text =
            |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.2}"));
        // Less is better for all metrics except economy, for which no direction is better.
        let best = match metric {
            Metric::Economy => None,
            _ => before().copied().min_by(f64::total_cmp),
        };
        let name = page.named(metric.name());
        page.add(format_args!(
            "<tr><td>{name}<td>{}<td>{}<td>{}</tr>",
            shown(&it.metrics, metric),
            text(before().next_back().copied()),
            text(best)
        ));
    }
    page.add(format_args!("</table>"));
}

fn sheet(page: &mut Page<'_>, chapter: &Chapter) {
    if chapter.sheet.is_empty() {
        return;
    }
    page.add(format_args!(
        "<h3>Instructor's assessment</h3><table><tr><th>item<th>of 5</tr>"
    ));
    for (item, points) in &chapter.sheet {
        page.add(format_args!("<tr><td>{}<td>{points}</tr>", escape(item)));
    }
    let sum: u32 = chapter
        .sheet
        .iter()
        .map(|(_, points)| u32::from(*points))
        .sum();
    page.add(format_args!(
        "<tr><td>sum<td>{sum} of {}</tr></table>",
        5 * chapter.sheet.len()
    ));
}

fn shown(values: &Values, metric: Metric) -> String {
    let value = values.get(metric);
    match (value.is_finite(), metric.unit()) {
        (false, _) => "–".to_owned(),
        (true, "n") => format!("{value:.0}"),
        (true, _) => format!("{value:.2}"),
    }
}

fn metrics(page: &mut Page<'_>, chapter: &Chapter) {
    page.add(format_args!(
        "<h3>All metrics</h3><details><summary>Show</summary><table><tr><th>metric<th>value<th class=\"l\">name in JSON \
         and rules</tr>"
    ));
    for metric in Metric::ALL {
        let name = page.named(metric.name());
        page.add(format_args!(
            "<tr><td>{name}<td>{}<td class=\"l\"><code>{}</code></tr>",
            shown(&chapter.assessed.metrics, metric),
            metric.name()
        ));
    }
    page.add(format_args!(
        "</table></details><p class=\"lead\">Recorded by {}; metrics of version {}.</p>",
        escape(&chapter.build),
        chapter.assessed.version
    ));
}

fn definitions(page: &mut Page<'_>) {
    page.add(format_args!(
        "<h2>What the metrics are</h2><details><summary>Show</summary><table><tr><th>metric<th class=\"l\">\
         definition<th class=\"l\">source</tr>"
    ));
    for metric in Metric::ALL {
        let name = page.named(metric.name());
        page.add(format_args!(
            "<tr><td>{name}<td class=\"l\">{}<td class=\"l\">{}</tr>",
            escape(metric.definition()),
            escape(metric.source())
        ));
    }
    page.add(format_args!("</table></details>"));
}
