//! Drawings of the report, as SVG.

use core::fmt::Write as _;

use figures::html::escape;

use super::words::Words;
use crate::alarm::Alarm;
use crate::assessment::Assessed;
use crate::tally::BIN_N;

pub(super) const INK: &str = "#282c34";
pub(super) const BAD: &str = "#9e2a2b";
pub(super) const TIP: &str = "#1e62a0";
pub(super) const LENS: &str = "#e69f00";
pub(super) const WIDTH: f64 = 720.0;

pub(super) struct Svg(String);

impl Svg {
    pub(super) fn new(width: f64, height: f64, title: &str) -> Self {
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" role=\"img\" font-family=\"sans-serif\" font-size=\"12\"><!-- Calot --><title>{}</title>",
            escape(title)
        ))
    }

    pub(super) fn add(&mut self, text: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(text);
    }

    pub(super) fn text(&mut self, x: f64, y: f64, anchor: &str, text: &str) {
        self.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{INK}\">{}</text>",
            escape(text)
        ));
    }

    pub(super) fn line(&mut self, [x1, y1, x2, y2]: [f64; 4], color: &str) {
        self.add(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>"
        ));
    }

    pub(super) fn end(self) -> String {
        self.0 + "</svg>"
    }
}

/// Step of 1, 2 or 5 times a power of ten that divides a length into at most `count` parts.
pub(super) fn step(length: f64, count: f64) -> f64 {
    let raw = (length / count).max(1e-9);
    let ten = 10f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|it| it * ten);
    steps.into_iter().find(|it| *it >= raw).unwrap_or(raw)
}

/// Kinds of events that the time line shows, one lane each, from the top.
pub const LANES: [&str; 17] = [
    "hung",
    "electro",
    "grasp",
    "clip",
    "cut",
    "tear",
    "leak",
    "crush",
    "perforation",
    "fall",
    "shake",
    "buried",
    "opened",
    "unclipped",
    "seared",
    "stone_spilled",
    "stone_retrieved",
];

/// Time line of the events, with a lane for each kind.
pub(super) fn time_line(assessed: &Assessed, seconds: f64, words: &dyn Words) -> String {
    let happened = |lane: &&str| assessed.moments.iter().any(|moment| moment.what == **lane);
    let lanes: Vec<&str> = LANES.into_iter().filter(|lane| happened(lane)).collect();
    let end_s = seconds.max(1.0);
    let (left, right) = (128.0, WIDTH - 12.0);
    let x = |at_s: f64| left + (right - left) * (at_s / end_s).clamp(0.0, 1.0);
    let height = 26.0 * (lanes.len() + 1) as f64 + 34.0;
    let mut svg = Svg::new(WIDTH, height, &words.say("page-time-line"));
    let every = step(end_s, 8.0);
    for tick in 0..=(end_s / every) as u32 {
        let at_s = f64::from(tick) * every;
        svg.line([x(at_s), 8.0, x(at_s), height - 26.0], "#ddd");
        svg.text(x(at_s), height - 10.0, "middle", &format!("{at_s:.0} s"));
    }
    svg.text(left - 8.0, 26.0, "end", &words.say("metric-alarms"));
    for alarm in &assessed.alarms {
        let at = x(alarm.at_s);
        svg.add(format_args!(
            "<path d=\"M{at:.1} 12 l7 13 h-14 z\" fill=\"{BAD}\"><title>{:.1} s: {}</title></path>",
            alarm.at_s,
            escape(&told(words, alarm))
        ));
    }
    for (number, lane) in lanes.iter().enumerate() {
        let y = 22.0 + 26.0 * (number + 1) as f64;
        let name = words.say(&format!("lane-{lane}"));
        svg.text(left - 8.0, y + 4.0, "end", &name);
        let moments = assessed
            .moments
            .iter()
            .filter(|moment| moment.what == *lane);
        if *lane == "electro" {
            let mut moments = moments.peekable();
            while let Some(moment) = moments.next() {
                let until_s = moments.peek().map_or(end_s, |next| next.at_s);
                if moment.value > 0.0 {
                    let (from, to) = (x(moment.at_s), x(until_s));
                    svg.add(format_args!(
                        "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"10\" fill=\"{LENS}\">\
                         <title>{:.1} – {until_s:.1} s</title></rect>",
                        y - 5.0,
                        (to - from).max(1.0),
                        moment.at_s
                    ));
                }
            }
            continue;
        }
        for moment in moments {
            let organ = moment.organ.as_deref();
            let organ = organ.map(|it| words.organ(it)).unwrap_or_default();
            svg.add(format_args!(
                "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{TIP}\" fill-opacity=\"0.75\"><title>{:.1} s: \
                 {} {}</title></circle>",
                x(moment.at_s),
                moment.at_s,
                escape(&name),
                escape(&organ)
            ));
        }
    }
    svg.end()
}

/// Text of an alarm.
fn told(words: &dyn Words, alarm: &Alarm) -> String {
    let organ = words.organ(alarm.organ.as_deref().unwrap_or("?"));
    let id = format!("alarm-{}", alarm.kind.name().replace('_', "-"));
    words.say_with(&id, &[("organ", &organ)])
}

/// Largest number of bars in the histogram of the force, so that each is wide enough to point at.
const BARS_MAX: usize = 60;
/// The histogram reaches at least to this force, N, so that small forces look small.
const FORCE_SHOWN_N: f64 = 2.0;

/// Histogram of the force on the hand.
pub(super) fn force_histogram(seconds: &[f64], words: &dyn Words) -> Option<String> {
    let least = (FORCE_SHOWN_N / BIN_N).ceil() as usize;
    let shown = seconds.len().max(least);
    let together = shown.div_ceil(BARS_MAX);
    let bins: Vec<f64> = seconds.chunks(together).map(|it| it.iter().sum()).collect();
    let tallest = bins.iter().copied().fold(0.0f64, f64::max);
    if tallest <= 0.0 {
        return None;
    }
    let (left, right, top, bottom) = (60.0, WIDTH - 12.0, 10.0, 180.0);
    let mut svg = Svg::new(WIDTH, 220.0, &words.say("page-force"));
    let bar_n = together as f64 * BIN_N;
    let span_n = shown.div_ceil(together) as f64 * bar_n;
    let width = (right - left) * bar_n / span_n;
    let every_s = step(tallest, 4.0);
    for tick in 0..=(tallest / every_s) as u32 {
        let at = f64::from(tick) * every_s;
        let y = bottom - (bottom - top) * at / tallest;
        svg.line([left, y, right, y], "#ddd");
        svg.text(left - 6.0, y + 4.0, "end", &format!("{} s", short(at)));
    }
    for (number, bin) in bins.iter().enumerate() {
        let height = (bottom - top) * bin / tallest;
        let force_n = number as f64 * bar_n;
        svg.add(format_args!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{TIP}\"><title>{} – {} N: \
             {bin:.1} s</title></rect>",
            left + width * number as f64,
            bottom - height,
            (width - 1.0).max(0.5),
            short(force_n),
            short(force_n + bar_n)
        ));
    }
    let every_n = step(span_n, 8.0);
    for tick in 0..=(span_n / every_n) as u32 {
        let force_n = f64::from(tick) * every_n;
        let x = left + (right - left) * force_n / span_n;
        svg.text(x, bottom + 18.0, "middle", &short(force_n));
    }
    svg.text(right, bottom + 34.0, "end", &words.say("page-force-axis"));
    Some(svg.end())
}

/// A number, rounded to six decimals. So the rounding errors of sums are not shown.
fn short(value: f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

/// Curve of a quantity from session to session, with a line at the pass rule. `None` for fewer than
/// two sessions.
#[must_use]
pub(super) fn curve(
    values: &[f64],
    rule: Option<f64>,
    name: &str,
    words: &dyn Words,
) -> Option<String> {
    let name = words.metric(name);
    if values.len() < 2 {
        return None;
    }
    let (left, right, top, bottom) = (60.0, WIDTH - 12.0, 12.0, 170.0);
    let all = || values.iter().copied().chain(rule);
    let most = all().fold(0.0f64, f64::max).max(1e-9) * 1.08;
    let mut svg = Svg::new(WIDTH, 210.0, &name);
    let y = |value: f64| bottom - (bottom - top) * (value / most).clamp(0.0, 1.0);
    let x = |number: usize| left + (right - left) * number as f64 / (values.len() - 1) as f64;
    let every = step(most, 4.0);
    for tick in 0..=(most / every) as u32 {
        let value = f64::from(tick) * every;
        svg.line([left, y(value), right, y(value)], "#ddd");
        svg.text(left - 6.0, y(value) + 4.0, "end", &short(value));
    }
    let mut points = String::new();
    for (number, value) in values.iter().enumerate() {
        let _ = write!(points, "{:.1},{:.1} ", x(number), y(*value));
    }
    svg.add(format_args!(
        "<polyline points=\"{points}\" fill=\"none\" stroke=\"{TIP}\" stroke-width=\"1.5\"/>"
    ));
    for (number, value) in values.iter().enumerate() {
        svg.add(format_args!(
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{TIP}\"><title>{value:.2}</title></circle>",
            x(number),
            y(*value)
        ));
        if values.len() <= 20 {
            svg.text(
                x(number),
                bottom + 16.0,
                "middle",
                &(number + 1).to_string(),
            );
        }
    }
    if let Some(rule) = rule {
        svg.line([left, y(rule), right, y(rule)], BAD);
        svg.text(right, y(rule) - 4.0, "end", &words.say("page-pass-rule"));
    }
    svg.text(
        right,
        bottom + 32.0,
        "end",
        &words.say_with("page-by-session", &[("name", &name)]),
    );
    Some(svg.end())
}

/// Learning curve of a metric, or of the score, as text of an SVG file. `None` for fewer than two
/// sessions.
#[must_use]
pub fn learning_curve(
    values: &[f64],
    rule: Option<f64>,
    name: &str,
    words: &dyn Words,
) -> Option<String> {
    curve(values, rule, name, words)
}
