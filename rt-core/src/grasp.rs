//! Jaws that hold: spheres within their reach move with the instrument until it lets go.

use heapless::Vec;

use crate::capacity::MAX_GRASPED;
use crate::collision::cylinder::meets;
use crate::fault::{Fault, FaultSet};
use crate::force::Pull;
use crate::math::{self, Pose, Vec3};
use crate::scene::Scene;
use crate::soft_body::{Bodies, inverse_mass_per_kg};
use crate::state::SphereBits;

/// Spheres that come this near to the middle of the jaws are between them, m. Inner spheres lie
/// up to some mm under the skin that the trainee sees.
const REACH_M: f32 = 0.005;

/// A sphere in the jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    sphere: u32,
    /// Its centre in the instrument's frame, m.
    in_instrument_m: Vec3,
}

/// What the jaws hold.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grasp {
    held: Vec<Held, MAX_GRASPED>,
}

impl Grasp {
    pub(crate) fn count(&self) -> u32 {
        self.held.len() as u32
    }

    /// The spheres held.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = u32> {
        self.held.iter().map(|held| held.sphere)
    }

    /// Closes on every movable sphere near the line from the jaw joint to the tip.
    pub(crate) fn close(
        &mut self,
        world_from_instrument: &Pose,
        tip_m: &Vec3,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        faults: &mut FaultSet,
    ) {
        let joint_m = world_from_instrument.translation.vector;
        for i in 0..scene.spheres.len() as u32 {
            let radius_m = *bodies.radius_m.at(i);
            let node = bodies.nodes.at_mut(i);
            let center = node.center_m();
            let is_between = meets(&center, radius_m, &joint_m, tip_m, REACH_M);
            if !is_between || node.inverse_mass_per_kg() <= 0.0 {
                continue;
            }
            let in_instrument_m = world_from_instrument.rotation.inverse() * (center - joint_m);
            if self
                .held
                .push(Held {
                    sphere: i,
                    in_instrument_m,
                })
                .is_err()
            {
                faults.raise(Fault::GraspOverflow);
                return;
            }
            node.set_inverse_mass_per_kg(0.0);
            let bits = bodies.bits.at_mut(i);
            *bits = bits.with(SphereBits::GRASPED);
        }
    }

    /// Lets go of everything.
    pub(crate) fn open(&mut self, scene: &Scene<'_>, bodies: &mut Bodies) {
        for held in &self.held {
            if let Some(rest) = scene.spheres.get(held.sphere as usize) {
                bodies
                    .nodes
                    .at_mut(held.sphere)
                    .set_inverse_mass_per_kg(inverse_mass_per_kg(rest));
                let bits = bodies.bits.at_mut(held.sphere);
                *bits = bits.without(SphereBits::GRASPED);
            }
        }
        self.held.clear();
    }

    /// Puts the held spheres where the instrument has carried them; immovable for the solver.
    pub(crate) fn carry(&self, world_from_instrument: &Pose, bodies: &mut Bodies) {
        for held in &self.held {
            let node = bodies.nodes.at_mut(held.sphere);
            let center = world_from_instrument.rotation * held.in_instrument_m
                + world_from_instrument.translation.vector;
            node.move_to(&(center - node.rest_m()));
        }
    }

    /// How the rest of the tissue pulls: one spring of the organ's contact stiffness, stretched
    /// by the mean stretch of the links that leave the jaws (Hooke, as for contact; the paper
    /// gives no law for grasping). `None` when nothing is held.
    pub(crate) fn pull(&self, scene: &Scene<'_>, bodies: &Bodies) -> Option<Pull> {
        let first = self.held.first()?;
        let stiffness_n_m = scene
            .material_of(*bodies.organ.at(first.sphere))
            .contact_stiffness_n_m;
        let (mut stretch_m, mut center_m, mut links) = (Vec3::zeros(), Vec3::zeros(), 0u32);
        for held in &self.held {
            let node = bodies.nodes.at(held.sphere);
            center_m += node.center_m();
            for &linked in bodies.adjacency.of(held.sphere) {
                let linked = u32::from(linked);
                if bodies.bits.at(linked).contains(SphereBits::GRASPED) {
                    continue;
                }
                let other = bodies.nodes.at(linked);
                let now = other.from(node).vec3();
                let rest_length_m = math::norm(&(other.rest_m() - node.rest_m()));
                if let Some(direction) = math::unit(&now) {
                    stretch_m += direction * (math::norm(&now) - rest_length_m);
                }
                links += 1;
            }
        }
        Some(Pull {
            at_m: center_m / self.held.len() as f32,
            force_n: stretch_m * (stiffness_n_m / links.max(1) as f32),
            stiffness_n_m,
        })
    }
}
