//! Force of the trocar on the hand: friction of the shaft in the seal, and the abdominal wall that
//! turns a tilted trocar back.
//!
//! # Seal
//!
//! The lips of the seal stick to the shaft and bend with it: a spring between the shaft and a point
//! that slides only at the limit of friction (elastoplastic, Hayward and Armstrong 2000; Dupont and
//! others 2002). Below the limit the point does not move at all, so a trembling hand does not drift
//! through the seal. The law computes with travel, not with speed, so coarse encoder steps do not
//! shake the force.
//!
//! The limit is the break-away friction `B` for a shaft that rests or reverses. While the shaft
//! slides, the limit falls to the sliding friction `S` within [`SLIP_M`]. The distance that the
//! shaft slid is forgotten within [`REST_S`], so a slow shaft has more friction than a fast one
//! (Stribeck), and a shaft that stops sticks again.
//!
//! # Wall
//!
//! With the elasticity `κ`, the shaft's direction `d` and the trocar's rest direction `a`, the wall
//! turns the shaft with the torque `κ (d × a)`: the gradient of the potential `−κ d·a`, which needs
//! no angle.
//!
//! # Stability
//!
//! Seal and wall are passive: the lips give back the energy that they store, and the point only
//! slides along the force. A sampled loop with a delay adds energy to any spring; the device's own
//! damping absorbs this energy up to some stiffness. So the trocar's stiffness is at most
//! [`STIFFNESS_SHARE`] of the stiffness that the device renders stably. Stiff tissue softens the
//! lips further, down to [`LEAST_SHARE`]; only then is the force of tissue scaled (`output_limit`).
//! Lips that soften keep their bend, and lips that stiffen keep their force, so neither gains
//! energy. The friction bypasses the passivity observer, because energy that the seal dissipates
//! would hide energy that a contact generates.

use crate::math::{Pose, Vec3};
use crate::scene::Trocar;
use crate::time::TICK_S;
use crate::tool::{Kinematics, Wrench};

/// Largest share of the device's stable stiffness that the trocar uses. With a larger share, the
/// force changes faster where the shaft reverses, and less stiffness is left to tissue.
const STIFFNESS_SHARE: f32 = 0.5;
/// Share of the device's stable stiffness that the trocar keeps beside the stiffest tissue.
const LEAST_SHARE: f32 = 0.2;
/// Largest change of the lips' stiffness in a tick, as a share of the device's stable stiffness. A
/// contact that begins softens the lips within 150 ms.
const SOFTENING: f32 = 0.002;
/// Stiffness of the seal's lips along the shaft, N/m, if the device renders it. Assumed: lips of
/// rubber that bend by a millimetre under 1 N.
const LIPS_N_M: f32 = 1000.0;
/// Least distance within which the friction of a sliding shaft falls from break-away to sliding, m.
/// Assumed: about the length of the lips.
const SLIP_M: f32 = 0.003;
/// Largest slope of this fall, as a share of the lips' stiffness. At 1 the shaft would snap from
/// one tick to the next.
const SNAP_SHARE: f32 = 0.5;
/// Time within which a shaft that has stopped sticks again, s. Assumed. A shaft faster than
/// `SLIP_M / REST_S` (15 mm/s) has the sliding friction alone.
const REST_S: f32 = 0.2;
/// Stiffness below which a device renders no trocar, N/m: the lips would bend by centimetres.
const STIFFNESS_MIN_N_M: f32 = 20.0;

/// The trocar's law and its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TrocarLaw {
    trocar: Trocar,
    /// Stiffness that the device renders stably, N/m.
    stable_n_m: f32,
    /// Stiffness of the lips, N/m.
    lips_n_m: f32,
    /// Length of the shaft outside the body in the last tick, m.
    outside_m: Option<f32>,
    /// Bend of the lips, m: positive inwards.
    bent_m: f32,
    /// Distance that the shaft slid lately in the direction of `slid_inwards`, m.
    slid_m: f32,
    slid_inwards: bool,
}

/// Force of the trocar on the hand, and its stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TrocarForce {
    /// Force at the handle, world frame, N.
    pub(crate) force_n: Vec3,
    /// Upper bound of the stiffness at the handle, N/m.
    pub(crate) stiffness_n_m: f32,
}

impl TrocarForce {
    /// No force.
    pub(crate) const NONE: Self = Self {
        force_n: Vec3::new(0.0, 0.0, 0.0),
        stiffness_n_m: 0.0,
    };
}

impl TrocarLaw {
    /// The law of `trocar` for a device that renders `stiffness_max_n_m` stably.
    pub(crate) fn new(trocar: &Trocar, stiffness_max_n_m: f32) -> Self {
        Self {
            trocar: *trocar,
            stable_n_m: stiffness_max_n_m,
            lips_n_m: lips_n_m(trocar, stiffness_max_n_m, 0.0),
            outside_m: None,
            bent_m: 0.0,
            slid_m: 0.0,
            slid_inwards: false,
        }
    }

    /// Straightens the lips, because the hand may have moved anywhere meanwhile.
    pub(crate) const fn release(&mut self) {
        self.outside_m = None;
        self.bent_m = 0.0;
        self.slid_m = 0.0;
    }

    /// Force on the hand in this tick, beside tissue of this stiffness at the handle.
    pub(crate) fn felt(
        &mut self,
        kinematics: &Kinematics,
        world_from_handle: &Pose,
        tissue_n_m: f32,
    ) -> TrocarForce {
        let budget_n_m = STIFFNESS_SHARE * self.stable_n_m;
        if !self.trocar.acts() || budget_n_m < STIFFNESS_MIN_N_M {
            return TrocarForce::NONE;
        }
        let axis = kinematics.axis(world_from_handle);
        let outside_m = kinematics.outside_m(world_from_handle);
        self.soften(tissue_n_m);
        self.slide(outside_m);
        // The lips push a shaft that was moved inwards back towards the hand.
        let seal_n = axis * -(self.lips_n_m * self.bent_m);
        let tilt_n_m = self.trocar.wall_nm_rad / (outside_m * outside_m);
        // Close to the port the wall would be too stiff for the rest of the budget, so it is scaled
        // down.
        let left_n_m = budget_n_m - self.lips_n_m;
        let share = (left_n_m / tilt_n_m.max(f32::MIN_POSITIVE)).min(1.0);
        let torque_nm = axis.cross(&self.trocar.axis) * (self.trocar.wall_nm_rad * share);
        let turned = kinematics.at_handle(
            world_from_handle,
            &Wrench {
                force_n: Vec3::zeros(),
                torque_nm,
            },
        );
        TrocarForce {
            force_n: seal_n + turned.force_n,
            stiffness_n_m: self.lips_n_m + tilt_n_m * share,
        }
    }

    /// Softens or stiffens the lips gradually. Neither adds to the energy that they store.
    fn soften(&mut self, tissue_n_m: f32) {
        let wanted_n_m = lips_n_m(&self.trocar, self.stable_n_m, tissue_n_m);
        let step_n_m = SOFTENING * self.stable_n_m;
        let change_n_m = (wanted_n_m - self.lips_n_m).max(-step_n_m).min(step_n_m);
        if change_n_m > 0.0 {
            self.bent_m *= self.lips_n_m / (self.lips_n_m + change_n_m);
        }
        self.lips_n_m += change_n_m;
    }

    /// Moves the shaft to `outside_m`: the lips bend, and slide at the limit of friction.
    fn slide(&mut self, outside_m: f32) {
        let inwards_m = self.outside_m.map_or(0.0, |last_m| last_m - outside_m);
        self.outside_m = Some(outside_m);
        let moved_m = self.bent_m + inwards_m;
        if (moved_m > 0.0) != self.slid_inwards {
            self.slid_m = 0.0; // the lips flip over
        }
        self.slid_m -= self.slid_m * (TICK_S / REST_S);
        let jump_n = self.trocar.breakaway_n - self.trocar.sliding_n;
        let lips_n_m = self.lips_n_m.max(f32::MIN_POSITIVE);
        let fall_m = (jump_n / (SNAP_SHARE * lips_n_m)).max(SLIP_M);
        let limit_n = self.trocar.sliding_n + jump_n * (1.0 - self.slid_m / fall_m).max(0.0);
        let limit_m = limit_n / lips_n_m;
        self.bent_m = moved_m.max(-limit_m).min(limit_m);
        let slip_m = moved_m - self.bent_m;
        if slip_m.abs() > 0.0 {
            self.slid_inwards = slip_m > 0.0;
            self.slid_m += slip_m.abs();
        }
    }
}

/// Stiffness of the lips beside tissue of stiffness `tissue_n_m`, N/m. Beside a wall, the lips have
/// three quarters of the trocar's share.
fn lips_n_m(trocar: &Trocar, stable_n_m: f32, tissue_n_m: f32) -> f32 {
    if trocar.breakaway_n <= 0.0 {
        return 0.0;
    }
    let left_n_m = (stable_n_m - tissue_n_m)
        .max(LEAST_SHARE * stable_n_m)
        .min(STIFFNESS_SHARE * stable_n_m);
    let has_wall = trocar.wall_nm_rad > 0.0;
    LIPS_N_M.min(left_n_m * if has_wall { 0.75 } else { 1.0 })
}

#[cfg(test)]
mod tests;
