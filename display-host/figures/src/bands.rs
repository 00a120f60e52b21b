//! Heat maps of time: a band for each quantity, a cell for each step of time.

use core::fmt::Write as _;

use crate::html::escape;

/// Cells of a band. More steps share cells, and a cell shows the greatest of its steps.
const CELLS: usize = 120;
const LEFT: usize = 110;
const WIDTH: usize = 5;
const HEIGHT: usize = 18;
/// Room for the axis of time and the legend.
const BELOW: usize = 52;
/// Colours of the legend, from little to much. Their order shows without colour, too (Wong 2011:
/// dark means much).
const COLOURS: [&str; 6] = [
    "#f2f2f2", "#d6e4ee", "#a9c8de", "#e6b35a", "#cf6a2f", "#7a1f1f",
];

/// A band of the map.
#[derive(Debug, Clone)]
pub struct Band<'a> {
    /// Name at its left.
    pub name: &'a str,
    /// Value of each step.
    pub values: Vec<f64>,
}

/// Draws the bands over a time of `seconds`. `bounds` are the values at which the colours change,
/// in this `unit`. `None` if there is nothing to draw.
#[must_use]
pub fn bands(all: &[Band<'_>], seconds: f64, bounds: [f64; 5], unit: &str) -> Option<String> {
    let steps = all.iter().map(|band| band.values.len()).max()?;
    if steps == 0 {
        return None;
    }
    let share = steps.div_ceil(CELLS);
    let cells = steps.div_ceil(share);
    let (width, height) = (LEFT + CELLS * WIDTH + 20, all.len() * HEIGHT + BELOW);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\">"
    );
    // Cells fill the width, whatever their number.
    let wide = (CELLS * WIDTH) as f64 / cells as f64;
    for (row, band) in all.iter().enumerate() {
        let y = row * HEIGHT;
        // Writing to a string cannot fail.
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            LEFT - 8,
            y + 13,
            escape(band.name)
        );
        for (i, values) in band.values.chunks(share).enumerate() {
            let value = values.iter().copied().fold(0.0, f64::max);
            let _ = write!(
                svg,
                "<rect x=\"{:.1}\" y=\"{y}\" width=\"{wide:.1}\" height=\"{}\" fill=\"{}\"/>",
                LEFT as f64 + i as f64 * wide,
                HEIGHT - 1,
                colour(value, bounds)
            );
        }
    }
    let y = all.len() * HEIGHT + 14;
    for part in 0..=4usize {
        let x = LEFT + part * CELLS * WIDTH / 4;
        let at_s = seconds * part as f64 / 4.0;
        let _ = write!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{at_s:.0} s</text>"
        );
    }
    let y = y + 12;
    let edges = bounds.map(|bound| format!("{bound:.0}"));
    for (i, colour) in COLOURS.iter().enumerate() {
        let x = LEFT + i * 100;
        let words = match (i.checked_sub(1).and_then(|i| edges.get(i)), edges.get(i)) {
            (None, Some(high)) => format!("up to {high}"),
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (low, _) => format!("above {} {unit}", low.map_or("", String::as_str)),
        };
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"14\" height=\"14\" fill=\"{colour}\" \
             stroke=\"#999\"/><text x=\"{}\" y=\"{}\">{words}</text>",
            x + 19,
            y + 12
        );
    }
    svg += "</svg>";
    Some(svg)
}

fn colour(value: f64, bounds: [f64; 5]) -> &'static str {
    let above = bounds.iter().filter(|&&bound| value > bound).count();
    COLOURS.get(above).copied().unwrap_or("#000")
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: [f64; 5] = [10.0, 30.0, 100.0, 300.0, 1000.0];

    fn count(svg: &str, colour: &str) -> usize {
        svg.matches(&format!("fill=\"{colour}\"")).count()
    }

    #[test]
    fn each_step_has_a_cell_in_the_colour_of_its_value() {
        let band = |name, values: &[f64]| Band {
            name,
            values: values.to_vec(),
        };
        let all = [band("solve", &[5.0, 200.0, 2000.0]), band("<b>", &[5.0; 3])];
        let svg = bands(&all, 3.0, BOUNDS, "µs").expect("drawn");
        // One more of each colour is in the legend.
        let counts = COLOURS.map(|colour| count(&svg, colour));
        assert_eq!(counts, [5, 1, 1, 2, 1, 2]);
        assert!(svg.contains("&lt;b&gt;") && svg.contains("above 1000 µs"));
        assert!(svg.contains(">3 s<") && svg.contains(">10 to 30<"));
    }

    #[test]
    fn many_steps_share_cells_and_the_greatest_is_shown() {
        let mut values = vec![1.0; 1000];
        values[777] = 5000.0;
        let all = [Band {
            name: "solve",
            values,
        }];
        let svg = bands(&all, 1000.0, BOUNDS, "µs").expect("drawn");
        assert!(svg.matches("<rect").count() <= CELLS + COLOURS.len());
        assert_eq!(count(&svg, COLOURS[5]), 2);
        assert!(bands(&[], 1.0, BOUNDS, "µs").is_none());
    }
}
