//! A place of the tissue: which spheres carry it, and push back when it is pushed.

use heapless::Vec;

use crate::math::Vec3;
use crate::soft_body::Bodies;

/// Spheres that a place follows, at most: those of three vertices of a skin, or what lies under
/// a tip that is wider than the spheres are apart. What is more goes to the first.
const PATCH_MAX: usize = 96;

/// A place of the tissue that spheres carry, each once; the weights sum to 1.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patch {
    parts: Vec<(u16, f32), PATCH_MAX>,
}

impl Patch {
    /// Lets it follow a sphere by this much more.
    pub(crate) fn add(&mut self, sphere: u32, weight: f32) {
        let sphere = sphere as u16; // sphere indices fit: asserted in `capacity`
        if weight == 0.0 {
            return;
        }
        match self.parts.iter_mut().find(|(own, _)| *own == sphere) {
            Some((_, sum)) => *sum += weight,
            None => {
                if self.parts.push((sphere, weight)).is_err()
                    && let Some((_, sum)) = self.parts.first_mut()
                {
                    *sum += weight;
                }
            }
        }
    }

    /// Its spheres and their weights.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (u32, f32)> {
        self.parts
            .iter()
            .map(|(sphere, weight)| (u32::from(*sphere), *weight))
    }

    /// Where it is, world frame, m.
    pub(crate) fn at_m(&self, bodies: &Bodies) -> Vec3 {
        let mut at = Vec3::zeros();
        for (sphere, weight) in self.parts() {
            at += bodies.nodes.at(sphere).center_m() * weight;
        }
        at
    }

    /// `Σ w ω²`: how fast it goes under a force, 1/kg.
    pub(crate) fn inverse_mass_per_kg(&self, bodies: &Bodies) -> f32 {
        let yields = |(sphere, weight): (u32, f32)| {
            bodies.nodes.at(sphere).inverse_mass_per_kg() * weight * weight
        };
        self.parts().map(yields).sum()
    }

    /// Pushes it: an impulse times the step, kg m.
    pub(crate) fn push(&self, push_kg_m: &Vec3, bodies: &mut Bodies) {
        for (sphere, weight) in &self.parts {
            let node = bodies.nodes.at_mut(u32::from(*sphere));
            let step_m = push_kg_m * (node.inverse_mass_per_kg() * weight);
            node.move_by(&step_m);
        }
    }
}
