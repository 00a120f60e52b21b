//! A patch: the weighted spheres that carry a point of the tissue and take its load.

use heapless::Vec;

use crate::math::Vec3;
use crate::tissue::Bodies;
use crate::tissue::lanes::Lanes;

/// Capacity of a patch, in spheres. Three skin vertices need at most 36. A tip of 10 mm on a
/// gallbladder of 2500 spheres needs 115. When a patch is full, the first sphere takes the weight
/// of further spheres.
const SPHERES_MAX: usize = 160;

/// A point of the tissue, carried by weighted spheres. Each sphere is listed once, and the weights
/// sum to 1.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patch {
    spheres: Vec<(u16, f32), SPHERES_MAX>,
}

impl Patch {
    /// Adds a sphere's weight.
    pub(crate) fn add(&mut self, sphere: u32, weight: f32) {
        let sphere = sphere as u16; // sphere indices fit: asserted in `capacity`
        if weight == 0.0 {
            return;
        }
        match self
            .spheres
            .iter_mut()
            .find(|(member, _)| *member == sphere)
        {
            Some((_, sum)) => *sum += weight,
            None => {
                if self.spheres.push((sphere, weight)).is_err()
                    && let Some((_, sum)) = self.spheres.first_mut()
                {
                    *sum += weight;
                }
            }
        }
    }

    /// Spheres of the patch, and their weights.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = (u32, f32)> {
        self.spheres
            .iter()
            .map(|(sphere, weight)| (u32::from(*sphere), *weight))
    }

    /// Position, world frame, m.
    pub(crate) fn at_m(&self, bodies: &Bodies) -> Vec3 {
        let mut at = Lanes::ZERO;
        for (sphere, weight) in self.spheres() {
            at = at + bodies.nodes.at(sphere).center() * Lanes::splat(weight);
        }
        at.vec3()
    }

    /// Inverse mass of the point, 1/kg: `Σ wᵢ² / mᵢ` over spheres of weight `wᵢ` and mass `mᵢ`.
    pub(crate) fn inverse_mass_per_kg(&self, bodies: &Bodies) -> f32 {
        let inverse_mass_share = |(sphere, weight): (u32, f32)| {
            bodies.nodes.at(sphere).inverse_mass_per_kg() * weight * weight
        };
        self.spheres().map(inverse_mass_share).sum()
    }

    /// Reduces the travel of each sphere in this substep by this share times the sphere's weight.
    pub(crate) fn damp(&self, share: f32, bodies: &mut Bodies) {
        for (sphere, weight) in &self.spheres {
            let node = bodies.nodes.at_mut(u32::from(*sphere));
            if node.inverse_mass_per_kg() > 0.0 {
                node.scale_step(1.0 - share * weight);
            }
        }
    }

    /// Applies a positional impulse, kg m. Each sphere moves by `push · w / m`.
    pub(crate) fn push(&self, push_kg_m: &Vec3, bodies: &mut Bodies) {
        for (sphere, weight) in &self.spheres {
            let node = bodies.nodes.at_mut(u32::from(*sphere));
            let step_m = push_kg_m * (node.inverse_mass_per_kg() * weight);
            node.move_by(&step_m);
        }
    }
}

/// Slots of a [`PatchBuilder`]: more than twice as many as a patch can have spheres.
const SLOTS: usize = 512;

/// A patch under construction. A hash table finds its spheres in constant time.
#[derive(Debug)]
pub(crate) struct PatchBuilder {
    pub(crate) patch: Patch,
    /// One more than each sphere's index in the patch; 0 for an empty slot. A sphere whose slot is
    /// taken uses the next free one.
    slots: [u8; SLOTS],
}

impl Default for PatchBuilder {
    fn default() -> Self {
        Self {
            patch: Patch::default(),
            slots: [0; SLOTS],
        }
    }
}

impl PatchBuilder {
    /// As [`Patch::add`].
    #[inline]
    pub(crate) fn add(&mut self, sphere: u16, weight: f32) {
        if weight == 0.0 {
            return;
        }
        let spheres = &mut self.patch.spheres;
        let mut slot = usize::from(sphere);
        for _ in 0..SLOTS {
            let place = &mut self.slots[slot & (SLOTS - 1)];
            if *place == 0 {
                if spheres.push((sphere, weight)).is_ok() {
                    *place = spheres.len() as u8; // `SPHERES_MAX` fits
                } else if let Some((_, sum)) = spheres.first_mut() {
                    *sum += weight;
                }
                return;
            }
            match spheres.get_mut(usize::from(*place) - 1) {
                Some((member, sum)) if *member == sphere => {
                    *sum += weight;
                    return;
                }
                _ => slot += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The builder makes the same patch as `Patch::add`.
        #[test]
        fn patch_builder_makes_the_same_patch_as_patch_add(spheres in prop::collection::vec((0u16..4096, -1.0f32..1.0), 0..300),
                                      few in 1u16..240) {
            let (mut quick, mut plain) = (PatchBuilder::default(), Patch::default());
            for (sphere, weight) in spheres {
                quick.add((sphere % few) * 17, weight);
                plain.add(u32::from((sphere % few) * 17), weight);
            }
            prop_assert_eq!(&quick.patch.spheres, &plain.spheres);
        }
    }
}
