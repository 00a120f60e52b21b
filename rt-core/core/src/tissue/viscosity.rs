//! Viscosity: the strain of each constraint right after its own projection in the last substep.
//!
//! A constraint resists the change of its strain from one of its projections to the next, which lie
//! one substep apart. At rest nothing changes, so viscosity vanishes. A rate that compares with the
//! start of the substep would not vanish: within a pass, the constraints that come first move what
//! later ones move back, and an organ of 2.6 ms retardation would sag by 4 % too much.

use crate::capacity::{MAX_BATCHES, MAX_LINKS};
use crate::math;
use crate::scene::{LANES, Organ, Scene};

/// Strains of a batch of tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchStrain {
    /// Determinant of the deformation.
    pub(crate) volume: [f32; LANES],
    /// Frobenius norm of the deformation.
    pub(crate) shape: [f32; LANES],
}

impl BatchStrain {
    /// No deformation.
    pub(crate) const REST: Self = Self {
        volume: [1.0; LANES],
        shape: [1.732_050_8; LANES],
    };
}

/// Strains of all tetrahedra and links after their last projection.
#[derive(Debug, Clone)]
pub(crate) struct LastStrains {
    batches: [BatchStrain; MAX_BATCHES],
    /// Length of each link, m.
    links_m: [f32; MAX_LINKS],
}

impl LastStrains {
    pub(crate) const REST: Self = Self {
        batches: [BatchStrain::REST; MAX_BATCHES],
        links_m: [0.0; MAX_LINKS],
    };

    /// Puts every constraint of an organ to its strain at rest. A strain that is not a number would
    /// otherwise make that of every later substep none.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>, organ: &Organ) {
        self.batches_of(organ).fill(BatchStrain::REST);
        let at_m = |sphere: u32| scene.spheres.get(sphere as usize).map(|it| it.center_m);
        let links = scene.elastic_links_of(organ);
        for (length_m, link) in self.links_of(organ).iter_mut().zip(links) {
            *length_m = match (at_m(link.a), at_m(link.b)) {
                (Some(a_m), Some(b_m)) => math::norm(&(a_m - b_m)),
                _ => 0.0,
            };
        }
    }

    /// Strains of an organ's batches.
    pub(crate) fn batches_of(&mut self, organ: &Organ) -> &mut [BatchStrain] {
        range(&mut self.batches, organ.batch_start, organ.batch_count)
    }

    /// Lengths of an organ's elastic links, m.
    pub(crate) fn links_of(&mut self, organ: &Organ) -> &mut [f32] {
        range(&mut self.links_m, organ.link_start, organ.elastic_links)
    }
}

fn range<T>(all: &mut [T], start: u32, count: u32) -> &mut [T] {
    let (start, count) = (start as usize, count as usize);
    all.get_mut(start..start.saturating_add(count))
        .unwrap_or(&mut [])
}
