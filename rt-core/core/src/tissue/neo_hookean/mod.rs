//! Tissue as a neo-Hookean solid over the tetrahedra between sphere centres.
//!
//! Its constraints follow from Young's modulus, Poisson's ratio and density. Stiffness depends
//! neither on passes nor on the time step while the stiffness number `E dt² / (ρ h²)` of a substep
//! is at most 0.2. Preparation chooses the organ's number of substeps accordingly.

mod kernel;
mod wide;

use kernel::Moduli;

use crate::scene::{Material, Organ, Scene};
use crate::tissue::bar::Bar;
use crate::tissue::{Bodies, Solver};

/// Largest Poisson's ratio that is used. Linear tetrahedra lock beyond it: at 0.49 they sag a fifth
/// too little. A liver of 0.49, computed with 0.45, hangs 0.64 mm rms off finite elements; with
/// 0.49 it is 2.3 mm.
pub const POISSON_MAX: f32 = 0.45;

/// Share of Young's modulus that the tetrahedra use. They resist more than the solid that they
/// represent: they are linear, span sphere centres, and carry the tissue up to the skin. Fitted on
/// one scene, the sag of the liver of 581 spheres against finite elements (`evaluate`), as one
/// number for every organ, material and resolution.
pub const STIFFNESS_SHARE: f32 = 0.965;

/// XPBD stable neo-Hookean tetrahedra and elastic links. O(tetrahedra + links).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NeoHookean;

impl Solver for NeoHookean {
    fn project(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies) {
        let Bodies {
            nodes,
            parted,
            last_strains,
            organ: organs,
            ..
        } = bodies;
        let batches = scene.batches_of(organ);
        if let (false, Some(moduli)) = (batches.is_empty(), moduli(&organ.material, step_s)) {
            kernel::project(nodes, batches, last_strains.batches_of(organ), &moduli);
        }
        let shrunk = parted.shrunk(*organs.at(organ.sphere_start));
        let lefts = parted.left_of_links(organ);
        let links = scene.elastic_links_of(organ).iter().zip(lefts);
        for ((link, left), last_m) in links.zip(last_strains.links_of(organ)) {
            if left > 0.0 {
                let bar = Bar {
                    rest_length_m: link.rest_length_m * shrunk,
                    compliance_m_n: link.compliance_m_n / left,
                    step_s,
                };
                let rate = organ.material.retardation_s / step_s;
                bar.project(nodes, [link.a, link.b], rate, last_m);
            }
        }
    }
}

/// Stable neo-Hookean moduli (Smith, de Goes and Kim 2018): `λ = λ₀ + μ`, `γ = 1 + μ/λ`. `None` for
/// a material without stiffness.
fn moduli(material: &Material, step_s: f32) -> Option<Moduli> {
    let poisson = material.poisson.min(POISSON_MAX);
    let mu_pa = STIFFNESS_SHARE * material.young_pa / (2.0 * (1.0 + poisson));
    let lambda_pa = 2.0 * mu_pa * poisson / (1.0 - 2.0 * poisson) + mu_pa;
    (mu_pa > 0.0).then(|| Moduli {
        hydrostatic: (lambda_pa * step_s * step_s).recip(),
        deviatoric: (mu_pa * step_s * step_s).recip(),
        rest_volume: 1.0 + mu_pa / lambda_pa,
        rate: material.retardation_s / step_s,
    })
}

#[cfg(test)]
mod tests;
