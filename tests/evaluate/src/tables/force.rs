//! Tables of forces on tools, from `evaluate force` and `evaluate calculix`.

use super::{Table, largest, median, sorted};
use crate::csv::{Csv, Row};
use crate::force::TOUCHES_N;

/// Errors of the force over the depth, by law of contact.
pub(super) fn by_law(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "contact law",
        "places",
        "rows",
        "within 7 %",
        "median rms error, %",
        "largest, %",
    ]);
    for (seen, places) in [
        ("false", "not used for tuning"),
        ("true", "used for tuning"),
    ] {
        for law in csv.distinct("law") {
            let errors = sorted(
                csv.rows()
                    .filter(|r| r.text("seen") == seen && r.text("law") == law)
                    .map(|r| r.number("rms_error_pct")),
            );
            table.row([
                law.clone(),
                places.to_owned(),
                errors.len().to_string(),
                errors.iter().filter(|e| **e <= 7.0).count().to_string(),
                format!("{:.1}", median(&errors)),
                format!("{:.1}", largest(&errors)),
            ]);
        }
    }
    table
}

/// Errors of Calot's torque about the port and of its line of action, by tool.
pub(super) fn torque(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "tool",
        "rows with a torque",
        "median torque error, %",
        "largest, %",
        "rows with a line of action",
        "median distance, mm",
        "largest, mm",
    ]);
    for tool in csv.distinct("tool") {
        let values = |column: &str| {
            let ours = csv.rows().filter(|r| r.text("law") == "Calot");
            let of = ours.filter(|r| r.text("tool") == tool);
            sorted(of.map(|r| r.number(column)).filter(|x| x.is_finite()))
        };
        let (torques, lines) = (values("torque_error_pct"), values("line_off_mm"));
        if lines.is_empty() {
            continue; // its references have no torque
        }
        let or_none = |x: f64, digits: usize| {
            if x.is_finite() {
                format!("{x:.digits$}")
            } else {
                String::new()
            }
        };
        table.row([
            tool.clone(),
            torques.len().to_string(),
            or_none(median(&torques), 1),
            or_none(largest(&torques), 1),
            lines.len().to_string(),
            or_none(median(&lines), 2),
            or_none(largest(&lines), 2),
        ]);
    }
    table
}

/// Differences between the references' two meshes, by depth, where the tool touches.
pub(super) fn reference(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "mesher",
        "depth, mm",
        "places and tools",
        "median difference of the meshes, %",
        "largest, %",
    ]);
    let same = |a: &Row<'_>, b: &Row<'_>| {
        ["organ", "site", "tool", "depth_mm"]
            .iter()
            .all(|column| a.text(column) == b.text(column))
    };
    for (name, is_new) in [("4", true), ("1 to 3", false)] {
        for depth in ["1", "2", "4", "8"] {
            let of = |mesh: &'static str| {
                csv.rows().filter(move |r| {
                    (r.text("mesher") == "4") == is_new
                        && r.text("depth_mm") == depth
                        && r.text("mesh") == mesh
                })
            };
            let differences = sorted(of("finer").filter_map(|fine| {
                let coarse = of("coarser").find(|coarse| same(coarse, &fine))?;
                let [coarse_n, fine_n] = [coarse, fine].map(|row| row.number("force_out_n"));
                (fine_n >= TOUCHES_N).then(|| 100.0 * (coarse_n / fine_n - 1.0).abs())
            }));
            if differences.is_empty() {
                continue;
            }
            table.row([
                name.to_owned(),
                depth.to_owned(),
                differences.len().to_string(),
                format!("{:.1}", median(&differences)),
                format!("{:.1}", largest(&differences)),
            ]);
        }
    }
    table
}

/// Forces by CalculiX and by the reference's own elements.
pub(super) fn calculix(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "press",
        "nodes",
        "depth, mm",
        "CalculiX, N",
        "ours with its law, N",
        "difference, %",
        "ours with Calot's law, N",
        "difference, %",
    ]);
    for r in csv.rows() {
        let [calculix, same, calot] =
            ["calculix_n", "same_law_n", "calot_law_n"].map(|column| r.number(column));
        let off = |x: f64| format!("{:.1}", 100.0 * (x / calculix - 1.0));
        table.row([
            r.text("case").to_owned(),
            r.text("nodes").to_owned(),
            r.text("depth_mm").to_owned(),
            format!("{calculix:.4}"),
            format!("{same:.4}"),
            off(same),
            format!("{calot:.4}"),
            off(calot),
        ]);
    }
    table
}

/// The largest steps of the force from one tick to the next, by motion.
pub(super) fn steps(csv: &Csv) -> Table {
    let mut table = Table::new(&["motion", "rows", "median step, mN a tick", "largest"]);
    for motion in csv.distinct("motion") {
        let steps = sorted(
            csv.rows()
                .filter(|r| r.text("motion") == motion)
                .map(|r| r.number("largest_step_mn_per_tick")),
        );
        table.row([
            motion.clone(),
            steps.len().to_string(),
            format!("{:.2}", median(&steps)),
            format!("{:.2}", largest(&steps)),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table_of(name: &str, text: &str, table: fn(&Csv) -> Table) -> String {
        let file = std::env::temp_dir().join(format!("calot-{name}-{}.csv", std::process::id()));
        std::fs::write(&file, text).expect("a folder of temporary files");
        let csv = Csv::read(&file);
        std::fs::remove_file(&file).expect("written above");
        table(&csv.expect("as many cells as columns")).markdown()
    }

    /// Only Calot's rows count. A tool without any torque is left out, and so is a row without a
    /// torque.
    #[test]
    fn a_torque_is_shown_where_it_is_known() {
        let text = "tool,law,torque_error_pct,line_off_mm\n\
                    tip,Calot,4.0,0.10\n\
                    tip,Calot,,0.30\n\
                    tip,spheres,90.0,9.00\n\
                    jaws,Calot,,\n";
        let shown = table_of("torque", text, torque);
        assert!(
            shown.contains("| tip | 1 | 4.0 | 4.0 | 2 | 0.20 | 0.30 |"),
            "{shown}"
        );
        assert!(!shown.contains("jaws"), "{shown}");
        // Files that are older than the torque have no such columns.
        let before = table_of("before", "tool,law\ntip,Calot\n", torque);
        assert!(!before.contains("tip"), "{before}");
    }

    /// At the smallest depth this tool hardly touches, so a relative difference is meaningless.
    #[test]
    fn meshes_are_compared_where_the_tool_touches() {
        let text = "organ,site,tool,mesher,mesh,depth_mm,force_out_n\n\
                    liver,lobe,tip,4,coarser,1,0.0012\n\
                    liver,lobe,tip,4,finer,1,0.0010\n\
                    liver,lobe,tip,4,coarser,2,0.0404\n\
                    liver,lobe,tip,4,finer,2,0.0400\n";
        let shown = table_of("meshes", text, reference);
        assert!(shown.contains("| 4 | 2 | 1 | 1.0 | 1.0 |"), "{shown}");
        assert!(!shown.contains("| 4 | 1 |"), "{shown}");
    }
}
