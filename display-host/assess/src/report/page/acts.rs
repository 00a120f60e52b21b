//! Acts of an instructor during the session.

use figures::html::escape;

use super::Page;
use super::lessons::{clock, replay_command};
use crate::report::Chapter;

/// Acts that change the trainee's work.
const COMPLICATIONS: [&str; 3] = ["fog", "bleeding", "slipped_clip"];

pub(super) fn write(page: &mut Page<'_>, chapter: &Chapter) {
    let acts = &chapter.assessed.acts;
    if acts.is_empty() {
        return;
    }
    page.heading("page-acts");
    if acts.iter().any(|act| COMPLICATIONS.contains(&&*act.kind)) {
        let text = page.say("page-acts-note");
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
    page.columns(&["page-act-at", "<page-act"]);
    for act in acts {
        let what = match &act.remark {
            // A remark keeps the direction of its own script.
            Some(remark) => format!("<q dir=\"auto\">{}</q>", escape(remark)),
            None => page.say(&act.message()),
        };
        let at = clock(act.at_s);
        let command = escape(&replay_command(&chapter.name, act.session_s));
        page.add(format_args!("<tr><td>{at}<td class=\"l\">{what}</tr>"));
        let command = format!("<code>{command}</code>");
        page.replays.push([format!("{at} {what}"), command]);
    }
    page.add(format_args!("</table>"));
}
