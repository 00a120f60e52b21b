//! The page's HTML.

use core::fmt::Write as _;

use figures::html::{STYLE, escape};

use super::words::Words;
use super::{Chapter, drawing, paths};
use crate::assessment::Moment;
use crate::metrics::{Metric, Values};
use crate::task::Outcome;

mod acts;
mod asides;
mod compared;
mod judged;
mod lessons;

pub use lessons::in_shell;

/// Styles of the debrief, in addition to those of all pages.
const MORE: &str = "h3{margin-top:1.6rem;font-size:1.05rem}td,th{vertical-align:top}.l{text-align:left}\
.open{background:#fdf4dc;border-left:4px solid #8a5a12;padding:.5rem 1rem}.score{font-size:2.2rem;\
font-weight:600}.lesson{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,20rem);gap:.4rem 1.4rem;\
border-top:1px solid #ddd;padding:.8rem 0}.lesson h4{margin:0 0 .3rem;font-size:1rem}.lesson p{margin:.3rem 0}\
.lesson figure{margin:0}.lesson img{width:100%;border-radius:4px}code{background:#f1f1f1;padding:.1rem .3rem;\
overflow-wrap:anywhere}@media(max-width:45rem){.lesson{grid-template-columns:1fr}}";

struct Page<'a> {
    text: String,
    words: &'a dyn Words,
    /// Rules of the chapter and their sources, as HTML.
    sources: Vec<[String; 2]>,
    /// Times of the chapter and the commands that replay them, as HTML.
    replays: Vec<[String; 2]>,
}

impl Page<'_> {
    fn add(&mut self, text: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(text);
    }

    /// Text of a message, safe between tags.
    fn say(&self, id: &str) -> String {
        self.say_with(id, &[])
    }

    /// Text of a message with values, safe between tags.
    fn say_with(&self, id: &str, values: &[(&str, &str)]) -> String {
        escape(&self.words.say_with(id, values))
    }

    /// Adds a heading.
    fn heading(&mut self, id: &str) {
        let text = self.say(id);
        self.add(format_args!("<h3>{text}</h3>"));
    }

    /// Adds the head of a table. A column whose name begins with `<` is text, and aligned to the
    /// left.
    fn columns(&mut self, names: &[&str]) {
        self.add(format_args!("<table><tr>"));
        for name in names {
            let (id, class) = match name.strip_prefix('<') {
                Some(id) => (id, " class=\"l\""),
                None => (*name, ""),
            };
            let text = self.say(id);
            self.add(format_args!("<th{class}>{text}"));
        }
        self.add(format_args!("</tr>"));
    }

    /// Name of a metric, or of the score, with its unit.
    fn named(&self, name: &str) -> String {
        let title = escape(&self.words.metric(name));
        match Metric::from_name(name).map(Metric::unit) {
            None | Some("1" | "n") => title,
            Some("deg") => format!("{title}, °"),
            Some(unit) => format!("{title}, {unit}"),
        }
    }

    /// A value of a metric.
    fn shown(&self, values: &Values, metric: Metric) -> String {
        let value = values.get(metric);
        match (value.is_finite(), metric.unit()) {
            (false, _) => "–".to_owned(),
            (true, "n") => format!("{value:.0}"),
            // A path of 3 mm is not none.
            (true, "m") if value < 0.1 => self.words.number(value, 3),
            (true, _) => self.words.number(value, 2),
        }
    }

    /// Name and value of a metric, with its unit behind the value.
    fn told(&self, name: &str, value: f64) -> String {
        let title = escape(&self.words.metric(name));
        let metric = Metric::from_name(name);
        let number = |value: f64| self.words.number(value, usize::from(value < 100.0));
        let value = match metric.map(Metric::unit) {
            Some("n") => self.words.number(value, 0),
            Some("deg") => format!("{}°", number(value)),
            _ if metric.is_some_and(Metric::is_share) => format!("{} %", number(100.0 * value)),
            None | Some("1") => number(value),
            Some(unit) => format!("{} {unit}", number(value)),
        };
        format!("{title}: {value}")
    }

    /// A mark and a word for yes or no.
    fn answer(&self, yes: bool) -> String {
        match yes {
            true => format!("✓ {}", self.say("page-yes")),
            false => format!("✗ {}", self.say("page-no")),
        }
    }

    /// Name of a task.
    fn task(&self, chapter: &Chapter) -> String {
        self.say(&format!("task-{}", chapter.assessed.task.name()))
    }
}

/// The report of these sessions, in the order given.
#[must_use]
pub fn html(chapters: &[Chapter], words: &dyn Words) -> String {
    let mut page = Page {
        text: String::new(),
        words,
        sources: Vec::new(),
        replays: Vec::new(),
    };
    let (code, title) = (escape(words.code()), page.say("launcher-debrief"));
    page.add(format_args!(
        "<!doctype html><html lang=\"{code}\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: {title}</title><style>{STYLE}{MORE}</style>\
         <h1>{title}</h1>"
    ));
    if chapters.len() > 1 {
        together(&mut page, chapters);
    }
    for chapter in chapters {
        one(&mut page, chapter);
    }
    asides::definitions(&mut page);
    page.text + "</html>\n"
}

fn together(page: &mut Page<'_>, chapters: &[Chapter]) {
    let title = page.say("page-sessions");
    page.add(format_args!("<h2>{title}</h2>"));
    page.columns(&[
        "<page-when",
        "<start-task",
        "<page-outcome",
        "metric-score",
        "page-time-s",
        "page-path-m",
        "metric-alarms",
    ]);
    for chapter in chapters {
        let it = &chapter.assessed;
        let (task, outcome) = (page.task(chapter), outcome(page, chapter));
        let [time, path] =
            [Metric::Time, Metric::Path].map(|metric| page.shown(&it.metrics, metric));
        page.add(format_args!(
            "<tr><td>{}<td class=\"l\">{task}<td class=\"l\">{outcome}<td>{:.0}<td>{time}<td>{path}<td>{}</tr>",
            escape(&chapter.when),
            it.score,
            it.alarms.len()
        ));
    }
    page.add(format_args!("</table>"));
    let persons = chapters.iter().filter(|it| !it.is_scripted);
    let scores: Vec<f64> = persons.map(|it| it.assessed.score).collect();
    if let Some(curve) = drawing::curve(&scores, None, "score", page.words) {
        page.add(format_args!("<figure>{curve}</figure>"));
    }
}

/// Outcome of a session, with a note if a script operated.
fn outcome(page: &Page<'_>, chapter: &Chapter) -> String {
    let outcome = page.say(&format!("outcome-{}", chapter.assessed.outcome.name()));
    match chapter.is_scripted {
        true => format!("{outcome}, {}", page.say("page-scripted")),
        false => outcome,
    }
}

fn one(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let task = page.task(chapter);
    let difficulty = page.say(&format!("difficulty-{}", it.difficulty.name()));
    // A message's name has neither colons nor spaces. A scene is called `patient:NAME`, or by its
    // title if it came from a file.
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let scene: String = chapter.scene.chars().map(plain).collect();
    let scene = format!("scene-{scene}");
    let scene = match page.words.has(&scene) {
        true => page.say(&scene),
        false => escape(&chapter.scene),
    };
    let trainee = chapter.trainee.as_ref();
    let trainee = trainee.map_or_else(String::new, |name| format!("{} – ", escape(name)));
    page.add(format_args!(
        "<h2>{task}</h2><p class=\"lead\">{trainee}{} – {difficulty} – {scene}</p>",
        escape(&chapter.when)
    ));
    if let Some(case) = &chapter.case {
        let line = escape(&case.line(page.words));
        page.add(format_args!("<p>{line}</p>"));
    }
    if let Some(why) = &chapter.cut_short {
        let text = page.say_with("page-cut-short", &[("why", why)]);
        page.add(format_args!("<p class=\"bad\">{text}</p>"));
    }
    if chapter.is_scripted {
        let text = page.say("page-scripted-note");
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
    asides::slow(page, chapter);
    asides::stalled(page, &it.metrics);
    asides::jar(page, chapter);
    asides::stones(page, &it.metrics);
    verdict(page, chapter);
    lessons::write(page, chapter);
    acts::write(page, chapter);
    judged::injuries(page, chapter);
    judged::pass_rules(page, chapter);
    judged::points(page, chapter);
    judged::critical_view(page, chapter);
    asides::not_counted(page, &it.metrics);
    time_line(page, chapter);
    compared::pictures(page, chapter);
    page.heading("page-paths");
    let drawn = paths::projections(&it.paths, &chapter.outlines, page.words);
    page.add(format_args!("<figure>{drawn}</figure>"));
    if let Some(histogram) = drawing::force_histogram(&it.force_histogram_s, page.words) {
        page.heading("page-force");
        let caption = page.say("page-force-note");
        page.add(format_args!(
            "<figure>{histogram}<figcaption>{caption}</figcaption></figure>"
        ));
    }
    judged::handling(page, chapter);
    judged::published(page, chapter);
    compared::past(page, chapter);
    compared::sheet(page, chapter);
    compared::metrics(page, chapter);
    asides::sources(page);
    asides::replays(page);
    unrest(page, &it.moments);
    asides::ticks(page, chapter);
    asides::technical(page, chapter);
}

fn time_line(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let seconds = it.moments.iter().map(|moment| moment.at_s);
    let alarms = it.alarms.iter().map(|alarm| alarm.at_s);
    let end_s = seconds
        .chain(alarms)
        .fold(it.metrics.get(Metric::Time), f64::max);
    page.heading("page-time-line");
    let (drawn, caption) = (
        drawing::time_line(it, end_s, page.words),
        page.say("page-time-line-note"),
    );
    page.add(format_args!(
        "<figure>{drawn}<figcaption>{caption}</figcaption></figure>"
    ));
}

fn verdict(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let class = match it.outcome {
        Outcome::Passed => "good",
        Outcome::Failed => "bad",
        Outcome::Running | Outcome::Aborted | Outcome::Practised => "open",
    };
    let (of, outcome) = (
        page.say("page-of-100"),
        page.say(&format!("outcome-{}", it.outcome.name())),
    );
    page.add(format_args!(
        "<p class=\"{class}\"><span class=\"score\">{:.0}</span> {of} &nbsp; <b>{outcome}</b>",
        it.score
    ));
    if it.outcome == Outcome::Aborted {
        let (score, _) = chapter.rules.score(it.task, &it.metrics);
        let score = format!("{score:.0}");
        let text = page.say_with("page-unfinished", &[("score", &score)]);
        page.add(format_args!("<br>{text}"));
    }
    // The table of the steps, below, shows which ones are open.
    let reasons = it.reasons.iter().filter(|it| it.open_step().is_none());
    for reason in reasons {
        let reason = escape(&sentence(&page.words.reason(reason)));
        page.add(format_args!("<br>{reason}"));
    }
    page.add(format_args!("</p>"));
    asides::restarts(page, &it.metrics);
    if !it.steps.is_empty() {
        page.columns(&["<page-step", "page-done"]);
        for (step, done) in &it.steps {
            let (step, mark) = (escape(&page.words.step(step)), page.answer(*done));
            page.add(format_args!("<tr><td>{step}<td>{mark}</tr>"));
        }
        page.add(format_args!("</table>"));
    }
}

/// Writes which organs fell or shook, and in which organ the instrument lay at its device's first
/// sample, or at the first after a gap. None of this is the trainee's fault, so it is folded, among
/// the notes for engineers.
fn unrest(page: &mut Page<'_>, moments: &[Moment]) {
    let mut told = String::new();
    for moment in moments {
        let id = match moment.what.as_str() {
            "fall" => "page-fell",
            "shake" => "page-shook",
            "buried" => "page-buried",
            _ => continue,
        };
        let organ = page
            .words
            .organ(moment.organ.as_deref().unwrap_or_default());
        let [at, by] = [moment.at_s, f64::from(moment.value) * 1e3].map(|it| format!("{it:.0}"));
        let text = page.say_with(id, &[("at", &at), ("organ", &organ), ("by", &by)]);
        told += &format!("<p>{text}</p>");
    }
    if !told.is_empty() {
        let title = page.say("debrief-machine");
        page.add(format_args!(
            "<details><summary>{title}</summary>{told}</details>"
        ));
    }
}

/// A text with a capital letter at its beginning.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}
