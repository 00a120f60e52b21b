//! Chart of groups next to each other: a dot for each member, a box for the quartiles, a bar for
//! the median.

use core::fmt::Write as _;

use crate::html::escape;

/// Fill colours of the groups, in turn. People with colour blindness can tell them apart (Okabe and
/// Ito 2008).
const COLORS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"];
/// Colour of the text.
const INK: &str = "#282c34";
/// Width and height of the chart, px.
const SIZE: [f64; 2] = [360.0, 260.0];
/// Edges of the plotted area: left, right, top, bottom, px.
const AREA: [f64; 4] = [58.0, 350.0, 34.0, 216.0];

/// A group of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Name under its dots.
    pub name: String,
    /// A value for each member; those that are not finite are left out.
    pub values: Vec<f64>,
    /// First quartile, median and third quartile.
    pub quartiles: [f64; 3],
}

/// Draws the groups as SVG. `title` names the values and their unit. Returns `None` if no value is
/// finite.
#[must_use]
pub fn groups(title: &str, groups: &[Group]) -> Option<String> {
    let values = groups.iter().flat_map(|it| it.values.iter().copied());
    let values = values.filter(|it| it.is_finite());
    let (least, most) = values.fold((f64::MAX, f64::MIN), |(least, most), it| {
        (least.min(it), most.max(it))
    });
    if least > most {
        return None;
    }
    // The axis begins at zero if the least value is below half of the largest.
    let floor = if least > 0.0 && least < 0.5 * most {
        0.0
    } else {
        least
    };
    let margin = 0.06 * (most - floor).max(1e-9 * most.abs()).max(1e-9);
    let (low, high) = (
        if floor > 0.0 || least < 0.0 {
            floor - margin
        } else {
            0.0
        },
        most + margin,
    );
    let [left, right, top, bottom] = AREA;
    let y = |value: f64| bottom - (bottom - top) * (value - low) / (high - low);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" role=\"img\" \
         font-family=\"sans-serif\" font-size=\"12\"><!-- Calot --><title>{title}</title>\
         <text x=\"{left}\" y=\"18\" font-size=\"14\" fill=\"{INK}\">{title}</text>",
        SIZE[0],
        SIZE[1],
        SIZE[0],
        SIZE[1],
        title = escape(title)
    );
    let interval = step(high - low, 4.0);
    let digits = (-interval.log10().floor()).max(0.0) as usize;
    let mut tick = (low / interval).ceil() * interval;
    while tick <= high {
        let at = y(tick);
        let _ = write!(
            svg,
            "<line x1=\"{left}\" y1=\"{at:.1}\" x2=\"{right}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"{INK}\">{tick:.digits$}</text>",
            left - 6.0,
            at + 4.0
        );
        tick += interval;
    }
    let width = (right - left) / groups.len() as f64;
    for ((number, group), color) in groups.iter().enumerate().zip(COLORS.iter().cycle()) {
        let middle = left + width * (number as f64 + 0.5);
        draw_group(&mut svg, group, (middle, 0.3 * width.min(120.0)), color, &y);
    }
    Some(svg + "</svg>")
}

/// Draws one group. `middle` is its place on the horizontal axis, and `half` is half of its width,
/// px; `y` turns a value into a vertical place.
fn draw_group(
    svg: &mut String,
    group: &Group,
    (middle, half): (f64, f64),
    color: &str,
    y: &impl Fn(f64) -> f64,
) {
    let finite: Vec<f64> = { group.values.iter() }
        .copied()
        .filter(|it| it.is_finite())
        .collect();
    let [first, median, third] = group.quartiles;
    if finite.len() > 2 {
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\" fill-opacity=\"0.15\"/>",
            middle - half,
            y(third),
            2.0 * half,
            y(first) - y(third)
        );
    }
    if !finite.is_empty() {
        let at = y(median);
        let _ = write!(
            svg,
            "<line x1=\"{:.1}\" y1=\"{at:.1}\" x2=\"{:.1}\" y2=\"{at:.1}\" stroke=\"{color}\" stroke-width=\"3\"/>",
            middle - half,
            middle + half
        );
    }
    for (number, value) in finite.iter().enumerate() {
        // Each dot is shifted sideways by another amount, so that equal values stay visible.
        let shift = (number as f64 * 0.618_034).fract() - 0.5;
        let _ = write!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{color}\" fill-opacity=\"0.7\"><title>{value:.3}</title></circle>",
            middle + shift * half,
            y(*value)
        );
    }
    let short_name: String = group.name.chars().take(18).collect();
    let _ = write!(
        svg,
        "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{INK}\">{}</text>\
         <text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#555\">n = {}</text>",
        AREA[3] + 18.0,
        escape(&short_name),
        AREA[3] + 34.0,
        finite.len()
    );
}

/// Step of 1, 2 or 5 times a power of ten that divides a length into at most `count` parts.
fn step(length: f64, count: f64) -> f64 {
    let raw = (length / count).max(1e-12);
    let ten = 10f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|it| it * ten);
    steps.into_iter().find(|it| *it >= raw).unwrap_or(raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(name: &str, values: &[f64]) -> Group {
        Group {
            name: name.to_owned(),
            values: values.to_vec(),
            quartiles: [1.0, 2.0, 3.0],
        }
    }

    #[test]
    fn every_member_has_a_dot_and_names_are_escaped() {
        let all = [group("<b>", &[1.0, 2.0, f64::NAN, 3.0]), group("b", &[2.5])];
        let drawn = groups("time, s", &all).unwrap();
        assert_eq!(drawn.matches("<circle").count(), 4);
        assert!(drawn.contains("n = 3") && drawn.contains("n = 1"));
        assert!(!drawn.contains("<b>") && !drawn.contains("NaN"));
        assert_eq!(groups("nothing", &[group("a", &[f64::NAN])]), None);
    }

    #[test]
    fn equal_and_negative_values_are_drawn() {
        for values in [&[0.0, 0.0, 0.0][..], &[5.0, 5.0], &[-1.4, -2.0], &[1e-9]] {
            let drawn = groups("x", &[group("a", values)]).unwrap();
            assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
        }
    }
}
