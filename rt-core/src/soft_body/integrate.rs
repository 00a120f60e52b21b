//! Time steps: before the constraints ([`Bodies::predict`]) and after them ([`Bodies::advance`]).

use crate::math::{self, Vec3};
use crate::scene::{Organ, Scene};
use crate::sim::TICK_S;
use crate::soft_body::Bodies;

/// No sphere leaves a tick faster than this, m/s: above what an instrument does, below what
/// would carry a sphere through its neighbour in a tick.
const SPEED_MAX_M_S: f32 = 3.0;
/// No sphere leaves this distance from its rest position, m.
const DISPLACEMENT_MAX_M: f32 = 10.0;

/// The box around an organ's spheres, world frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low_m: Vec3,
    pub(crate) high_m: Vec3,
}

impl Bounds {
    /// Around nothing.
    pub(crate) const EMPTY: Self = Self {
        low_m: Vec3::new(f32::MAX, f32::MAX, f32::MAX),
        high_m: Vec3::new(f32::MIN, f32::MIN, f32::MIN),
    };

    /// Grows to hold the sphere at `center_m`.
    #[inline]
    pub(crate) fn add(&mut self, center_m: &Vec3, radius_m: f32) {
        let r = Vec3::new(radius_m, radius_m, radius_m);
        self.low_m = self.low_m.inf(&(center_m - r));
        self.high_m = self.high_m.sup(&(center_m + r));
    }

    /// Whether the two boxes come nearer than `margin_m` to each other.
    pub(crate) fn is_near(&self, other: &Self, margin_m: f32) -> bool {
        let gap = (self.low_m - other.high_m).sup(&(other.low_m - self.high_m));
        gap.x < margin_m && gap.y < margin_m && gap.z < margin_m
    }
}

impl Bodies {
    /// Velocity takes gravity and damping, displacement takes velocity. Immovable spheres stay.
    pub(crate) fn predict(&mut self, scene: &Scene<'_>, organ: &Organ) {
        let fall = scene.room.gravity_m_s2 * TICK_S;
        let keep = (1.0 - organ.material.damping_per_s * TICK_S).max(0.0);
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let nodes = self.nodes.range_mut(start, count).iter_mut();
        let displacements = self.displacement_m.range(start, count);
        let velocities = self.velocity_m_s.range_mut(start, count);
        for ((node, u), v) in nodes.zip(displacements).zip(velocities) {
            if node.inverse_mass_per_kg() > 0.0 {
                *v = (*v + fall) * keep;
            } else {
                *v = Vec3::zeros();
            }
            node.move_to(&(u + *v * TICK_S));
        }
    }

    /// What the constraints made of the prediction becomes the state: `v = Δu / dt`, at most
    /// [`SPEED_MAX_M_S`]. A sphere that is not finite, or left the room, goes back to where it
    /// was and rests. Returns the organ's box, and how many spheres were put back.
    pub(crate) fn advance(&mut self, organ: &Organ) -> (Bounds, u32) {
        let (mut bounds, mut put_back) = (Bounds::EMPTY, 0);
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let nodes = self.nodes.range_mut(start, count).iter_mut();
        let displacements = self.displacement_m.range_mut(start, count);
        let velocities = self.velocity_m_s.range_mut(start, count);
        let radii = self.radius_m.range(start, count);
        for (((node, u), v), radius_m) in nodes.zip(displacements).zip(velocities).zip(radii) {
            let moved_m = node.moved_m();
            // Not `>`: a comparison with NaN is false.
            let is_good = moved_m.amax() <= DISPLACEMENT_MAX_M && math::is_finite(&moved_m);
            if is_good {
                *v = limited((moved_m - *u) / TICK_S);
                *u = moved_m;
            } else {
                node.move_to(u);
                *v = Vec3::zeros();
                put_back += 1;
            }
            bounds.add(&(node.rest_m() + *u), *radius_m);
        }
        (bounds, put_back)
    }
}

fn limited(velocity_m_s: Vec3) -> Vec3 {
    let squared = velocity_m_s.norm_squared();
    if squared > SPEED_MAX_M_S * SPEED_MAX_M_S {
        velocity_m_s * (SPEED_MAX_M_S / math::sqrt(squared))
    } else {
        velocity_m_s
    }
}
