//! The files of `evaluate force`.

use super::curve::DEPTHS_MM;
use super::{Row, Step};

/// The rows as `force.csv`: one line for each law, case and number of spheres. `tool_mm` is the
/// radius of the tool's parts. `torque_error_pct` is the error of the torque about the port, and
/// `line_off_mm` is the distance of the force's line of action from the reference's; both are empty
/// where the reference's torque is too small or not known. `reference_doubt_pct` is the difference
/// between the forces on the reference's two meshes. `mesher` is the version of the mesher that
/// made these meshes. `to_mm` is the largest depth at which the row has a force.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "organ,site,tool_mm,spheres,rms_error_pct,max_error_pct,torque_error_pct,\
                    line_off_mm,law,tool,seen,reference_doubt_pct,mesher,to_mm\n"
        .to_owned();
    let or_none = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.2}"));
    for row in rows {
        let (site, [rms, most]) = (&row.case.site, row.error_pct());
        text += &format!(
            "{},{},{},{},{rms:.2},{most:.2},{},{},{},\"{}\",{},{:.2},{},{}\n",
            site.subject.name(),
            site.name,
            row.case.tool.radius_m() * 1e3,
            row.spheres,
            or_none(row.torque_error_pct()),
            or_none(row.line_off_mm()),
            row.law.name(),
            row.case.tool.name(),
            site.seen,
            row.reference.doubt_pct(),
            row.reference.mesher,
            DEPTHS_MM[row.felt.len() - 1],
        );
    }
    text
}

/// The rows as `force_depth.csv`, one line for each depth: the force out of the body (against the
/// tool's motion), and the torques about the port in the axes out, along and across.
pub(crate) fn depth_csv(rows: &[Row]) -> String {
    let mut text =
        "organ,site,tool,law,spheres,depth_mm,force_n,reference_n,coarser_reference_n".to_owned();
    for of in ["torque", "reference_torque", "coarser_reference_torque"] {
        for axis in ["out", "along", "across"] {
            text += &format!(",{of}_{axis}_nm");
        }
    }
    text.push('\n');
    for row in rows {
        let site = &row.case.site;
        let pairs = row.felt.iter().zip(&row.reference.fine);
        for (i, (depth, (felt, fine))) in DEPTHS_MM.iter().zip(pairs).enumerate() {
            let coarse = row.reference.coarse.get(i);
            text += &format!(
                "{},{},\"{}\",{},{},{depth},{:.5},{:.5},{}",
                site.subject.name(),
                site.name,
                row.case.tool.name(),
                row.law.name(),
                row.spheres,
                felt.out_n(),
                fine.out_n(),
                coarse.map_or_else(String::new, |c| format!("{:.5}", c.out_n())),
            );
            for wrench in [Some(felt), Some(fine), coarse] {
                for axis in 0..3 {
                    let torque = wrench.map(|w| w.torque_nm[axis]);
                    let known = torque.filter(|t| t.is_finite());
                    text.push(',');
                    text += &known.map_or_else(String::new, |t| format!("{t:.6}"));
                }
            }
            text.push('\n');
        }
    }
    text
}

/// The steps as `force_steps.csv`.
pub(crate) fn steps_csv(steps: &[Step]) -> String {
    let mut text = "site,spheres,motion,largest_step_mn_per_tick\n".to_owned();
    for step in steps {
        text += &format!(
            "{},{},{},{:.3}\n",
            step.site,
            step.spheres,
            motion(step),
            step.step_n * 1e3
        );
    }
    text
}

/// Motion of a tool, in words.
pub(crate) fn motion(step: &Step) -> String {
    step.slide_m_s.map_or_else(
        || "press 10 mm/s".to_owned(),
        |speed| format!("slide {:.0} mm/s", speed * 1e3),
    )
}
