//! Relaxation: tissue that is held loses a part of its stress (quasi-linear viscoelasticity with
//! two Prony terms, Fung 1993).
//!
//! A material may ask for shares `gᵢ` and times `τᵢ`. Tissue that is strained at once and then held
//! pushes back with `G(t) = 1 − Σ gᵢ (1 − exp(−t / τᵢ))` of its first force. Young's modulus is that
//! of a fast strain; after long times `1 − Σ gᵢ` of it is left. Poisson's ratio does not relax.
//!
//! All stresses relax by one law, so the elastic force on each sphere tells enough. For each term a
//! sphere has the force that it has lost, `rᵢ`:
//!
//! ```text
//! drᵢ/dt = (gᵢ f − rᵢ) / τᵢ        f: force of the tetrahedra; f − Σ rᵢ acts
//! ```
//!
//! For small strains this is exact, with any shape and load. The sums of all `rᵢ` of an organ vanish
//! as those of `f` do, so an organ does not push itself. The lost forces keep their direction when
//! an organ turns, so tissue that turns much within `τᵢ` has a torque left over until it has relaxed.
//!
//! The tetrahedra do not know of it: the lost forces act like a weight. So an organ that does not
//! ask costs nothing, and computes the same bits. An organ that asks costs two vectors a sphere.
//! The dent under a tool relaxes by the same law (`contact::constraint`). Tubes do not relax.

use crate::scene::{Organ, Relaxation};
use crate::tissue::Node;
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::warm_start::SphereMemory;

/// Impulses that a sphere has lost, one for each term, m kg.
pub(crate) type Lost = [Lanes; 2];

/// No impulse.
pub(crate) const NOTHING_LOST: Lost = [Lanes::ZERO; 2];

/// Takes the lost impulses from the prediction of a substep.
pub(crate) fn apply(nodes: &mut PerSphere<Node>, organ: &Organ, lost: &[Lost]) {
    let nodes = nodes.range_mut(organ.sphere_start, organ.sphere_count);
    for (node, [fast, slow]) in nodes.iter_mut().zip(lost) {
        let weight = node.inverse_mass_per_kg();
        node.push((*fast + *slow).scaled(-1.0), weight);
    }
}

/// Lets the lost impulses follow the tetrahedra's impulses of this substep.
pub(crate) fn follow(
    relaxation: &Relaxation,
    step_s: f32,
    spheres: &[SphereMemory],
    lost: &mut [Lost],
) {
    let rates = relaxation.rates(step_s);
    for (lost, sphere) in lost.iter_mut().zip(spheres) {
        for ((lost, share), rate) in lost.iter_mut().zip(relaxation.shares).zip(rates) {
            *lost = *lost + (sphere.elastic.scaled(share) - *lost).scaled(rate);
        }
    }
}
