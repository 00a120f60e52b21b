//! A certificate of the levels that a trainee has completed, as a page to print.

use std::fmt::Write as _;

use display_host::words::Words;
use figures::html::escape;

use crate::report::utc;

/// A completed level.
pub(super) struct Level<'a> {
    pub(super) title: &'a str,
    pub(super) rows: Vec<Row>,
}

/// A task in which the trainee is proficient.
pub(super) struct Row {
    pub(super) task: &'static str,
    pub(super) difficulty: &'static str,
    /// Least score of a pass.
    pub(super) benchmark: f64,
    /// Passes in a row.
    pub(super) passes: usize,
    /// Beginning of the session with the last of these passes, Unix s.
    pub(super) since_unix_s: i64,
}

const STYLE: &str = "@page{size:A4;margin:0}body{font:16px/1.5 sans-serif;color:#111;background:#fff;\
max-width:46rem;margin:0 auto;padding:2rem}main{border:3px double #456;padding:2.5rem 3rem}\
h1{font-size:2.2rem;text-align:center;margin:0 0 1.5rem}.name{font-size:2rem;text-align:center;\
margin:.5rem 0;overflow-wrap:anywhere}.told{text-align:center}h2{font-size:1.1rem;margin:1.6rem 0 .3rem}\
table{width:100%;border-collapse:collapse}th{text-align:left;font-weight:normal;color:#456}\
th,td{padding:.2rem .6rem .2rem 0;border-bottom:1px solid #ccd;vertical-align:top}\
footer{margin-top:2rem;font-size:.85rem;color:#333}";

/// The page.
pub(super) fn page(trainee: &str, is_all: bool, levels: &[Level<'_>], words: &Words) -> String {
    let say = |id| escape(&words.say(id));
    let mut page = format!(
        "<!doctype html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\">\
         <title>Calot: {}</title><style>{STYLE}</style></head><body><main>\
         <h1>{}</h1><p class=\"name\" dir=\"auto\">{}</p><p class=\"told\">{}</p>",
        words.language().code(),
        say("certificate-title"),
        say("certificate-title"),
        escape(trainee),
        say(match is_all {
            true => "certificate-all",
            false => "certificate-some",
        }),
    );
    for level in levels {
        let _ = write!(page, "<h2>{}</h2><table><tr>", escape(level.title));
        for id in ["task", "difficulty", "rule", "since"] {
            let head = words.say(&format!("certificate-{id}"));
            let _ = write!(page, "<th>{}</th>", escape(&head));
        }
        page.push_str("</tr>");
        for row in &level.rows {
            page.push_str(&line(row, words));
        }
        page.push_str("</table>");
    }
    let version = concat!("Calot ", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(
        page,
        "<footer><p>{}</p><p>{version}</p></footer></main></body></html>",
        say("certificate-note")
    );
    page
}

fn line(row: &Row, words: &Words) -> String {
    let passes = row.passes.to_string().into();
    let score = words.number(row.benchmark, 0).into();
    let rule = match (row.passes, row.benchmark > 0.0) {
        (1, false) => words.say("certificate-rule-once"),
        _ => words.say_with(
            "certificate-rule-row",
            &[("passes", passes), ("score", score)],
        ),
    };
    let day = utc(row.since_unix_s.unsigned_abs());
    let day = day.split(' ').next().unwrap_or_default();
    let cells = [
        words.say(&format!("task-{}", row.task)),
        words.say(&format!("difficulty-{}", row.difficulty)),
        rule,
        day.to_owned(),
    ];
    let cells = cells.map(|it| format!("<td>{}</td>", escape(&it)));
    format!("<tr>{}</tr>", cells.concat())
}
