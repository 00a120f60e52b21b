//! Tables of the debrief that state each judged value, its rule, and the source of the rule.
//! Sources are quoted from the rules file and not translated.

use figures::html::escape;

use super::{Page, asides};
use crate::injury::{Cause, Injury, InjuryKind, Severity};
use crate::metrics::Metric;
use crate::report::Chapter;
use crate::rules::ViewRule;
use crate::task::Task;
use crate::view::{Shares, Shown};

/// Writes the injuries: time, structure, kind, cause and consequence of each.
pub(super) fn injuries(page: &mut Page<'_>, chapter: &Chapter) {
    let injuries: &[Injury] = &chapter.assessed.injuries;
    if injuries.is_empty() {
        return;
    }
    page.heading("metric-injuries");
    page.columns(&[
        "<page-time",
        "<page-structure",
        "<page-injury",
        "<page-cause",
        "<page-consequence",
    ]);
    for injury in injuries {
        let kind = page.say(match injury.kind {
            // Only heat from beside burns without heat of its own.
            InjuryKind::Burnt if injury.heat_j.is_none() => "injury-seared",
            // No wall is burnt: the organ was burnt deeper than its surface.
            InjuryKind::Burnt if injury.severity == Severity::Minor => "injury-deep",
            InjuryKind::Divided => "injury-divided",
            InjuryKind::Perforated => "injury-perforated",
            InjuryKind::Torn => "injury-torn",
            InjuryKind::Clipped => "injury-clipped",
            InjuryKind::Burnt => "injury-burnt",
        });
        let measured = [(injury.heat_j, "J"), (injury.depth_mm, "mm")].into_iter();
        let kind = measured.fold(kind, |kind, (value, unit)| match value {
            Some(value) => format!("{kind}, {} {unit}", page.words.number(value, 1)),
            None => kind,
        });
        let cause = page.say(match injury.cause {
            Cause::Cut => "cause-cut",
            Cause::Torn => "cause-torn",
            Cause::Burnt => "cause-burnt",
            Cause::Clipped => "cause-clipped",
        });
        let consequence = page.say(match injury.severity {
            Severity::Grave => "page-ends-task",
            Severity::Serious => "page-rules-out",
            Severity::Minor => "page-costs-points",
        });
        let at = page.words.number(injury.at_s, 1);
        let organ = escape(&page.words.organ(&injury.organ));
        page.add(format_args!(
            "<tr><td>{at} s<td class=\"l\">{organ}<td class=\"l\">{kind}<td class=\"l\">{cause}<td \
             class=\"l\">{consequence}</tr>"
        ));
        keep_source(page, chapter, format!("{organ}: {kind}"), &injury.source);
    }
    page.add(format_args!("</table>"));
    if injuries.iter().any(|it| it.severity > Severity::Minor) {
        let note = page.say("page-injury-note");
        page.add(format_args!("<p>{note}</p>"));
    }
}

/// Writes the pass rules of the task, and if each is met.
pub(super) fn pass_rules(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let pass = chapter.rules.pass(it.task, it.difficulty);
    if pass.is_empty() {
        return;
    }
    page.heading("page-pass-rules");
    page.columns(&["<metric", "page-value", "page-required", "page-met"]);
    for rule in pass.into_iter().chain(chapter.rules.time_rule(it.task)) {
        let (name, least, most) = (rule.name, rule.at_least, rule.at_most);
        let metric = Metric::from_name(name);
        // A rule that names no metric is about the score.
        let value = match metric {
            Some(metric) => it.metrics.get(metric),
            None => it.score,
        };
        let is_share = metric.is_some_and(Metric::is_share);
        let limit = |it: f64| match is_share {
            true => format!("{} %", page.words.number(100.0 * it, decimals(100.0 * it))),
            false => page.words.number(it, decimals(it)),
        };
        let [low, high] = [least, most].map(limit);
        let asked = match (least.is_finite(), most.is_finite()) {
            (true, true) => format!("{low} – {high}"),
            (true, false) => page.say_with("page-at-least", &[("limit", &low)]),
            (false, true) => page.say_with("page-at-most", &[("limit", &high)]),
            (false, false) => "–".to_owned(),
        };
        // A metric without a value, such as that of current nobody used, is not asked for.
        let met = match value.is_finite() {
            true => page.answer(!(value < least || value > most)),
            false => "–".to_owned(),
        };
        let shown = match metric {
            Some(_) if is_share && value.is_finite() => {
                format!("{} %", page.words.number(100.0 * value, 1))
            }
            Some(metric) => page.shown(&it.metrics, metric),
            None => page.words.number(value, 1),
        };
        let [name, value] = [page.named(name), shown];
        page.add(format_args!(
            "<tr><td>{name}<td>{value}<td>{asked}<td>{met}</tr>"
        ));
        keep_source(page, chapter, format!("{name}: {asked}"), rule.source);
    }
    let note = page.say("page-pass-and-proficiency");
    page.add(format_args!("</table><p class=\"lead\">{note}</p>"));
}

/// Keeps the source of a rule for the table of sources at the end of the chapter.
fn keep_source(page: &mut Page<'_>, chapter: &Chapter, rule: String, text: &str) {
    let source = source(page, chapter, text);
    let kept = [rule, source];
    if !page.sources.contains(&kept) {
        page.sources.push(kept);
    }
}

/// Source of a rule as the rules file has it, in the reader's language if the file can, or a text
/// that says that there is none.
fn source(page: &Page<'_>, chapter: &Chapter, text: &str) -> String {
    match text {
        "" | NO_SOURCE => page.say("page-no-source"),
        text => escape(chapter.rules.said(page.words.code(), text)),
    }
}

/// Source of a rule whose entry in the rules file names none.
const NO_SOURCE: &str = "no source";

/// Number of decimals that a limit needs, at most three.
fn decimals(limit: f64) -> usize {
    let is_whole = |digits: usize| {
        let scaled = limit * 10f64.powi(digits as i32);
        (scaled - scaled.round()).abs() < 1e-6
    };
    (0..3).find(|digits| is_whole(*digits)).unwrap_or(3)
}

/// Writes the lost points: metric, value and points of each loss.
pub(super) fn points(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    if it.lost.is_empty() {
        return;
    }
    page.heading("page-points-lost");
    page.columns(&["<metric", "page-value", "page-points"]);
    for lost in &it.lost {
        let name = page.named(lost.metric);
        let digits = match Metric::from_name(lost.metric).map(Metric::unit) {
            Some("n") => 0,
            _ => 1,
        };
        let value = page.words.number(lost.value, digits);
        let points = page.words.number(lost.points, 1);
        page.add(format_args!("<tr><td>{name}<td>{value}<td>{points}</tr>"));
        let source = chapter.rules.weight_source(it.task, lost.metric);
        let rule = format!("{name}: {}", page.say("page-points"));
        keep_source(page, chapter, rule, source);
    }
    page.add(format_args!("</table>"));
}

/// Writes published values next to the trainee's, if the trainee did every step.
pub(super) fn published(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let mut references = chapter.rules.references(it.task).peekable();
    // Time and path of an attempt that ended early compare with nobody's.
    let is_complete = it.steps.iter().all(|(_, done)| *done);
    if references.peek().is_none() || !is_complete {
        return;
    }
    page.heading("page-published");
    let note = page.say("page-published-note");
    page.add(format_args!("<p class=\"lead\">{note}</p>"));
    page.columns(&[
        "<metric",
        "page-here",
        "page-published-value",
        "<page-of-whom",
        "<page-source",
    ]);
    let said = |text: &str| escape(chapter.rules.said(page.words.code(), text));
    for reference in references {
        let name = page.named(reference.metric.name());
        let here = page.shown(&it.metrics, reference.metric);
        page.add(format_args!(
            "<tr><td>{name}<td>{here}<td>{}<td class=\"l\">{}<td class=\"l\">{}</tr>",
            page.words
                .number(reference.value, decimals(reference.value)),
            said(&reference.who),
            said(&reference.source)
        ));
    }
    page.add(format_args!("</table>"));
}

/// Writes the critical view of safety: the achieved share of each criterion, and the share that
/// the endoscope showed from the front and from behind. Tasks that begin after it do not ask for
/// it.
pub(super) fn critical_view(page: &mut Page<'_>, chapter: &Chapter) {
    let task = chapter.assessed.task;
    let is_asked = matches!(task, Task::Identify | Task::Full | Task::Free);
    let Some(cvs) = chapter.assessed.cvs.as_ref().filter(|_| is_asked) else {
        return;
    };
    page.heading("page-cvs");
    page.columns(&[
        "<page-criterion",
        "page-achieved",
        "page-seen",
        "page-from-front",
        "page-true-then",
        "page-from-behind",
        "page-true-then",
    ]);
    let none = [f64::NAN; 3];
    let of = |shares: Shares| [shares.triangle, shares.lower_bed, shares.two];
    let sides = [cvs.front, cvs.behind]
        .map(|shown| shown.map_or([none; 2], |it| [of(it.seen), of(it.truth)]));
    let rows = [
        ("metric-cvs-triangle", cvs.triangle),
        ("metric-cvs-bed", cvs.lower_bed),
        ("metric-cvs-two", cvs.two),
    ];
    for (index, (id, criterion)) in rows.into_iter().enumerate() {
        let name = page.say(id);
        page.add(format_args!(
            "<tr><td>{name}<td>{}<td>{}",
            percent(criterion.achieved),
            percent(criterion.visible.unwrap_or(f64::NAN)),
        ));
        for [seen, truth] in sides {
            let (seen, truth) = (percent(seen[index]), percent(truth[index]));
            page.add(format_args!("<td>{seen}<td>{truth}"));
        }
        page.add(format_args!("</tr>"));
    }
    page.add(format_args!("</table>"));
    for (side, shown) in [("front", cvs.front), ("behind", cvs.behind)] {
        view_shown(page, side, shown);
    }
    if let Some(rule) = chapter.rules.view() {
        view_rule(page, chapter, rule);
    }
}

fn percent(share: f64) -> String {
    match share.is_finite() {
        true => format!("{:.0} %", 100.0 * share),
        false => "–".to_owned(),
    }
}

/// Writes if and when the critical view was shown or held from a side.
fn view_shown(page: &mut Page<'_>, side: &str, shown: Option<Shown>) {
    let text = match shown {
        Some(it) => {
            let [at, off] = [(it.at_s, 1), (it.side_deg.abs(), 0)]
                .map(|(value, digits)| page.words.number(value, digits));
            let id = if it.held { "held" } else { "not-held" };
            let values = [("at", at.as_str()), ("off", off.as_str())];
            page.say_with(&format!("page-view-{id}-{side}"), &values)
        }
        None => page.say(&format!("page-view-not-shown-{side}")),
    };
    page.add(format_args!("<p>{text}</p>"));
}

/// Writes the limits that a view must meet to count, and their source.
fn view_rule(page: &mut Page<'_>, chapter: &Chapter, rule: &ViewRule) {
    let seconds = page.words.number(rule.hold_s, decimals(rule.hold_s));
    let limits =
        [&rule.front, &rule.behind].map(|it| [it.triangle, it.lower_bed, it.two].map(percent));
    let [[a, b, c], [d, e, f]] = &limits;
    let from = source(page, chapter, rule.source.as_deref().unwrap_or(NO_SOURCE));
    let text = page.say_with(
        "page-view-rule",
        &[
            ("seconds", &seconds),
            ("front-triangle", a),
            ("front-bed", b),
            ("front-two", c),
            ("behind-triangle", d),
            ("behind-bed", e),
            ("behind-two", f),
        ],
    );
    page.add(format_args!("<p class=\"lead\">{text}</p>"));
    let rule = page.say("page-cvs");
    page.sources.push([rule, from]);
}

/// Writes the metrics of the hand's motion. They cost no points.
pub(super) fn handling(page: &mut Page<'_>, chapter: &Chapter) {
    page.heading("page-handling");
    page.columns(&["<metric", "page-value"]);
    for metric in [
        Metric::Path,
        Metric::Movements,
        Metric::Smoothness,
        Metric::Economy,
        Metric::Idle,
        Metric::BothMoving,
    ] {
        let values = &chapter.assessed.metrics;
        let [name, value] = [page.named(metric.name()), page.shown(values, metric)];
        page.add(format_args!("<tr><td>{name}<td>{value}</tr>"));
    }
    let note = page.say("page-handling-note");
    page.add(format_args!("</table><p class=\"lead\">{note}</p>"));
    asides::unfelt(page, &chapter.assessed.metrics);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_has_the_decimals_that_it_needs() {
        let found = [70.0, 0.9, 70.25, 0.125].map(decimals);
        assert_eq!(found, [0, 1, 2, 3]);
    }
}
