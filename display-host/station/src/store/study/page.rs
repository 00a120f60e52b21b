//! study.html: a page that needs neither network nor other files.

use figures::groups::{Group, groups};
use figures::html::{STYLE, escape};
use figures::panels::{Panel, Scale, Series, panels};
use statistics::learning;

use super::figures::{Reliability, Row, rows};
use super::sample::{Sample, TaskSample};

/// Metrics that are drawn if they have values, in addition to those whose groups differ most.
const DRAWN: [&str; 6] = [
    "score",
    "time_s",
    "path_m",
    "movements",
    "smoothness",
    "idle_s",
];
/// Metrics for which learning curves are drawn and fitted.
const LEARNT: [&str; 3] = ["score", "time_s", "path_m"];

/// The page.
pub(super) fn html(sample: &Sample, agreements: &[Reliability]) -> String {
    let tasks: String = sample.tasks.iter().map(|it| task(sample, it)).collect();
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: study</title><style>{STYLE}.wide{{overflow-x:auto}}\
         .charts{{display:flex;flex-wrap:wrap;gap:1rem}}.few{{color:#555}}</style><main><h1>Study by {}</h1>\
         <p class=\"lead\">The unit is the person: each counts once, by the median of the person’s sessions.</p>\
         {}{tasks}{}{}</main></html>\n",
        sample.by.name(),
        who(sample),
        reliability(agreements),
        METHODS
    )
}

/// Methods and their sources.
const METHODS: &str = "<h2>Methods</h2><ul>\
<li>Quartiles lie linearly between values (Hyndman and Fan 1996, type 7).\
<li>p is the two-sided test of Mann and Whitney (1947), exact with ties for up to 100 persons, else normal with \
corrections for ties and continuity. p (Holm) holds for all comparisons of a task together (Holm 1979). Groups of \
fewer than three persons are not tested.\
<li>r is the rank-biserial correlation: the share of pairs in which the first group has more, minus the share in which \
it has less. 1 and −1 are groups that do not overlap.\
<li>Learning: an inverse curve, a + b/session, is fitted to each person with at least five sessions. The plateau is \
a; the learning rate is the number of sessions until the curve is within a tenth of it (Feldman et al., Surgery \
146:381, 2009). A rate beyond the person’s last session is a forecast.\
<li>ICC(2,1) is the absolute agreement of single raters on the sum of a sheet (Shrout and Fleiss 1979), with its 95 % \
interval (McGraw and Wong 1996). α is Cronbach’s (1951), of the items of a form. Sessions of one person are taken as \
independent in both.</ul>";

fn who(sample: &Sample) -> String {
    let mut notes = sample.left_out.in_words();
    let is_none = notes == ["none"];
    if is_none {
        notes.clear();
    }
    let mut text = match is_none {
        true => "<p>No session is left out.</p>".to_owned(),
        false => format!(
            "<p>Left out are sessions: {}.</p>",
            escape(&notes.join("; "))
        ),
    };
    if sample.has_scripted {
        text += "<p class=\"bad\">Scripted hands are among these sessions. They tell about the simulator and its \
                 metrics, not about people.</p>";
    }
    let doubts = [
        (
            sample.left_out.unknown_realtime,
            "nobody knows whether the run was realtime",
        ),
        (
            sample.left_out.unknown_consent,
            "nobody asked for consent (`calot store trainee NAME --consent yes`)",
        ),
    ];
    for (count, why) in doubts.iter().filter(|(count, _)| *count > 0) {
        text += &format!("<p>Of {count} sessions that are in, {}.</p>", escape(why));
    }
    text
}

fn task(sample: &Sample, task: &TaskSample) -> String {
    let names = task.groups();
    let rows = rows(task);
    let sizes: String = names
        .iter()
        .map(|name| {
            let people = || task.people.iter().filter(|it| it.group == *name);
            let sessions: usize = people().map(|it| it.sessions.len()).sum();
            format!(
                "<tr><td>{}<td>{}<td>{sessions}</tr>",
                escape(name),
                people().count()
            )
        })
        .collect();
    format!(
        "<h2>Task {}</h2><p class=\"lead\">Difficulty {}, version {} of the metrics.</p>\
         <table><tr><th>{}<th>persons<th>sessions</tr>{sizes}</table>{}{}{}",
        escape(&task.task),
        escape(&task.difficulty),
        task.version,
        sample.by.name(),
        charts(task, &names, &rows),
        table(&names, &rows),
        course(task)
    )
}

fn charts(task: &TaskSample, names: &[String], rows: &[Row]) -> String {
    let drawn = rows.iter().filter(|it| DRAWN.contains(&it.metric.as_str()));
    let drawn = drawn.filter_map(|row| {
        let all = names.iter().zip(&row.quartiles);
        let all: Vec<Group> = all
            .map(|(name, quartiles)| Group {
                name: name.clone(),
                values: task.medians(name, &row.metric),
                quartiles: *quartiles,
            })
            .collect();
        groups(&title(row), &all)
    });
    let drawn: String = drawn.collect();
    match drawn.is_empty() {
        true => drawn,
        false => format!(
            "<div class=\"charts\">{drawn}</div><p class=\"few\">A dot is a person, the bar the median, the box \
             the quartiles.</p>"
        ),
    }
}

fn title(row: &Row) -> String {
    match row.unit {
        "" | "1" | "n" => row.metric.clone(),
        unit => format!("{}, {unit}", row.metric),
    }
}

fn table(names: &[String], rows: &[Row]) -> String {
    let heads: String = names
        .iter()
        .map(|it| format!("<th>{}", escape(it)))
        .collect();
    if rows.is_empty() {
        return "<h3>Groups</h3><p class=\"few\">Medians need more persons.</p>".to_owned();
    }
    let mut body = String::new();
    for row in rows {
        let cells = row
            .quartiles
            .iter()
            .map(|[first, median, third]| match median.is_finite() {
                true => format!(
                    "<td>{} ({}–{})",
                    number(*median),
                    number(*first),
                    number(*third)
                ),
                false => "<td>no value".to_owned(),
            });
        let cells: String = cells.collect();
        let head = format!("<td>{}{cells}", escape(&title(row)));
        if row.pairs.is_empty() {
            body += &format!(
                "<tr>{head}<td colspan=\"4\" class=\"few\">too few persons to compare</tr>"
            );
        }
        for (number_of, pair) in row.pairs.iter().enumerate() {
            let head = match number_of {
                0 => head.clone(),
                _ => "<td>".repeat(names.len() + 1),
            };
            let [first, second] = pair.groups.each_ref().map(|it| escape(it));
            body += &format!(
                "<tr>{head}<td>{first} and {second}<td>{}<td>{}<td>{:+.2}</tr>",
                chance(pair.found.p),
                chance(pair.raised),
                pair.found.delta
            );
        }
    }
    format!(
        "<h3>Groups</h3><p>Median of the persons (first to third quartile).</p><div class=\"wide\"><table><tr><th>metric{heads}\
         <th>compared<th>p<th>p (Holm)<th>r</tr>{body}</table></div>"
    )
}

/// Curves and plateaus, if anybody has several sessions.
fn course(task: &TaskSample) -> String {
    let most = task.people.iter().map(|it| it.sessions.len()).max();
    if most.unwrap_or(0) < 2 {
        return "<h3>Learning</h3><p class=\"few\">Nobody has more than one session, so nothing is said about learning.</p>"
            .to_owned();
    }
    let panel = |metric: &&str| Panel {
        title: (*metric).to_owned(),
        axes: ["session".to_owned(), (*metric).to_owned()],
        scales: [Scale::Linear; 2],
        series: { task.people.iter() }
            .map(|it| Series {
                name: it.group.clone(),
                points: { it.values(metric).into_iter().enumerate() }
                    .map(|(index, value)| [(index + 1) as f64, value])
                    .collect(),
                is_thin: false,
            })
            .collect(),
    };
    let drawn = panels(&LEARNT.iter().map(panel).collect::<Vec<_>>(), 3).unwrap_or_default();
    let mut body = String::new();
    for person in &task.people {
        for metric in LEARNT {
            let Some(it) = learning(&person.values(metric)) else {
                continue;
            };
            let rate = match it.sessions {
                Some(at) if at <= person.sessions.len() as f64 => format!("{}", at.ceil()),
                Some(at) => format!("not reached (forecast {})", at.ceil()),
                None => "plateau is zero".to_owned(),
            };
            body += &format!(
                "<tr><td>{}<td>{}<td>{metric}<td>{}<td>{}<td>{rate}<td>{:.2}</tr>",
                escape(&person.label),
                escape(&person.group),
                number(it.first),
                number(it.plateau),
                it.explained
            );
        }
    }
    let body = match body.is_empty() {
        true => {
            "<p class=\"few\">Nobody has five sessions, so no plateau is fitted.</p>".to_owned()
        }
        false => format!(
            "<div class=\"wide\"><table><tr><th>person<th>group<th>metric<th>first<th>plateau<th>sessions to it<th>R²</tr>\
             {body}</table></div>"
        ),
    };
    format!("<h3>Learning</h3><figure>{drawn}</figure>{body}")
}

fn reliability(all: &[Reliability]) -> String {
    if all.is_empty() {
        return "<h2>Agreement</h2><p class=\"few\">No scoring sheet and no questionnaire belongs to these sessions.</p>"
            .to_owned();
    }
    let few = || "too little data".to_owned();
    let mut body = String::new();
    for it in all {
        let agreement = match it.agreement {
            Some(found) => {
                let [low, high] = found.interval;
                format!("{:.2} [{low:.2}, {high:.2}]", found.icc)
            }
            None if it.raters == 0 => "–".to_owned(),
            None => few(),
        };
        body += &format!(
            "<tr><td>{}<td>{}<td>{}<td>{}<td>{agreement}<td>{}</tr>",
            escape(&it.name),
            it.filled,
            it.raters,
            it.sessions,
            it.alpha.map_or_else(few, |it| format!("{it:.2}"))
        );
    }
    format!(
        "<h2>Agreement</h2><div class=\"wide\"><table><tr><th>form<th>filled<th>raters<th>sessions by all<th>ICC(2,1)<th>α</tr>\
         {body}</table></div>"
    )
}

/// A number with about three digits.
fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if size >= 100.0 => format!("{value:.0}"),
        _ if size >= 10.0 => format!("{value:.1}"),
        _ if size >= 0.1 || value == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

/// A probability, as text.
fn chance(p: f64) -> String {
    match p < 0.001 {
        true => "&lt;0.001".to_owned(),
        false => format!("{p:.3}"),
    }
}
