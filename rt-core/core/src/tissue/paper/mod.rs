//! The paper's solver: stretching and Laplacian coordinates in a fixed number of iterations.

pub mod laplacian;
pub mod stretch;

use core::ops::Add;

use crate::math;
use crate::scene::{Organ, Scene};
use crate::tissue::damage::Damage;
use crate::tissue::lanes::Lanes;
use crate::tissue::paper::laplacian::laplacian;
use crate::tissue::paper::stretch::stretch;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::{Adjacency, Bodies, Solver};

/// Position-based dynamics as in the paper (Eq. 3–8), with its scratch memory of 128 kB. Only a
/// simulation by this method needs it: build it in a `static` or on the heap.
///
/// An iteration visits all links in the scene's order, then all spheres in theirs. Each correction
/// sees the corrections before it (Gauss–Seidel). Preparation orders the links so that neighbours
/// in the list share no sphere where possible, so the processor can work on several at a time.
/// O(iterations · links).
#[derive(Debug, Clone)]
pub struct Paper {
    /// Iterations in a tick. A larger number stiffens the tissue, which is a known fault of the
    /// paper's method.
    iterations: u32,
    /// Copies of the spheres of the organ that is projected.
    spheres: PerSphere<PaperSphere>,
}

impl Paper {
    /// The method with this number of iterations in a tick.
    #[must_use]
    pub const fn new(iterations: u32) -> Self {
        Self {
            iterations,
            spheres: PerSphere::new(PaperSphere::ZERO),
        }
    }
}

/// A sphere's state in this method: half a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
struct PaperSphere {
    /// Centre at rest, world frame, m. Spare lane: inverse mass, 1/kg.
    rest_m: Lanes,
    /// Displacement from rest, m. Spare lane: zero.
    moved_m: Lanes,
}

impl PaperSphere {
    const ZERO: Self = Self {
        rest_m: Lanes::ZERO,
        moved_m: Lanes::ZERO,
    };

    #[inline(always)]
    fn weight(&self) -> f32 {
        self.rest_m.spare()
    }
}

impl Solver for Paper {
    fn project(&mut self, scene: &Scene<'_>, organ: &Organ, _step_s: f32, bodies: &mut Bodies) {
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let spheres = self.spheres.range_mut(start, count).iter_mut();
        for (sphere, node) in spheres.zip(bodies.nodes.range(start, count)) {
            let moved_m = node.moved_m + node.step_m;
            *sphere = PaperSphere {
                rest_m: node.rest_m.with_spare(node.inverse_mass_per_kg()),
                moved_m: moved_m.with_spare(0.0),
            };
        }
        for _ in 0..self.iterations {
            project_stretch(scene, organ, &mut self.spheres, &bodies.damage);
            project_laplacian(organ, &mut self.spheres, &bodies.adjacency);
        }
        let nodes = bodies.nodes.range_mut(start, count).iter_mut();
        for (node, sphere) in nodes.zip(self.spheres.range(start, count)) {
            node.step_m = (sphere.moved_m - node.moved_m).with_spare(0.0);
        }
    }
}

/// Projects the links. A damaged link pulls with its remaining stiffness. The Laplacian still
/// counts the ends of a severed link as neighbours.
fn project_stretch(
    scene: &Scene<'_>,
    organ: &Organ,
    spheres: &mut PerSphere<PaperSphere>,
    damage: &Damage,
) {
    let links = scene.links_of(organ).iter();
    for (link, left) in links.zip(damage.intact_of_links(organ)) {
        let stiffness = organ.material.stretch_stiffness * left;
        let (a, b) = (*spheres.at(link.a), *spheres.at(link.b));
        let (wa, wb) = (a.weight(), b.weight());
        let difference = (a.rest_m - b.rest_m) + (a.moved_m - b.moved_m);
        let length = math::sqrt(difference.norm_squared());
        let step = difference.scaled(stretch(length, wa + wb, link.rest_length_m, stiffness));
        spheres.at_mut(link.a).moved_m = a.moved_m - step * Lanes::splat(wa);
        spheres.at_mut(link.b).moved_m = b.moved_m + step * Lanes::splat(wb);
    }
}

fn project_laplacian(organ: &Organ, spheres: &mut PerSphere<PaperSphere>, adjacency: &Adjacency) {
    let stiffness = organ.material.laplacian_stiffness;
    if stiffness <= 0.0 {
        return;
    }
    for i in organ.sphere_start..organ.sphere_start.saturating_add(organ.sphere_count) {
        let sphere = *spheres.at(i);
        if sphere.weight() <= 0.0 {
            continue;
        }
        let linked = adjacency.of(i);
        let moved = |&n: &u16| spheres.at(u32::from(n)).moved_m;
        let sum = linked.iter().map(moved).fold(Lanes::ZERO, Lanes::add);
        let step = laplacian(sphere.moved_m, sum, linked.len(), stiffness);
        spheres.at_mut(i).moved_m = sphere.moved_m + step;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::Vec3;
    use crate::scene::Link;
    use crate::scene::tests::{organ, room, sphere};
    use crate::tissue::damage::{damage_all, spare_none};
    use std::boxed::Box;

    #[test]
    fn damaged_link_pulls_with_its_intact_share() {
        let spheres = [0.0, 0.02].map(|x| sphere(Vec3::new(x, 0.0, 0.0), 0.005));
        let links = [Link {
            a: 0,
            b: 1,
            rest_length_m: 0.02,
            compliance_m_n: 0.001,
        }];
        let mut organs = [organ(0, 2, 0, 1)];
        organs[0].material.stretch_stiffness = 1.0;
        organs[0].material.laplacian_stiffness = 0.0;
        let scene = Scene::new(&organs, &spheres, &links, room()).unwrap();
        let mut bodies = Box::new(Bodies::new());
        let mut paper = Box::new(Paper::new(1));
        // Amount by which one projection shortens a link that is 4 mm too long, m.
        let mut shortening_m = |damage: f32| {
            bodies.load(&scene);
            bodies.begin(&scene, true);
            damage_all(&scene, &mut bodies, spare_none, |_| (), |_, _| damage);
            bodies.nodes.at_mut(1).move_by(&(Vec3::x() * 0.004));
            paper.project(&scene, &organs[0], 0.001, &mut bodies);
            0.004 - bodies.nodes.at(1).from(bodies.nodes.at(0)).vec3().x + 0.02
        };
        assert!((shortening_m(0.0) - 0.004).abs() < 1.0e-7);
        assert!((shortening_m(0.5) - 0.004 / 3.0).abs() < 1.0e-7);
        assert!(shortening_m(1.0).abs() < 1.0e-7);
    }
}
