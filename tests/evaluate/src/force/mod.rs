//! `evaluate force`: compares force and torque on a tool, over its depth, with finite elements.

mod calculix;
mod case;
mod curve;
mod kept;
mod ours;
mod page;
mod reference;
mod rows;
mod sample;
mod wrench;

use std::path::Path;

use case::{Case, Shaped, Site};
use curve::{Curve, DEPTHS_MM};
use ours::{Law, Rig};
use wrench::{Wrench, force_errors, force_rms_pct, line_rms_mm, torque_rms_pct};

pub(crate) use calculix::run as run_calculix;
pub(crate) use page::{chart, section};
pub(crate) use reference::Meshes;
pub(crate) use rows::{csv, depth_csv, motion, steps_csv};
pub(crate) use sample::Sample;
pub(crate) use wrench::TOUCHES_N;

/// Finds each case's reference in `folder` or in the repository, or solves it and keeps it in
/// `folder`. Without `kept`, a stored reference is used only if the current version of the mesher
/// made its meshes.
///
/// # Errors
/// When the folder cannot be made, in words.
fn references(
    cases: &[Case],
    folder: &Path,
    meshes: Meshes,
    kept: bool,
) -> Result<Vec<Result<Curve, String>>, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let find = |(i, case): (usize, &Case)| {
        eprintln!("reference {} of {}: {}", i + 1, cases.len(), case.name());
        reference::curve(case, folder, meshes, kept)
    };
    Ok(cases.iter().enumerate().map(find).collect())
}

/// Results of one law in one case.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// The case.
    pub(crate) case: Case,
    /// The contact law.
    pub(crate) law: Law,
    /// Number of the organ's spheres.
    pub(crate) spheres: usize,
    /// Force and torque at the first depths of [`DEPTHS_MM`].
    pub(crate) felt: Vec<Wrench>,
    /// The tool's port as seen from the site, in the axes of [`Wrench`], m.
    port_m: nalgebra::Vector3<f64>,
    /// Force and torque of the finite elements.
    pub(crate) reference: Curve,
}

impl Row {
    /// Root mean square and largest error of the force over the depths, %.
    pub(crate) fn error_pct(&self) -> [f64; 2] {
        let truth = &self.reference.fine;
        let errors = force_errors(&self.felt, truth).map(|e| e.abs() * 100.0);
        let most = errors.fold(0.0, f64::max);
        [force_rms_pct(&self.felt, truth), most]
    }

    /// Root mean square error of the torque over the depths at which it is known and large enough,
    /// %.
    pub(crate) fn torque_error_pct(&self) -> Option<f64> {
        torque_rms_pct(&self.felt, &self.reference.fine)
    }

    /// Root mean square distance of the force's line of action from the reference's, mm.
    pub(crate) fn line_off_mm(&self) -> Option<f64> {
        line_rms_mm(&self.felt, &self.reference.fine, &self.port_m)
    }

    /// True if the result is independent: its site was not used to choose a constant, and its
    /// reference can be trusted.
    pub(crate) fn counts(&self) -> bool {
        !self.case.site.seen && self.reference.doubt_pct() <= DOUBT_MAX_PCT
    }
}

/// Just noticeable difference of force, %.
pub(crate) const GOAL_PCT: f64 = 7.0;
/// A reference is not used for conclusions if the forces on its two meshes differ by more than
/// this, %.
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
    /// The references as [`kept::csv`] writes them.
    pub(crate) references: String,
}

/// Solves the references that are neither in `out` nor in the repository, for the cases whose names
/// contain `only`.
///
/// # Errors
/// The reason in words.
pub(crate) fn solve(out: &Path, meshes: Meshes, only: &str) -> Result<(), String> {
    let mut cases = Case::all();
    cases.retain(|case| case.name().contains(only));
    for found in references(&cases, &out.join("reference"), meshes, false)? {
        if let Err(why) = found {
            eprintln!("  no reference: {why}");
        }
    }
    Ok(())
}

/// Measures all cases whose names contain `only`. References of the current mesher are taken from
/// `out` or from the repository; all others are solved. With `kept` none is solved: cases without a
/// stored reference are left out, and references of older meshers are used too.
///
/// # Errors
/// The reason in words.
pub(crate) fn run(out: &Path, quick: bool, only: &str, kept: bool) -> Result<Measured, String> {
    let mut cases = Case::all();
    let folder = out.join("reference");
    cases.retain(|case| {
        case.name().contains(only) && (!kept || kept::found(case, &folder, quick).is_some())
    });
    let meshes = if quick { Meshes::Quick } else { Meshes::Fine };
    let curves = references(&cases, &folder, meshes, kept)?;
    let known = cases.iter().zip(&curves);
    let known = known.filter_map(|(case, curve)| Some((case, curve.as_ref().ok()?)));
    let references = kept::csv(known);
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
                    Ok(curve) if !curve.fine.is_empty() => curve,
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
                        felt: rig.press(&placed, law, curve.fine.len())?,
                        port_m: placed.port_from_site_m(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use case::Placed;
    use scene_prepare::mesh::Mesh;

    /// The case with this name, its surface and its placed tool.
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
            let felt = rig.press(&placed, law, 6).expect("pressed");
            [(1, 0.055), (3, 0.144), (5, 0.249)]
                .map(|(i, r): (usize, f64)| felt[i].out_n() / r - 1.0)
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
            let felt = rig.press(&placed, Law::Ours, 3).expect("pressed");
            let off = felt[2].out_n() / 0.0682 - 1.0;
            assert!(off.abs() < 0.07, "{spheres}: {off}");
        }
    }
}
