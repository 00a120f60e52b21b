//! `evaluate force`: the force on a tool over its depth, against finite elements.

mod case;
mod ours;
mod page;
mod reference;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use case::{Case, Shaped, Site};
use ours::{Law, Rig};
use reference::{Curve, DEPTHS_MM, rms_pct};

pub(crate) use page::{chart, section};

/// Threads that solve reference curves at the same time.
const THREADS: usize = 2;

/// Finds each case's reference in `folder` or in the repository, or solves it and keeps it in
/// `folder`. Without `kept`, a found reference counts only if today's mesher made its meshes.
///
/// # Errors
/// When the folder cannot be made, in words.
fn references(
    cases: &[Case],
    folder: &Path,
    quick: bool,
    kept: bool,
) -> Result<Vec<Result<Curve, String>>, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let next = AtomicUsize::new(0);
    let found: Vec<Mutex<Option<Result<Curve, String>>>> =
        cases.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(i) else { break };
                    eprintln!("reference {} of {}: {}", i + 1, cases.len(), case.name());
                    let curve = reference::curve(case, folder, quick, kept);
                    if let Ok(mut slot) = found[i].lock() {
                        *slot = Some(curve);
                    }
                }
            });
        }
    });
    let take = |slot: Mutex<Option<_>>| {
        let inner = slot.into_inner().ok().flatten();
        inner.unwrap_or_else(|| Err("a reference's thread ended early".to_owned()))
    };
    Ok(found.into_iter().map(take).collect())
}

/// Figures of one law at one case.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// The case.
    pub(crate) case: Case,
    /// The contact law.
    pub(crate) law: Law,
    /// Number of the organ's spheres.
    pub(crate) spheres: usize,
    /// Force at the first depths of [`DEPTHS_MM`], N.
    pub(crate) force_n: Vec<f64>,
    /// The finite elements' forces.
    pub(crate) reference: Curve,
}

impl Row {
    /// Root mean square and largest error over the depths, %.
    pub(crate) fn error_pct(&self) -> [f64; 2] {
        let off = reference::off(&self.force_n, &self.reference.force_n);
        let worst = off.into_iter().map(|e| e.abs() * 100.0);
        let rms = rms_pct(&self.force_n, &self.reference.force_n);
        [rms, worst.fold(0.0, f64::max)]
    }

    /// True if the result is independent: its site was not used to choose a constant, and its
    /// reference can be trusted.
    pub(crate) fn counts(&self) -> bool {
        !self.case.site.seen && self.reference.doubt_pct() <= DOUBT_MAX_PCT
    }
}

/// Just noticeable difference of force, %.
pub(crate) const GOAL_PCT: f64 = 7.0;
/// Nothing is concluded from a reference if the forces on its two meshes differ by more than this,
/// %.
pub(crate) const DOUBT_MAX_PCT: f64 = 3.5;

/// The largest step of the force from one tick to the next, in one motion.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// Names of the body and the site.
    pub(crate) site: String,
    /// Number of the organ's spheres.
    pub(crate) spheres: usize,
    /// Speed along the surface, m/s; `None` for a press.
    pub(crate) slide_m_s: Option<f64>,
    /// Largest step of the force, N.
    pub(crate) step_n: f64,
}

/// Measurements.
pub(crate) struct Measured {
    /// Rows of every law at every case.
    pub(crate) rows: Vec<Row>,
    /// Largest steps of the force of Calot's contact law.
    pub(crate) steps: Vec<Step>,
    /// The references as [`reference::csv`] writes them.
    pub(crate) references: String,
}

/// Measures all cases whose names contain `only`. A reference of today's mesher is taken from `out`
/// or from the repository; any other is solved. With `kept` none is solved: cases without a
/// reference in either place are left out, and references of older meshers count too.
///
/// # Errors
/// The reason in words.
pub(crate) fn run(out: &Path, quick: bool, only: &str, kept: bool) -> Result<Measured, String> {
    let mut cases = Case::all();
    let folder = out.join("reference");
    cases.retain(|case| {
        case.name().contains(only) && (!kept || reference::found(case, &folder, quick).is_some())
    });
    let curves = references(&cases, &folder, quick, kept)?;
    let known = cases.iter().zip(&curves);
    let known = known.filter_map(|(case, curve)| Some((case, curve.as_ref().ok()?)));
    let references = reference::csv(known);
    let counts: &[usize] = if quick {
        &[250, 581]
    } else {
        &[250, 581, 1200, 2500]
    };
    let mut measured = Measured {
        rows: Vec::new(),
        steps: Vec::new(),
        references,
    };
    let mut sites: Vec<Site> = Vec::new();
    for case in &cases {
        if !sites.iter().any(|site| site.is(&case.site)) {
            sites.push(case.site);
        }
    }
    for site in &sites {
        let surface = site.subject.mesh()?;
        for &count in counts {
            eprintln!("{} {}, {count} spheres …", site.subject.name(), site.name);
            let mut rig = Rig::new(&surface, count, site)?;
            let here = cases.iter().zip(&curves);
            for (case, curve) in here.filter(|(case, _)| case.site.is(site)) {
                let curve = match curve {
                    Ok(curve) if !curve.force_n.is_empty() => curve,
                    Ok(_) => continue,
                    Err(why) => {
                        eprintln!("  no reference: {why}");
                        continue;
                    }
                };
                let placed = case.placed(&surface)?;
                for law in Law::ALL {
                    let row = Row {
                        case: *case,
                        law,
                        spheres: rig.spheres(),
                        force_n: rig.press(&placed, law, curve.force_n.len())?,
                        reference: curve.clone(),
                    };
                    let [rms, most] = row.error_pct();
                    eprintln!(
                        "  {}, {}: rms {rms:.1} %, max {most:.1} %",
                        case.name(),
                        law.name()
                    );
                    measured.rows.push(row);
                }
                if case.tool == Shaped::Tip(5.0) {
                    for slide_m_s in [None, Some(0.02), Some(0.1), Some(0.3)] {
                        let step_n = rig.largest_step_n(&placed, slide_m_s)?;
                        measured.steps.push(Step {
                            site: format!("{} {}", site.subject.name(), site.name),
                            spheres: rig.spheres(),
                            slide_m_s,
                            step_n,
                        });
                    }
                }
            }
        }
    }
    Ok(measured)
}

/// The rows as `force.csv`: one line for each law, case and number of spheres. `tool_mm` is the
/// radius of the tool's parts. `reference_doubt_pct` is the difference between the forces on the
/// reference's two meshes. `mesher` is the version of the mesher that made these meshes. `to_mm` is
/// the largest depth at which the row has a force.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "organ,site,tool_mm,spheres,rms_error_pct,max_error_pct,law,tool,seen,\
                    reference_doubt_pct,mesher,to_mm\n"
        .to_owned();
    for row in rows {
        let (site, [rms, most]) = (&row.case.site, row.error_pct());
        text += &format!(
            "{},{},{},{},{rms:.2},{most:.2},{},\"{}\",{},{:.2},{},{}\n",
            site.subject.name(),
            site.name,
            row.case.tool.radius_m() * 1e3,
            row.spheres,
            row.law.name(),
            row.case.tool.name(),
            site.seen,
            row.reference.doubt_pct(),
            row.reference.mesher,
            DEPTHS_MM[row.force_n.len() - 1],
        );
    }
    text
}

/// The rows as `force_depth.csv`, one line for each depth.
pub(crate) fn depth_csv(rows: &[Row]) -> String {
    let mut text =
        "organ,site,tool,law,spheres,depth_mm,force_n,reference_n,coarser_reference_n\n".to_owned();
    for row in rows {
        let site = &row.case.site;
        let forces = row.force_n.iter().zip(&row.reference.force_n);
        for (i, (depth, (force, reference))) in DEPTHS_MM.iter().zip(forces).enumerate() {
            let coarse = row.reference.coarse_n.get(i);
            text += &format!(
                "{},{},\"{}\",{},{},{depth},{force:.5},{reference:.5},{}\n",
                site.subject.name(),
                site.name,
                row.case.tool.name(),
                row.law.name(),
                row.spheres,
                coarse.map_or_else(String::new, |f| format!("{f:.5}")),
            );
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

#[cfg(test)]
mod tests {
    use super::*;
    use case::Placed;
    use scene_prepare::mesh::Mesh;

    /// The case of this name, its surface and its tool.
    fn known(name: &str) -> (Case, Mesh, Placed) {
        let of = |case: &Case| case.name() == name;
        let case = Case::all().into_iter().find(of).expect("in the list");
        let surface = case.site.subject.mesh().expect("built in");
        let placed = case.placed(&surface).expect("a place");
        (case, surface, placed)
    }

    /// The expected forces at 2, 4 and 6 mm come from the full run.
    #[test]
    fn ours_is_near_the_reference_and_a_rigid_skin_is_not() {
        let (case, surface, placed) = known("liver left lobe: tip 5 mm");
        let mut rig = Rig::new(&surface, 250, &case.site).expect("packed");
        let mut error = |law| {
            let force = rig.press(&placed, law, 6).expect("pressed");
            [(1, 0.055), (3, 0.144), (5, 0.249)]
                .map(|(i, r): (usize, f64)| force[i] / r - 1.0)
                .map(f64::abs)
                .into_iter()
                .fold(0.0, f64::max)
        };
        let (ours, rigid) = (error(Law::Ours), error(Law::RigidSkin));
        assert!(ours < 0.3 && rigid > 2.0 * ours, "{ours} {rigid}");
    }

    /// The expected force at 3 mm comes from the full run. With a contact patch as narrow as the
    /// tip, the force with 2500 spheres was 19 % too high.
    #[test]
    fn a_thin_tip_meets_many_spheres_as_it_meets_few() {
        let (case, surface, placed) = known("gallbladder neck: tip 3 mm");
        for spheres in [250, 2500] {
            let mut rig = Rig::new(&surface, spheres, &case.site).expect("packed");
            let force_n = rig.press(&placed, Law::Ours, 3).expect("pressed");
            let off = force_n[2] / 0.0682 - 1.0;
            assert!(off.abs() < 0.07, "{spheres}: {off}");
        }
    }
}
