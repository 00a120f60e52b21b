//! Charts as SVG text, for the report.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

use super::Distribution;

const SIZE: (u32, u32) = (720, 260);
const FONT: (&str, i32) = ("sans-serif", 13);
const INK: RGBColor = RGBColor(40, 44, 52);
const BAR: RGBColor = RGBColor(158, 42, 43);
const LIMIT: RGBColor = RGBColor(30, 98, 160);

/// A histogram over a logarithmic time axis (µs), with a logarithmic count axis so that single
/// outliers are seen; a line marks `limit_us` where one is given.
pub(super) fn histogram(times: &Distribution, limit_us: Option<f64>) -> Option<String> {
    let bins = times.log_bins(4);
    let (first, last) = (bins.first()?.0, bins.last()?.0);
    let to_us = |ns: f64| ns / 1e3;
    let right = to_us(last * 1.5).max(limit_us.unwrap_or(0.0) * 1.2);
    let tallest = bins.iter().map(|b| b.1).max()? as f64;
    let x = (to_us(first * 0.9)..right).log_scale();
    let y = (0.7..tallest * 2.0).log_scale();
    draw(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(62)
            .build_cartesian_2d(x, y)?;
        axes(&mut chart, "µs", "ticks")?;
        let width = 2f64.powf(0.25);
        chart.draw_series(bins.iter().filter(|b| b.1 > 0).map(|&(lower, count)| {
            let corners = [(to_us(lower), 0.7), (to_us(lower * width), count as f64)];
            Rectangle::new(corners, BAR.filled())
        }))?;
        if let Some(limit) = limit_us {
            let line = [(limit, 0.7), (limit, tallest * 2.0)];
            chart.draw_series(LineSeries::new(line, LIMIT.stroke_width(2)))?;
        }
        Ok(())
    })
}

/// A quantity over time, from zero.
pub(super) fn course(points: &[(f64, f64)], unit: &str) -> Option<String> {
    let end = points.last()?.0.max(1.0);
    let top = points.iter().fold(0.0f64, |top, p| top.max(p.1)).max(1e-3) * 1.1;
    draw(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(62)
            .build_cartesian_2d(0.0..end, 0.0..top)?;
        axes(&mut chart, "s", unit)?;
        chart.draw_series(AreaSeries::new(points.iter().copied(), 0.0, BAR.mix(0.25)))?;
        chart.draw_series(LineSeries::new(points.iter().copied(), BAR.stroke_width(2)))?;
        Ok(())
    })
}

type Failure = DrawingAreaErrorKind<std::io::Error>;
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(paint: impl FnOnce(&Area<'_>) -> Result<(), Failure>) -> Option<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE).ok()?;
        paint(&root).ok()?;
        root.present().ok()?;
    }
    Some(svg)
}

fn axes<X, Y>(
    chart: &mut ChartContext<'_, SVGBackend<'_>, Cartesian2d<X, Y>>,
    x_unit: &str,
    y_unit: &str,
) -> Result<(), Failure>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .label_style(FONT.into_font().color(&INK))
        .axis_style(INK.mix(0.6))
        .bold_line_style(INK.mix(0.15))
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .x_desc(x_unit)
        .y_desc(y_unit)
        .draw()
}

/// A label of few characters: 0.5, 12, 3k, 2M.
fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 1e6 => format!("{:.0}M", value / 1e6),
        v if v >= 1e3 => format!("{:.0}k", value / 1e3),
        v if v >= 10.0 || v == 0.0 => format!("{value:.0}"),
        v if v >= 1.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_recorded_draws_nothing() {
        assert!(histogram(&Distribution::new(), None).is_none());
        assert!(course(&[], "N").is_none());
    }

    #[test]
    fn a_histogram_has_a_bar_for_every_bin() {
        let mut times = Distribution::new();
        for ns in [20_000, 21_000, 900_000] {
            times.record(ns);
        }
        let bars = times.log_bins(4).iter().filter(|b| b.1 > 0).count();
        let svg = histogram(&times, Some(1000.0)).unwrap();
        let fill = svg.matches("fill=\"#9E2A2B\"").count();
        assert_eq!(fill, bars, "{svg}");
    }

    #[test]
    fn a_single_value_is_drawn_too() {
        let mut times = Distribution::new();
        times.record(1);
        assert!(histogram(&times, None).is_some());
        assert!(course(&[(0.0, 0.0)], "N").is_some());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.25), "0.25");
        assert_eq!(short(1500.0), "2k");
        assert_eq!(short(10.0), "10");
    }
}
