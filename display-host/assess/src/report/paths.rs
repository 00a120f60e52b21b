//! Paths of instrument and endoscope over the organs, as SVG.

use core::fmt::Write as _;

use figures::html::escape;

use super::drawing::{INK, LENS, Svg, TIP, WIDTH, step};
use super::outline::{CELLS, Outlines, View};
use super::words::Words;
use crate::assessment::Path;

/// Side of a view.
const SIDE: f64 = 228.0;
/// Upper edge of the views.
const TOP: f64 = 4.0;
/// A view is wider than the widest extent of the paths, by this share of the extent.
const MARGIN: f64 = 0.3;
/// Shorter paths get a view as wide as for this extent, m.
const EXTENT_MIN_M: f64 = 0.01;
/// Size of an organ's name. A letter is taken to be half as wide.
const NAME_SIZE: f64 = 10.0;

/// The three views: message of the caption, and the axes to the right and upwards.
const VIEWS: [(&str, [usize; 2]); 3] = [
    ("page-front", [0, 1]),
    ("page-side", [2, 1]),
    ("page-above", [0, 2]),
];

/// Both paths over the organs at rest, projected along the three world axes.
pub(super) fn projections(paths: &[Path; 2], organs: &Outlines, words: &dyn Words) -> String {
    let mut svg = Svg::new(WIDTH, SIDE + 40.0, &words.say("page-paths"));
    let ranges = [0, 1, 2].map(|axis| range(paths, axis));
    let extents = ranges.iter().map(|[least, most]| most - least);
    let width_m = extents.fold(EXTENT_MIN_M, f64::max) * (1.0 + MARGIN);
    for (number, (caption, axes)) in VIEWS.into_iter().enumerate() {
        let corner = [6.0 + 238.0 * number as f64, TOP];
        let from_m = axes.map(|axis| {
            let [least, most] = ranges.get(axis).copied().unwrap_or_default();
            0.5 * (least + most - width_m)
        });
        let view = View {
            axes,
            from_m,
            width_m,
        };
        background(&mut svg, corner, &words.say(caption));
        silhouettes(&mut svg, corner, view, organs, words);
        lines(&mut svg, corner, view, paths);
        if number == 0 {
            scale(&mut svg, corner, width_m);
        }
    }
    let legend = words.say(match organs.is_any() {
        true => "page-legend-organs",
        false => "page-legend",
    });
    svg.text(6.0, SIDE + 37.0, "start", &legend);
    svg.end()
}

/// Smallest and largest coordinate of the paths, m.
fn range(paths: &[Path; 2], axis: usize) -> [f64; 2] {
    let points = paths.iter().flatten().filter_map(|point| point.get(axis));
    let [least, most] = points.fold([f64::MAX, f64::MIN], |[least, most], x| {
        let x = f64::from(*x);
        [least.min(x), most.max(x)]
    });
    if least > most {
        [0.0; 2]
    } else {
        [least, most]
    }
}

fn background(svg: &mut Svg, [left, top]: [f64; 2], caption: &str) {
    svg.add(format_args!(
        "<rect x=\"{left}\" y=\"{top}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"#fafafa\" \
         stroke=\"#ccc\"/>"
    ));
    svg.text(left + 0.5 * SIDE, SIDE + 20.0, "middle", caption);
}

/// Draws the organs, and each name that overlaps no earlier name.
fn silhouettes(svg: &mut Svg, corner: [f64; 2], view: View, organs: &Outlines, words: &dyn Words) {
    let cell = SIDE / CELLS as f64;
    let mut names: Vec<([f64; 2], f64, String)> = Vec::new();
    for organ in organs.seen(view) {
        svg.add(format_args!(
            "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.1}\" stroke-opacity=\"0.7\"/>",
            organ.path(corner, SIDE),
            organ.color,
            cell + 0.1
        ));
        let Some([column, row]) = organ.middle else {
            continue;
        };
        let name = words.organ(organ.name);
        let half = 0.25 * NAME_SIZE * name.chars().count() as f64;
        let [left, right] = [corner[0] + half, corner[0] + SIDE - half];
        let x = (corner[0] + cell * column).clamp(left, right.max(left));
        let y =
            (corner[1] + SIDE - cell * row).clamp(corner[1] + NAME_SIZE, corner[1] + SIDE - 4.0);
        let is_free = names.iter().all(|([other_x, other_y], other_half, _)| {
            (other_x - x).abs() > half + other_half || (other_y - y).abs() > NAME_SIZE
        });
        if is_free {
            names.push(([x, y], half, name));
        }
    }
    for ([x, y], _, name) in names {
        svg.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" font-size=\"{NAME_SIZE}\" \
             fill=\"#6b5b55\">{}</text>",
            escape(&name)
        ));
    }
}

fn lines(svg: &mut Svg, [left, top]: [f64; 2], view: View, paths: &[Path; 2]) {
    for (path, color) in paths.iter().zip([TIP, LENS]) {
        // At most 6000 points are drawn, because more do not change the line on a page.
        let every = (path.len() / 3000).max(1);
        let mut drawn = String::new();
        for point in path.iter().step_by(every) {
            let along = |number: usize| {
                let axis = view.axes.get(number).copied().unwrap_or_default();
                let value = f64::from(point.get(axis).copied().unwrap_or_default());
                (value - view.from_m.get(number).copied().unwrap_or_default()) / view.width_m
            };
            // Writing to a string cannot fail.
            let _ = write!(
                drawn,
                "{:.1},{:.1} ",
                left + SIDE * along(0),
                top + SIDE * (1.0 - along(1))
            );
        }
        svg.add(format_args!(
            "<polyline points=\"{drawn}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.2\" \
             stroke-opacity=\"0.9\"/>"
        ));
    }
}

fn scale(svg: &mut Svg, [left, _]: [f64; 2], width_m: f64) {
    let bar_m = step(width_m, 4.0);
    let (from, y) = (left + 8.0, SIDE - 6.0);
    svg.line([from, y, from + bar_m / width_m * SIDE, y], INK);
    svg.text(from, y - 6.0, "start", &format!("{:.0} mm", bar_m * 1e3));
}
