//! The paper's solver: stretching and Laplacian coordinates, a fixed number of iterations.

use core::ops::Add;

use crate::math;
use crate::scene::{Organ, Scene};
use crate::soft_body::lanes::Lanes;
use crate::soft_body::laplacian::laplacian;
use crate::soft_body::stretch::stretch;
use crate::soft_body::{Bodies, Solver};

/// Position-based dynamics as in the paper (Eq. 3–8).
///
/// In each iteration all links in the scene's order, then all spheres in theirs, each seeing
/// what the ones before did (Gauss–Seidel). Preparation orders the links so that neighbours in
/// the list share no sphere: the processor can then work on several at a time.
/// O(iterations · links).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PaperPbd {
    /// Iterations in a tick. The paper's stiffness grows with it: its known fault.
    pub iterations: u32,
}

impl Solver for PaperPbd {
    fn project(&self, scene: &Scene<'_>, organ: &Organ, bodies: &mut Bodies) {
        for _ in 0..self.iterations {
            project_stretch(scene, organ, bodies);
            project_laplacian(organ, bodies);
        }
    }
}

fn project_stretch(scene: &Scene<'_>, organ: &Organ, bodies: &mut Bodies) {
    let stiffness = organ.material.stretch_stiffness;
    let nodes = &mut bodies.nodes;
    for link in scene.links_of(organ) {
        let (a, b) = (*nodes.at(link.a), *nodes.at(link.b));
        let (wa, wb) = (a.inverse_mass_per_kg(), b.inverse_mass_per_kg());
        let difference = a.from(&b);
        let length = math::sqrt(difference.norm_squared());
        let step = difference.scaled(stretch(length, wa + wb, link.rest_length_m, stiffness));
        nodes.at_mut(link.a).moved_m = a.moved_m - step * Lanes::splat(wa);
        nodes.at_mut(link.b).moved_m = b.moved_m + step * Lanes::splat(wb);
    }
}

fn project_laplacian(organ: &Organ, bodies: &mut Bodies) {
    let stiffness = organ.material.laplacian_stiffness;
    if stiffness <= 0.0 {
        return;
    }
    let nodes = &mut bodies.nodes;
    for i in organ.sphere_start..organ.sphere_start.saturating_add(organ.sphere_count) {
        let own = *nodes.at(i);
        if own.inverse_mass_per_kg() <= 0.0 {
            continue;
        }
        let linked = bodies.adjacency.of(i);
        let moved = |&n: &u16| nodes.at(u32::from(n)).moved_m;
        let sum = linked.iter().map(moved).fold(Lanes::ZERO, Lanes::add);
        let step = laplacian(own.moved_m, sum, linked.len(), stiffness);
        nodes.at_mut(i).moved_m = own.moved_m + step;
    }
}
