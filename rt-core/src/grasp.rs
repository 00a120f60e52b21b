//! Jaws that hold: spheres within their reach go with the instrument until it lets go.

use heapless::Vec;

use crate::capacity::MAX_GRASPED;
use crate::collision::cylinder::meets;
use crate::fault::{Fault, FaultSet};
use crate::force::Pull;
use crate::math::{Pose, Vec3};
use crate::scene::Scene;
use crate::soft_body::Bodies;
use crate::state::SphereBits;

/// Spheres that come this near to the middle of the jaws are between them, m. Inner spheres lie
/// up to some mm under the skin that the trainee sees.
const REACH_M: f32 = 0.005;

/// Stiffness of the grip on all that is between the jaws together, N/m: below what a Touch-class
/// device can render, so that its limit does not change what is felt.
const GRIP_N_M: f32 = 500.0;

/// A sphere in the jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    sphere: u32,
    /// Its place in the instrument's frame, m.
    in_instrument_m: Vec3,
    /// Where that was at the end of the last tick, world frame, m.
    was_at_m: Vec3,
}

/// What the jaws hold.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grasp {
    held: Vec<Held, MAX_GRASPED>,
    /// What the tissue pulled with in the last tick, world frame, N.
    pull_n: Vec3,
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
            let node = bodies.nodes.at(i);
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
                    was_at_m: center,
                })
                .is_err()
            {
                faults.raise(Fault::GraspOverflow);
                return;
            }
            let bits = bodies.bits.at_mut(i);
            *bits = bits.with(SphereBits::GRASPED);
        }
    }

    /// Lets go of everything.
    pub(crate) fn open(&mut self, bodies: &mut Bodies) {
        for held in &self.held {
            let bits = bodies.bits.at_mut(held.sphere);
            *bits = bits.without(SphereBits::GRASPED);
        }
        self.held.clear();
        self.pull_n = Vec3::zeros();
    }

    /// Draws the held spheres of organ `organ` to where the instrument has carried them by `share`
    /// of the tick; every one of them if no organ is given. The grip is a spring (XPBD, Macklin
    /// 2016): the multiplier is what the tissue pulls with.
    pub(crate) fn carry(
        &mut self,
        organ: Option<u8>,
        share: f32,
        world_from_instrument: &Pose,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
    ) {
        let stiffness_n_m = GRIP_N_M / self.held.len().max(1) as f32;
        let mut pull_n = Vec3::zeros();
        for held in &mut self.held {
            let own = *bodies.organ.at(held.sphere);
            if organ.is_some_and(|organ| organ != own) {
                continue;
            }
            let end_m = world_from_instrument.rotation * held.in_instrument_m
                + world_from_instrument.translation.vector;
            let target_m = held.was_at_m + (end_m - held.was_at_m) * share;
            let step_s = scene.step_s_of(own);
            let node = bodies.nodes.at_mut(held.sphere);
            let yielding_m_n = node.inverse_mass_per_kg() * step_s * step_s;
            let away_m = target_m - node.center_m();
            let force_n = away_m * (stiffness_n_m / (1.0 + stiffness_n_m * yielding_m_n));
            node.move_by(&(force_n * yielding_m_n));
            pull_n -= force_n;
            if organ.is_none() {
                held.was_at_m = end_m;
            }
        }
        self.pull_n = pull_n;
    }

    /// How the tissue pulls on the jaws. `None` when nothing is held.
    pub(crate) fn pull(&self, bodies: &Bodies) -> Option<Pull> {
        let center = |held: &Held| bodies.nodes.at(held.sphere).center_m();
        let sum_m: Vec3 = self.held.iter().map(center).sum();
        (!self.held.is_empty()).then(|| Pull {
            at_m: sum_m / self.held.len() as f32,
            force_n: self.pull_n,
            stiffness_n_m: GRIP_N_M,
        })
    }
}
