//! Lessons of the session: what went wrong, what to do next time, a close picture, and the command
//! that replays the moment.

use base64::Engine as _;
use figures::html::escape;

use super::{Page, sentence};
use crate::metrics::Metric;
use crate::report::close::{close_picture, png};
use crate::report::lesson::Lesson;
use crate::report::{CLOSE_MAX, Chapter};
use crate::step::Reason;

/// Largest number of moments that a lesson lists.
const TIMES_MAX: usize = 6;
/// Time before an error or an act at which its replay begins, s.
const LEAD_S: f64 = 3.0;

pub(super) fn write(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    let lessons = Lesson::of(&it.alarms);
    page.heading("page-lessons");
    let open = it.reasons.iter().find_map(Reason::open_step);
    let is_flawless = lessons.is_empty() && it.reasons.is_empty() && it.lost.is_empty();
    if is_flawless {
        let text = page.say("page-no-alarm");
        page.add(format_args!("<p>{text}</p>"));
    }
    for (number, lesson) in lessons.iter().enumerate() {
        one(page, chapter, lesson, number < CLOSE_MAX);
    }
    if let Some(step) = open {
        let [what, next, place] = [
            escape(&sentence(&page.words.say_with(
                "reason-not-done",
                &[("step", &page.words.step(step))],
            ))),
            page.say("page-next-time"),
            escape(&page.words.place(step)),
        ];
        page.add(format_args!(
            "<section class=\"lesson\"><div><h4>{what}</h4><p><b>{next}</b> {place}</p></div></section>"
        ));
    }
    lost(page, chapter);
    unmet(page, chapter);
}

fn one(page: &mut Page<'_>, chapter: &Chapter, lesson: &Lesson, has_picture: bool) {
    let it = &chapter.assessed;
    let organ = page.words.organ(lesson.organ.as_deref().unwrap_or("?"));
    let kind = format!("alarm-{}", lesson.kind.name().replace('_', "-"));
    let what = page.say_with(&kind, &[("organ", &organ)]);
    let count = lesson.alarms.len().to_string();
    let times = page.say_with("page-times", &[("count", &count)]);
    let title = sentence(&what);
    let next = [page.say("page-next-time"), page.say(&lesson.advice())];
    page.add(format_args!(
        "<section class=\"lesson\"><div><h4>{title} <small>{times}</small></h4><p><b>{}</b> {}</p>",
        next[0], next[1]
    ));
    let mut times = Vec::new();
    let alarms = lesson
        .alarms
        .iter()
        .filter_map(|it| chapter.assessed.alarms.get(*it));
    for alarm in alarms.take(TIMES_MAX) {
        let at = clock(alarm.at_s);
        let command = replay_command(&chapter.name, alarm.session_s);
        page.replays.push([
            format!("{at} {what}"),
            format!("<code>{}</code>", escape(&command)),
        ]);
        times.push(at);
    }
    let at = page.say_with("page-happened-at", &[("times", &times.join(", "))]);
    page.add(format_args!("<p>{at}</p></div>"));
    let first = lesson.alarms.first().copied().unwrap_or(0);
    let picture = it
        .alarms
        .get(first)
        // A place without an organ, such as that of a lost clip, has nothing to show.
        .filter(|alarm| has_picture && alarm.organ.is_some())
        .and_then(|alarm| {
            let hands = it.hands.get(first).and_then(Option::as_ref);
            png(&close_picture(
                &chapter.outlines,
                (alarm.organ.as_deref(), alarm.at_m),
                hands,
            )?)
        });
    if let Some(png) = picture {
        let data = base64::engine::general_purpose::STANDARD.encode(png);
        let caption = page.say_with("page-close-note", &[("organ", &organ)]);
        page.add(format_args!(
            "<figure><img alt=\"{what}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}\
             </figcaption></figure>"
        ));
    }
    page.add(format_args!("</section>"));
}

/// Writes advice about lost points that no alarm explains.
fn lost(page: &mut Page<'_>, chapter: &Chapter) {
    for lost in &chapter.assessed.lost {
        let advice = format!("advice-metric-{}", lost.metric.replace('_', "-"));
        if !page.words.has(&advice) {
            continue;
        }
        let points = page.words.number(lost.points, 1);
        let [name, points, next, advice] = [
            page.told(lost.metric, lost.value),
            page.say_with("page-cost", &[("points", &points)]),
            page.say("page-next-time"),
            page.say(&advice),
        ];
        page.add(format_args!(
            "<section class=\"lesson\"><div><h4>{name} <small>{points}</small></h4><p><b>{next}</b> {advice}</p>\
             </div></section>"
        ));
    }
}

/// Writes advice about pass rules that are not met and cost no points.
fn unmet(page: &mut Page<'_>, chapter: &Chapter) {
    let it = &chapter.assessed;
    for reason in &it.reasons {
        let metric = match reason {
            Reason::TooLittle { metric, .. } | Reason::TooMuch { metric, .. } => *metric,
            _ => None,
        };
        let Some(name) = metric.map(Metric::name) else {
            continue;
        };
        let advice = format!("advice-metric-{}", name.replace('_', "-"));
        if it.lost.iter().any(|lost| lost.metric == name) || !page.words.has(&advice) {
            continue;
        }
        let [what, next, advice] = [
            escape(&sentence(&page.words.reason(reason))),
            page.say("page-next-time"),
            page.say(&advice),
        ];
        page.add(format_args!(
            "<section class=\"lesson\"><div><h4>{what}</h4><p><b>{next}</b> {advice}</p></div></section>"
        ));
    }
}

/// Minutes and seconds.
pub(super) fn clock(seconds: f64) -> String {
    let seconds = seconds.max(0.0) as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// A text as one word of a shell.
#[must_use]
pub fn in_shell(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Command that replays a session from a little before this moment: what led to an error teaches
/// more than what followed.
pub(super) fn replay_command(session: &str, session_s: f64) -> String {
    let session_s = (session_s - LEAD_S).max(0.0);
    let session = in_shell(session);
    format!("calot replay {session} --at {session_s:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replay_command_is_safe_in_a_shell() {
        assert_eq!(
            replay_command("it's; rm", 12.34),
            "calot replay 'it'\\''s; rm' --at 9.3"
        );
        assert!(replay_command("a", 1.0).ends_with("--at 0.0"));
        assert_eq!(clock(75.9), "1:15");
    }
}
