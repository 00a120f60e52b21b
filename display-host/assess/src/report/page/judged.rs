//! Tables of the debrief that say what was judged, by which rule, and where the rule comes from.

use figures::html::escape;

use super::{Page, shown};
use crate::injury::{Injury, Severity};
use crate::metrics::Metric;
use crate::report::Chapter;
use crate::view::Shares;

pub(super) fn injuries(page: &mut Page<'_>, injuries: &[Injury]) {
    if injuries.is_empty() {
        return;
    }
    page.add(format_args!(
        "<h3>Injuries</h3><table><tr><th>time<th class=\"l\">structure<th class=\"l\">injury<th \
         class=\"l\">cause<th class=\"l\">consequence<th class=\"l\">source of the rule</tr>"
    ));
    for injury in injuries {
        let consequence = match injury.severity {
            Severity::Grave => "ends the task",
            Severity::Serious => "rules out a pass",
            Severity::Minor => "costs points",
        };
        page.add(format_args!(
            "<tr><td>{:.1} s<td class=\"l\">{}<td class=\"l\">{}<td class=\"l\">{}<td \
             class=\"l\">{consequence}<td class=\"l\">{}</tr>",
            injury.at_s,
            escape(&injury.organ),
            injury.kind,
            injury.cause,
            escape(&injury.source)
        ));
    }
    page.add(format_args!("</table>"));
}

pub(super) fn pass_rules(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let pass = chapter.rules.pass(it.task, it.difficulty);
    if !pass.is_empty() {
        page.add(format_args!(
            "<h3>Pass rules</h3><table><tr><th>metric<th>value<th>required<th>met<th class=\"l\">source</tr>"
        ));
        for rule in pass.into_iter().chain(chapter.rules.time_rule(it.task)) {
            let (name, least, most) = (rule.name, rule.at_least, rule.at_most);
            let value = match Metric::from_name(name) {
                Some(metric) => it.metrics.get(metric),
                None => it.score,
            };
            let asked = match (least.is_finite(), most.is_finite()) {
                (true, true) => format!("{least} to {most}"),
                (true, false) => format!("at least {least}"),
                (false, true) => format!("at most {most}"),
                (false, false) => "–".to_owned(),
            };
            let met = if value < least || value > most {
                "✗ no"
            } else {
                "✓ yes"
            };
            let name = page.named(name);
            page.add(format_args!(
                "<tr><td>{name}<td>{value:.1}<td>{asked}<td>{met}<td class=\"l\">{}</tr>",
                escape(rule.source)
            ));
        }
        page.add(format_args!("</table>"));
    }
}

pub(super) fn points(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    if !it.lost.is_empty() {
        page.add(format_args!(
            "<h3>Points lost</h3><table><tr><th>metric<th>value<th>points<th class=\"l\">source of the \
             weight</tr>"
        ));
        for lost in &it.lost {
            let name = page.named(lost.metric);
            page.add(format_args!(
                "<tr><td>{name}<td>{:.1}<td>{:.1}<td class=\"l\">{}</tr>",
                lost.value,
                lost.points,
                escape(chapter.rules.weight_source(it.task, lost.metric))
            ));
        }
        page.add(format_args!("</table>"));
    }
}

/// Writes published values beside the trainee's.
pub(super) fn published(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let mut references = chapter.rules.references(it.task).peekable();
    if references.peek().is_none() {
        return;
    }
    page.add(format_args!(
        "<h3>Published values</h3><p class=\"lead\">They come from other simulators or from operations. They say \
         what is usual, and judge nothing.</p><table><tr><th>metric<th>here<th>published<th class=\"l\">of whom<th \
         class=\"l\">source</tr>"
    ));
    for reference in references {
        let name = page.named(reference.metric.name());
        page.add(format_args!(
            "<tr><td>{name}<td>{}<td>{}<td class=\"l\">{}<td class=\"l\">{}</tr>",
            shown(&it.metrics, reference.metric),
            reference.value,
            escape(&reference.who),
            escape(&reference.source)
        ));
    }
    page.add(format_args!("</table>"));
}

/// Writes the critical view of safety: what was achieved, and what the endoscope showed of it.
pub(super) fn critical_view(page: &mut Page<'_>, chapter: &Chapter) {
    let Some(cvs) = &chapter.assessed.cvs else {
        return;
    };
    page.add(format_args!(
        "<h3>Critical view of safety</h3><table><tr><th class=\"l\">criterion<th>achieved<th>most seen at once<th>seen \
         from the front<th>true then<th>seen from behind<th>true then</tr>"
    ));
    let percent = |share: f64| match share.is_finite() {
        true => format!("{:.0} %", 100.0 * share),
        false => "–".to_owned(),
    };
    let none = [f64::NAN; 3];
    let of = |shares: Shares| [shares.triangle, shares.lower_bed, shares.two];
    let sides = [cvs.front, cvs.behind]
        .map(|shown| shown.map_or([none; 2], |it| [of(it.seen), of(it.truth)]));
    let rows = [
        ("triangle free of tissue", cvs.triangle),
        ("lower third of the bed free", cvs.lower_bed),
        ("two structures: cystic duct and artery", cvs.two),
    ];
    for (index, (name, criterion)) in rows.into_iter().enumerate() {
        page.add(format_args!(
            "<tr><td class=\"l\">{name}<td>{}<td>{}",
            percent(criterion.achieved),
            percent(criterion.visible.unwrap_or(f64::NAN)),
        ));
        for [seen, truth] in sides {
            page.add(format_args!(
                "<td>{}<td>{}",
                percent(seen[index]),
                percent(truth[index])
            ));
        }
        page.add(format_args!("</tr>"));
    }
    page.add(format_args!("</table>"));
    for (name, shown) in [("the front", cvs.front), ("behind", cvs.behind)] {
        match shown {
            Some(it) if it.held => page.add(format_args!(
                "<p>Shown from {name} and held, until {:.1} s, {:.0}° off the plane of duct and artery.</p>",
                it.at_s,
                it.side_deg.abs()
            )),
            Some(it) => page.add(format_args!(
                "<p>Not held from {name}. The best picture came at {:.1} s.</p>",
                it.at_s
            )),
            None => page.add(format_args!("<p>Not shown from {name}.</p>")),
        }
    }
    if let Some(rule) = chapter.rules.view() {
        page.add(format_args!(
            "<p class=\"lead\">A view counts if it is held for {} s and shows, from the front, {} of the triangle, {} \
             of the bed and {} of duct and artery each; from behind, {}, {} and {}. Source of these limits: {}. \
             Achieved and true are the model's: tissue removed, vessels whole. Seen is what an identity image \
             of the endoscope's picture shows. Pictures are below.</p>",
            rule.hold_s,
            percent(rule.front.triangle),
            percent(rule.front.lower_bed),
            percent(rule.front.two),
            percent(rule.behind.triangle),
            percent(rule.behind.lower_bed),
            percent(rule.behind.two),
            escape(rule.source.as_deref().unwrap_or("no source"))
        ));
    }
}

/// Writes how the hand moved: shown, and not scored.
pub(super) fn handling(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    page.add(format_args!(
        "<h3>How the hand moved</h3><table><tr><th>metric<th>value</tr>"
    ));
    for metric in [
        Metric::Path,
        Metric::Movements,
        Metric::Smoothness,
        Metric::Economy,
        Metric::Idle,
        Metric::BothMoving,
    ] {
        let name = page.named(metric.name());
        page.add(format_args!(
            "<tr><td>{name}<td>{}</tr>",
            shown(&it.metrics, metric)
        ));
    }
    page.add(format_args!(
        "</table><p class=\"lead\">These cost no points. A hand that trembles is less smooth, and one that pauses is \
         idle for longer; but at another trainer smoothness, economy and idle time told surgeons from novices in \
         no task (<code>calot report --rules-file</code> says how that was measured), and no publication known to \
         us gives a limit. Compare them with earlier sessions of the same hand.</p>"
    ));
}
