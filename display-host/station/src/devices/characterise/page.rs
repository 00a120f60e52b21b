//! The page with charts.

use std::path::Path;

use figures::Machine;
use figures::html::{STYLE, escape, machine_table};
use figures::panels::{Panel, Scale, Series, panels};
use hardware::characterise::{Axis, Characterised, Trace, Wall};

use super::{place, table};
use crate::problem::Problem;

/// Largest number of points of a measured course that the chart draws.
const POINTS: usize = 250;

/// The whole page.
pub(super) fn html(path: &Path, found: &Characterised) -> Result<String, Problem> {
    let mut body = format!(
        "<h1>Calot: a haptic device measured</h1><p class=\"lead\">{}, with forces up to {:.2} N</p><pre>{}</pre>",
        escape(&path.display().to_string()),
        found.force_n,
        escape(&table::text(found)),
    );
    for (at, axis) in found.measured() {
        let name = ["x", "y", "z"][at];
        body += &format!(
            "<h2>Along {name}</h2><figure>{}<figcaption>The model is {:.1} g, {:.3} N s/m and {:.3} N of dry friction \
             with a delay of {:.2} ms. It stays within {:.3} mm rms of the measurement. It begins the run-out with \
             the measured place and speed.</figcaption></figure>",
            panels(&of_axis(axis), 2)?,
            axis.mass_kg.value * 1e3,
            axis.damping_n_s_m.value,
            axis.friction_n.value,
            axis.delay_s.value * 1e3,
            axis.rms_m * 1e3,
        );
    }
    let mut last = vec![place::panel(found)];
    last.extend(found.wall.as_ref().map(wall));
    body += &format!(
        "<h2>Stiffness</h2><figure>{}<figcaption>Lines: the devices of `evaluate haptics`. Calot renders 0.7 of K = \
         damping / (T/2 + delay).</figcaption></figure>{}",
        panels(&last, last.len())?,
        machine_table(&Machine::read(), &[]),
    );
    Ok(format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: a haptic device measured</title><style>{STYLE}</style>\
         {body}</html>\n"
    ))
}

fn of_axis(axis: &Axis) -> [Panel; 4] {
    let [slow, fast] = &axis.chirp;
    [
        friction(axis),
        course("Run-out after a push", &axis.run_out),
        course("Chirp, slow", slow),
        course("Chirp, fast", fast),
    ]
}

fn friction(axis: &Axis) -> Panel {
    let model = |v_m_s: f64| {
        let dry_n = axis.friction_n.value * v_m_s.signum();
        [v_m_s, dry_n + axis.damping_n_s_m.value * v_m_s]
    };
    let reach = axis
        .friction_curve
        .iter()
        .map(|it| it[0].abs())
        .fold(0.05, f64::max);
    let ends = [-reach, -1e-6, 1e-6, reach];
    linear(
        "Friction",
        ["speed, m/s", "friction, N"],
        axis.friction_curve.clone(),
        ends.map(model).to_vec(),
    )
}

fn course(title: &str, trace: &Trace) -> Panel {
    let points = |of: &[f64], every: usize| {
        let all = trace.at_s.iter().zip(of).step_by(every);
        all.map(|(at_s, at_m)| [at_s * 1e3, at_m * 1e3]).collect()
    };
    let every = trace.at_s.len().div_ceil(POINTS).max(1);
    linear(
        title,
        ["time, ms", "place, mm"],
        points(&trace.measured_m, every),
        points(&trace.fitted_m, 1),
    )
}

fn linear(title: &str, axes: [&str; 2], measured: Vec<[f64; 2]>, model: Vec<[f64; 2]>) -> Panel {
    let series = |name: &str, points, is_thin| Series {
        name: name.to_owned(),
        points,
        is_thin,
    };
    Panel {
        title: title.to_owned(),
        axes: axes.map(str::to_owned),
        scales: [Scale::Linear, Scale::Linear],
        series: vec![
            series("measured", measured, false),
            series("model", model, true),
        ],
    }
}

/// The chart of the walls: swing of the handle over the stiffness; 0 if the wall did not buzz.
fn wall(wall: &Wall) -> Panel {
    let trials = |buzzes: bool| {
        let of = wall
            .trials
            .iter()
            .filter(move |it| it.buzz.is_some() == buzzes);
        let swing_mm = |it: &hardware::characterise::Trial| it.buzz.map_or(0.0, |it| it.1 * 1e3);
        let mut points: Vec<_> = of.map(|it| [it.stiffness_n_m, swing_mm(it)]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points
    };
    let series = |name: &str, points| Series {
        name: name.to_owned(),
        points,
        is_thin: false,
    };
    Panel {
        title: "Virtual walls".to_owned(),
        axes: ["stiffness, N/m".to_owned(), "swing, mm".to_owned()],
        scales: [Scale::Log, Scale::Linear],
        series: vec![
            series("still", trials(false)),
            series("buzzes", trials(true)),
        ],
    }
}
