//! Line charts in panels, as SVG.

use std::fmt::Write as _;

/// A set of points, joined by a line or not.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
    /// True if a line joins the points.
    pub(crate) is_line: bool,
}

/// One coordinate system.
pub(crate) struct Panel {
    pub(crate) title: &'static str,
    pub(crate) axes: [&'static str; 2],
    /// True for a logarithmic axis.
    pub(crate) is_log: [bool; 2],
    /// Numbers printed along each axis. The first and the last number are the ends of the axis.
    pub(crate) marks: [&'static [f64]; 2],
    pub(crate) series: Vec<Series>,
}

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 330.0;
/// Left, top, right and bottom margin of the coordinate system.
const INSET: [f64; 4] = [58.0, 34.0, 16.0, 46.0];
/// Colours that people with reduced colour vision can tell apart too (Okabe and Ito 2008).
const COLORS: [&str; 9] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#888888",
    "#7b3f9e",
];

/// Draws the panels, two in a row, and the legend below. Points beyond the end of an axis are drawn
/// at this end.
pub(crate) fn draw(panels: &[Panel]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series) {
        if !names.contains(&series.name.as_str()) {
            names.push(&series.name);
        }
    }
    let rows = panels.len().div_ceil(2);
    let (width, below) = (2.0 * WIDTH, HEIGHT * rows as f64);
    let height = below + 20.0 * names.len().div_ceil(3) as f64 + 14.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for (i, panel) in panels.iter().enumerate() {
        let at = [WIDTH * (i % 2) as f64, HEIGHT * (i / 2) as f64];
        one(&mut svg, panel, at, &names);
    }
    for (i, name) in names.iter().enumerate() {
        let (x, y) = (
            20.0 + width / 3.0 * (i % 3) as f64,
            below + 16.0 + 20.0 * (i / 3) as f64,
        );
        let color = COLORS[i % COLORS.len()];
        let _ = writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{}\" r=\"4\" fill=\"{color}\"/><text x=\"{}\" y=\"{y}\">{name}</text>",
            y - 4.0,
            x + 9.0
        );
    }
    svg + "</svg>\n"
}

fn one(svg: &mut String, panel: &Panel, [left, top]: [f64; 2], names: &[&str]) {
    let inner = [WIDTH - INSET[0] - INSET[2], HEIGHT - INSET[1] - INSET[3]];
    let share = |axis: usize, value: f64| {
        let marks = panel.marks[axis];
        let (low, high) = (marks[0], marks[marks.len() - 1]);
        let scaled = |v: f64| {
            if panel.is_log[axis] {
                libm::log(v.max(1e-9))
            } else {
                v
            }
        };
        ((scaled(value) - scaled(low)) / (scaled(high) - scaled(low))).clamp(0.0, 1.0)
    };
    let x = |value: f64| left + INSET[0] + inner[0] * share(0, value);
    let y = |value: f64| top + INSET[1] + inner[1] * (1.0 - share(1, value));
    let (right, bottom) = (left + WIDTH - INSET[2], top + HEIGHT - INSET[3]);
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" font-size=\"15\">{}</text>",
        left + INSET[0],
        top + 22.0,
        panel.title
    );
    for &mark in panel.marks[0] {
        let at = x(mark);
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} {:.1}V{bottom:.1}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{mark}</text>",
            top + INSET[1],
            bottom + 16.0
        );
    }
    for &mark in panel.marks[1] {
        let at = y(mark);
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1} {at:.1}H{right:.1}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{mark}</text>",
            left + INSET[0],
            left + INSET[0] - 6.0,
            at + 4.0
        );
    }
    let middle = (left + INSET[0] + right) / 2.0;
    let _ = writeln!(
        svg,
        "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        bottom + 34.0,
        panel.axes[0]
    );
    let (cx, cy) = (left + 14.0, top + INSET[1] + inner[1] / 2.0);
    let _ = writeln!(
        svg,
        "<text transform=\"translate({cx:.1} {cy:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        panel.axes[1]
    );
    for series in &panel.series {
        let place = names.iter().position(|name| *name == series.name);
        let color = COLORS[place.unwrap_or(0) % COLORS.len()];
        let at = |p: &[f64; 2]| (x(p[0]), y(p[1]));
        if series.is_line {
            let line: Vec<String> = series
                .points
                .iter()
                .map(|p| format!("{:.1},{:.1}", at(p).0, at(p).1))
                .collect();
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.6\"/>",
                line.join(" ")
            );
        }
        for p in &series.points {
            let (cx, cy) = at(p);
            let _ = writeln!(
                svg,
                "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3.2\" fill=\"{color}\"/>"
            );
        }
    }
}
