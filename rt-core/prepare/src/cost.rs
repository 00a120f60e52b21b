//! Time of a scene's tick in the realtime process, predicted from the scene's counts.
//!
//! The prices of the tissue's step (µs per unit of work) come from
//! `cargo run --release -p scene-prepare --example organ_cost`. It steps prepared scenes with every
//! organ awake and prints prediction and measurement. The prices are older than the warm start of
//! tissue and than the price of ties, and must be measured again: until then, the accuracy of
//! predictions is unknown. Organs have similar numbers of tetrahedra per sphere, so the
//! measurements determine the sum of the prices well and each price badly.
//!
//! The price of the other stages comes from `cargo run --release -p rt-core --example stages`: the
//! contact search takes 22 µs for 581 spheres, and 53 µs for 1056 spheres of two organs.
//!
//! Both programs measure with warm caches and without device drivers. This module only helps to
//! choose a reasonable number of spheres. Admission decides whether a scene fits: the realtime
//! process measures the scene with cold caches when it loads it. For a scene predicted at 197 µs,
//! admission measured a worst tick of 262 µs.

use rt_core::tissue::solutions_per_tick;
use shared_mem::scene::{SceneData, WORLD};

/// Machine on which the prices were measured.
pub(crate) const MACHINE: &str = "a virtual Xeon with AVX-512";

/// Price of a sphere in a substep, which predicts and integrates its motion and decides about
/// sleep.
const SPHERE_STEP_US: f64 = 0.0115;
/// Price of a tetrahedron in a substep, with AVX, which solves eight at once.
const TETRA_STEP_US: f64 = 0.0130;
/// Price of a link that carries load in a substep.
const LINK_STEP_US: f64 = 0.0095;
/// Price of one solution of an attachment.
const TIE_STEP_US: f64 = 0.0095;
/// Price of a sphere in the other stages of a tick, such as contact search and publishing.
const SPHERE_TICK_US: f64 = 0.055;
/// Price of a tick without any sphere.
const TICK_US: f64 = 0.5;

/// Amount of work in one tick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Spheres, each once.
    pub spheres: f64,
    /// Spheres times their organ's substeps.
    pub sphere_steps: f64,
    /// Tetrahedra times their organ's substeps.
    pub tetra_steps: f64,
    /// Links that carry load times their organ's substeps.
    pub link_steps: f64,
    /// Attachments times their solutions in a tick.
    pub tie_steps: f64,
}

impl Work {
    /// Time of the stage that solves the tissue, µs.
    #[must_use]
    pub fn solve_us(&self) -> f64 {
        SPHERE_STEP_US * self.sphere_steps
            + TETRA_STEP_US * self.tetra_steps
            + LINK_STEP_US * self.link_steps
            + TIE_STEP_US * self.tie_steps
    }

    /// Time of the whole tick, µs.
    #[must_use]
    pub fn tick_us(&self) -> f64 {
        TICK_US + SPHERE_TICK_US * self.spheres + self.solve_us()
    }
}

/// Counts the work of a tick of this scene while every organ is awake.
#[must_use]
pub fn work(scene: &SceneData) -> Work {
    let mut work = Work::default();
    let mut substeps = vec![1; scene.spheres.len()];
    for organ in &scene.organs {
        let [start, count] = organ.spheres.map(|n| n as usize);
        substeps[start..start + count].fill(organ.substeps);
        let steps = f64::from(organ.substeps);
        work.spheres += f64::from(organ.spheres[1]);
        work.sphere_steps += steps * f64::from(organ.spheres[1]);
        work.tetra_steps += steps * f64::from(organ.tetrahedra[1]);
        work.link_steps += steps * f64::from(organ.elastic_links);
    }
    for tie in &scene.attachments {
        let ends = if tie.b == WORLD {
            [tie.a; 2]
        } else {
            [tie.a, tie.b]
        };
        let ends = ends.map(|end| end as usize);
        let weight_per_kg = ends.map(|end| match &scene.spheres[end] {
            held if held.held != 0 => 0.0,
            free => free.mass_kg.recip(),
        });
        let solutions = solutions_per_tick(
            tie.compliance_m_n,
            weight_per_kg.iter().sum(),
            ends.map(|end| substeps[end]),
        );
        work.tie_steps += f64::from(solutions);
    }
    work
}
