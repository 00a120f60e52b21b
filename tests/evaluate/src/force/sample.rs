//! Presses of Calot's contact at a few sites, kept ready to be repeated.

use super::case::{Case, Placed, Shaped, Site};
use super::curve::Curve;
use super::ours::{Law, Rig};
use super::wrench::force_rms_pct;
use super::{GOAL_PCT, kept};

/// Spheres of each body.
const SPHERES: usize = 581;
/// Sites of the presses.
const SITES: [&str; 4] = ["left lobe", "free lobe", "body", "neck"];
/// Speed of the slides in which the force's steps are found, m/s.
const SLIDE_M_S: f64 = 0.02;

/// A tool at a site, and its reference.
type Press = (Case, Placed, Curve);

/// Bodies, and the tools that press on them.
pub(crate) struct Sample {
    sites: Vec<(Rig, Vec<Press>)>,
}

/// Result of all presses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pressed {
    /// Number of presses whose force is within the goal.
    pub(crate) within: usize,
    /// Mean error of the force over the presses, rms %.
    pub(crate) rms_pct: f64,
    /// Largest step of the force in a slow press or slide, N.
    pub(crate) step_n: f64,
}

impl Sample {
    /// Packs the bodies.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn new() -> Result<Self, String> {
        let mut sites: Vec<(Site, Rig, Vec<Press>)> = Vec::new();
        let here = std::path::Path::new("");
        for case in Case::all() {
            let Some(curve) = kept::found(&case, here, false) else {
                continue;
            };
            if !SITES.contains(&case.site.name) {
                continue;
            }
            let surface = case.site.subject.mesh()?;
            let pressed = (case, case.placed(&surface)?, curve);
            match sites.iter_mut().find(|(site, ..)| site.is(&case.site)) {
                Some((_, _, presses)) => presses.push(pressed),
                None => {
                    let rig = Rig::new(&surface, SPHERES, &case.site)?;
                    sites.push((case.site, rig, vec![pressed]));
                }
            }
        }
        let sites = sites.into_iter().map(|(_, rig, presses)| (rig, presses));
        Ok(Self {
            sites: sites.collect(),
        })
    }

    /// Presses with every tool at every site.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn press(&mut self) -> Result<Pressed, String> {
        let (mut errors, mut step_n) = (Vec::new(), 0.0_f64);
        for (rig, presses) in &mut self.sites {
            for (case, placed, curve) in presses {
                let felt = rig.press(placed, Law::Ours, curve.fine.len())?;
                errors.push(force_rms_pct(&felt, &curve.fine));
                if case.tool == Shaped::Tip(5.0) {
                    step_n = step_n.max(rig.largest_step_n(placed, None)?);
                    step_n = step_n.max(rig.largest_step_n(placed, Some(SLIDE_M_S))?);
                }
            }
        }
        Ok(Pressed {
            within: errors.iter().filter(|it| **it <= GOAL_PCT).count(),
            rms_pct: errors.iter().sum::<f64>() / errors.len() as f64,
            step_n,
        })
    }
}
