//! The results as a table and as JSON.

use std::path::Path;

use hardware::characterise::{Axis, Characterised, Estimate, Opened, Trial, Wall, rendered_n_m};
use serde_json::{Value, json};

use super::place;

const NAMES: [&str; 3] = ["x", "y", "z"];
/// Width of the names of the rows, in characters.
const WIDTH: usize = 28;

/// A row: name, unit, factor from SI to the unit, number of decimals, and the value.
type Row = (
    &'static str,
    &'static str,
    f64,
    usize,
    fn(&Axis) -> Estimate,
);

const ROWS: [Row; 7] = [
    ("mass", "g", 1e3, 1, |it| it.mass_kg),
    ("viscous damping", "N s/m", 1.0, 3, |it| it.damping_n_s_m),
    ("friction, moving", "N", 1.0, 3, |it| it.friction_n),
    ("friction, break-away", "N", 1.0, 3, |it| it.break_away_n),
    ("force against weight", "N", 1.0, 3, |it| it.carries_n),
    (TREMOR, "N s/m", 1.0, 3, Axis::tremor_damping_n_s_m),
    (DELAY, "ms", 1e3, 2, |it| it.delay_s),
];
/// Name of the row with the damping at the speed of a tremor. The table also has its declared
/// value.
const TREMOR: &str = "damping of a tremor";
/// Name of the row with the delay. The table also has its declared value.
const DELAY: &str = "delay";

/// Axes that were measured, with their names; the opening comes last.
pub(super) fn columns(found: &Characterised) -> Vec<(&'static str, &Axis)> {
    let axes = found.measured().map(|(at, axis)| (NAMES[at], axis));
    let opened = found.opening.iter().filter_map(|it| it.as_ref().ok());
    axes.chain(opened.map(|it| ("opening", &it.axis))).collect()
}

/// Heading of the lines for the station file.
pub(super) const STATION: &str =
    "For [haptic] of the station file, with two standard errors of margin:";

/// A row of the table as text.
pub(super) struct Line {
    /// Name and unit.
    pub(super) name: String,
    /// Value of each column.
    pub(super) cells: Vec<String>,
    /// Declared value; empty if none is declared.
    pub(super) declared: String,
}

/// Rows of the table.
pub(super) fn rows(found: &Characterised) -> Vec<Line> {
    let cell = |of: Estimate, factor: f64, decimals: usize| {
        // Round first, because a small negative value would become "-0.000".
        let unit = 10f64.powi(decimals as i32);
        let rounded = (of.value * factor * unit).round() / unit + 0.0;
        format!("{rounded:.decimals$} ± {:.decimals$}", of.error * factor)
    };
    let rows = ROWS.iter();
    rows.map(|(name, unit, factor, decimals, of)| Line {
        name: format!("{name}, {unit}"),
        cells: columns(found)
            .iter()
            .map(|(_, axis)| cell(of(axis), *factor, *decimals))
            .collect(),
        declared: match *name {
            TREMOR => format!("{:.3}", found.declared.damping_n_s_m),
            DELAY => format!("{:.2}", found.declared.delay_s * 1e3),
            _ => String::new(),
        },
    })
    .collect()
}

/// Sentences about axes that were not measured, the echo of a command, and comparisons.
pub(super) fn sentences(found: &Characterised) -> Vec<String> {
    let axes = NAMES.iter().zip(&found.axes);
    let axes = axes.filter_map(|(name, of)| Some((*name, of.as_ref()?.as_ref().err()?)));
    let opening = found.opening.iter().filter_map(|it| it.as_ref().err());
    let opening = opening.map(|reason| ("opening", reason));
    let mut all: Vec<String> = axes
        .chain(opening)
        .map(|(name, reason)| format!("{name}: not measured. {reason}"))
        .collect();
    if let Some(echo_s) = found.echo_s {
        all.push(format!(
            "a command is confirmed after {:.1} ms",
            echo_s * 1e3
        ));
    }
    all.extend(found.verdicts());
    all.extend(place::sentence(found));
    all
}

/// Table, comparisons, and lines for the station file.
pub(super) fn text(found: &Characterised) -> String {
    let mut text = format!("{:<WIDTH$}", "");
    for (name, _) in columns(found) {
        text += &format!("{name:>18}");
    }
    text += &format!("{:>12}\n", "declared");
    for row in rows(found) {
        text += &format!("{:<WIDTH$}", row.name);
        text.extend(row.cells.iter().map(|cell| format!("{cell:>18}")));
        text = format!("{text}{:>12}", row.declared).trim_end().to_owned() + "\n";
    }
    text.extend(sentences(found).iter().map(|it| format!("- {it}\n")));
    let lines = found.station_lines();
    if !lines.is_empty() {
        text += &format!("\n{STATION}\n{lines}");
    }
    text.trim_end().to_owned()
}

fn estimate(of: Estimate) -> Value {
    json!({ "value": of.value, "error": of.error })
}

fn axis(axis: &Axis) -> Value {
    json!({
        "mass_kg": estimate(axis.mass_kg),
        "damping_n_s_m": estimate(axis.damping_n_s_m),
        "friction_n": estimate(axis.friction_n),
        "break_away_n": estimate(axis.break_away_n),
        "carries_n": estimate(axis.carries_n),
        "delay_s": estimate(axis.delay_s),
        "tremor_damping_n_s_m": estimate(axis.tremor_damping_n_s_m()),
        "rms_m": axis.rms_m,
        "friction_curve": axis.friction_curve,
    })
}

fn opened(opened: &Opened) -> Value {
    let mut all = axis(&opened.axis);
    all["range"] = json!(opened.range);
    all["given"] = json!(opened.given);
    all
}

fn wall(wall: &Wall) -> Value {
    let trial = |it: &Trial| {
        json!({
            "stiffness_n_m": it.stiffness_n_m,
            "buzz_hz": it.buzz.map(|buzz| buzz.0),
            "buzz_m": it.buzz.map(|buzz| buzz.1),
        })
    };
    json!({
        "still_n_m": wall.still_n_m,
        "buzzes_n_m": wall.buzzes_n_m,
        "was_left": wall.was_left,
        "trials": wall.trials.iter().map(trial).collect::<Vec<_>>(),
    })
}

/// All figures as one object.
pub(super) fn json(path: &Path, found: &Characterised) -> Value {
    let axes: serde_json::Map<String, Value> = NAMES
        .iter()
        .zip(&found.axes)
        .filter_map(|(name, of)| {
            let of = match of.as_ref()? {
                Ok(of) => axis(of),
                Err(reason) => json!({ "not_measured": reason }),
            };
            Some(((*name).to_owned(), of))
        })
        .collect();
    let declared = &found.declared;
    let opening = found.opening.as_ref().map(|of| match of {
        Ok(of) => opened(of),
        Err(reason) => json!({ "not_measured": reason }),
    });
    let declared_opening = declared.opening.is_measured().then(|| {
        json!({
            "travel_m": declared.opening.travel_m,
            "force_max_n": declared.opening.force_max_n,
            "stiffness_max_n_m": declared.opening.stiffness_max_n_m,
        })
    });
    json!({
        "program": concat!("calot ", env!("CARGO_PKG_VERSION")),
        "device": path,
        "force_n": found.force_n,
        "declared": {
            "damping_n_s_m": declared.damping_n_s_m,
            "delay_s": declared.delay_s,
            "stiffness_max_n_m": declared.stiffness_max_n_m,
            "force_max_n": declared.force_max_n,
            "force_continuous_n": declared.force_continuous_n,
            "rendered_n_m": rendered_n_m(
                declared.damping_n_s_m.into(),
                declared.delay_s.into(),
                declared.rate_hz,
            ),
            "opening": declared_opening,
        },
        "axes": axes,
        "opening": opening,
        "echo_s": found.echo_s,
        "damping_n_s_m": found.damping_n_s_m().map(estimate),
        "delay_s": found.delay_s().map(estimate),
        "rendered_n_m": found.rendered_n_m(),
        "wall": found.wall.as_ref().map(wall),
        "opening_wall": found.opening_wall.as_ref().map(wall),
        "verdicts": found.verdicts(),
        "place": place::sentence(found),
        "station_lines": found.station_lines(),
    })
}
