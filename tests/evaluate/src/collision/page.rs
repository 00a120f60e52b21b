//! The chart and the section of experiment 2.

use super::{Measured, Row, Way};
use crate::page::{Section, number, strings, table};
use figures::panels::{self, Panel, Scale, Series};

/// The paper's collision times, ms (Table 3).
const PAPER_MS: [(&str, f64); 4] = [
    ("liver", 1.25),
    ("gallbladder", 1.21),
    ("intestine", 1.16),
    ("stomach", 1.24),
];

/// Time over faces, one panel for each organ, and time over spheres for the paper's kernel alone.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn chart(measured: &Measured) -> Result<String, String> {
    let mut panels: Vec<Panel> = Vec::new();
    let mut organs: Vec<&str> = measured.rows.iter().map(|r| r.organ).collect();
    organs.dedup();
    for organ in organs {
        let rows = || measured.rows.iter().filter(|r| r.organ == organ);
        let over = if organ == "balls" { "spheres" } else { "faces" };
        // Calot comes last, because the first colours are the faint ones.
        let series = Way::ALL.into_iter().rev().map(|way| Series {
            name: way.name().to_owned(),
            points: rows()
                .filter(|r| r.way == way)
                .map(|r| {
                    [
                        if organ == "balls" { r.spheres } else { r.faces } as f64,
                        r.tick_us(),
                    ]
                })
                .collect(),
            is_thin: false,
        });
        panels.push(Panel {
            title: if organ == "balls" {
                "the paper’s kernel alone"
            } else {
                organ
            }
            .to_owned(),
            axes: [over.to_owned(), "µs a tick, moving organ".to_owned()],
            scales: [Scale::Log; 2],
            series: series.filter(|s| !s.points.is_empty()).collect(),
        });
    }
    panels::panels(&panels, 3)
}

/// The section of the page.
pub(crate) fn section(measured: &Measured, svg: &str) -> Section {
    let card = match &measured.card {
        Ok(name) => format!("The graphics card here: <b>{name}</b>."),
        Err(why) => format!("The paper’s GPU kernel was not measured: {why}."),
    };
    Section {
        title: "Collision: what the instruments touch (the paper’s experiment 2)".to_owned(),
        body: format!(
            "<p>Two instruments of three parts each go around an organ and in and out of its surface. Every way gets \
the same organ at rest and the same motion, and reports the depth of the deepest part in every tick. The truth is the \
signed distance of the mesh from places 0.25 mm apart on every part’s axis. Precision is the share of the reported \
touches that are true; recall is the share of the true touches that are reported. The finer mesh has the same faces cut \
into four, with 4 times as many spheres.</p><p>{card} Its time includes sending the spheres, the launch and reading \
back. When an organ moves, ways that use its mesh must move the mesh with the spheres (four to a vertex) in every tick, \
and update the structure over it. parry refits its boxes and keeps its tree. An octree’s cells stay where they are, so \
its tree is built again. The column “to follow” and the chart include that time. Calot moves its contact skin only \
near a tool, within its own time.</p><p>{}</p>{svg}{}<details><summary>All figures</summary>{}</details>",
            pays(&measured.rows),
            table(&beside_the_paper(&measured.rows)),
            table(&all(&measured.rows)),
        ),
    }
}

/// Sentence about the smallest number of spheres at which the card is faster than the CPU.
fn pays(rows: &[Row]) -> String {
    let of = |way| {
        rows.iter()
            .filter(move |r| r.organ == "balls" && r.way == way)
    };
    let mut ahead = of(Way::Card).filter(|card| {
        of(Way::Spheres).any(|cpu| cpu.spheres == card.spheres && cpu.us[0] > card.us[0])
    });
    match (of(Way::Card).next_back(), ahead.next()) {
        (None, _) => String::new(),
        (Some(_), Some(first)) => format!(
            "The paper’s kernel is quicker on this card than on one core of this CPU from {} spheres on.",
            first.spheres
        ),
        (Some(most), None) => format!(
            "The paper’s kernel is nowhere quicker on this card than on one core of this CPU, up to {} spheres.",
            most.spheres
        ),
    }
}

fn beside_the_paper(rows: &[Row]) -> Vec<Vec<String>> {
    let mut lines = vec![strings([
        "organ",
        "spheres",
        "paper, ms",
        "paper’s kernel, GPU here, µs",
        "paper’s kernel, CPU here, µs",
        "parry, with following, µs",
        "Calot, µs",
        "its p99, µs",
        "its precision, recall",
        "its depth off by, mm",
    ])];
    for (organ, ms) in PAPER_MS {
        let of = |way| {
            rows.iter()
                .find(move |r: &&Row| r.organ == organ && r.way == way)
        };
        let Some(ours) = of(Way::Ours) else { continue };
        let time = |row: Option<&Row>| row.map_or_else(|| "–".to_owned(), |r| number(r.us[0], 1));
        let [precision, recall] = ours.precision_recall;
        lines.push(vec![
            organ.to_owned(),
            ours.spheres.to_string(),
            number(ms, 2),
            time(of(Way::Card)),
            time(of(Way::Spheres)),
            of(Way::Parry).map_or_else(|| "–".to_owned(), |r| number(r.tick_us(), 1)),
            number(ours.us[0], 1),
            number(ours.us[1], 1),
            format!("{precision:.3}, {recall:.3}"),
            number(ours.depth_error_mm, 2),
        ]);
    }
    lines
}

fn all(rows: &[Row]) -> Vec<Vec<String>> {
    let mut lines = vec![strings([
        "organ",
        "way",
        "faces",
        "spheres",
        "p50 µs",
        "p99 µs",
        "to follow µs",
        "precision",
        "recall",
        "depth off by mm",
    ])];
    for r in rows {
        let is_sweep = r.organ == "balls";
        let or_not = |text: String| if is_sweep { String::new() } else { text };
        lines.push(vec![
            r.organ.to_owned(),
            r.way.name().to_owned(),
            or_not(r.faces.to_string()),
            r.spheres.to_string(),
            number(r.us[0], 1),
            number(r.us[1], 1),
            or_not(number(r.follow_us, 0)),
            or_not(number(r.precision_recall[0], 3)),
            or_not(number(r.precision_recall[1], 3)),
            or_not(number(r.depth_error_mm, 2)),
        ]);
    }
    lines
}
