//! The offline page: sections, each with a description, a chart and a table.

use std::process::Command;

use crate::accuracy;
use crate::methods::Way;
use crate::reference;
use crate::stability;
use figures::html::escape;
use figures::panels::{self, Cell, Panel, Scale, Series};

/// A section of the page.
pub(crate) struct Section {
    /// The section's heading, as text.
    pub(crate) title: String,
    /// The section's content, as HTML.
    pub(crate) body: String,
}

/// A table as HTML. The first row is its head. Cells are plain text.
pub(crate) fn table(rows: &[Vec<String>]) -> String {
    let mut html = "<div class=wide><table>".to_owned();
    for (i, row) in rows.iter().enumerate() {
        let tag = if i == 0 { "th" } else { "td" };
        html += "<tr>";
        for cell in row {
            html += &format!("<{tag}>{}", escape(cell));
        }
        html += "\n";
    }
    html + "</table></div>"
}

pub(crate) fn strings<const N: usize>(row: [&str; N]) -> Vec<String> {
    row.map(str::to_owned).to_vec()
}

pub(crate) fn number(value: f64, digits: usize) -> String {
    if value.is_finite() {
        format!("{value:.digits$}")
    } else {
        "blew up".to_owned()
    }
}

/// Time against error, one panel for each of `scenes`, of the methods that `shows` takes.
fn panels(rows: &[accuracy::Row], scenes: &[&str], shows: fn(&str) -> bool) -> Vec<Panel> {
    let panel = |scene: &&str| {
        let mut series: Vec<Series> = Vec::new();
        let shown = rows.iter().filter(|r| shows(&r.method));
        for row in shown.filter(|r| r.scene == **scene) {
            let point = [row.us_per_tick, row.rms_mm];
            match series.iter_mut().find(|s| s.name == row.method) {
                Some(series) => series.points.push(point),
                None => series.push(Series {
                    name: row.method.clone(),
                    points: vec![point],
                    is_thin: false,
                }),
            }
        }
        Panel {
            title: (*scene).to_owned(),
            axes: [
                "µs a tick of 1 ms, one core".to_owned(),
                "rms displacement error, mm".to_owned(),
            ],
            scales: [Scale::Log; 2],
            series,
        }
    };
    scenes.iter().map(panel).collect()
}

fn scenes(rows: &[accuracy::Row]) -> Vec<&str> {
    let mut scenes: Vec<&str> = rows.iter().map(|r| r.scene.as_str()).collect();
    scenes.dedup();
    scenes
}

/// The chart of accuracy with all cases.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn accuracy_chart(rows: &[accuracy::Row]) -> Result<String, String> {
    panels::panels(&panels(rows, &scenes(rows), Way::is_named), 3)
}

/// The chart of competitors beside Calot; `None` without competitors.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn competitors_chart(rows: &[accuracy::Row]) -> Result<Option<String>, String> {
    let shows = |method: &str| !Way::is_named(method);
    let mut scenes = scenes(rows);
    scenes.retain(|scene| {
        let mut all = rows.iter().filter(|r| r.scene == *scene);
        all.any(|r| shows(&r.method))
    });
    if scenes.is_empty() {
        return Ok(None);
    }
    // Calot is the first, and green as in the chart of methods.
    panels::panels_from(&panels(rows, &scenes, shows), 3, 7).map(Some)
}

/// The chart for the README: sag, pull and quarter turn of the liver; `None` without these cases.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn main_chart(rows: &[accuracy::Row]) -> Result<Option<String>, String> {
    let all = scenes(rows);
    let wanted = all
        .get(..3)
        .filter(|s| s.iter().all(|s| s.starts_with("liver")));
    wanted
        .map(|scenes| panels::panels(&panels(rows, scenes, Way::is_named), 3))
        .transpose()
}

/// The sections about accuracy: the chart with all results, the competitors, and the paper's
/// Table 2.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn accuracy(rows: &[accuracy::Row], svg: &str) -> Result<Vec<Section>, String> {
    let mut sections = methods(rows, svg);
    if let Some(svg) = competitors_chart(rows)? {
        sections.insert(1, competitors(&svg));
    }
    Ok(sections)
}

fn competitors(svg: &str) -> Section {
    Section {
        title: "Competitors".to_owned(),
        body: format!(
            "<p>Other simulators, as their publishers offer them for Python, with the same liver. A grid of cells has \
nodes of its own; every other competitor gets Calot's spheres, tetrahedra and masses, without the tetrahedra that \
are held altogether. Their settings are in the table above. Lower left is better.</p>{svg}"
        ),
    }
}

fn methods(rows: &[accuracy::Row], svg: &str) -> Vec<Section> {
    let mut all = vec![strings([
        "scene",
        "method",
        "setting",
        "spheres",
        "µs/tick",
        "rms mm",
        "max mm",
        "force error %",
        "volume error %",
    ])];
    for r in rows {
        all.push(vec![
            r.scene.clone(),
            r.method.clone(),
            r.setting.clone(),
            r.spheres.to_string(),
            number(r.us_per_tick, 0),
            number(r.rms_mm, 2),
            number(r.max_mm, 1),
            if r.force_error_pct.is_nan() {
                String::new()
            } else {
                number(r.force_error_pct, 1)
            },
            number(r.volume_error_pct, 2),
        ]);
    }
    let chart = Section {
        title: "Speed against accuracy".to_owned(),
        body: format!(
            "<p>Each case loads an organ as a surgeon may load it. Time grows to the right, error upwards: <b>lower \
left is better</b>. The error is the distance of each free sphere from its place by finite elements (quadratic \
tetrahedra of the same neo-Hookean tissue, verified against closed forms, and for convergence as below). A line joins a method's sphere counts; a cross on the upper edge is a count at which it blew up.</p>\
<p>All methods get the same spheres, tetrahedra, edges and masses. In every method the spheres that Calot's preparation holds \
follow the reference. No other sphere has a prescribed displacement. Dimensionless stiffnesses (“k fitted”) are fitted on the \
first scene only, the sag, by the mean displacement, and kept in all others. All other settings follow from E, ν and \
density; the share of E that Calot's tetrahedra get was fitted on that scene, once.</p><p>In the presses a rigid, frictionless ball goes into the top by its radius. Calot meets it \
with its contact skin. Every other method moves the spheres, which fit into the skin, clear of the ball at the end of a \
step. 581 spheres lie 13 mm apart, so <b>their force on a smaller ball depends on the place that it hits</b>.</p><p>“Calot” is the product's own solver. “Inner spheres” is the paper's method, which the product keeps \
for comparison. The other methods are written plainly, for one thread, without vector instructions by hand. Methods take \
turns, and times are medians over the turns, so compare times within a panel only. A missing case had no reference: the \
finite elements found no equilibrium, or the organ's mesh is not at hand.</p>{svg}\
<details><summary>All figures</summary>{}</details>",
            table(&all)
        ),
    };
    let mut two = vec![strings([
        "method",
        "paper: elements + constraints",
        "paper: ms/step",
        "here: spheres",
        "here: µs/tick",
        "sag rms mm",
        "pull rms mm",
        "90° rms mm",
        "180° rms mm",
    ])];
    let ways = [
        ("FEM (hexahedra)", "967", "48.6", Way::Hexahedra),
        (
            "mass-spring (explicit Euler)",
            "6427",
            "2.5",
            Way::ExplicitSprings,
        ),
        (
            "PBD (stretch + volume)",
            "6427 + 4079",
            "2.2",
            Way::StretchVolume(0.5),
        ),
        ("inner spheres", "3588 + 581", "7.6", Way::Paper(1.0, 1)),
        (
            "inner spheres, stiffness fitted",
            "",
            "",
            Way::Paper(0.5, 1),
        ),
        ("Calot", "", "", Way::Ours),
    ];
    for (name, elements, ms, way) in ways {
        // The size nearest to the paper's: 581 spheres, or 967 cubes with 1300 corners.
        let wanted: usize = if way == Way::Hexahedra { 1300 } else { 581 };
        let mine = || rows.iter().filter(|r| r.method == way.name());
        let Some(size) = mine().map(|r| r.spheres).min_by_key(|n| n.abs_diff(wanted)) else {
            continue;
        };
        let find = |scene: &str| {
            let here = |r: &&accuracy::Row| r.scene == scene;
            let nearest = mine().filter(here).min_by_key(|r| r.spheres.abs_diff(size));
            nearest.map_or_else(String::new, |r| number(r.rms_mm, 2))
        };
        let time = mine()
            .find(|r| r.spheres == size)
            .map_or(0.0, |r| r.us_per_tick);
        two.push(vec![
            name.to_owned(),
            elements.to_owned(),
            ms.to_owned(),
            size.to_string(),
            number(time, 0),
            find("liver: sag"),
            find("liver: pull 30 mm"),
            find("liver: twist 90°"),
            find("liver: twist 180°"),
        ]);
    }
    let paper = Section {
        title: "The paper's Table 2, with the errors".to_owned(),
        body: format!(
            "<p>The paper compares deformation methods by their time and their looks. This table has its figures (on \
its machine) beside ours, and the error of each method.</p>{}",
            table(&two)
        ),
    };
    vec![chart, paper]
}

/// The chart of stability: a heat map.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn stability_chart(rows: &[stability::Row]) -> Result<String, String> {
    let (mut cases, mut methods): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for row in rows {
        if !cases.iter().any(|c| c == row.case) {
            cases.push(row.case.to_owned());
        }
        if !methods.contains(&row.method) {
            methods.push(row.method.clone());
        }
    }
    let cell = |case: &str, method: &str| {
        let row = rows.iter().find(|r| r.case == case && r.method == method);
        row.map_or(
            Cell {
                text: "–".to_owned(),
                good: None,
            },
            |row| Cell {
                text: stability::words(row),
                good: Some(if row.survived { 1.0 } else { 0.5 * row.share }),
            },
        )
    };
    let line = |case: &String| methods.iter().map(|m| cell(case, m)).collect();
    let cells: Vec<Vec<Cell>> = cases.iter().map(line).collect();
    panels::heat_map(&methods, &cases, &cells)
}

/// The section on stability.
pub(crate) fn stability(rows: &[stability::Row], svg: &str) -> Section {
    let ours = || rows.iter().filter(|r| r.method == Way::Ours.name());
    let (count, kept) = (ours().count(), ours().filter(|r| r.survived).count());
    Section {
        title: "Stability: the limits of the methods".to_owned(),
        body: format!(
            "<p>Each case sweeps one quantity from harmless to the value that has to be survived. A cell has the \
largest value that the method survives. Blue is the whole sweep (≥), pale to orange a part of it; “fails” is not even \
the smallest value. A method survives if the organ stays finite and comes back to rest within 0.5 mm once it is left \
alone. (In the sweeps of stiffness, mass and removed constraints, it must not blow up or fall off. In the spin, it must \
keep momentum within 1 % and angular momentum within 15 %, and gain no energy.) Calot survives {kept} of {count}.</p>{svg}"
        ),
    }
}

/// The section on the reference.
pub(crate) fn reference(rows: &[reference::Row]) -> Section {
    let mut all = vec![strings([
        "scene",
        "layers",
        "nodes",
        "force N or torque N m",
        "largest displacement mm",
        "rms to finest mm",
        "max to finest mm",
    ])];
    for r in rows {
        all.push(vec![
            r.scene.clone(),
            r.layers.to_string(),
            r.nodes.to_string(),
            format!("{:.4}", r.load),
            number(r.displacement_mm, 2),
            number(r.rms_mm, 3),
            number(r.max_mm, 3),
        ]);
    }
    Section {
        title: "Convergence of the reference".to_owned(),
        body: format!(
            "<p>The same scene on ever finer meshes, probed at the free centres of 581 spheres. The mesh has a layer \
of corners on each plane of a hold. Without these layers the solution would depend on the mesh by more than the methods \
differ. The remaining difference of the meshes is the smallest error that the charts can show.</p>{}",
            table(&all)
        ),
    }
}

/// Warning on the page of a reduced run, as HTML.
pub(crate) const QUICK: &str = "<p><b>A reduced run (--quick): its figures are coarse.</b></p>";

/// The whole page of the solvers.
pub(crate) fn whole(sections: &[Section], quick: bool) -> String {
    let warning = if quick { QUICK } else { "" };
    titled("Calot: its solvers, measured", sections, warning)
}

/// A page with a title, and a warning as HTML.
pub(crate) fn titled(title: &str, sections: &[Section], warning: &str) -> String {
    let mut links = String::new();
    let mut body = String::new();
    for (i, section) in sections.iter().enumerate() {
        let title = escape(&section.title);
        links += &format!("<li><a href='#s{i}'>{title}</a>");
        body += &format!("<h2 id=s{i}>{title}</h2>{}\n", section.body);
    }
    format!(
        "<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title>\
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:78rem;margin:2rem auto;padding:0 1rem;color:#222}}\
p,ul{{max-width:50rem}}table{{border-collapse:collapse;font-size:14px}}\
td,th{{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #ddd;vertical-align:bottom}}\
td:first-child,td:nth-child(2),th:first-child,th:nth-child(2){{text-align:left}}\
.wide{{overflow-x:auto}}svg{{max-width:100%;height:auto}}summary{{cursor:pointer;margin:1rem 0}}</style>\
<h1>{title}</h1>{warning}<p>{}</p><ul>{links}</ul>{body}</html>\n",
        escape(&about())
    )
}

/// A line with the machine, the commit and the command.
fn about() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name"));
    let machine = name.map_or("unknown processor", |n| {
        n.trim_start_matches([' ', '\t', ':'])
    });
    let git = Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12"])
        .output();
    let commit = git.ok().filter(|o| o.status.success());
    let commit = commit.map_or("unknown".to_owned(), |o| {
        String::from_utf8_lossy(&o.stdout).trim().to_owned()
    });
    let command: Vec<String> = std::env::args().skip(1).collect();
    let release = if cfg!(debug_assertions) {
        ""
    } else {
        " --release"
    };
    format!(
        "Machine: {machine}. Commit: {commit}. Command: cargo run{release} -p evaluate -- {}",
        command.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_its_sections_and_loads_nothing() {
        let section = Section {
            title: "One & two".to_owned(),
            body: table(&[strings(["a"]), strings(["<b>"])]),
        };
        let html = whole(&[section], true);
        assert!(html.contains("One &amp; two") && html.contains("<td>&lt;b&gt;"));
        assert!(html.contains("Commit: ") && html.contains("reduced run"));
        assert!(!html.contains("http") && !html.contains("<script"));
    }
}
