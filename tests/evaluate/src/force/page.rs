//! The chart and the section of force over depth.

use super::case::PORT_M;
use super::ours::Law;
use super::wrench::Wrench;
use super::{DEPTHS_MM, DOUBT_MAX_PCT, GOAL_PCT, Measured, Row, Step, motion};
use crate::page::{Section, number, strings, table};
use figures::panels::{self, Panel, Scale, Series};

/// Force over depth, one panel for each case: the reference with the goal's range, and Calot's
/// force.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn chart(rows: &[Row]) -> Result<String, String> {
    let mut panels: Vec<(String, Panel)> = Vec::new();
    for row in rows.iter().filter(|r| r.law == Law::Ours) {
        let name = row.case.name();
        if !panels.iter().any(|(n, _)| *n == name) {
            let forces = |curve: &[Wrench]| curve.iter().map(Wrench::out_n).collect::<Vec<_>>();
            let [truth, coarse] = [&row.reference.fine, &row.reference.coarse].map(|c| forces(c));
            let scaled = |by: f64, name: String, is_thin| Series {
                name,
                points: points(truth.iter().map(|f| f * by)),
                is_thin,
            };
            let goal = || format!("{GOAL_PCT} % above and below");
            let doubt = row.reference.doubt_pct();
            let panel = Panel {
                title: if doubt > DOUBT_MAX_PCT {
                    format!("{name} (±{doubt:.0} %)")
                } else {
                    name.clone()
                },
                axes: ["depth, mm".to_owned(), "force, N".to_owned()],
                scales: [Scale::Linear; 2],
                series: vec![
                    scaled(1.0 - GOAL_PCT / 100.0, goal(), true),
                    scaled(1.0 + GOAL_PCT / 100.0, goal(), true),
                    scaled(1.0, "finite elements".to_owned(), false),
                    Series {
                        name: "finite elements, coarser".to_owned(),
                        points: points(coarse.iter().copied()),
                        is_thin: true,
                    },
                ],
            };
            panels.push((name.clone(), panel));
        }
        if let Some((_, panel)) = panels.iter_mut().find(|(n, _)| *n == name) {
            panel.series.push(Series {
                name: format!("Calot, about {} spheres", rounded(row.spheres)),
                points: points(row.felt.iter().map(Wrench::out_n)),
                is_thin: false,
            });
        }
    }
    let panels: Vec<Panel> = panels.into_iter().map(|(_, panel)| panel).collect();
    panels::panels(&panels, 4)
}

fn points(force_n: impl Iterator<Item = f64>) -> Vec<[f64; 2]> {
    let at = DEPTHS_MM.iter().zip(force_n);
    at.map(|(depth, force)| [*depth, force]).collect()
}

/// The requested number of spheres that is nearest to the packed number.
fn rounded(spheres: usize) -> usize {
    let asked = [250, 581, 1200, 2500];
    let nearest = asked
        .into_iter()
        .min_by_key(|n: &usize| n.abs_diff(spheres));
    nearest.unwrap_or(spheres)
}

/// The section of the page.
pub(crate) fn section(measured: &Measured, svg: &str) -> Section {
    let rows = &measured.rows;
    let ours = || rows.iter().filter(|r| r.law == Law::Ours);
    let counting = || ours().filter(|r| r.counts());
    let kept = counting().filter(|r| r.error_pct()[0] <= GOAL_PCT).count();
    Section {
        title: "Force over depth".to_owned(),
        body: format!(
            "<p>A rigid, frictionless tool is pressed into an organ 1 to 8 mm deep, along the normal where it first \
touches; sizes are <b>radii</b>. The force along its way is compared with that of finite elements (quadratic \
tetrahedra of the same neo-Hookean tissue, frictionless contact). A curve ends where the reference finds no \
more equilibrium. Every reference is solved on two meshes. If they differ by more than {DOUBT_MAX_PCT} %, the panel has \
their difference, and nothing is concluded. The goal is the just noticeable difference of force, {GOAL_PCT} % \
rms. The torque is that about the port, {:.0} mm along the tool’s axis; over the length outside, it is the force that \
a hand feels across the shaft. The line of action says where the force acts.</p><p>The sites “right lobe” and “neck” were used to choose constants of the contact law; all other sites are \
unseen. <b>{kept} of {} rows at unseen sites with a trusted reference are within the goal.</b></p>{svg}{}\
<p>Steps of the product’s force from one tick to the next, for a tip of 5 mm radius: pressed to 5 mm, and slid over 40 mm \
at a depth of 4 mm. Each is the largest of all sites and sphere counts.</p>{}<details><summary>All figures</summary>{}</details>",
            PORT_M * 1e3,
            counting().count(),
            table(&laws(rows)),
            table(&smoothness(&measured.steps)),
            table(&all(rows)),
        ),
    }
}

/// A summary of every law.
fn laws(rows: &[Row]) -> Vec<Vec<String>> {
    let mut lines = vec![strings([
        "law",
        "rows",
        "median rms error %",
        "worst rms error %",
        "rows within 7 %",
        "median torque error %",
        "median line of action off, mm",
    ])];
    for law in Law::ALL {
        let mine = rows.iter().filter(|r| r.law == law && r.counts());
        let mut errors: Vec<f64> = mine.map(|r| r.error_pct()[0]).collect();
        errors.sort_by(f64::total_cmp);
        let Some(worst) = errors.last() else { continue };
        let within = errors.iter().filter(|e| **e <= GOAL_PCT).count();
        let median = |value: fn(&Row) -> Option<f64>| {
            let mine = rows.iter().filter(|r| r.law == law && r.counts());
            let mut values: Vec<f64> = mine.filter_map(value).collect();
            values.sort_by(f64::total_cmp);
            let middle = values.get(values.len() / 2);
            middle.map_or_else(String::new, |x| number(*x, 2))
        };
        lines.push(vec![
            law.name().to_owned(),
            errors.len().to_string(),
            number(errors[errors.len() / 2], 1),
            number(*worst, 1),
            within.to_string(),
            median(Row::torque_error_pct),
            median(Row::line_off_mm),
        ]);
    }
    lines
}

fn smoothness(steps: &[Step]) -> Vec<Vec<String>> {
    let mut lines = vec![strings(["motion", "largest step, mN a tick", "where"])];
    let mut motions: Vec<String> = steps.iter().map(motion).collect();
    motions.sort_unstable();
    motions.dedup();
    for name in motions {
        let mine = steps.iter().filter(|s| motion(s) == name);
        if let Some(worst) = mine.max_by(|a, b| a.step_n.total_cmp(&b.step_n)) {
            let place = format!("{}, {} spheres", worst.site, worst.spheres);
            lines.push(vec![name, number(worst.step_n * 1e3, 2), place]);
        }
    }
    lines
}

fn all(rows: &[Row]) -> Vec<Vec<String>> {
    let or_none = |x: Option<f64>| x.map_or_else(String::new, |x| number(x, 2));
    let mut lines = vec![strings([
        "case",
        "law",
        "spheres",
        "rms error %",
        "max error %",
        "torque error %",
        "line of action off, mm",
        "meshes differ %",
        "to mm",
        "site",
    ])];
    for row in rows {
        let [rms, most] = row.error_pct();
        lines.push(vec![
            row.case.name(),
            row.law.name().to_owned(),
            row.spheres.to_string(),
            number(rms, 1),
            number(most, 1),
            or_none(row.torque_error_pct()),
            or_none(row.line_off_mm()),
            number(row.reference.doubt_pct(), 1),
            row.felt.len().to_string(),
            if row.case.site.seen { "seen" } else { "unseen" }.to_owned(),
        ]);
    }
    lines
}
