//! The page with charts.

use std::path::Path;

use figures::Machine;
use figures::html::{STYLE, escape, machine_table};
use figures::panels::{Panel, Scale, Series, panels, panels_from};
use hardware::characterise::{Axis, Characterised, Opened, Trace, Wall};

use super::{place, table};
use crate::problem::Problem;

/// Largest number of points of a measured course that the chart draws.
const POINTS: usize = 250;
/// No line joins two samples that are farther apart than this, ms: the motion between them is not
/// known.
const GAP_MS: f64 = 3.0;
/// First colour of charts with a measurement and its model: green, then black.
const GREEN: usize = 7;

pub(super) fn html(path: &Path, found: &Characterised) -> Result<String, Problem> {
    let mut body = format!(
        "<h1>Calot: a haptic device measured</h1><p class=\"lead\">{}, with forces up to {:.2} N</p>{}",
        escape(&path.display().to_string()),
        found.force_n,
        results(found),
    );
    for (name, axis) in table::columns(found) {
        let of = match name {
            "opening" => "the opening",
            name => name,
        };
        body += &format!(
            "<h2>Along {of}</h2><figure>{}<figcaption>The model is {:.1} g, {:.3} N s/m and {:.3} N of dry friction \
             with a delay of {:.2} ms. It stays within {:.3} mm rms of the measurement. It begins the run-out with \
             the measured place and speed.</figcaption></figure>",
            panels_from(&of_axis(axis), 2, GREEN)?,
            axis.mass_kg.value * 1e3,
            axis.damping_n_s_m.value,
            axis.friction_n.value,
            axis.delay_s.value * 1e3,
            axis.rms_m * 1e3,
        );
    }
    let opened = found.opening.iter().filter_map(|it| it.as_ref().ok());
    for opened in opened.filter(|it| !it.given.is_empty()) {
        body += &format!(
            "<figure>{}<figcaption>The opening reaches from {:.2} to {:.2}. The force given is the one with which \
             the model moves as the ring did. A motor that saturates gives less of large \
             forces.</figcaption></figure>",
            panels_from(&[given(opened)], 1, GREEN)?,
            opened.range[0],
            opened.range[1],
        );
    }
    let mut last = vec![place::panel(found)];
    last.extend(found.wall.as_ref().map(|it| wall("Virtual walls", it)));
    let along = found.opening_wall.as_ref();
    last.extend(along.map(|it| wall("Virtual walls along the opening", it)));
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

/// The table, the comparisons, and the lines for the station file.
fn results(found: &Characterised) -> String {
    let columns = table::columns(found);
    let mut html = "<table><tr><th>".to_owned();
    html.extend(columns.iter().map(|(name, _)| format!("<th>{name}")));
    html += "<th>declared</tr>";
    for row in table::rows(found) {
        html += &format!("<tr><td>{}", row.name);
        let cells = row.cells.iter().chain([&row.declared]);
        html.extend(cells.map(|cell| format!("<td>{cell}")));
        html += "</tr>";
    }
    html += "</table><ul>";
    let lines = table::sentences(found);
    html.extend(lines.iter().map(|it| format!("<li>{}</li>", escape(it))));
    html += "</ul>";
    let station = found.station_lines();
    if !station.is_empty() {
        html += &format!("<p>{}</p><pre>{}</pre>", table::STATION, escape(&station));
    }
    html
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
    let curve = &axis.friction_curve;
    let reach = curve.iter().map(|it| it[0].abs()).fold(0.05, f64::max);
    let ends = [-reach, -1e-6, 1e-6, reach];
    // No line joins both directions: nothing was measured between them.
    let (back, forth) = curve.iter().partition(|it| it[0] < 0.0);
    linear(
        "Friction",
        ["speed, m/s", "friction, N"],
        vec![back, forth],
        vec![ends.map(model).to_vec()],
    )
}

fn course(title: &str, trace: &Trace) -> Panel {
    let points = |of: &[f64], every: usize| -> Vec<[f64; 2]> {
        let all = trace.at_s.iter().zip(of).step_by(every);
        all.map(|(at_s, at_m)| [at_s * 1e3, at_m * 1e3]).collect()
    };
    let every = trace.at_s.len().div_ceil(POINTS).max(1);
    let pieces = |of: &[f64], every: usize| {
        let gap_ms = GAP_MS * every as f64;
        let all = points(of, every);
        let pieces = all.chunk_by(|a, b| b[0] - a[0] < gap_ms);
        pieces.map(<[_]>::to_vec).collect()
    };
    linear(
        title,
        ["time, ms", "place, mm"],
        pieces(&trace.measured_m, every),
        pieces(&trace.fitted_m, 1),
    )
}

fn linear(
    title: &str,
    axes: [&str; 2],
    measured: Vec<Vec<[f64; 2]>>,
    model: Vec<Vec<[f64; 2]>>,
) -> Panel {
    let series = |name: &str, points, is_thin| Series {
        name: name.to_owned(),
        points,
        is_thin,
    };
    let measured = measured.into_iter().map(|it| series("measured", it, false));
    let model = model.into_iter().map(|it| series("model", it, true));
    Panel {
        title: title.to_owned(),
        axes: axes.map(str::to_owned),
        scales: [Scale::Linear, Scale::Linear],
        series: measured.chain(model).collect(),
    }
}

/// The chart of the forces that the opening's motor gives.
fn given(opened: &Opened) -> Panel {
    let all_n = opened.given.iter().map(|it| it[0]).fold(0.0, f64::max);
    let given = opened.given.iter();
    linear(
        "Force along the opening",
        ["force asked for, N", "force given, N"],
        vec![
            given
                .map(|[asked_n, share]| [*asked_n, asked_n * share])
                .collect(),
        ],
        vec![vec![[0.0, 0.0], [all_n, all_n]]],
    )
}

/// The chart of the walls: swing of the handle over the stiffness; 0 if the wall did not buzz.
fn wall(title: &str, wall: &Wall) -> Panel {
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
        title: title.to_owned(),
        axes: ["stiffness, N/m".to_owned(), "swing, mm".to_owned()],
        scales: [Scale::Log, Scale::Linear],
        series: vec![
            series("still", trials(false)),
            series("buzzes", trials(true)),
        ],
    }
}
