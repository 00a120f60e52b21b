//! The chart of speed against accuracy, and the page around it.

use plotters::prelude::*;

use crate::accuracy::Row;

const SIZE: (u32, u32) = (1180, 620);
const COLORS: [RGBColor; 8] = [
    RGBColor(150, 150, 150),
    RGBColor(90, 90, 90),
    RGBColor(230, 159, 0),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 60),
    RGBColor(0, 0, 0),
];

/// A method's name without its fitted setting, which differs between sphere counts.
fn family(row: &Row) -> &str {
    if row.method.contains("k = 1") {
        return &row.method;
    }
    row.method.split(", k =").next().unwrap_or(&row.method)
}

/// One panel a scene: µs a tick against rms error, both logarithmic, a line through the sphere
/// counts of each method. What blew up stands on the upper edge as a cross.
///
/// # Errors
/// The drawing library's words.
pub(crate) fn svg(rows: &[Row]) -> Result<String, String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        draw(&root, rows).map_err(|e| e.to_string())?;
        root.present().map_err(|e| e.to_string())?;
    }
    Ok(text)
}

fn draw<'a>(
    root: &DrawingArea<SVGBackend<'a>, plotters::coord::Shift>,
    rows: &[Row],
) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>> {
    root.fill(&WHITE)?;
    let mut scenes: Vec<&str> = rows.iter().map(|r| r.scene.as_str()).collect();
    scenes.dedup();
    let mut methods: Vec<&str> = Vec::new();
    for row in rows {
        if !methods.contains(&family(row)) {
            methods.push(family(row));
        }
    }
    let finite = || {
        rows.iter()
            .map(|r| r.rms_mm)
            .filter(|e| e.is_finite() && *e > 0.0)
    };
    let (low, high) = (
        finite().fold(1.0, f64::min) / 1.5,
        finite().fold(1.0, f64::max) * 2.0,
    );
    let times = || rows.iter().map(|r| r.us_per_tick);
    // Whole decades, so that both ends have a number.
    let decade = |v: f64, round: fn(f64) -> f64| 10_f64.powf(round(v.log10()));
    let fast = decade(times().fold(f64::INFINITY, f64::min), f64::floor);
    let slow = decade(times().fold(1.0, f64::max), f64::ceil);
    let (panels, legend) = root.split_vertically(SIZE.1 - 90);
    for (panel, scene) in panels
        .split_evenly((1, scenes.len().max(1)))
        .iter()
        .zip(&scenes)
    {
        let mut chart = ChartBuilder::on(panel)
            .caption(*scene, ("sans-serif", 18))
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(52)
            .build_cartesian_2d((fast..slow).log_scale(), (low..high).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("µs a tick (1 ms)")
            .y_desc("rms displacement error, mm")
            .light_line_style(RGBColor(240, 240, 240))
            .draw()?;
        for (method, color) in methods.iter().zip(COLORS) {
            let here = || {
                rows.iter()
                    .filter(|r| r.scene == *scene && family(r) == *method)
            };
            let points: Vec<_> = here()
                .map(|r| (r.us_per_tick, r.rms_mm.min(high / 1.1)))
                .collect();
            let solid = here()
                .filter(|r| r.rms_mm.is_finite())
                .map(|r| (r.us_per_tick, r.rms_mm));
            chart.draw_series(LineSeries::new(solid, color.stroke_width(2)))?;
            for (row, point) in here().zip(points) {
                if row.rms_mm.is_finite() {
                    chart.draw_series([Circle::new(point, 5, color.filled())])?;
                } else {
                    chart.draw_series([Cross::new(point, 6, color.stroke_width(2))])?;
                }
            }
        }
    }
    for (i, (method, color)) in methods.iter().zip(COLORS).enumerate() {
        let (x, y) = (60 + 370 * (i as i32 / 3), 12 + 24 * (i as i32 % 3));
        legend.draw(&Circle::new((x, y), 5, color.filled()))?;
        legend.draw(&Text::new(
            (*method).to_owned(),
            (x + 12, y - 8),
            ("sans-serif", 15),
        ))?;
    }
    Ok(())
}

/// The offline page: what was done, the chart, the table.
pub(crate) fn page(rows: &[Row], svg: &str, about: &str) -> String {
    let number = |v: f64, digits: usize| {
        if v.is_finite() {
            format!("{v:.digits$}")
        } else {
            "blew up".to_owned()
        }
    };
    let mut table = String::new();
    for r in rows {
        table += &format!(
            "<tr><td>{}<td>{}<td>{}<td>{:.0}<td>{}<td>{}<td>{}<td>{}\n",
            r.scene,
            r.method,
            r.spheres,
            r.us_per_tick,
            number(r.rms_mm, 2),
            number(r.max_mm, 1),
            number(r.force_error_pct, 1),
            number(r.volume_error_pct, 2)
        );
    }
    format!(
        "<!doctype html><meta charset=utf-8><title>Calot: speed against accuracy</title>\
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:75rem;margin:2rem auto;padding:0 1rem}}\
table{{border-collapse:collapse}}td,th{{padding:.2rem .7rem;text-align:right;border-bottom:1px solid #ddd}}\
td:first-child,td:nth-child(2),th:first-child,th:nth-child(2){{text-align:left}}svg{{max-width:100%;height:auto}}</style>\
<h1>Speed against accuracy</h1>\
<p>A liver (170 mm, E = 5 kPa, ν = 0.45) is loaded in each way that a surgeon may load it, by every method, \
from the same spheres. Right is slower, up is less accurate: <b>lower left is better</b>. The error is the \
distance of each sphere from where finite elements (quadratic tetrahedra, verified against closed forms) put it. \
A line joins a method's sphere counts; a cross means that the method blew up.</p>\
<p>Dimensionless settings are fitted on the sag alone, by the mean displacement; methods without “fitted” follow \
from E and ν. Times are of one thread, without vector instructions by hand: they compare methods, they are not \
the product's.</p><p>{about}</p>{svg}<table><tr><th>scene<th>method<th>spheres<th>µs/tick<th>rms mm<th>max mm\
<th>force error %<th>volume error %\n{table}</table>\n"
    )
}
