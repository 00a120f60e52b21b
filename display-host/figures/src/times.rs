//! Charts of times as SVG.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

use crate::Distribution;

const SIZE: (u32, u32) = (720, 260);
const FONT: (&str, i32) = ("sans-serif", 13);
const INK: RGBColor = RGBColor(40, 44, 52);
const BAR: RGBColor = RGBColor(158, 42, 43);
const LIMIT: RGBColor = RGBColor(30, 98, 160);
/// Colours of the lines in one chart, distinguishable with colour blindness.
const LINES: [RGBColor; 6] = [
    BAR,
    LIMIT,
    RGBColor(230, 159, 0),
    RGBColor(0, 133, 98),
    RGBColor(120, 94, 160),
    RGBColor(110, 110, 110),
];

/// Draws a histogram over a logarithmic time axis (µs). The count axis is logarithmic too, so that
/// single outliers are visible. A line marks `limit_us` if given.
#[must_use]
pub fn histogram(times: &Distribution, limit_us: Option<f64>) -> Option<String> {
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

/// Draws a quantity over time. The axis of the quantity starts at zero.
#[must_use]
pub fn course(points: &[(f64, f64)], unit: &str) -> Option<String> {
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

/// Draws several quantities over time in one chart. `unit` is the label of their axis. Lines
/// without names get no legend.
#[must_use]
pub fn courses(lines: &[(&str, &[(f64, f64)])], unit: &str) -> Option<String> {
    let all = || lines.iter().flat_map(|(_, line)| line.iter());
    let end = all().map(|p| p.0).reduce(f64::max)?.max(1e-3);
    let top = all().map(|p| p.1).fold(0.0f64, f64::max);
    let bottom = all().map(|p| p.1).fold(0.0f64, f64::min);
    let margin = (top - bottom).max(1e-6) * 0.08;
    let low = if bottom < 0.0 { bottom - margin } else { 0.0 };
    draw(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(62)
            .build_cartesian_2d(0.0..end, low..top + margin)?;
        axes(&mut chart, "time, s", unit)?;
        for (i, (name, line)) in lines.iter().enumerate() {
            let colour = LINES[i % LINES.len()];
            chart
                .draw_series(LineSeries::new(
                    line.iter().copied(),
                    colour.stroke_width(2),
                ))?
                .label(*name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2))
                });
        }
        if lines.iter().all(|(name, _)| name.is_empty()) {
            return Ok(());
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(INK.mix(0.3))
            .label_font(FONT.into_font().color(&INK))
            .draw()
    })
}

/// Draws the exceedance of several distributions: how many times in a million are longer than a
/// given one. It shows the tail that a histogram hides. Both axes are logarithmic. The better line
/// is further left and lower.
#[must_use]
pub fn exceedance(series: &[(String, &Distribution)]) -> Option<String> {
    let lines: Vec<(&str, Vec<(f64, f64)>)> = series
        .iter()
        .filter(|(_, times)| times.count() > 0)
        .map(|(name, times)| (name.as_str(), exceeded(times)))
        .collect();
    let ends = |f: fn(f64, f64) -> f64, at: fn(&(f64, f64)) -> f64| {
        let all = lines.iter().flat_map(|(_, line)| line);
        all.map(at).reduce(f)
    };
    let left = ends(f64::min, |p| p.0)?.max(0.05) * 0.9;
    let right = ends(f64::max, |p| p.0)?.max(left) * 1.3;
    let bottom = ends(f64::min, |p| p.1)? * 0.7;
    draw(|root| {
        let mut chart = ChartBuilder::on(root)
            .margin(8)
            .x_label_area_size(38)
            .y_label_area_size(62)
            .build_cartesian_2d((left..right).log_scale(), (bottom..1.2e6).log_scale())?;
        axes(&mut chart, "µs", "exceeded, in a million")?;
        for (i, (name, line)) in lines.into_iter().enumerate() {
            let colour = LINES[i % LINES.len()];
            let line = line.into_iter().map(|(us, ppm)| (us.max(left), ppm));
            chart
                .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2))
                });
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(INK.mix(0.3))
            .label_font(FONT.into_font().color(&INK))
            .draw()
    })
}

/// Points (time in µs, number of recorded times per million that are longer), one per distinct
/// time. The longest time counts as exceeded by half a record, because zero has no logarithm.
fn exceeded(times: &Distribution) -> Vec<(f64, f64)> {
    let all = times.count().max(1) as f64;
    let mut left = all;
    times
        .counts()
        .into_iter()
        .map(|(ns, count)| {
            left -= count as f64;
            (ns as f64 / 1e3, left.max(0.5) * 1e6 / all)
        })
        .collect()
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

/// A short label: 0.5, 12, 3k, 2M.
fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 1e6 => format!("{:.0}M", value / 1e6),
        v if v >= 1e3 => format!("{:.0}k", value / 1e3),
        v if v >= 10.0 || v == 0.0 => format!("{value:.0}"),
        v if v >= 1.0 => format!("{value:.1}"),
        // Rounded first, because a value just below zero would become "-0.00".
        _ => format!("{:.2}", (value * 100.0).round() / 100.0 + 0.0),
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
    fn a_line_without_a_name_gets_no_legend_and_zero_no_sign() {
        let line = [(0.0, -0.5), (1.0, 0.5)];
        let plain = courses(&[("", &line)], "force along x, N").expect("drawn");
        let named = courses(&[("what if", &line)], "force along x, N").expect("drawn");
        assert!(named.matches("<rect").count() > plain.matches("<rect").count());
        assert!(plain.contains("force along x, N") && plain.contains("time, s"));
        assert!(!plain.contains("-0.00"), "{plain}");
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
    fn exceedance_falls_from_all_to_less_than_one() {
        let mut times = Distribution::new();
        for ns in [1000, 2000, 3000, 4000] {
            times.record(ns);
        }
        let line = exceeded(&times);
        let ppm: Vec<f64> = line.iter().map(|p| p.1).collect();
        assert_eq!(ppm, [750_000.0, 500_000.0, 250_000.0, 125_000.0]);
        let svg = exceedance(&[
            ("ours".into(), &times),
            ("none".into(), &Distribution::new()),
        ]);
        assert!(svg.is_some_and(|svg| svg.contains("ours") && !svg.contains("none<")));
        assert!(exceedance(&[]).is_none());
    }

    #[test]
    fn courses_below_zero_and_of_no_points_are_drawn_or_not() {
        let (up, down) = ([(0.0, 1.0), (1.0, 2.0)], [(0.0, -1.0), (1.0, 0.5)]);
        let svg = courses(&[("first", &up), ("second", &down)], "N").unwrap();
        assert!(svg.contains("first") && svg.contains("second"));
        assert!(courses(&[("none", &[])], "N").is_none());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.25), "0.25");
        assert_eq!(short(1500.0), "2k");
        assert_eq!(short(10.0), "10");
    }
}
