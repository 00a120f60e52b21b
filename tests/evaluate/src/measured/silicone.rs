//! Cylinders of silicone between plates, pressed by Calot's solver.

use fem_reference::Material;

use super::plates::{Ends, Pressed, Setting, press};
use super::published::{SILICONES, STRAINS_PCT, Silicone};
use super::specimen::Cylinder;
use super::{Bar, Row, work};
use crate::body::{Body, Tissue};

/// Publication of the silicones.
const SOURCE: &str = "Dawood 2026, github.com/abubakardawood/tissue-phantom-material-database";
/// The published specimen.
pub(super) const SPECIMEN: Cylinder = Cylinder {
    radius_m: 0.025,
    height_m: 0.030,
};
/// Strain at which the modulus is fitted, and its index in [`STRAINS_PCT`].
pub(super) const FITTED_PCT: f64 = 10.0;
const FITTED: usize = 1;
/// Density of silicone, kg/m³. It has no effect on forces at rest.
const DENSITY_KG_M3: f64 = 1070.0;
/// Relative difference of the force at which the fit ends.
const FIT_SHARE: f64 = 0.003;

/// A specimen pressed by the solver.
#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) silicone: &'static Silicone,
    pub(super) spheres: usize,
    pub(super) ends: Ends,
    pub(super) setting: Setting,
    /// Young's modulus that gives the published force at [`FITTED_PCT`], Pa.
    pub(super) young_pa: f64,
    pub(super) pressed: Vec<Pressed>,
}

impl Run {
    /// Difference of the force from the published one at each strain, per cent.
    pub(super) fn errors_pct(&self) -> impl Iterator<Item = f64> + '_ {
        let both = self.pressed.iter().zip(&self.silicone.force_n);
        both.map(|(pressed, published)| (pressed.force_n / published[0] - 1.0) * 100.0)
    }

    /// Difference of the closed form of Calot's law from the published forces, per cent. The ends
    /// are free, and the modulus is fitted at [`FITTED_PCT`].
    pub(super) fn law_errors_pct(&self) -> Result<Vec<f64>, String> {
        let law = Material::new(1.0, 0.45, DENSITY_KG_M3).map_err(|e| e.to_string())?;
        let stress = |pct: f64| -law.uniaxial(1.0 - pct / 100.0).1;
        let scale = self.silicone.force_n[FITTED][0] / stress(FITTED_PCT);
        let both = STRAINS_PCT.iter().zip(&self.silicone.force_n);
        Ok(both
            .map(|(pct, published)| (stress(*pct) * scale / published[0] - 1.0) * 100.0)
            .collect())
    }
}

/// The runs, and their rows.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) rows: Vec<Row>,
    /// Runs with the product's settings.
    pub(super) runs: Vec<Run>,
    /// Runs with other settings of the solver, to find the cause of a difference.
    pub(super) causes: Vec<Run>,
}

#[derive(Clone, Copy)]
struct Job<'a> {
    silicone: &'static Silicone,
    spheres: usize,
    body: &'a Body,
    ends: Ends,
    setting: Setting,
}

/// Presses all silicones, or only the one with this name.
///
/// # Errors
/// Calot's message if it refuses a specimen.
pub(super) fn run(quick: bool, named: Option<&str>) -> Result<Found, String> {
    let (count, sizes): (_, &[usize]) = match quick {
        true => (1, &[250]),
        false => (SILICONES.len(), &[250, 581, 2500]),
    };
    let silicones = SILICONES
        .iter()
        .filter(|it| named.is_none_or(|name| it.name == name))
        .take(count);
    let prepare = |spheres: &usize| SPECIMEN.body(*spheres, material(6000.0));
    let bodies = work::all(sizes, prepare)?;
    let mut jobs = Vec::new();
    for silicone in silicones {
        for (spheres, body) in sizes.iter().zip(&bodies) {
            jobs.extend(Ends::ALL.map(|ends| Job {
                silicone,
                spheres: *spheres,
                body,
                ends,
                setting: Setting::SHIPPED,
            }));
        }
    }
    let shipped = jobs.len();
    if !quick {
        jobs.extend(causes(&jobs));
    }
    let mut runs = work::all(&jobs, measure)?;
    let causes = runs.split_off(shipped);
    Ok(Found {
        rows: runs.iter().flat_map(rows).collect(),
        runs,
        causes,
    })
}

/// Jobs that separate the influences of the solver: without viscosity, and with finer substeps.
fn causes<'a>(shipped: &[Job<'a>]) -> Vec<Job<'a>> {
    let settings = [(1, false), (4, true), (4, false)];
    let soft = shipped
        .iter()
        .filter(|job| job.silicone.name == shipped[0].silicone.name && job.ends == Ends::Free);
    soft.flat_map(|job| {
        settings.map(|(finer, is_viscous)| Job {
            setting: Setting { finer, is_viscous },
            ..*job
        })
    })
    .collect()
}

fn material(young_pa: f64) -> Tissue {
    Tissue {
        young_pa,
        poisson: 0.45,
        density_kg_m3: DENSITY_KG_M3,
    }
}

fn measure(job: &Job<'_>) -> Result<Run, String> {
    let depth_m = |pct: &f64| pct / 100.0 * SPECIMEN.height_m;
    let wanted_n = job.silicone.force_n[FITTED][0];
    let fit_m: Vec<f64> = STRAINS_PCT[..=FITTED].iter().map(depth_m).collect();
    let mut young_pa = job.silicone.young_pa;
    for _ in 0..5 {
        let pressed = press(job.body, material(young_pa), job.ends, job.setting, &fit_m)?;
        let ratio = wanted_n / pressed[FITTED].force_n;
        if (ratio - 1.0).abs() < FIT_SHARE {
            break;
        }
        young_pa *= ratio;
    }
    let all_m: Vec<f64> = STRAINS_PCT.iter().map(depth_m).collect();
    let pressed = press(job.body, material(young_pa), job.ends, job.setting, &all_m)?;
    let run = Run {
        silicone: job.silicone,
        spheres: job.spheres,
        ends: job.ends,
        setting: job.setting,
        young_pa,
        pressed,
    };
    let errors: Vec<String> = run.errors_pct().map(|e| format!("{e:+.1}")).collect();
    let unsteady = |it: &Pressed| (it.unsteady_n / it.force_n).abs() * 100.0;
    eprintln!(
        "  {:14} {:5} {:11} x{} {} E {:.0} Pa: {} %, unsteady by {:.1} %",
        run.silicone.name,
        run.spheres,
        run.ends.name(),
        run.setting.finer,
        if run.setting.is_viscous {
            "viscous"
        } else {
            "inviscid"
        },
        run.young_pa,
        errors.join(" "),
        run.pressed.iter().map(unsteady).fold(0.0, f64::max)
    );
    Ok(run)
}

fn rows(run: &Run) -> Vec<Row> {
    let all = STRAINS_PCT.iter().zip(&run.silicone.force_n);
    all.zip(&run.pressed)
        .map(|((pct, [mean, sd]), pressed)| Row {
            source: SOURCE.to_owned(),
            quantity: "force between plates, N".to_owned(),
            condition: format!(
                "{}, {pct} % strain, {}, {} spheres",
                run.silicone.name,
                run.ends.name(),
                run.spheres
            ),
            published: *mean,
            published_sd: Some(*sd),
            calot: Some(pressed.force_n),
            bar: Bar::Percent,
        })
        .collect()
}
