//! Tissue as a neo-Hookean solid over the tetrahedra between sphere centres.
//!
//! The constraints follow from Young's modulus and Poisson's ratio. At rest the stress is that of
//! the energy, with any number of substeps.

mod kernel;
mod wide;

use kernel::Moduli;

use crate::tissue::relaxation;

use crate::scene::{Material, Organ, Scene};
use crate::tissue::links;
use crate::tissue::warm_start::{self, Limits};
use crate::tissue::{Bodies, Solver};

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
            warm_start: memory_of,
            organ: organs,
            ..
        } = bodies;
        let limits = memory_of.limits(*organs.at(organ.sphere_start));
        let memory = memory_of.of(organ);
        let batches = scene.batches_of(organ);
        if let (false, Some(moduli)) = (batches.is_empty(), moduli(&organ.material, step_s, limits))
        {
            let relaxation = &organ.material.relaxation;
            if relaxation.acts() {
                relaxation::apply(nodes, organ, memory.lost);
            }
            warm_start::begin(nodes, organ, limits.kept_share, memory.spheres);
            kernel::project(nodes, batches, memory.batches, &moduli);
            warm_start::end(nodes, organ, limits.kept_share, memory.spheres);
            if relaxation.acts() {
                relaxation::follow(relaxation, step_s, memory.spheres, memory.lost);
            }
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

/// Weight of the strain rate relative to the strain: retardation time divided by dt, at most
/// `Limits::rate_max`.
pub(crate) fn rate(material: &Material, step_s: f32, limits: Limits) -> f32 {
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
