//! Soft tissue: inner spheres moved by position-based dynamics.
//!
//! A tick moves an organ in its number of substeps. Each lets every sphere fly (`predict`), lets a
//! [`Solver`], ties and the contacts correct where it lands, and makes the correction its velocity
//! (`advance`). Organs go side by side (`substeps`).
//!
//! A centre is stored as rest position, displacement, and the displacement's change in this
//! substep. Displacement and change are small, so that they keep the bits which a centre far from
//! the origin would lose: a resting organ rests.

mod adjacency;
pub(crate) mod attachment;
pub(crate) mod bar;
mod breath;
pub mod cells;
mod integrate;
pub mod lanes;
pub mod laplacian;
pub mod neo_hookean;
pub(crate) mod pace;
pub(crate) mod part;
pub mod pbd;
pub(crate) mod per_sphere;
pub(crate) mod sleep;
pub mod stretch;
pub(crate) mod substeps;
pub mod suture;
pub(crate) mod tubes;

pub(crate) use integrate::Bounds;

use crate::math::Vec3;
use crate::scene::{Organ, RestSphere, Scene};
use crate::tissue::cells::Cells;
use crate::tissue::tubes::Beads;
use crate::words::SphereBits;
pub(crate) use adjacency::Adjacency;
use attachment::Ties;
use lanes::Lanes;
use neo_hookean::NeoHookean;
use part::Parted;
use pbd::{PaperPbd, PaperSphere};
use per_sphere::PerSphere;
use suture::Sutures;

/// Corrects the predicted displacements of one organ by its inner constraints. Contacts are not
/// its business.
pub trait Solver {
    /// Projects every constraint of `organ` for a substep of `step_s`; must be bounded by the
    /// organ's counts.
    fn project(&self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies);
}

/// How tissue is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Neo-Hookean tetrahedra: the material is what it is.
    #[default]
    NeoHookean,
    /// The paper's stretching and Laplacian coordinates: to compare with.
    Paper(PaperPbd),
}

impl Solver for Method {
    fn project(&self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies) {
        match self {
            Self::NeoHookean => NeoHookean.project(scene, organ, step_s, bodies),
            Self::Paper(paper) => paper.project(scene, organ, step_s, bodies),
        }
    }
}

/// A sphere as the solver sees it: a cache line, of which tetrahedra touch the first half.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Displacement from rest at the start of this substep, m; beside it the inverse mass, 1/kg, 0
    /// if immovable.
    moved_m: Lanes,
    /// How far it goes in this substep, as predicted and corrected so far, m; beside it zero.
    step_m: Lanes,
    /// Centre at rest, world frame, m; beside it zero.
    rest_m: Lanes,
    /// Velocity at the end of the last substep, m/s; of an immovable sphere, the velocity with
    /// which it is led. Beside it zero.
    velocity_m_s: Lanes,
}

impl Node {
    pub(crate) const ZERO: Self = Self {
        moved_m: Lanes::ZERO,
        step_m: Lanes::ZERO,
        rest_m: Lanes::ZERO,
        velocity_m_s: Lanes::ZERO,
    };

    #[inline(always)]
    pub(crate) fn inverse_mass_per_kg(&self) -> f32 {
        self.moved_m.spare()
    }

    pub(crate) fn set_inverse_mass_per_kg(&mut self, inverse_mass_per_kg: f32) {
        self.moved_m = self.moved_m.with_spare(inverse_mass_per_kg);
    }

    /// Centre at rest, world frame, m.
    #[inline]
    pub(crate) fn rest_m(&self) -> Vec3 {
        self.rest_m.vec3()
    }

    /// Displacement from rest as predicted and corrected so far, m.
    #[inline]
    pub(crate) fn moved_m(&self) -> Vec3 {
        (self.moved_m + self.step_m).vec3()
    }

    /// Velocity at the end of the last substep, m/s.
    #[inline]
    pub(crate) fn velocity_m_s(&self) -> Vec3 {
        self.velocity_m_s.vec3()
    }

    /// Bits of the displacement from rest, and of what stands beside it.
    #[inline(always)]
    pub(crate) fn moved_bits(&self) -> [u64; 2] {
        (self.moved_m + self.step_m).to_bits()
    }

    /// Bits of the velocity, and of the zero beside it.
    #[inline(always)]
    pub(crate) fn velocity_bits(&self) -> [u64; 2] {
        self.velocity_m_s.to_bits()
    }

    /// Moves the sphere on, m.
    #[inline]
    pub(crate) fn move_by(&mut self, step_m: &Vec3) {
        self.step_m = self.step_m + Lanes::new(step_m, 0.0);
    }

    /// Leaves so much of its way in this substep.
    #[inline]
    pub(crate) fn slow(&mut self, keep: f32) {
        self.step_m = self.step_m.scaled(keep);
    }

    /// Predicted centre, world frame, m.
    #[inline]
    pub(crate) fn center_m(&self) -> Vec3 {
        self.center().vec3()
    }

    /// Predicted centre, world frame, m; what stands beside is of no meaning.
    #[inline(always)]
    pub(crate) fn center(&self) -> Lanes {
        self.rest_m + self.moved_m + self.step_m
    }

    /// Predicted centre, as seen from that of `other`, m; what stands beside is of no meaning.
    /// Rest positions, displacements and steps are subtracted apart: the differences keep bits
    /// that the difference of centres has lost.
    #[inline(always)]
    pub(crate) fn from(&self, other: &Self) -> Lanes {
        (self.rest_m - other.rest_m)
            + ((self.moved_m - other.moved_m) + (self.step_m - other.step_m))
    }

    /// The same at the start of this substep.
    #[inline(always)]
    pub(crate) fn away_at_start(&self, other: &Self) -> Lanes {
        (self.rest_m - other.rest_m) + (self.moved_m - other.moved_m)
    }

    /// Puts the sphere to this displacement from rest, m, and leaves it there with this velocity.
    pub(crate) fn put(&mut self, moved_m: &Vec3, velocity_m_s: &Vec3) {
        self.moved_m = Lanes::new(moved_m, self.moved_m.spare());
        self.step_m = Lanes::ZERO;
        self.velocity_m_s = Lanes::new(velocity_m_s, 0.0);
    }
}

/// Every sphere's state, and which are linked.
#[derive(Debug, Clone)]
pub struct Bodies {
    /// Where each is and goes.
    pub(crate) nodes: PerSphere<Node>,
    /// Scratch of the paper's method.
    paper: PerSphere<PaperSphere>,
    /// Radius, m.
    pub(crate) radius_m: PerSphere<f32>,
    /// Written by contact and procedure.
    pub(crate) bits: PerSphere<SphereBits>,
    /// Index of each sphere's organ.
    pub(crate) organ: PerSphere<u8>,
    pub(crate) adjacency: Adjacency,
    pub(crate) parted: Parted,
    /// Layered tissue.
    pub(crate) cells: Cells,
    /// Where tools meet organs without a contact skin.
    pub(crate) beads: Beads,
    /// What hangs organs on the abdominal wall.
    pub(crate) sutures: Sutures,
    ties: Ties,
    /// What follows each sphere's displacement some ticks behind, m.
    trail_m: PerSphere<Lanes>,
}

impl Bodies {
    /// Nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            nodes: PerSphere::new(Node::ZERO),
            paper: PerSphere::new(PaperSphere::ZERO),
            radius_m: PerSphere::new(0.0),
            bits: PerSphere::new(SphereBits(0)),
            organ: PerSphere::new(0),
            adjacency: Adjacency::new(),
            parted: Parted::NONE,
            cells: Cells::new(),
            beads: Beads::new(),
            sutures: Sutures::NONE,
            ties: Ties::NONE,
            trail_m: PerSphere::new(Lanes::ZERO),
        }
    }

    /// Takes over `scene`, at rest.
    pub(crate) fn load(&mut self, scene: &Scene<'_>) {
        self.adjacency.build(scene.links);
        self.beads.build(scene, &self.adjacency);
        for (index, organ) in (0u8..).zip(scene.organs) {
            self.organ
                .range_mut(organ.sphere_start, organ.sphere_count)
                .fill(index);
        }
        let organs = &self.organ;
        self.ties.build(scene, |sphere| *organs.at(sphere));
        for (i, rest) in (0u32..).zip(scene.spheres) {
            self.nodes.at_mut(i).rest_m = Lanes::new(&rest.center_m, 0.0);
        }
        self.rest(scene);
    }

    /// Starts a tick: every organ is simulated, or none, and nothing is touched yet.
    pub(crate) fn begin(&mut self, scene: &Scene<'_>, is_awake: bool) {
        if is_awake {
            self.sutures.draw_in();
        }
        for bits in self.bits.range_mut(0, scene.spheres.len() as u32) {
            let awake = if is_awake {
                SphereBits::AWAKE
            } else {
                SphereBits(0)
            };
            let kept = SphereBits::GRASPED.with(SphereBits::GONE);
            *bits = SphereBits(bits.0 & kept.0).with(awake);
        }
    }

    /// Tells that an organ is not simulated this tick.
    pub(crate) fn stand(&mut self, organ: &Organ) {
        let bits = self.bits.range_mut(organ.sphere_start, organ.sphere_count);
        for bits in bits {
            *bits = SphereBits(bits.0 & !SphereBits::AWAKE.0);
        }
    }

    /// Inverse mass of a sphere, 1/kg; 0 while its organ is not simulated.
    #[inline]
    pub(crate) fn weight_per_kg(&self, sphere: u32) -> f32 {
        if self.bits.at(sphere).contains(SphereBits::AWAKE) {
            self.nodes.at(sphere).inverse_mass_per_kg()
        } else {
            0.0
        }
    }

    /// The box around an organ as it lies now.
    pub(crate) fn bounds(&self, organ: &Organ) -> Bounds {
        let (mut low_m, mut high_m) = (Lanes::splat(f32::MAX), Lanes::splat(f32::MIN));
        let (start, count) = (organ.sphere_start, organ.sphere_count);
        let radii = self.radius_m.range(start, count);
        for (node, radius_m) in self.nodes.range(start, count).iter().zip(radii) {
            let (center_m, radius_m) = (node.center(), Lanes::splat(*radius_m));
            low_m = (center_m - radius_m).min(low_m);
            high_m = (center_m + radius_m).max(high_m);
        }
        let (low_m, high_m) = (low_m.vec3(), high_m.vec3());
        Bounds { low_m, high_m }
    }

    /// Puts every sphere back to rest, and joins what has torn.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>) {
        self.parted.heal(scene);
        self.cells.rest(scene);
        self.sutures.rest(scene);
        for (i, rest) in (0u32..).zip(scene.spheres) {
            let node = self.nodes.at_mut(i);
            node.put(&Vec3::zeros(), &Vec3::zeros());
            node.set_inverse_mass_per_kg(inverse_mass_per_kg(rest));
            *self.trail_m.at_mut(i) = node.moved_m;
            *self.radius_m.at_mut(i) = rest.radius_m;
            *self.bits.at_mut(i) = SphereBits(0);
        }
    }
}

impl Default for Bodies {
    fn default() -> Self {
        Self::new()
    }
}

/// Inverse mass of a sphere that nobody holds.
pub(crate) fn inverse_mass_per_kg(rest: &RestSphere) -> f32 {
    if rest.held { 0.0 } else { rest.mass_kg.recip() }
}
