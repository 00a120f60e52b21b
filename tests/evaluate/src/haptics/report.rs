//! The rows as CSV, as a map, and as a section of the page.

use super::device::Hand;
use super::felt::Felt;
use super::{LawKind, Row, SOFTEST_N_M, STIFFEST_N_M, Test};
use crate::page::Section;
use figures::panels::{Cell, heat_map};

/// The rows as `haptics.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "test,law,hand,device_damping_n_s_m,friction_n,delay_ms,rate_hz,lost,late_ms,of,\
stable_up_to_n_m,rendered_n_m,stable,swing_mm,step_mn,force_n,given_mj,observed_least_mj,damped_ticks,capped_ticks,lag_ms,\
osc_peak_mn,osc_rms_mn,injected_mj,rise_ms,drag_mn,jerk_m_s3,deepest_mm\n"
        .to_owned();
    for r in rows {
        if let Some(felt) = &r.felt {
            text += &stroke(r, felt);
            continue;
        }
        let (d, o) = (&r.device, &r.outcome);
        let test = match r.test {
            Test::Wall => "wall",
            Test::Tissue => "tissue",
            Test::Free => "free",
            Test::Response => "response",
            Test::Felt => "felt",
        };
        text += &format!(
            "{test},\"{}\",{},{},{},{},{},{},{},{:.1},{:.1},{:.1},{},{:.4},{:.3},{:.4},{:.4},{:.4},{},{},{:.2},,,,,,,\n",
            r.kind.name(),
            r.hand.name,
            d.damping_n_s_m,
            d.friction_n,
            d.delay_s * 1e3,
            1000 / d.every,
            d.lost,
            d.late,
            r.of,
            r.stiffness_n_m,
            r.rendered_n_m,
            u8::from(o.is_stable()),
            o.swing_m * 1e3,
            o.step_n * 1e3,
            o.force_n,
            o.given_j * 1e3,
            r.limits.energy_j * 1e3,
            r.limits.damped,
            r.limits.capped,
            r.lag_s * 1e3,
        );
    }
    text
}

/// The line of a stroke, with what a stroke measures.
fn stroke(r: &Row, it: &Felt) -> String {
    let rise = it
        .rise_s
        .map_or_else(String::new, |s| format!("{:.1}", s * 1e3));
    format!(
        "felt,\"{}\",{},{},{},{},{},{},{},{:.1},,,,,,,,{:.4},{},{},,{:.3},{:.4},{:.4},{rise},{:.4},{:.2},{:.3}\n",
        r.kind.name(),
        r.hand.name,
        r.device.damping_n_s_m,
        r.device.friction_n,
        r.device.delay_s * 1e3,
        1000 / r.device.every,
        r.device.lost,
        r.device.late,
        r.of,
        r.limits.energy_j * 1e3,
        r.limits.damped,
        r.limits.capped,
        it.peak_n * 1e3,
        it.rms_n * 1e3,
        it.injected_j * 1e3,
        it.drag_n * 1e3,
        it.jerk_m_s3,
        it.deepest_m * 1e3,
    )
}

/// The rows of [`super::waits`] as `haptics_wait.csv`.
pub(crate) fn waits_csv(rows: &[Row]) -> String {
    let mut text =
        "law,hand,device,delay_ms,wait_ms,stable_up_to_n_m,rendered_n_m,swing_mm,given_mj\n"
            .to_owned();
    for r in rows {
        text += &format!(
            "\"{}\",{},{},{},{},{:.1},{:.1},{:.4},{:.4}\n",
            r.kind.name(),
            r.hand.name,
            device(r),
            r.device.delay_s * 1e3,
            r.device.wait_s * 1e3,
            r.stiffness_n_m,
            r.rendered_n_m,
            r.outcome.swing_m * 1e3,
            r.outcome.given_j * 1e3,
        );
    }
    text
}

/// Name of a column of the map: the delay, and any slow, lost or late samples.
fn column(r: &Row) -> String {
    let d = &r.device;
    let mut name = format!("{} ms", d.delay_s * 1e3);
    if d.every > 1 {
        name += &format!(", {} Hz", 1000 / d.every);
    }
    if d.lost > 0.0 {
        name += &format!(", {} % lost", d.lost * 100.0);
    }
    if d.late > 0 {
        name += &format!(", {} ms late", d.late);
    }
    name
}

fn device(r: &Row) -> String {
    let d = &r.device;
    if d.friction_n > 0.0 {
        "Touch".to_owned()
    } else {
        format!("{} N s/m", d.damping_n_s_m)
    }
}

/// Names in the order in which they first occur.
fn in_order(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

/// Map of the stiffness up to which walls are stable.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn chart(rows: &[Row]) -> Result<String, String> {
    let walls: Vec<&Row> = rows.iter().filter(|r| r.test == Test::Wall).collect();
    let columns = in_order(walls.iter().map(|r| column(r)));
    let devices = in_order(walls.iter().map(|r| device(r)));
    let (mut names, mut lines) = (Vec::new(), Vec::new());
    for of in &devices {
        for hand in Hand::ALL {
            for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
                names.push(format!("{of}, hand {}: {}", hand.name, kind.name()));
                let cell = |name: &String| {
                    let found = walls.iter().find(|r| {
                        device(r) == *of && r.hand == hand && r.kind == kind && column(r) == *name
                    });
                    found.map_or(
                        Cell {
                            text: String::new(),
                            good: None,
                        },
                        |r| wall_cell(r),
                    )
                };
                lines.push(columns.iter().map(cell).collect());
            }
        }
    }
    heat_map(&columns, &names, &lines)
}

/// A cell of the map. For Calot, the rendered stiffness follows in brackets.
fn wall_cell(r: &Row) -> Cell {
    let limit = if r.stiffness_n_m >= STIFFEST_N_M {
        "all".to_owned()
    } else if r.stiffness_n_m < SOFTEST_N_M {
        "none".to_owned()
    } else {
        format!("≤ {:.0}", r.stiffness_n_m)
    };
    let text = if r.kind == LawKind::Ours && r.stiffness_n_m > 0.0 {
        format!("{limit} ({:.0})", r.rendered_n_m)
    } else {
        limit
    };
    let good = (r.stiffness_n_m / SOFTEST_N_M).max(1.0).ln() / (STIFFEST_N_M / SOFTEST_N_M).ln();
    Cell {
        text,
        good: Some(good),
    }
}

/// The section of the page.
pub(crate) fn section(rows: &[Row], svg: &str) -> Section {
    let ours = |test| {
        rows.iter()
            .filter(move |r| r.test == test && r.kind == LawKind::Ours)
    };
    let walls = ours(Test::Wall).count();
    let all = ours(Test::Wall).filter(|r| r.stiffness_n_m >= STIFFEST_N_M);
    let mut body = format!(
        "<p>A handle of 45 g (emulated Touch: 0.055 mm encoder steps, 3.3 N, force held for a millisecond), mechanics \
at 20 kHz. A hand presses (nobody: a weight lies on the handle; relaxed: 30 N/m and 0.2 N s/m; firm: 400 N/m, 4 N s/m \
and 20 g), with 1 N into a wall or with 0.3 N into a liver of 581 spheres. A contact is stable if the handle swings within 0.275 mm after 1.2 s, or its swing gets smaller. \
The map has the stiffness up to which all walls are stable, from 100 N/m to 20 kN/m. Calot knows the device's damping, \
friction and delay, but neither the hand nor lost and late samples. In brackets is the stiffness that Calot renders in the \
stiffest stable wall. In {} of {walls} settings Calot is stable with every wall. “Touch” has 0.2 N s/m and 0.26 N of \
dry friction; the others have no friction.</p>{svg}",
        all.count()
    );
    let left: Vec<String> = ours(Test::Wall)
        .filter(|r| r.stiffness_n_m < STIFFEST_N_M)
        .map(|r| {
            format!(
                "{}, hand {}, {}: up to {:.0} N/m",
                device(r),
                r.hand.name,
                column(r),
                r.stiffness_n_m
            )
        })
        .collect();
    if !left.is_empty() {
        body += &format!(
            "<details><summary>Calot's exceptions</summary><p>At 0 N/m, the stiffness that the device's \
damping allows at its delay does not carry the weight.</p><ul><li>{}</ul></details>",
            left.join("<li>")
        );
    }
    body += "<h3>A liver</h3><p>A liver of 5 and 20 kPa is met at its contact skin; only the rigid multiplier meets its spheres. The devices \
have 0.1 and 0.5 N s/m, or are the Touch; their delays are 0 to 4 ms.</p><table><tr><th>law<th>stable<th>largest change of force a tick while held, mN<th>most \
energy given, mJ<th>ticks damped";
    for kind in [LawKind::Ours, LawKind::Bare, LawKind::Rigid] {
        let of = || {
            rows.iter()
                .filter(move |r| r.test == Test::Tissue && r.kind == kind)
        };
        let most = |f: fn(&Row) -> f64| of().map(f).fold(0.0, f64::max);
        body += &format!(
            "<tr><td>{}<td>{} of {}<td>{:.1}<td>{:.2}<td>{}",
            kind.name(),
            of().filter(|r| r.outcome.is_stable()).count(),
            of().count(),
            most(|r| r.outcome.step_n * 1e3),
            most(|r| r.outcome.given_j * 1e3),
            of().map(|r| r.limits.damped).sum::<u64>(),
        );
    }
    body += "</table><h3>Free space, and bandwidth</h3><table><tr><th>law<th>most force in free space, mN<th>at 1, 3, \
10, 30, 100 Hz: gain N/m of a wall of 300 N/m, lag ms (delay 2 ms)";
    for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
        let of = |test| {
            rows.iter()
                .filter(move |r| r.test == test && r.kind == kind)
        };
        let free = of(Test::Free)
            .map(|r| r.outcome.force_n)
            .fold(0.0, f64::max);
        let response: Vec<String> = of(Test::Response)
            .map(|r| format!("{:.0}, {:.1}", r.stiffness_n_m, r.lag_s * 1e3))
            .collect();
        body += &format!(
            "<tr><td>{}<td>{:.2}<td>{}",
            kind.name(),
            free * 1e3,
            response.join("; ")
        );
    }
    Section {
        title: "Contact under a hand".to_owned(),
        body: body + "</table>" + &strokes(rows),
    }
}

/// Measures of the strokes: the median of each law.
fn strokes(rows: &[Row]) -> String {
    let mut text = "<h3>As OmniSurg’s haptic bench measures</h3><p>A hand waves in free air, presses a wall with 1 N, \
holds and leaves. The definitions are those of the bench’s version 1, at 1 kHz instead of 120 Hz. Medians over walls \
of 300, 1000 and 3000 N/m, two devices, and delays of 0 to 4 ms.</p><table><tr><th>law<th>hand<th>oscillation 20 to \
300 Hz: peak, rms mN<th>injected energy, mJ<th>rise, ms<th>drag, mN<th>jerk, m/s³<th>depth, mm"
        .to_owned();
    for hand in [Hand::RELAXED, Hand::FIRM] {
        for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
            let own = || {
                let own = rows.iter().filter(|r| r.kind == kind && r.hand == hand);
                own.filter_map(|r| r.felt)
            };
            let median = |f: fn(&Felt) -> f64| {
                statistics::median(&own().map(|it| f(&it)).collect::<Vec<_>>())
            };
            if own().count() == 0 {
                continue;
            }
            text += &format!(
                "<tr><td>{}<td>{}<td>{:.1}, {:.2}<td>{:.2}<td>{:.0}<td>{:.2}<td>{:.0}<td>{:.2}",
                kind.name(),
                hand.name,
                median(|it| it.peak_n * 1e3),
                median(|it| it.rms_n * 1e3),
                median(|it| it.injected_j * 1e3),
                median(|it| it.rise_s.unwrap_or(0.0) * 1e3),
                median(|it| it.drag_n * 1e3),
                median(|it| it.jerk_m_s3),
                median(|it| it.deepest_m * 1e3),
            );
        }
    }
    text + "</table>"
}
