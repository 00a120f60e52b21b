//! Time integration: prediction before the constraints, velocity after them ([`Bodies::predict`],
//! [`Bodies::advance`]).

use crate::math::{self, Vec3};
use crate::scene::{Organ, Scene};
use crate::time::TICK_S;
use crate::tissue::lanes::Lanes;
use crate::tissue::{Bodies, neo_hookean};

/// Largest speed of a sphere, m/s. An instrument is slower. A faster sphere could pass through its
/// neighbour in one tick.
const SPEED_MAX_M_S: f32 = 3.0;
/// Largest displacement of a sphere from rest along an axis, m. Beyond it, the solver has diverged.
const DISPLACEMENT_MAX_M: f32 = 10.0;

/// Time constant of the low-pass filter that gives a sphere's trail, ticks. A longer filter also
/// ignores slower oscillations.
const TRAIL_TICKS: f32 = 32.0;

/// Bounding box of an organ's spheres, world frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low_m: Vec3,
    pub(crate) high_m: Vec3,
}

impl Bounds {
    /// The empty box.
    pub(crate) const EMPTY: Self = Self {
        low_m: Vec3::new(f32::MAX, f32::MAX, f32::MAX),
        high_m: Vec3::new(f32::MIN, f32::MIN, f32::MIN),
    };

    /// Extends the box to contain the sphere at `center_m`.
    #[inline]
    pub(crate) fn add(&mut self, center_m: &Vec3, radius_m: f32) {
        let r = Vec3::new(radius_m, radius_m, radius_m);
        self.low_m = self.low_m.inf(&(center_m - r));
        self.high_m = self.high_m.sup(&(center_m + r));
    }

    /// Bounding box, grown by `reach_m`, of the part of the segment from `a_m` to `b_m` that lies
    /// in this box grown by `reach_m`. Empty if there is no such part.
    pub(crate) fn within(&self, a_m: &Vec3, b_m: &Vec3, reach_m: f32) -> Self {
        let along_m = b_m - a_m;
        let (mut from, mut to) = (0.0f32, 1.0f32);
        let axes = self.low_m.iter().zip(&self.high_m);
        for ((low, high), (at, along)) in axes.zip(a_m.iter().zip(&along_m)) {
            let (low, high) = (low - reach_m - at, high + reach_m - at);
            if along.abs() > 1.0e-9 {
                let (one, other) = (low / along, high / along);
                from = from.max(one.min(other));
                to = to.min(one.max(other));
            } else if low > 0.0 || high < 0.0 {
                return Self::EMPTY;
            }
        }
        let mut within = Self::EMPTY;
        if from <= to {
            within.add(&(a_m + along_m * from), reach_m);
            within.add(&(a_m + along_m * to), reach_m);
        }
        within
    }

    /// True if a place comes nearer to the box than `reach_m`.
    pub(crate) fn reaches(&self, at_m: &Vec3, reach_m: f32) -> bool {
        let place = Self {
            low_m: *at_m,
            high_m: *at_m,
        };
        self.is_near(&place, reach_m)
    }

    /// True if the boxes come nearer to each other than `margin_m`.
    pub(crate) fn is_near(&self, other: &Self, margin_m: f32) -> bool {
        let gap = (self.low_m - other.high_m).sup(&(other.low_m - self.high_m));
        gap.x < margin_m && gap.y < margin_m && gap.z < margin_m
    }
}

impl Bodies {
    /// Predicts the free motion of a substep: damps the velocity, then adds gravity, and sets the
    /// step to velocity times `step_s`. Damping comes first, so that it does not weaken gravity.
    /// Held spheres move with their prescribed velocity.
    pub(crate) fn predict(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32) {
        let fall = scene.room.gravity_m_s2 * (organ.gravity_share * step_s);
        let remaining = (1.0 - organ.material.damping_per_s * step_s).max(0.0);
        let (fall, remaining) = (Lanes::new(&fall, 0.0), Lanes::splat(remaining));
        let step_s = Lanes::splat(step_s);
        for node in self.nodes.range_mut(organ.sphere_start, organ.sphere_count) {
            if node.inverse_mass_per_kg() > 0.0 {
                node.velocity_m_s = node.velocity_m_s * remaining + fall;
            }
            node.step_m = node.velocity_m_s * step_s;
        }
    }

    /// Ends a substep: adds the corrected step `d` to the displacement, and sets the velocity to `d
    /// / dt`, at most [`SPEED_MAX_M_S`]. A sphere that is not finite, or is farther from rest than
    /// [`DISPLACEMENT_MAX_M`] along an axis, goes back to its place before the substep, without
    /// velocity. Returns the number of such spheres.
    pub(crate) fn advance(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32) -> u32 {
        let mut quarantined = 0;
        let per_step = Lanes::splat(step_s.recip());
        let memory = self.warm_start.of(organ).spheres;
        let has_memory = organ.batch_count > 0;
        let nodes = self.nodes.range_mut(organ.sphere_start, organ.sphere_count);
        for (node, last) in nodes.iter_mut().zip(memory) {
            let weight_per_kg = node.inverse_mass_per_kg();
            let tools_m = node.step_m - last.tools;
            last.tools = neo_hookean::impulse(tools_m, weight_per_kg);
            if has_memory {
                let outer_m = node.step_m - last.step_after_tetrahedra_m;
                last.outer = neo_hookean::impulse(outer_m, weight_per_kg);
            }
            let [x, y, z, _] = (node.moved_m + node.step_m).to_array();
            // Not `>`: a comparison with NaN is false. Not `&&`: evaluating all three at once is
            // quicker.
            let is_inside = |x: f32| x.abs() <= DISPLACEMENT_MAX_M;
            if is_inside(x) & is_inside(y) & is_inside(z) {
                node.moved_m = node.moved_m + node.step_m;
                if node.inverse_mass_per_kg() > 0.0 {
                    node.velocity_m_s = limited(node.step_m * per_step);
                }
            } else {
                node.velocity_m_s = Lanes::ZERO;
                quarantined += 1;
            }
            node.step_m = Lanes::ZERO;
        }
        if quarantined > 0 {
            self.warm_start.reset(scene, organ);
        }
        quarantined
    }

    /// Stores the steps of an organ's spheres before the tools act on them.
    pub(crate) fn store_steps_before_tools(&mut self, organ: &Organ) {
        let memory = self.warm_start.of(organ).spheres;
        let nodes = self.nodes.range(organ.sphere_start, organ.sphere_count);
        for (node, last) in nodes.iter().zip(memory) {
            last.tools = node.step_m;
        }
    }

    /// Net speed of the fastest free sphere of an organ over the last ticks, m/s. Also advances the
    /// trails. Heavily loaded spheres alternate between places micrometres apart; the filter
    /// removes this.
    pub(crate) fn net_speed_m_s(&mut self, organ: &Organ) -> f32 {
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let trails = self.trail_m.range_mut(start, count).iter_mut();
        let mut farthest = 0.0f32;
        for (trail_m, node) in trails.zip(self.nodes.range(start, count)) {
            let lag_m = node.moved_m - *trail_m;
            *trail_m = *trail_m + lag_m.scaled(TRAIL_TICKS.recip());
            if node.inverse_mass_per_kg() > 0.0 {
                farthest = farthest.max(lag_m.norm_squared());
            }
        }
        // A sphere in steady motion is `TRAIL_TICKS` ticks ahead of its trail.
        math::sqrt(farthest) / (TRAIL_TICKS * TICK_S)
    }

    /// Velocity of a sphere over the last ticks, m/s, as [`Self::net_speed_m_s`] measures its
    /// speed.
    pub(crate) fn net_velocity_m_s(&self, sphere: u32) -> Vec3 {
        let lag_m = self.nodes.at(sphere).moved_m - *self.trail_m.at(sphere);
        lag_m.scaled((TRAIL_TICKS * TICK_S).recip()).vec3()
    }

    /// Index of the free sphere of an organ that is fastest over the last ticks.
    pub(crate) fn fastest(&self, organ: &Organ) -> u32 {
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let trails = self.trail_m.range(start, count).iter();
        let (mut sphere, mut farthest) = (start, 0.0f32);
        let spheres = (start..).zip(trails.zip(self.nodes.range(start, count)));
        for (number, (trail_m, node)) in spheres {
            let lag_m2 = (node.moved_m - *trail_m).norm_squared();
            if node.inverse_mass_per_kg() > 0.0 && lag_m2 > farthest {
                (sphere, farthest) = (number, lag_m2);
            }
        }
        sphere
    }

    /// Ends a tick of an organ: sets the prescribed velocity of its held spheres to zero.
    pub(crate) fn stop_leading(&mut self, organ: &Organ) {
        for node in self.nodes.range_mut(organ.sphere_start, organ.sphere_count) {
            if node.inverse_mass_per_kg() <= 0.0 {
                node.velocity_m_s = Lanes::ZERO;
            }
        }
    }

    /// Sets the velocities of an organ to zero.
    pub(crate) fn halt(&mut self, organ: &Organ) {
        for node in self.nodes.range_mut(organ.sphere_start, organ.sphere_count) {
            node.velocity_m_s = Lanes::ZERO;
        }
    }

    /// Prescribes the velocity that takes a held sphere to the displacement `moved_m`, m, within
    /// one tick.
    pub(crate) fn lead(&mut self, sphere: u32, moved_m: &Vec3) {
        let node = self.nodes.at_mut(sphere);
        let step_m = moved_m - node.moved_m();
        node.velocity_m_s = Lanes::new(&(step_m / TICK_S), 0.0);
    }
}

/// The velocity, limited to [`SPEED_MAX_M_S`].
fn limited(velocity_m_s: Lanes) -> Lanes {
    let squared = velocity_m_s.norm_squared();
    if squared > SPEED_MAX_M_S * SPEED_MAX_M_S {
        velocity_m_s.scaled(SPEED_MAX_M_S / math::sqrt(squared))
    } else {
        velocity_m_s
    }
}
