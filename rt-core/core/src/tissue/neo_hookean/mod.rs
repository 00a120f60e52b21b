//! Tissue as a neo-Hookean solid over the tetrahedra between sphere centres.
//!
//! The constraints follow from Young's modulus and Poisson's ratio. At rest the stress is that of
//! the energy, with any number of substeps.

mod kernel;
mod wide;

use kernel::Moduli;

use crate::scene::{Material, Organ, Scene};
use crate::tissue::lanes::Lanes;
use crate::tissue::links;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::warm_start::{Limits, SphereMemory};
use crate::tissue::{Bodies, Node, Solver};

/// Largest Poisson's ratio that is used. Linear tetrahedra lock at a larger ratio: at 0.49 they sag
/// a fifth too little. The shape of a hanging liver of ratio 0.49 differs from finite elements by
/// 0.64 mm rms if it is computed with 0.45, and by 2.3 mm if it is computed with 0.49.
pub const POISSON_MAX: f32 = 0.45;

/// Share of Young's modulus that the tetrahedra use. Tetrahedra are stiffer than the solid that
/// they represent, because they are linear, span sphere centres, and carry the tissue up to the
/// skin. Fitted to the sag of one liver (581 spheres) against finite elements (`evaluate`). Every
/// organ, material and resolution uses this number.
pub const STIFFNESS_SHARE: f32 = 0.965;

/// XPBD stable neo-Hookean tetrahedra and elastic links. O(tetrahedra + links).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NeoHookean;

impl Solver for NeoHookean {
    fn project(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies) {
        let Bodies {
            nodes,
            warm_start,
            organ: organs,
            ..
        } = bodies;
        let limits = warm_start.limits(*organs.at(organ.sphere_start));
        let memory = warm_start.of(organ);
        let batches = scene.batches_of(organ);
        if let (false, Some(moduli)) = (batches.is_empty(), moduli(&organ.material, step_s, limits))
        {
            begin(nodes, organ, limits.kept_share, memory.spheres);
            kernel::project(nodes, batches, memory.batches, &moduli);
            end(nodes, organ, limits.kept_share, memory.spheres);
        }
    }

    fn project_links(
        &mut self,
        scene: &Scene<'_>,
        organs: impl Iterator<Item = u8>,
        bodies: &mut Bodies,
    ) {
        links::project(scene, organs, bodies);
    }
}

/// Keeps the prediction in `step_after_tetrahedra_m`, and adds the impulses of the last substep to
/// the steps.
fn begin(nodes: &mut PerSphere<Node>, organ: &Organ, kept_share: f32, memory: &mut [SphereMemory]) {
    let nodes = nodes.range_mut(organ.sphere_start, organ.sphere_count);
    for (node, last) in nodes.iter_mut().zip(memory) {
        let weight = kept_share * node.inverse_mass_per_kg();
        last.step_after_tetrahedra_m = node.step_m;
        node.step_m = node.step_m + (last.elastic + last.outer).scaled(weight);
    }
}

/// Subtracts the outer impulses from the steps, and stores the tetrahedra's impulses of this
/// substep.
fn end(nodes: &mut PerSphere<Node>, organ: &Organ, kept_share: f32, memory: &mut [SphereMemory]) {
    let nodes = nodes.range_mut(organ.sphere_start, organ.sphere_count);
    for (node, last) in nodes.iter_mut().zip(memory) {
        let weight = node.inverse_mass_per_kg();
        node.step_m = node.step_m - last.outer.scaled(kept_share * weight);
        last.elastic = impulse(node.step_m - last.step_after_tetrahedra_m, weight);
        last.step_after_tetrahedra_m = node.step_m;
    }
}

/// Positional impulse, m kg, that moves a sphere of this inverse mass by `step_m`.
pub(crate) fn impulse(step_m: Lanes, weight_per_kg: f32) -> Lanes {
    if weight_per_kg > 0.0 {
        step_m.scaled(weight_per_kg.recip())
    } else {
        Lanes::ZERO
    }
}

/// Weight of the strain rate relative to the strain: retardation time divided by dt, at most
/// `Limits::rate_max`.
fn rate(material: &Material, step_s: f32, limits: Limits) -> f32 {
    (material.retardation_s / step_s).min(limits.rate_max)
}

/// Modulus of a pressure wave, `λ₀ + 2μ`, Pa: the stiffest response of a material.
pub(crate) fn wave_modulus_pa(material: &Material) -> f32 {
    moduli(material, 1.0, Limits::NONE)
        .map_or(0.0, |it| it.shear * (1.0 + it.shear_over_bulk.recip()))
}

/// Stable neo-Hookean moduli (Smith, de Goes and Kim 2018): `λ = λ₀ + μ`, `γ = 1 + μ/λ`. `None` for
/// a material without stiffness.
fn moduli(material: &Material, step_s: f32, limits: Limits) -> Option<Moduli> {
    let poisson = material.poisson.min(POISSON_MAX);
    let mu_pa = STIFFNESS_SHARE * material.young_pa / (2.0 * (1.0 + poisson));
    let lambda_pa = 2.0 * mu_pa * poisson / (1.0 - 2.0 * poisson) + mu_pa;
    (mu_pa > 0.0).then(|| Moduli {
        shear: mu_pa * step_s * step_s,
        shear_over_bulk: mu_pa / lambda_pa,
        rest_volume: 1.0 + mu_pa / lambda_pa,
        rate: rate(material, step_s, limits),
        kept_share: limits.kept_share,
    })
}

#[cfg(test)]
mod tests;
