//! Two rigid plates that press a specimen of Calot's tissue.
//!
//! Before the constraints of each substep, a share of the last force acts on the spheres on the
//! plates. After the substep, these spheres are moved to their plate. In the product's tick, a
//! contact acts likewise on the spheres under a tool. The force on a plate is the sum of the forces
//! that move the spheres.

use std::cell::RefCell;

use rt_core::study::{Correction, Tissue as Solved};
use rt_core::time::TICK_S;

use crate::body::{Body, Tissue, V3};
use crate::methods::{Parts, Surroundings};

/// Share of the last force that a plate applies before the constraints of a substep.
const LEAN: f32 = 0.75;
/// Ticks per millimetre of the plates' motion.
const TICKS_PER_MM: f64 = 100.0;
/// Ticks of rest at a depth before the force is measured.
const REST_TICKS: usize = 500;
/// Ticks over which the force is averaged.
const READ_TICKS: usize = 100;

/// Contact of the specimen's ends with the plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    /// They slide without friction.
    Free,
    /// They stick.
    Bonded,
}

impl Ends {
    pub(super) const ALL: [Self; 2] = [Self::Free, Self::Bonded];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Free => "ends free",
            Self::Bonded => "ends bonded",
        }
    }
}

/// Settings of the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Setting {
    /// Factor of the product's number of substeps.
    pub(super) finer: u32,
    /// True: the product's viscosity and damping; false: none but 4/s of damping.
    pub(super) is_viscous: bool,
}

impl Setting {
    /// The product's settings.
    pub(super) const SHIPPED: Self = Self {
        finer: 1,
        is_viscous: true,
    };
}

/// Result of a press to one depth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Pressed {
    /// Force on the upper plate, N.
    pub(super) force_n: f64,
    /// Force on the lower plate, N. In equilibrium both are equal.
    pub(super) below_n: f64,
    /// Largest difference between the upper plate's force in a tick and its mean, N.
    pub(super) unsteady_n: f64,
    /// Smallest determinant of the deformation gradient. Where it is negative, tissue is inverted.
    pub(super) least_volume: f64,
}

/// Presses the specimen to each of these depths in turn, m, and rests there. A negative depth
/// pulls.
///
/// # Errors
/// Calot's message if it refuses the scene.
pub(super) fn press(
    specimen: &Body,
    tissue: Tissue,
    ends: Ends,
    setting: Setting,
    depths_m: &[f64],
) -> Result<Vec<Pressed>, String> {
    let mut body = specimen.clone();
    let density = (tissue.density_kg_m3 / body.tissue.density_kg_m3) as f32;
    body.mass_kg.iter_mut().for_each(|mass| *mass *= density);
    let softer = (body.tissue.young_pa / tissue.young_pa) as f32;
    (body.springs.iter_mut()).for_each(|spring| spring.compliance_m_n *= softer);
    body.tissue = tissue;
    if !body.tets.is_empty() {
        // The solver finds the number of substeps that the product uses for this material.
        body.substeps = 1;
    }
    let on_plate = std::mem::replace(&mut body.supported, vec![false; body.rest_m.len()]);
    let mut parts = Parts::new(&body, &Surroundings::weightless(&tissue), None)
        .map_err(|e| e.to_string())?
        .finer(setting.finer);
    if !setting.is_viscous {
        parts = parts.without_viscosity();
    }
    let plates = RefCell::new(Plates::new(&body, &on_plate, ends));
    let mut solved = parts.bare().map_err(|e| e.to_string())?;
    let mut at_m = 0.0;
    let mut found = Vec::new();
    for depth_m in depths_m {
        let ticks = ((depth_m - at_m).abs() * 1e3 * TICKS_PER_MM)
            .ceil()
            .max(1.0) as usize;
        let from_m = std::mem::replace(&mut at_m, *depth_m);
        for i in 1..=ticks {
            let now_m = from_m + (depth_m - from_m) * i as f64 / ticks as f64;
            tick(&mut solved, &plates, now_m);
        }
        for _ in 0..REST_TICKS {
            tick(&mut solved, &plates, *depth_m);
        }
        let read = || tick(&mut solved, &plates, *depth_m);
        let forces: Vec<[f64; 2]> = std::iter::repeat_with(read).take(READ_TICKS).collect();
        let mean = |side: usize| forces.iter().map(|it| it[side]).sum::<f64>() / READ_TICKS as f64;
        let off = forces.iter().map(|it| (it[1] - mean(1)).abs());
        found.push(Pressed {
            force_n: mean(1),
            below_n: mean(0),
            unsteady_n: off.fold(0.0, f64::max),
            least_volume: least_volume(&body, &solved),
        });
    }
    Ok(found)
}

/// Advances one tick, at the end of which the upper plate is at this depth, m. Returns the forces
/// on the lower and the upper plate, N.
fn tick(solved: &mut Solved<'_>, plates: &RefCell<Plates>, depth_m: f64) -> [f64; 2] {
    plates.borrow_mut().begin(depth_m);
    solved.step_between(
        |tissue, step_s| plates.borrow_mut().lean(tissue, step_s),
        |tissue, step_s| plates.borrow_mut().correct(tissue, step_s),
    );
    plates.borrow().force_n
}

fn least_volume(body: &Body, solved: &Solved<'_>) -> f64 {
    let at = |n: usize| solved.displacement_m(n as u32);
    let volumes = body
        .tets
        .iter()
        .map(|t| Body::gradient(t, at).determinant());
    f64::from(volumes.fold(f32::INFINITY, f32::min))
}

/// A sphere on a plate.
struct Foot {
    sphere: u32,
    rest_m: V3,
    is_upper: bool,
    /// Force of the plate on the sphere in the last substep, N.
    push_n: V3,
}

struct Plates {
    feet: Vec<Foot>,
    ends: Ends,
    /// Depth at the end of the last tick and of this one, m.
    depth_m: [f64; 2],
    /// Substeps of this tick that have begun.
    begun: u32,
    /// Mean over this tick of the force on the lower and the upper plate, N.
    force_n: [f64; 2],
}

impl Plates {
    fn new(body: &Body, on_plate: &[bool], ends: Ends) -> Self {
        let middle_m = body.rest_m.iter().map(|x| x.z).sum::<f32>() / body.rest_m.len() as f32;
        let all = (0_u32..).zip(body.rest_m.iter().zip(on_plate));
        let feet = all.filter(|(_, (_, on))| **on);
        Self {
            feet: feet
                .map(|(sphere, (x, _))| Foot {
                    sphere,
                    rest_m: *x,
                    is_upper: x.z > middle_m,
                    push_n: V3::zeros(),
                })
                .collect(),
            ends,
            depth_m: [0.0; 2],
            begun: 0,
            force_n: [0.0; 2],
        }
    }

    fn begin(&mut self, depth_m: f64) {
        self.depth_m = [self.depth_m[1], depth_m];
        self.begun = 0;
        self.force_n = [0.0; 2];
    }

    fn lean(&mut self, tissue: &mut Correction<'_>, step_s: f32) {
        self.begun += 1;
        for foot in &self.feet {
            let yields = tissue.inverse_mass_per_kg(foot.sphere) * step_s * step_s;
            tissue.move_by(foot.sphere, &(foot.push_n * (LEAN * yields)));
        }
    }

    fn correct(&mut self, tissue: &mut Correction<'_>, step_s: f32) {
        let share = f64::from(step_s / TICK_S) * f64::from(self.begun);
        let [from_m, to_m] = self.depth_m;
        let down_m = (from_m + (to_m - from_m) * share) as f32;
        for foot in &mut self.feet {
            let led_m = if foot.is_upper { -down_m } else { 0.0 };
            let wanted_m = foot.rest_m + V3::new(0.0, 0.0, led_m);
            let mut off_m = wanted_m - tissue.center_m(foot.sphere);
            if self.ends == Ends::Free {
                (off_m.x, off_m.y) = (0.0, 0.0);
            }
            tissue.move_by(foot.sphere, &off_m);
            let yields = tissue.inverse_mass_per_kg(foot.sphere) * step_s * step_s;
            foot.push_n = foot.push_n * LEAN + off_m / yields;
            let up_n = f64::from(foot.push_n.z * step_s / TICK_S);
            self.force_n[usize::from(foot.is_upper)] += if foot.is_upper { -up_n } else { up_n };
        }
    }
}
