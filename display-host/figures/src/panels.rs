//! Charts as SVG: panels of series over logarithmic or linear axes, and heat maps. The drawing code
//! knows numbers and names only, not their meaning.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences take equal lengths.
    Linear,
    /// Equal factors take equal lengths; only decades have labels.
    Log,
}

/// A line or a cloud of points.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// Name in the legend. A name has one colour in all panels.
    pub name: String,
    /// Points. A point whose `y` is not finite becomes a cross on the upper edge.
    pub points: Vec<[f64; 2]>,
    /// True for a thin line without dots, such as the line of a limit.
    pub is_thin: bool,
}

/// A coordinate system with its series.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Heading.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Scales of the axes.
    pub scales: [Scale; 2],
    /// Series to draw.
    pub series: Vec<Series>,
}

/// A cell of a heat map.
#[derive(Debug, Clone)]
pub struct Cell {
    /// Text to draw.
    pub text: String,
    /// Quality that sets the colour, from 0 (bad) to 1 (good); `None` if unknown.
    pub good: Option<f64>,
}

type Failure<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Colours that people with colour blindness can distinguish (Okabe and Ito 2008).
const COLORS: [RGBColor; 9] = [
    RGBColor(160, 160, 160),
    RGBColor(90, 90, 90),
    RGBColor(230, 159, 0),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(0, 0, 0),
];
const INK: RGBColor = RGBColor(30, 30, 30);

/// Draws panels, `columns` per row, with one legend below.
///
/// # Errors
///
/// The drawing library's message.
pub fn panels(panels: &[Panel], columns: usize) -> Result<String, String> {
    panels_from(panels, columns, 0)
}

/// Draws panels as [`panels`] does, with colours that start at number `first`. Number 7 is green,
/// 8 is black.
///
/// # Errors
///
/// The drawing library's message.
pub fn panels_from(panels: &[Panel], columns: usize, first: usize) -> Result<String, String> {
    // A series' colour is its place in this list, so the colours before `first` get no name.
    let mut names: Vec<&str> = vec![""; first];
    for series in panels.iter().flat_map(|p| &p.series) {
        if !names.contains(&series.name.as_str()) {
            names.push(&series.name);
        }
    }
    let rows = panels.len().div_ceil(columns.max(1));
    let legend = 24 * (names.len() - first).div_ceil(3) as u32 + 16;
    let size = (400 * columns as u32, 380 * rows as u32 + legend);
    draw(size, |root| {
        let (top, bottom) = root.split_vertically(size.1 - legend);
        for (panel, area) in panels.iter().zip(top.split_evenly((rows, columns))) {
            one(panel, &area, &names)?;
        }
        for (i, name) in names.iter().skip(first).enumerate() {
            let column = 400 * columns as i32 / 3;
            let (x, y) = (30 + column * (i as i32 % 3), 12 + 24 * (i as i32 / 3));
            bottom.draw(&Circle::new((x, y), 5, color(first + i).filled()))?;
            let text = Text::new((*name).to_owned(), (x + 12, y - 8), ("sans-serif", 15));
            bottom.draw(&text)?;
        }
        Ok(())
    })
}

/// Draws a table of coloured cells.
///
/// # Errors
///
/// The drawing library's message.
pub fn heat_map(
    columns: &[String],
    rows: &[String],
    cells: &[Vec<Cell>],
) -> Result<String, String> {
    const LEFT: i32 = 250;
    const TOP: i32 = 64;
    const WIDTH: i32 = 112;
    const HEIGHT: i32 = 34;
    let size = (
        (LEFT + WIDTH * columns.len() as i32 + 10) as u32,
        (TOP + HEIGHT * rows.len() as i32 + 10) as u32,
    );
    draw(size, |root| {
        let small = || ("sans-serif", 12).into_font().color(&INK);
        for (i, name) in columns.iter().enumerate() {
            for (line, words) in wrap(name, 17).iter().enumerate() {
                let at = (LEFT + WIDTH * i as i32 + 4, 6 + 15 * line as i32);
                root.draw(&Text::new(words.clone(), at, small()))?;
            }
        }
        for (j, (name, cells)) in rows.iter().zip(cells).enumerate() {
            let y = TOP + HEIGHT * j as i32;
            root.draw(&Text::new(name.clone(), (6, y + 10), small()))?;
            for (i, cell) in cells.iter().enumerate() {
                let x = LEFT + WIDTH * i as i32;
                let fill = cell.good.map_or(RGBColor(235, 235, 235), shade);
                let corners = [(x + 1, y + 1), (x + WIDTH - 1, y + HEIGHT - 1)];
                root.draw(&Rectangle::new(corners, fill.filled()))?;
                root.draw(&Text::new(cell.text.clone(), (x + 6, y + 10), small()))?;
            }
        }
        Ok(())
    })
}

fn draw(
    size: (u32, u32),
    what: impl for<'a> Fn(&Area<'a>) -> Result<(), Failure<'a>>,
) -> Result<String, String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let all = root.fill(&WHITE).and_then(|()| what(&root));
        all.and_then(|()| root.present())
            .map_err(|e| e.to_string())?;
    }
    Ok(text)
}

fn color(i: usize) -> RGBColor {
    COLORS[i % COLORS.len()]
}

/// Colour from orange through pale to blue, which avoids red against green.
fn shade(good: f64) -> RGBColor {
    let mix =
        |from: u8, to: u8, t: f64| (f64::from(from) + (f64::from(to) - f64::from(from)) * t) as u8;
    let good = good.clamp(0.0, 1.0);
    let (from, to, t) = if good < 0.5 {
        ((240, 140, 90), (250, 240, 215), good * 2.0)
    } else {
        ((250, 240, 215), (140, 200, 235), good * 2.0 - 1.0)
    };
    RGBColor(
        mix(from.0, to.0, t),
        mix(from.1, to.1, t),
        mix(from.2, to.2, t),
    )
}

fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + word.chars().count() >= width {
            lines.push(word.to_owned());
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last] += word;
        }
    }
    lines
}

/// Range from the least to the greatest finite value. A logarithmic range covers whole decades, so
/// that its ends have labels.
fn range(values: impl Iterator<Item = f64>, scale: Scale) -> [f64; 2] {
    let drawn = |v: &f64| v.is_finite() && (scale == Scale::Linear || *v > 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(drawn) {
        (low, high) = (low.min(v), high.max(v));
    }
    if low > high {
        (low, high) = (1.0, 10.0);
    }
    match scale {
        Scale::Log => {
            let decade = |v: f64, round: fn(f64) -> f64| 10_f64.powf(round(v.log10()));
            [decade(low, f64::floor), decade(high * 1.01, f64::ceil)]
        }
        Scale::Linear => {
            let margin = 0.05 * (high - low).max(1e-9);
            [low - margin, high + margin]
        }
    }
}

fn one<'a>(panel: &Panel, area: &Area<'a>, names: &[&str]) -> Result<(), Failure<'a>> {
    let points = || panel.series.iter().flat_map(|s| &s.points);
    let [x0, x1] = range(points().map(|p| p[0]), panel.scales[0]);
    let [y0, y1] = range(points().map(|p| p[1]), panel.scales[1]);
    let mut builder = ChartBuilder::on(area);
    builder
        .caption(&panel.title, ("sans-serif", 17))
        .margin(8)
        .margin_right(24)
        .x_label_area_size(38)
        .y_label_area_size(52);
    // Each pair of scales is a type of its own in the library.
    match panel.scales {
        [Scale::Log, Scale::Log] => {
            let mut c = builder.build_cartesian_2d((x0..x1).log_scale(), (y0..y1).log_scale())?;
            fill(&mut c, panel, names, y1)
        }
        [Scale::Log, Scale::Linear] => {
            let mut c = builder.build_cartesian_2d((x0..x1).log_scale(), y0..y1)?;
            fill(&mut c, panel, names, y1)
        }
        [Scale::Linear, Scale::Log] => {
            let mut c = builder.build_cartesian_2d(x0..x1, (y0..y1).log_scale())?;
            fill(&mut c, panel, names, y1)
        }
        [Scale::Linear, Scale::Linear] => {
            let mut c = builder.build_cartesian_2d::<_, _>(
                RangedCoordf64::from(x0..x1),
                RangedCoordf64::from(y0..y1),
            )?;
            fill(&mut c, panel, names, y1)
        }
    }
}

/// Short label of a value. On a logarithmic axis only decades have labels.
fn label(value: f64, scale: Scale) -> String {
    if scale == Scale::Log && (value.log10() - value.log10().round()).abs() > 1e-6 {
        return String::new();
    }
    let plain = |v: f64| {
        let text = format!("{v:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0" } else { text }.to_owned()
    };
    match value.abs() {
        v if v >= 1e6 => plain(value / 1e6) + " M",
        v if v >= 1e4 => plain(value / 1e3) + " k",
        _ => plain(value),
    }
}

fn fill<'a, X, Y>(
    chart: &mut ChartContext<'_, SVGBackend<'a>, Cartesian2d<X, Y>>,
    panel: &Panel,
    names: &[&str],
    top: f64,
) -> Result<(), Failure<'a>>
where
    X: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
{
    let [across, up] = panel.scales.map(|scale| move |v: &f64| label(*v, scale));
    chart
        .configure_mesh()
        .x_desc(&panel.axes[0])
        .y_desc(&panel.axes[1])
        .x_label_formatter(&across)
        .y_label_formatter(&up)
        .light_line_style(RGBColor(242, 242, 242))
        .draw()?;
    for series in &panel.series {
        let place = names.iter().position(|n| *n == series.name).unwrap_or(0);
        let color = color(place);
        let sound = series.points.iter().filter(|p| p[1].is_finite());
        let line: Vec<(f64, f64)> = sound.map(|p| (p[0], p[1])).collect();
        let width = if series.is_thin { 1 } else { 2 };
        chart.draw_series(LineSeries::new(
            line.iter().copied(),
            color.stroke_width(width),
        ))?;
        if series.is_thin {
            continue;
        }
        chart.draw_series(line.iter().map(|&p| Circle::new(p, 4, color.filled())))?;
        let broken = series.points.iter().filter(|p| !p[1].is_finite());
        chart.draw_series(broken.map(|p| Cross::new((p[0], top), 5, color.stroke_width(2))))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_begin_with_the_one_asked_for() {
        let panel = Panel {
            title: "A title".to_owned(),
            axes: ["time, ms".to_owned(), "place, mm".to_owned()],
            scales: [Scale::Linear, Scale::Linear],
            series: vec![Series {
                name: "measured".to_owned(),
                points: vec![[0.0, 1.0], [1.0, 2.0]],
                is_thin: false,
            }],
        };
        let grey = panels(std::slice::from_ref(&panel), 1).expect("drawn");
        let green = panels_from(&[panel], 1, 7).expect("drawn");
        assert!(
            grey.contains("#A0A0A0") && !green.contains("#A0A0A0"),
            "{green}"
        );
        assert!(green.contains("#009E73"), "{green}");
        assert_eq!(green.matches("measured").count(), 1);
    }

    #[test]
    fn panels_show_every_series_and_mark_what_broke() {
        let panel = |scales| Panel {
            title: "A title".to_owned(),
            axes: ["time, µs".to_owned(), "error, mm".to_owned()],
            scales,
            series: vec![Series {
                name: "a method".to_owned(),
                points: vec![[10.0, 1.0], [100.0, 0.1], [50.0, f64::INFINITY]],
                is_thin: false,
            }],
        };
        let all = [Scale::Linear, Scale::Log];
        let all: Vec<Panel> = all
            .iter()
            .flat_map(|x| all.iter().map(|y| panel([*x, *y])))
            .collect();
        let svg = panels(&all, 2).expect("drawn");
        assert!(svg.ends_with("</svg>\n") && svg.contains("a method"));
        assert_eq!(svg.matches("A title").count(), 4);
        assert!(svg.matches("<circle").count() >= 8);
    }

    #[test]
    fn a_heat_map_has_its_words() {
        let cell = |text: &str, good| Cell {
            text: text.to_owned(),
            good,
        };
        let cells = [vec![cell("fine", Some(1.0)), cell("–", None)]];
        let names = [
            "one method".to_owned(),
            "another with a long name".to_owned(),
        ];
        let svg = heat_map(&names, &["a case".to_owned()], &cells).expect("drawn");
        assert!(svg.contains("fine") && svg.contains("a case") && svg.contains("long name"));
    }

    #[test]
    fn labels_are_short() {
        let log = |v| label(v, Scale::Log);
        assert_eq!([log(1e5), log(3e5), log(0.1)], ["100 k", "", "0.1"]);
        assert_eq!(label(2.5, Scale::Linear), "2.5");
        assert_eq!(label(1e-12 - 1.2e-12, Scale::Linear), "0");
    }

    #[test]
    fn ranges_are_whole_decades() {
        let [low, high] = range([0.3, 20.0, f64::INFINITY].into_iter(), Scale::Log);
        assert!((low - 0.1).abs() < 1e-9 && (high - 100.0).abs() < 1e-9);
    }
}
