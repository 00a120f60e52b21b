//! Viscosity: the strain of each constraint right after its own projection in the last substep.
//!
//! A constraint resists the change of its strain from one of its projections to the next, which lie
//! one substep apart. At rest nothing changes, so viscosity vanishes. A rate that compares with the
//! start of the substep would not vanish: within a pass, the constraints that come first move what
//! later ones move back, and an organ of 2.6 ms retardation would sag by 4 % too much.

use crate::capacity::{MAX_BATCHES, MAX_LINKS};
use crate::math;
use crate::scene::{LANES, Organ, Scene};
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;

/// Share of the impulses with which the next substep begins.
pub(crate) const KEPT: f32 = 0.999;

/// Strains of a batch of tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchMemory {
    /// Determinant of the deformation.
    pub(crate) volume: [f32; LANES],
    /// Frobenius norm of the deformation.
    pub(crate) shape: [f32; LANES],
    /// Impulses over dt on the corners 1 to 3, m kg. Corner 0 gets minus the sum.
    pub(crate) impulses: [[[f32; LANES]; 3]; 3],
}

impl BatchMemory {
    /// No deformation.
    pub(crate) const REST: Self = Self {
        volume: [1.0; LANES],
        shape: [1.732_050_8; LANES],
        impulses: [[[0.0; LANES]; 3]; 3],
    };
}

/// Memory of a link.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinkMemory {
    /// Length after its last projection, m.
    pub(crate) length_m: f32,
    /// Impulse over dt on its first end, m kg.
    pub(crate) push: Lanes,
}

/// Strains of all tetrahedra and links after their last projection.
#[derive(Debug, Clone)]
pub(crate) struct WarmStart {
    batches: [BatchMemory; MAX_BATCHES],
    links: [LinkMemory; MAX_LINKS],
    /// Sum of all impulses on each sphere, over dt, as a displacement, m.
    pub(crate) moved_m: PerSphere<Lanes>,
}

impl WarmStart {
    pub(crate) const REST: Self = Self {
        batches: [BatchMemory::REST; MAX_BATCHES],
        links: [LinkMemory { length_m: 0.0, push: Lanes::ZERO }; MAX_LINKS],
        moved_m: PerSphere::new(Lanes::ZERO),
    };

    /// Puts every constraint to its strain at rest.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>) {
        self.batches.fill(BatchMemory::REST);
        let at_m = |sphere: u32| scene.spheres.get(sphere as usize).map(|it| it.center_m);
        self.moved_m = PerSphere::new(Lanes::ZERO);
        for (memory, link) in self.links.iter_mut().zip(scene.links) {
            memory.push = Lanes::ZERO;
            memory.length_m = match (at_m(link.a), at_m(link.b)) {
                (Some(a_m), Some(b_m)) => math::norm(&(a_m - b_m)),
                _ => 0.0,
            };
        }
    }

    /// Strains of an organ's batches.
    pub(crate) fn batches_of(&mut self, organ: &Organ) -> &mut [BatchMemory] {
        range(&mut self.batches, organ.batch_start, organ.batch_count)
    }

    /// Lengths of an organ's elastic links, m.
    pub(crate) fn links_of(&mut self, organ: &Organ) -> &mut [LinkMemory] {
        range(&mut self.links, organ.link_start, organ.elastic_links)
    }
}

impl WarmStart {
    /// Forgets the impulses of an organ.
    pub(crate) fn forget(&mut self, organ: &Organ) {
        for batch in self.batches_of(organ) {
            batch.impulses = [[[0.0; LANES]; 3]; 3];
        }
        for link in self.links_of(organ) {
            link.push = Lanes::ZERO;
        }
        self.moved_m
            .range_mut(organ.sphere_start, organ.sphere_count)
            .fill(Lanes::ZERO);
    }
}

fn range<T>(all: &mut [T], start: u32, count: u32) -> &mut [T] {
    let (start, count) = (start as usize, count as usize);
    all.get_mut(start..start.saturating_add(count))
        .unwrap_or(&mut [])
}
