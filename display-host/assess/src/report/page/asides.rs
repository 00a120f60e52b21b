//! Parts of the debrief beside its judgement: times that do not count, the simulation's timing, and
//! the definitions.

use figures::html::escape;

use super::Page;
use crate::metrics::{Metric, Values};
use crate::report::{Chapter, PICTURES_MIN};

/// Up to this noise of the handle, mm, the page promises that a resting hand has less than 5 mm of
/// path a minute. The test `a_resting_hand_with_a_noisy_device_rests_at_every_rate` checks the
/// promise at 100 Hz.
const NOISE_MAX_MM: f64 = 0.7;
/// Time in gaps of the recording above which the result is not the hand's alone, s: the built-in
/// rules allow an exam as much.
const STALLED_S: f64 = 5.0;
/// Volume in the suction's jar from which the page tells it, ml.
const JAR_ML_MIN: f64 = 0.05;

/// Press on a protected structure above which the page compares it with the hand's force, N: five
/// steps of the metric, which tells it in steps of 0.1 N.
const PRESSED_N: f64 = 0.5;
/// Share of the press that the hand felt, below which its forces say nothing of the press. A device
/// that is on passes the press on, up to its own limit.
const UNFELT: f64 = 0.1;

/// Writes the durations of the simulation's ticks, and how many were late or missed.
pub(super) fn ticks(page: &mut Page<'_>, chapter: &Chapter) {
    let Some(ticks) = &chapter.ticks else {
        return;
    };
    let title = page.say("page-timing");
    page.add(format_args!(
        "<details><summary>{title}</summary><table lang=\"en\"><tr><th>µs<th>p50<th>p99<th>max</tr>"
    ));
    let stages = ticks.stage_ns.iter().map(|(name, it)| (name.as_str(), it));
    for (name, spread) in [("whole tick", &ticks.tick_ns)].into_iter().chain(stages) {
        let [p50, p99, max] = [spread.p50, spread.p99, spread.max].map(|ns| ns as f64 / 1e3);
        page.add(format_args!(
            "<tr><td>{}<td>{p50:.1}<td>{p99:.1}<td>{max:.1}</tr>",
            escape(name)
        ));
    }
    let [count, late, missed] =
        [ticks.tick_ns.count, ticks.late_ticks, ticks.missed_periods].map(|it| it.to_string());
    let values = [
        ("count", count.as_str()),
        ("late", late.as_str()),
        ("missed", missed.as_str()),
    ];
    let id = match ticks.realtime {
        true => "page-timing-realtime",
        false => "page-timing-otherwise",
    };
    let text = page.say_with(id, &values);
    page.add(format_args!(
        "</table><p class=\"lead\">{text}</p></details>"
    ));
}

/// Writes the sources of the chapter's rules, folded: they are for those who examine the rules.
pub(super) fn sources(page: &mut Page<'_>) {
    let sources = core::mem::take(&mut page.sources);
    folded(
        page,
        "page-sources",
        &sources,
        ["page-rule", "page-source"],
        "",
    );
}

/// Writes the commands that replay the errors, folded: a trainee uses the window.
pub(super) fn replays(page: &mut Page<'_>) {
    let replays = core::mem::take(&mut page.replays);
    let english = " lang=\"en\"";
    folded(
        page,
        "page-replays",
        &replays,
        ["page-time", "page-replay"],
        english,
    );
}

/// Writes a table of two columns that is folded at first. `is_in` is the attribute of the right
/// column's language, if it is not the page's.
fn folded(page: &mut Page<'_>, title: &str, rows: &[[String; 2]], heads: [&str; 2], is_in: &str) {
    if rows.is_empty() {
        return;
    }
    let [title, left, right] = [title, heads[0], heads[1]].map(|id| page.say(id));
    page.add(format_args!(
        "<details><summary>{title}</summary><table><tr><th>{left}<th class=\"l\">{right}</tr>"
    ));
    for [left, right] in rows {
        page.add(format_args!(
            "<tr><td>{left}<td class=\"l\"{is_in}>{right}</tr>"
        ));
    }
    page.add(format_args!("</table></details>"));
}

/// Links the page about the station, so that nobody takes it for the debrief.
pub(super) fn technical(page: &mut Page<'_>, chapter: &Chapter) {
    if let Some(file) = chapter.technical.as_deref().map(escape) {
        let text = page.say("page-technical");
        page.add(format_args!(
            "<p class=\"lead\">{text} <a href=\"{file}\">{file}</a></p>"
        ));
    }
}

/// Says that the hand felt almost nothing of what the tissue felt. The forces on the hand then tell
/// nothing about how hard the instrument pressed.
pub(super) fn unfelt(page: &mut Page<'_>, values: &Values) {
    let [felt_n, pressed_n] = [Metric::ForceMax, Metric::PressWrongMax].map(|it| values.get(it));
    if pressed_n > PRESSED_N && felt_n < UNFELT * pressed_n {
        let [felt, pressed] = [felt_n, pressed_n].map(|it| page.words.number(it, 1));
        let values = [("felt", felt.as_str()), ("pressed", &pressed)];
        let text = page.say_with("page-unfelt", &values);
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
}

/// Warns if the window showed too few pictures to train with.
pub(super) fn slow(page: &mut Page<'_>, chapter: &Chapter) {
    let rate = chapter.ticks.as_ref().and_then(|it| it.pictures_per_second);
    if let Some(rate) = rate.filter(|it| *it < PICTURES_MIN) {
        let rate = page.words.number(rate, 1);
        let text = page.say_with("page-slow-computer", &[("rate", &rate)]);
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
}

/// Warns if the recording has long gaps: the computer stood still while the hook may have burnt.
pub(super) fn stalled(page: &mut Page<'_>, values: &Values) {
    let gaps_s = values.get(Metric::Gaps);
    if gaps_s > STALLED_S {
        let seconds = page.words.number(gaps_s, 0);
        let text = page.say_with("page-stood-still", &[("seconds", &seconds)]);
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
}

/// Tells the volumes in the suction's jar, if it was used.
pub(super) fn jar(page: &mut Page<'_>, chapter: &Chapter) {
    let Some(fluids) = chapter.ticks.as_ref().and_then(|it| it.fluids) else {
        return;
    };
    let all = [fluids.blood, fluids.bile, fluids.water];
    if all.iter().all(|it| it.jar_ml < JAR_ML_MIN) {
        return;
    }
    let left_ml = all.iter().map(|it| it.on_tissue_ml).sum();
    let [blood, bile, water] = all.map(|it| page.words.number(it.jar_ml, 1));
    let left = page.words.number(left_ml, 1);
    let values = [
        ("blood", blood.as_str()),
        ("bile", &bile),
        ("water", &water),
        ("left", &left),
    ];
    let text = page.say_with("page-jar", &values);
    page.add(format_args!("<p class=\"lead\">{text}</p>"));
}

/// Tells the spilled stones, and the danger of those that were left behind.
pub(super) fn stones(page: &mut Page<'_>, values: &Values) {
    let [spilled, out, left] = [
        Metric::StonesSpilled,
        Metric::StonesRetrieved,
        Metric::StonesLeft,
    ]
    .map(|it| values.get(it));
    if !Metric::StonesSpilled.is_worth_mention(spilled) {
        return;
    }
    let [spilled, out, left_text] = [spilled, out, left].map(|it| format!("{it:.0}"));
    let values = [
        ("spilled", spilled.as_str()),
        ("out", &out),
        ("left", &left_text),
    ];
    let mut text = page.say_with("page-stones", &values);
    if left > 0.0 {
        text.push(' ');
        text.push_str(&page.say("page-stones-left"));
    }
    page.add(format_args!("<p class=\"open\">{text}</p>"));
}

/// Tells how often the trainee started over. A pass of a fourth attempt is not one of the first.
pub(super) fn restarts(page: &mut Page<'_>, values: &Values) {
    let count = values.get(Metric::Restarts);
    if Metric::Restarts.is_worth_mention(count) {
        let count = format!("{count:.0}");
        let text = page.say_with("page-restarted", &[("count", &count)]);
        page.add(format_args!("<p class=\"open\">{text}</p>"));
    }
}

/// Writes the times that do not count as the trainee's, and the noise of the handle.
pub(super) fn not_counted(page: &mut Page<'_>, values: &Values) {
    let times = [
        (Metric::Paused, "page-was-paused"),
        (Metric::Gaps, "page-has-gaps"),
        (Metric::DeviceLost, "page-lost-device"),
    ];
    let times: Vec<String> = times
        .into_iter()
        .map(|(metric, id)| (metric, values.get(metric), id))
        .filter(|(metric, seconds, _)| metric.is_worth_mention(*seconds))
        .map(|(_, seconds, id)| {
            let seconds = page.words.number(seconds, 1);
            page.say_with(id, &[("seconds", &seconds)])
        })
        .collect();
    if !times.is_empty() {
        let note = page.say("page-not-counted");
        page.add(format_args!(
            "<p class=\"open\">{} {note}</p>",
            times.join(" ")
        ));
    }
    let noise_mm = values.get(Metric::Noise);
    if noise_mm > 0.0 {
        let id = match noise_mm <= NOISE_MAX_MM {
            true => "page-noise-small",
            false => "page-noise-large",
        };
        let noise = page.words.number(noise_mm, 2);
        let text = page.say_with(id, &[("noise", &noise)]);
        page.add(format_args!("<p class=\"lead\">{text}</p>"));
    }
}

/// Writes the definitions in the reader's language. If it has none, those of the program's
/// documentation, in English.
pub(super) fn definitions(page: &mut Page<'_>) {
    let [title, metric, definition, source] = [
        page.say("page-definitions"),
        page.say("metric"),
        page.say("page-definition"),
        page.say("page-source"),
    ];
    page.add(format_args!(
        "<h2>{title}</h2><details><summary>{definition}</summary><table><tr><th>{metric}<th \
         class=\"l\">{definition}<th class=\"l\">{source}</tr>"
    ));
    for metric in Metric::ALL {
        let name = page.named(metric.name());
        let own = format!("definition-{}", metric.name().replace('_', "-"));
        let (is_in, text) = match page.words.has(&own) {
            true => ("", page.say(&own)),
            false => (" lang=\"en\"", escape(metric.definition())),
        };
        // Other sources are names of products and publications.
        let source = match metric.source() {
            "own" => page.say("page-source-own"),
            source => escape(source),
        };
        page.add(format_args!(
            "<tr><td>{name}<td class=\"l\"{is_in}>{text}<td class=\"l\">{source}</tr>"
        ));
    }
    page.add(format_args!("</table></details>"));
}
