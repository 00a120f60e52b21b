//! Soft tissue: inner spheres moved by position-based dynamics.
//!
//! A tick moves every sphere in three steps: `predict` lets it fly, a [`Solver`] and
//! the contacts correct where it lands, `advance` makes the correction its velocity.
//!
//! A centre is stored as rest position plus displacement. The displacement is small, so that it
//! keeps the bits which a centre far from the origin would lose, and a resting organ rests.

mod adjacency;
mod integrate;
pub mod lanes;
pub mod laplacian;
pub mod pbd;
pub(crate) mod per_sphere;
pub mod stretch;

pub(crate) use integrate::Bounds;

use crate::math::Vec3;
use crate::scene::{Organ, RestSphere, Scene};
use crate::state::SphereBits;
use adjacency::Adjacency;
use lanes::Lanes;
use per_sphere::PerSphere;

/// Corrects the predicted displacements of one organ for one tick by its inner constraints.
/// Contacts are not its business. The seam at which the paper's method is replaced.
pub trait Solver {
    /// Projects every constraint of `organ`; must be bounded by the organ's counts.
    fn project(&self, scene: &Scene<'_>, organ: &Organ, bodies: &mut Bodies);
}

/// A sphere as the solver sees it: half a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Node {
    /// Centre at rest, world frame, m; beside it the inverse mass, 1/kg, 0 if immovable.
    rest_m: Lanes,
    /// Displacement from rest at the end of this tick, as predicted and corrected so far, m;
    /// beside it zero.
    moved_m: Lanes,
}

impl Node {
    const ZERO: Self = Self {
        rest_m: Lanes::ZERO,
        moved_m: Lanes::ZERO,
    };

    #[inline(always)]
    pub(crate) fn inverse_mass_per_kg(&self) -> f32 {
        self.rest_m.spare()
    }

    pub(crate) fn set_inverse_mass_per_kg(&mut self, inverse_mass_per_kg: f32) {
        self.rest_m = self.rest_m.with_spare(inverse_mass_per_kg);
    }

    /// Centre at rest, world frame, m.
    #[inline]
    pub(crate) fn rest_m(&self) -> Vec3 {
        self.rest_m.vec3()
    }

    /// Predicted displacement from rest, m.
    #[inline]
    pub(crate) fn moved_m(&self) -> Vec3 {
        self.moved_m.vec3()
    }

    /// Puts the sphere to this displacement from rest, m.
    #[inline]
    pub(crate) fn move_to(&mut self, moved_m: &Vec3) {
        self.moved_m = Lanes::new(moved_m, 0.0);
    }

    /// Moves the sphere on, m.
    #[inline]
    pub(crate) fn move_by(&mut self, step_m: &Vec3) {
        self.moved_m = self.moved_m + Lanes::new(step_m, 0.0);
    }

    /// Predicted centre, world frame, m.
    #[inline]
    pub(crate) fn center_m(&self) -> Vec3 {
        (self.rest_m + self.moved_m).vec3()
    }

    /// Predicted centre, as seen from that of `other`, m; what stands beside is of no meaning.
    /// Rest positions and displacements are subtracted apart: both differences keep bits that
    /// the difference of centres has lost.
    #[inline(always)]
    pub(crate) fn from(&self, other: &Self) -> Lanes {
        (self.rest_m - other.rest_m) + (self.moved_m - other.moved_m)
    }
}

/// Every sphere's state, and which are linked.
#[derive(Debug)]
pub struct Bodies {
    /// What the solver works on; `moved_m` is scratch between predict and advance.
    pub(crate) nodes: PerSphere<Node>,
    /// Radius, m.
    pub(crate) radius_m: PerSphere<f32>,
    /// Displacement from rest at the end of the last tick, m; written by advance.
    pub(crate) displacement_m: PerSphere<Vec3>,
    /// Velocity at the end of the last tick, m/s; written by advance.
    pub(crate) velocity_m_s: PerSphere<Vec3>,
    /// Written by contact and procedure.
    pub(crate) bits: PerSphere<SphereBits>,
    /// Index of each sphere's organ.
    pub(crate) organ: PerSphere<u8>,
    pub(crate) adjacency: Adjacency,
}

impl Bodies {
    pub(crate) const fn new() -> Self {
        Self {
            nodes: PerSphere::new(Node::ZERO),
            radius_m: PerSphere::new(0.0),
            displacement_m: PerSphere::new(Vec3::new(0.0, 0.0, 0.0)),
            velocity_m_s: PerSphere::new(Vec3::new(0.0, 0.0, 0.0)),
            bits: PerSphere::new(SphereBits(0)),
            organ: PerSphere::new(0),
            adjacency: Adjacency::new(),
        }
    }

    /// Takes over `scene`, at rest.
    pub(crate) fn load(&mut self, scene: &Scene<'_>) {
        self.adjacency.build(scene.links);
        for (index, organ) in (0u8..).zip(scene.organs) {
            self.organ
                .range_mut(organ.sphere_start, organ.sphere_count)
                .fill(index);
        }
        for (i, rest) in (0u32..).zip(scene.spheres) {
            self.nodes.at_mut(i).rest_m = Lanes::new(&rest.center_m, 0.0);
            *self.radius_m.at_mut(i) = rest.radius_m;
        }
        self.rest(scene);
    }

    /// Starts a tick: every organ is simulated, or none, and nothing is touched yet.
    pub(crate) fn begin(&mut self, scene: &Scene<'_>, is_awake: bool) {
        for bits in self.bits.range_mut(0, scene.spheres.len() as u32) {
            let awake = if is_awake {
                SphereBits::AWAKE
            } else {
                SphereBits(0)
            };
            *bits = SphereBits(bits.0 & SphereBits::GRASPED.0).with(awake);
        }
    }

    /// Tells that an organ is not simulated this tick.
    pub(crate) fn stand(&mut self, organ: &Organ) {
        let bits = self.bits.range_mut(organ.sphere_start, organ.sphere_count);
        for bits in bits {
            *bits = SphereBits(bits.0 & !SphereBits::AWAKE.0);
        }
    }

    /// The box around an organ as it lies now.
    pub(crate) fn bounds(&self, organ: &Organ) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let radii = self.radius_m.range(start, count);
        for (node, radius_m) in self.nodes.range(start, count).iter().zip(radii) {
            bounds.add(&node.center_m(), *radius_m);
        }
        bounds
    }

    /// Puts every sphere back to rest.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>) {
        for (i, rest) in (0u32..).zip(scene.spheres) {
            let node = self.nodes.at_mut(i);
            node.move_to(&Vec3::zeros());
            node.set_inverse_mass_per_kg(inverse_mass_per_kg(rest));
            *self.displacement_m.at_mut(i) = Vec3::zeros();
            *self.velocity_m_s.at_mut(i) = Vec3::zeros();
            *self.bits.at_mut(i) = SphereBits(0);
        }
    }
}

/// Inverse mass of a sphere that no jaw holds.
pub(crate) fn inverse_mass_per_kg(rest: &RestSphere) -> f32 {
    if rest.held { 0.0 } else { rest.mass_kg.recip() }
}
