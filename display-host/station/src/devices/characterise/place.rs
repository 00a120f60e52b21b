//! Place of a device on the map of `evaluate haptics`: stiffness over delay, by damping.

use std::f64::consts::PI;

use figures::panels::{Panel, Scale, Series};
use hardware::characterise::{Characterised, STIFFEST_N_M, TREMOR_M_S, rendered_n_m};

/// Viscous dampings of the map's devices (`tests/evaluate/src/haptics`) except 0, N s/m.
const DAMPINGS: [f64; 5] = [0.1, 0.2, 0.5, 1.0, 2.0];
/// The map's Touch: its damping, N s/m, and dry friction, N.
const TOUCH: (f64, f64) = (0.2, 0.26);
/// Delays of the chart, ms. The map ends at 5 ms.
const DELAYS_MS: [f64; 9] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 7.5, 10.0];

/// The map's devices with their dampings, N s/m, least first. The Touch's includes its dry
/// friction at the speed of a tremor.
fn devices() -> Vec<(String, f64)> {
    let viscous = DAMPINGS.iter().map(|it| (format!("{it} N s/m"), *it));
    let touch = (
        "the Touch".to_owned(),
        TOUCH.0 + 4.0 * TOUCH.1 / (PI * TREMOR_M_S),
    );
    let mut all: Vec<_> = viscous.chain([touch]).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

/// A sentence that says between which devices of the map the measured device lies.
pub(super) fn sentence(found: &Characterised) -> Option<String> {
    let (damping, delay) = (found.damping_n_s_m()?, found.delay_s()?);
    let rate_hz = found.declared.rate_hz;
    let own_n_m = rendered_n_m(damping.value, delay.value, rate_hz);
    let all = devices();
    let below = all.iter().rev().find(|it| it.1 <= damping.value);
    let above = all.iter().find(|it| it.1 > damping.value);
    let named = |it: &(String, f64)| {
        format!(
            "{} ({:.0} N/m)",
            it.0,
            rendered_n_m(it.1, delay.value, rate_hz)
        )
    };
    let place = match (below, above) {
        (Some(below), Some(above)) => format!("between {} and {}", named(below), named(above)),
        (Some(below), None) => format!("above {}", named(below)),
        (None, Some(above)) => format!("below {}", named(above)),
        (None, None) => return None,
    };
    let beyond = if delay.value > 5e-3 {
        " The map ends at a delay of 5 ms."
    } else {
        ""
    };
    Some(format!(
        "At {:.1} ms of delay Calot renders {own_n_m:.0} N/m on it. On the map of `evaluate haptics` it lies \
         {place}.{beyond}",
        delay.value * 1e3
    ))
}

/// The chart: lines for the map's devices, and points for this device: declared, measured, and its
/// stiffest still wall.
pub(super) fn panel(found: &Characterised) -> Panel {
    let rate_hz = found.declared.rate_hz;
    let line = |(name, damping): (String, f64)| Series {
        name,
        points: DELAYS_MS
            .iter()
            .map(|ms| [*ms, rendered_n_m(damping, ms * 1e-3, rate_hz)])
            .collect(),
        is_thin: true,
    };
    let point = |name: &str, delay_s: f64, stiffness_n_m: f64| Series {
        name: name.to_owned(),
        points: vec![[delay_s * 1e3, stiffness_n_m]],
        is_thin: false,
    };
    let mut series: Vec<Series> = devices().into_iter().map(line).collect();
    let declared = &found.declared;
    let declared_s = f64::from(declared.delay_s);
    let declared_n_m = rendered_n_m(declared.damping_n_s_m.into(), declared_s, rate_hz);
    series.push(point(
        "as declared",
        declared_s,
        declared_n_m.min(STIFFEST_N_M),
    ));
    if let (Some(delay), Some(stiffness_n_m)) = (found.delay_s(), found.rendered_n_m()) {
        series.push(point(
            "as measured",
            delay.value,
            stiffness_n_m.min(STIFFEST_N_M),
        ));
        let still = found.wall.as_ref().and_then(|wall| wall.still_n_m);
        series.extend(still.map(|n_m| point("stiffest still wall", delay.value, n_m)));
    }
    Panel {
        title: "Stiffest contact that Calot renders".to_owned(),
        axes: ["delay, ms".to_owned(), "stiffness, N/m".to_owned()],
        scales: [Scale::Linear, Scale::Log],
        series,
    }
}
