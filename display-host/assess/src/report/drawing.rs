//! Drawings of the report, as SVG.

use core::fmt::Write as _;

use figures::html::escape;

use crate::assessment::{Assessed, Path};
use crate::tally::BIN_N;

const INK: &str = "#282c34";
const BAD: &str = "#9e2a2b";
const TIP: &str = "#1e62a0";
const LENS: &str = "#e69f00";
const WIDTH: f64 = 720.0;

struct Svg(String);

impl Svg {
    fn new(width: f64, height: f64, title: &str) -> Self {
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" role=\"img\" font-family=\"sans-serif\" font-size=\"12\"><!-- Calot --><title>{}</title>",
            escape(title)
        ))
    }

    fn add(&mut self, text: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(text);
    }

    fn text(&mut self, x: f64, y: f64, anchor: &str, text: &str) {
        self.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{INK}\">{}</text>",
            escape(text)
        ));
    }

    fn line(&mut self, [x1, y1, x2, y2]: [f64; 4], color: &str) {
        self.add(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>"
        ));
    }

    fn end(self) -> String {
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

/// Time line of the events, with a lane for each kind.
pub(super) fn time_line(assessed: &Assessed, seconds: f64) -> String {
    let shown = [
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
    ];
    let happened = |lane: &&str| assessed.moments.iter().any(|moment| moment.what == **lane);
    let lanes: Vec<&str> = shown.into_iter().filter(|lane| happened(lane)).collect();
    let end_s = seconds.max(1.0);
    let (left, right) = (92.0, WIDTH - 12.0);
    let x = |at_s: f64| left + (right - left) * (at_s / end_s).clamp(0.0, 1.0);
    let height = 26.0 * (lanes.len() + 1) as f64 + 34.0;
    let mut svg = Svg::new(WIDTH, height, "Time line");
    let every = step(end_s, 8.0);
    for tick in 0..=(end_s / every) as u32 {
        let at_s = f64::from(tick) * every;
        svg.line([x(at_s), 8.0, x(at_s), height - 26.0], "#ddd");
        svg.text(x(at_s), height - 10.0, "middle", &format!("{at_s:.0} s"));
    }
    svg.text(left - 8.0, 26.0, "end", "alarm");
    for alarm in &assessed.alarms {
        let at = x(alarm.at_s);
        svg.add(format_args!(
            "<path d=\"M{at:.1} 12 l7 13 h-14 z\" fill=\"{BAD}\"><title>{:.1} s: {}</title></path>",
            alarm.at_s,
            escape(&alarm.text())
        ));
    }
    for (number, lane) in lanes.iter().enumerate() {
        let y = 22.0 + 26.0 * (number + 1) as f64;
        svg.text(
            left - 8.0,
            y + 4.0,
            "end",
            if *lane == "electro" { "current" } else { lane },
        );
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
                         <title>{:.1} to {until_s:.1} s</title></rect>",
                        y - 5.0,
                        (to - from).max(1.0),
                        moment.at_s
                    ));
                }
            }
            continue;
        }
        for moment in moments {
            let organ = moment.organ.as_deref().unwrap_or("nothing");
            svg.add(format_args!(
                "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{TIP}\" fill-opacity=\"0.75\"><title>{:.1} s: \
                 {} {}</title></circle>",
                x(moment.at_s),
                moment.at_s,
                escape(&moment.what),
                escape(organ)
            ));
        }
    }
    svg.end()
}

/// Both paths, projected along the three world axes.
pub(super) fn projections(paths: &[Path; 2]) -> String {
    let side = 228.0;
    let mut svg = Svg::new(WIDTH, side + 40.0, "Paths of instrument and endoscope");
    let views = [
        ("from the front (x, y)", 0, 1),
        ("from the side (z, y)", 2, 1),
        ("from above (x, z)", 0, 2),
    ];
    let points = || paths.iter().flatten();
    let range = |axis: usize| {
        let values = points()
            .filter_map(|point| point.get(axis))
            .map(|x| f64::from(*x));
        values.fold((f64::MAX, f64::MIN), |(least, most), x| {
            (least.min(x), most.max(x))
        })
    };
    let ranges = [0, 1, 2].map(range);
    let widest = ranges
        .iter()
        .map(|(least, most)| most - least)
        .fold(0.01f64, f64::max)
        * 1.1;
    for (number, (name, across, up)) in views.into_iter().enumerate() {
        let left = 6.0 + 238.0 * number as f64;
        svg.add(format_args!(
            "<rect x=\"{left}\" y=\"4\" width=\"{side}\" height=\"{side}\" fill=\"#fafafa\" stroke=\"#ccc\"/>"
        ));
        svg.text(left + 0.5 * side, side + 20.0, "middle", name);
        let place =
            |value: f64, (least, most): (f64, f64)| (value - 0.5 * (least + most)) / widest + 0.5;
        for (path, color) in paths.iter().zip([TIP, LENS]) {
            // At most 6000 points are drawn, because more do not change the line on a page.
            let every = (path.len() / 3000).max(1);
            let mut drawn = String::new();
            for point in path.iter().step_by(every) {
                let [x, y] = [across, up].map(|axis: usize| {
                    let value = point.get(axis).copied().unwrap_or_default();
                    place(f64::from(value), *ranges.get(axis).unwrap_or(&(0.0, 1.0)))
                });
                let _ = write!(
                    drawn,
                    "{:.1},{:.1} ",
                    left + side * x,
                    4.0 + side * (1.0 - y)
                );
            }
            svg.add(format_args!(
                "<polyline points=\"{drawn}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.2\" \
                 stroke-opacity=\"0.8\"/>"
            ));
        }
        if number == 0 {
            let bar_m = step(widest, 4.0);
            let length = bar_m / widest * side;
            svg.line(
                [left + 8.0, side - 6.0, left + 8.0 + length, side - 6.0],
                INK,
            );
            svg.text(
                left + 8.0,
                side - 12.0,
                "start",
                &format!("{:.0} mm", bar_m * 1e3),
            );
        }
    }
    svg.text(
        6.0,
        side + 37.0,
        "start",
        "blue: the instrument's tip; orange: the endoscope's lens",
    );
    svg.end()
}

/// Histogram of the force on the hand.
pub(super) fn force_histogram(seconds: &[f64]) -> Option<String> {
    // Four bins are drawn as one of 0.2 N, which is easier to read.
    let bins: Vec<f64> = seconds.chunks(4).map(|four| four.iter().sum()).collect();
    let tallest = bins.iter().copied().fold(0.0f64, f64::max);
    if tallest <= 0.0 {
        return None;
    }
    let (left, right, top, bottom) = (60.0, WIDTH - 12.0, 10.0, 180.0);
    let mut svg = Svg::new(WIDTH, 220.0, "Time at each force");
    let width = (right - left) / bins.len() as f64;
    let every_s = step(tallest, 4.0);
    for tick in 0..=(tallest / every_s) as u32 {
        let at = f64::from(tick) * every_s;
        let y = bottom - (bottom - top) * at / tallest;
        svg.line([left, y, right, y], "#ddd");
        svg.text(left - 6.0, y + 4.0, "end", &format!("{at} s"));
    }
    for (number, bin) in bins.iter().enumerate() {
        let height = (bottom - top) * bin / tallest;
        let force_n = number as f64 * 4.0 * BIN_N;
        svg.add(format_args!(
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{TIP}\"><title>{force_n:.1} N: \
             {bin:.1} s</title></rect>",
            left + width * number as f64,
            bottom - height,
            (width - 1.0).max(0.5)
        ));
    }
    let span_n = bins.len() as f64 * 4.0 * BIN_N;
    let every_n = step(span_n, 8.0);
    for tick in 0..=(span_n / every_n) as u32 {
        let force_n = f64::from(tick) * every_n;
        let x = left + (right - left) * force_n / span_n;
        svg.text(x, bottom + 18.0, "middle", &format!("{force_n:.1}"));
    }
    svg.text(right, bottom + 34.0, "end", "force on the hand, N");
    Some(svg.end())
}

/// Curve of a quantity from session to session, with a line at the pass rule.
#[must_use]
pub(super) fn curve(values: &[f64], rule: Option<f64>, name: &str) -> Option<String> {
    if values.len() < 2 {
        return None;
    }
    let (left, right, top, bottom) = (60.0, WIDTH - 12.0, 12.0, 170.0);
    let all = || values.iter().copied().chain(rule);
    let most = all().fold(0.0f64, f64::max).max(1e-9) * 1.08;
    let mut svg = Svg::new(WIDTH, 210.0, name);
    let y = |value: f64| bottom - (bottom - top) * (value / most).clamp(0.0, 1.0);
    let x = |number: usize| left + (right - left) * number as f64 / (values.len() - 1) as f64;
    let every = step(most, 4.0);
    for tick in 0..=(most / every) as u32 {
        let value = f64::from(tick) * every;
        svg.line([left, y(value), right, y(value)], "#ddd");
        svg.text(
            left - 6.0,
            y(value) + 4.0,
            "end",
            &format!("{}", (value * 1e6).round() / 1e6),
        );
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
        svg.text(right, y(rule) - 4.0, "end", "pass rule");
    }
    svg.text(
        right,
        bottom + 32.0,
        "end",
        &format!("{name}, session by session"),
    );
    Some(svg.end())
}

/// Learning curve as a file of its own.
#[must_use]
pub fn learning_curve(values: &[f64], rule: Option<f64>, name: &str) -> Option<String> {
    curve(values, rule, name)
}
