//! The results as a table and as JSON.

use std::path::Path;

use hardware::characterise::{Axis, Characterised, Estimate, Trial, rendered_n_m};
use serde_json::{Value, json};

use super::place;

const NAMES: [&str; 3] = ["x", "y", "z"];

/// A row: name, unit, factor to the unit, decimals, and the value.
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
    ("force that carries it", "N", 1.0, 3, |it| it.carries_n),
    (TREMOR, "N s/m", 1.0, 3, Axis::tremor_damping_n_s_m),
    (DELAY, "ms", 1e3, 2, |it| it.delay_s),
];
/// Name of the row with the damping of a tremor. The row has a declared value.
const TREMOR: &str = "damping of a tremor";
/// Name of the row with the delay. The row has a declared value.
const DELAY: &str = "delay";

/// Table, comparisons, and lines for the station file.
pub(super) fn text(found: &Characterised) -> String {
    let mut text = format!("{:<24}", "");
    for (at, _) in found.measured() {
        text += &format!("{:>20}", NAMES[at]);
    }
    text += &format!("{:>12}\n", "declared");
    for (name, unit, factor, decimals, of) in ROWS {
        text += &format!("{:<24}", format!("{name}, {unit}"));
        for (_, axis) in found.measured() {
            let Estimate { value, error } = of(axis);
            let (value, error) = (value * factor, error * factor);
            let cell = format!("{value:.decimals$} ± {error:.decimals$}");
            text += &format!("{cell:>20}");
        }
        let declared = match name {
            TREMOR => format!("{:.3}", found.declared.damping_n_s_m),
            DELAY => format!("{:.2}", found.declared.delay_s * 1e3),
            _ => String::new(),
        };
        text += &format!("{declared:>12}\n");
    }
    for (at, axis) in found.axes.iter().enumerate() {
        if let Some(Err(reason)) = axis {
            text += &format!("{}: not measured. {reason}\n", NAMES[at]);
        }
    }
    if let Some(echo_s) = found.echo_s {
        text += &format!("A command is confirmed after {:.1} ms.\n", echo_s * 1e3);
    }
    for verdict in found.verdicts() {
        text += &format!("- {verdict}\n");
    }
    text.extend(place::sentence(found).map(|it| format!("- {it}\n")));
    let lines = found.station_lines();
    if !lines.is_empty() {
        text += &format!(
            "\nFor [haptic] of the station file, with two standard errors of margin:\n{lines}"
        );
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
    let trial = |it: &Trial| {
        json!({
            "stiffness_n_m": it.stiffness_n_m,
            "buzz_hz": it.buzz.map(|buzz| buzz.0),
            "buzz_m": it.buzz.map(|buzz| buzz.1),
        })
    };
    let wall = found.wall.as_ref().map(|wall| {
        json!({
            "still_n_m": wall.still_n_m,
            "buzzes_n_m": wall.buzzes_n_m,
            "was_left": wall.was_left,
            "trials": wall.trials.iter().map(trial).collect::<Vec<_>>(),
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
        },
        "axes": axes,
        "echo_s": found.echo_s,
        "damping_n_s_m": found.damping_n_s_m().map(estimate),
        "delay_s": found.delay_s().map(estimate),
        "rendered_n_m": found.rendered_n_m(),
        "wall": wall,
        "verdicts": found.verdicts(),
        "place": place::sentence(found),
        "station_lines": found.station_lines(),
    })
}
