//! References that were solved earlier. A folder has one file for each; the repository has a table
//! of all.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::case::Case;
use super::curve::{Curve, DEPTHS_MM};
use super::wrench::Wrench;

/// All curves that the repository keeps, in the format of [`csv`]. Solving them takes hours.
const RECORDED: &str = include_str!("../../../results/force_reference.csv");

/// Header of the table.
const COLUMNS: &str = "organ,site,tool,mesher,mesh,nodes,depth_mm,force_out_n,force_along_n,\
                       force_across_n,torque_out_nm,torque_along_nm,torque_across_nm";

/// The curve that was solved earlier: from `folder` or, if it is not there, from the repository.
pub(crate) fn found(case: &Case, folder: &Path, quick: bool) -> Option<Curve> {
    let text = std::fs::read_to_string(place(case, folder, quick));
    let kept = text.ok().and_then(|text| recorded(case, &text));
    kept.or_else(|| recorded(case, RECORDED).filter(|_| !quick))
}

/// Keeps a curve in the folder.
///
/// # Errors
/// When the file cannot be written, in words.
pub(crate) fn keep(case: &Case, curve: &Curve, folder: &Path, quick: bool) -> Result<(), String> {
    let file = place(case, folder, quick);
    let text = csv([(case, curve)].into_iter());
    std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))
}

/// The references as `force_reference.csv`, one line for each depth of each mesh. Torques are about
/// the port, in the axes of [`Wrench`]. Values that older references lack are empty; an unknown
/// number of nodes is 0.
pub(crate) fn csv<'a>(curves: impl Iterator<Item = (&'a Case, &'a Curve)>) -> String {
    let mut text = format!("{COLUMNS}\n");
    for (case, curve) in curves {
        let meshes = ["coarser", "finer"].into_iter().zip(curve.nodes);
        for ((name, nodes), wrenches) in meshes.zip([&curve.coarse, &curve.fine]) {
            for (depth, wrench) in DEPTHS_MM.iter().zip(wrenches) {
                text += &format!(
                    "{},{},{name},{nodes},{depth}{}{}\n",
                    columns(case),
                    curve.mesher,
                    cells(&wrench.force_n, 6),
                    cells(&wrench.torque_nm, 7)
                );
            }
        }
    }
    text
}

fn cells(v: &Vector3<f64>, digits: usize) -> String {
    let cell = |x: &f64| {
        if x.is_finite() {
            format!(",{x:.digits$}")
        } else {
            ",".to_owned()
        }
    };
    v.iter().map(cell).collect()
}

/// The columns that identify a case in a table.
fn columns(case: &Case) -> String {
    let (subject, site) = (case.site.subject.name(), case.site.name);
    format!("{subject},{site},\"{}\"", case.tool.name())
}

/// The curve of a case, from a table that [`csv`] wrote.
fn recorded(case: &Case, table: &str) -> Option<Curve> {
    let columns = columns(case) + ",";
    let own = table.lines().filter_map(|line| line.strip_prefix(&columns));
    let mut curve: Option<Curve> = None;
    for line in own {
        let words: Vec<&str> = line.split(',').collect();
        let [mesher, mesh, nodes, _, numbers @ ..] = &words[..] else {
            return None;
        };
        let numbers: Vec<f64> = numbers
            .iter()
            .map(|word| word.parse().unwrap_or(f64::NAN))
            .collect();
        let [a, b, c, d, e, f] = numbers[..] else {
            return None;
        };
        let wrench = Wrench {
            force_n: Vector3::new(a, b, c),
            torque_nm: Vector3::new(d, e, f),
        };
        let curve = curve.get_or_insert_with(Curve::default);
        curve.mesher = mesher.parse().ok()?;
        let is_fine = *mesh == "finer";
        curve.nodes[usize::from(is_fine)] = nodes.parse().ok()?;
        if is_fine {
            curve.fine.push(wrench);
        } else {
            curve.coarse.push(wrench);
        }
    }
    curve
}

fn place(case: &Case, folder: &Path, quick: bool) -> PathBuf {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = case.name().chars().map(plain).collect();
    folder.join(format!("{name}{}.csv", if quick { "_quick" } else { "" }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_back_what_it_was_given() {
        let cases = Case::all();
        let wrench = |n: f64| Wrench {
            force_n: Vector3::new(n, -0.001, 0.002),
            torque_nm: Vector3::new(0.0, 0.003, -0.0001),
        };
        let curve = |nodes: usize| Curve {
            fine: vec![wrench(0.02), wrench(0.05), wrench(0.09123)],
            coarse: vec![wrench(0.021), wrench(0.049)],
            nodes: [4000, nodes],
            mesher: 4,
        };
        let curves: Vec<Curve> = (1..=cases.len()).map(curve).collect();
        let table = csv(cases.iter().zip(&curves));
        for (case, curve) in cases.iter().zip(&curves) {
            assert_eq!(recorded(case, &table).as_ref(), Some(curve), "{table}");
        }
        assert_eq!(recorded(&cases[0], "nothing"), None);
    }

    /// The repository keeps references of existing cases only.
    #[test]
    fn recorded_reference_is_read() {
        assert_eq!(RECORDED.lines().next(), Some(COLUMNS));
        let lines = RECORDED.lines().count() - 1;
        let cases = Case::all();
        let curves = cases.iter().filter_map(|case| recorded(case, RECORDED));
        let depths: usize = curves.map(|c| c.fine.len() + c.coarse.len()).sum();
        assert_eq!(depths, lines);
    }
}
