//! Soft tissue: spheres that carry mass, tetrahedra between their centres, and links.
//!
//! # State
//!
//! A centre is stored as its rest position, its displacement, and the change of the displacement in
//! this substep. Displacement and change are small, so they keep low bits that the coordinates of a
//! centre far from the origin would lose. Without these bits, rounding errors would keep an organ
//! at rest in motion.
//!
//! # A substep
//!
//! Each organ has its own number of substeps a tick, a power of two. A substep predicts the free
//! flight of every sphere (`predict`), lets a [`Solver`], the attachments and the contacts correct
//! it, and takes the velocity from the corrected displacement (`advance`). A substep makes one pass
//! and does not iterate, because the apparent stiffness must not depend on the number of passes.
//!
//! # The neo-Hookean solid
//!
//! Each tetrahedron has the stable neo-Hookean energy of Smith, de Goes and Kim 2018:
//!
//! ```text
//! V (μ/2 F:F + λ/2 (det F − γ)²)        λ = λ₀ + μ        γ = 1 + μ/λ
//! ```
//!
//! `F = I + Σ e_a b_aᵀ`, with `e` the displacements of the edges and `b` the shape gradients. XPBD
//! solves it (Macklin 2016; Macklin and Müller 2021), with two differences. First, a substep begins
//! with the impulses of the last one (`warm_start`), so tissue at rest has the stress of the
//! energy, with any number of substeps. Second, a projection solves implicitly for all of `F`, not
//! along one gradient, so flat tetrahedra are stable (equations: `neo_hookean::kernel`).
//!
//! Viscosity resists only the change of volume from one substep to the next, so it damps neither
//! rigid motion nor rest. Linear tetrahedra lock beyond a Poisson's ratio of 0.45, so a larger
//! ratio counts as 0.45 (`POISSON_MAX`). Linear tetrahedra are also a little stiffer than the solid
//! that they approximate, so they get 0.965 of Young's modulus (`STIFFNESS_SHARE`).
//!
//! Preparation orders the tetrahedra so that batches of eight share no sphere. `kernel` solves a
//! batch at a time, in AVX registers or in plain arrays. Both do equal operations in equal order,
//! so they give equal bits.
//!
//! # Links
//!
//! Tubes, and tissue without tetrahedra, have elastic links: `C = |p1 − p2| − L` with a
//! compliance, solved from zero multipliers. One pass over them is softer than the material, by a
//! known amount that the links of a tube leave out (`one_pass`). So a tube has its material's
//! stiffness while the stiffness number `E dt² / (ρ h²)` of a substep is at most 2.4, with the
//! spacing `h` of the spheres; other links, while it is at most 0.2. Preparation chooses the
//! number of substeps by that bound. Attachments between organs, sutures, the grip of jaws and
//! contact are constraints of the same kind. The force of each is its multiplier divided by `dt²`.
//!
//! # Damage
//!
//! A link has one damage variable, from 0 (intact) to 1 (torn). It models a bundle of fibres that
//! tear one after another (a cohesive law). Its force rises with the stiffness `k` up to an
//! elongation `s`, in m, and falls with the slope `−k` to zero at `2 s`. A complete tear takes the
//! energy `G = k s²`, which is toughness times area. So `s = √(G c)` follows from `G` and the
//! compliance `c = 1/k`. A half-torn link unloads along a straight line to zero, so a cycle never
//! yields energy. Scissors and current damage links too. Tetrahedra neither tear nor are cut yet.
//!
//! # Organs in unequal substeps
//!
//! A constraint between two organs acts on the finer organ in each of its substeps. A sphere of the
//! coarser organ is then in the middle of a longer substep. The constraint uses the position that
//! this sphere has at the end of the finer substep; the impulse on the sphere acts over the whole
//! of the longer substep. If an attachment acted only once a tick, an organ of 16 substeps would
//! receive its whole correction in the last substep, at sixteen times the speed.
//!
//! # Sleep
//!
//! An organ that rests for 50 ticks sleeps until a tool or a moving organ comes near it or pulls at
//! it. Motion is measured by the distance of a sphere from its low-pass filtered position (its
//! trail). The momentary speed would be misleading, because heavily loaded spheres alternate
//! between places micrometres apart.
//!
//! # Cells
//!
//! Fat and connective tissue are divided into cells. The organ's spheres carry the cells, and each
//! cell belongs to the nearest sphere. A cell is removed when it has absorbed the energy that boils
//! it away, or when its strand has torn. The effects depend on the set of removed cells, not on the
//! order of removal. The contact skin sinks by the thickness of the removed cells under it. The
//! stiffness of a link falls with the share of cells left at either of its spheres. A sphere that
//! has lost all cells touches nothing and follows its neighbours. Tetrahedra of fat keep their
//! stiffness.
//!
//! # The paper's method
//!
//! `Method::Paper` is the baseline: stretching (Eq. 3–5) and Laplacian coordinates (Eq. 6–8), in a
//! fixed number of iterations. The faults of the method are kept. Stiffness depends on the number
//! of iterations. The vector `L` does not rotate with the tissue, so a rotated organ is pulled
//! back. A Laplacian step moves one sphere alone, so momentum is not conserved.
//!
//! Its scratch memory, [`paper::Paper`], is not in [`Bodies`]; the caller passes it with the
//! method. Checkpoints leave it out, because nothing in it is needed after the projection of one
//! organ.

mod adjacency;
pub(crate) mod attachment;
pub(crate) mod bar;
mod breath;
pub mod cells;
pub(crate) mod damage;
mod integrate;
pub mod lanes;
mod links;
pub(crate) mod multirate;
pub mod neo_hookean;
mod one_pass;
pub mod paper;
pub(crate) mod per_sphere;
pub(crate) mod sleep;
pub(crate) mod substeps;
pub mod suture;
pub(crate) mod tubes;
pub(crate) mod warm_start;

pub(crate) use integrate::Bounds;

use crate::math::Vec3;
use crate::scene::{Organ, RestSphere, Scene};
use crate::tissue::cells::Cells;
use crate::tissue::tubes::Beads;
use crate::words::SphereBits;
pub(crate) use adjacency::Adjacency;
use attachment::TieSchedule;
pub use attachment::solutions_per_tick;
use damage::Damage;
use lanes::Lanes;
use neo_hookean::NeoHookean;
use one_pass::OnePass;
use paper::Paper;
use per_sphere::PerSphere;
use suture::Sutures;
use warm_start::WarmStart;

/// Corrects predicted displacements by the inner constraints of organs. Contacts are solved
/// elsewhere.
pub trait Solver {
    /// Projects the constraints of `organ`, except links, in a substep of `step_s`. The organ's
    /// counts bound the cost.
    fn project(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies);

    /// Projects the links of all organs that begin a substep. The number of links bounds the cost.
    fn project_links(
        &mut self,
        _scene: &Scene<'_>,
        _organs: impl Iterator<Item = u8>,
        _bodies: &mut Bodies,
    ) {
    }
}

/// Method by which tissue is solved.
#[derive(Debug, Default)]
pub enum Method<'a> {
    /// Neo-Hookean tetrahedra with the material's own moduli.
    #[default]
    NeoHookean,
    /// The paper's stretching and Laplacian coordinates, as the baseline, with its storage.
    Paper(&'a mut Paper),
}

impl Solver for Method<'_> {
    fn project(&mut self, scene: &Scene<'_>, organ: &Organ, step_s: f32, bodies: &mut Bodies) {
        match self {
            Self::NeoHookean => NeoHookean.project(scene, organ, step_s, bodies),
            Self::Paper(paper) => paper.project(scene, organ, step_s, bodies),
        }
    }

    fn project_links(
        &mut self,
        scene: &Scene<'_>,
        organs: impl Iterator<Item = u8>,
        bodies: &mut Bodies,
    ) {
        match self {
            Self::NeoHookean => NeoHookean.project_links(scene, organs, bodies),
            Self::Paper(_) => {} // `project` includes its links
        }
    }
}

/// A sphere's state in the solver: one cache line. Tetrahedra read only its first half.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Displacement from rest at the start of this substep, m. Spare lane: inverse mass, 1/kg; 0
    /// for a held sphere.
    moved_m: Lanes,
    /// Change of the displacement in this substep, as predicted and corrected so far, m. Spare
    /// lane: zero.
    step_m: Lanes,
    /// Centre at rest, world frame, m. Spare lane: zero.
    rest_m: Lanes,
    /// Velocity at the end of the last substep, m/s; for a held sphere, its prescribed velocity.
    /// Spare lane: zero.
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

    /// Bits of the displacement from rest, and of the inverse mass in the spare lane.
    #[inline(always)]
    pub(crate) fn moved_bits(&self) -> [u64; 2] {
        (self.moved_m + self.step_m).to_bits()
    }

    /// Bits of the velocity, and of the zero in the spare lane.
    #[inline(always)]
    pub(crate) fn velocity_bits(&self) -> [u64; 2] {
        self.velocity_m_s.to_bits()
    }

    /// Adds `step_m` to the displacement, m.
    #[inline]
    pub(crate) fn move_by(&mut self, step_m: &Vec3) {
        self.step_m = self.step_m + Lanes::new(step_m, 0.0);
    }

    /// Applies a positional impulse (force times dt², m kg) to a sphere of this inverse mass.
    #[inline(always)]
    pub(crate) fn push(&mut self, impulse_m_kg: Lanes, weight_per_kg: f32) {
        self.step_m = self.step_m + impulse_m_kg.scaled(weight_per_kg);
    }

    /// Scales the displacement of this substep by `factor`.
    #[inline]
    pub(crate) fn scale_step(&mut self, factor: f32) {
        self.step_m = self.step_m.scaled(factor);
    }

    /// Predicted centre, world frame, m.
    #[inline]
    pub(crate) fn center_m(&self) -> Vec3 {
        self.center().vec3()
    }

    /// Predicted centre, world frame, m. The spare lane has no meaning.
    #[inline(always)]
    pub(crate) fn center(&self) -> Lanes {
        self.rest_m + self.moved_m + self.step_m
    }

    /// Predicted centre relative to the predicted centre of `other`, m. The spare lane has no
    /// meaning. Rest positions, displacements and steps are subtracted separately: their
    /// differences keep bits that the difference of two centres has lost.
    #[inline(always)]
    pub(crate) fn from(&self, other: &Self) -> Lanes {
        (self.rest_m - other.rest_m)
            + ((self.moved_m - other.moved_m) + (self.step_m - other.step_m))
    }

    /// Centre relative to the centre of `other` at the start of this substep, m. The spare lane has
    /// no meaning.
    #[inline(always)]
    pub(crate) fn away_at_start(&self, other: &Self) -> Lanes {
        (self.rest_m - other.rest_m) + (self.moved_m - other.moved_m)
    }

    /// Sets the displacement from rest, m, and the velocity, m/s.
    pub(crate) fn put(&mut self, moved_m: &Vec3, velocity_m_s: &Vec3) {
        self.moved_m = Lanes::new(moved_m, self.moved_m.spare());
        self.step_m = Lanes::ZERO;
        self.velocity_m_s = Lanes::new(velocity_m_s, 0.0);
    }
}

/// State of every sphere, and of the structures between them.
#[derive(Debug, Clone)]
pub struct Bodies {
    /// Rest position, displacement, velocity and inverse mass of each sphere.
    pub(crate) nodes: PerSphere<Node>,
    /// Radius, m.
    pub(crate) radius_m: PerSphere<f32>,
    /// Flags of each sphere, written by contact and procedure.
    pub(crate) bits: PerSphere<SphereBits>,
    /// Index of each sphere's organ.
    pub(crate) organ: PerSphere<u8>,
    pub(crate) adjacency: Adjacency,
    pub(crate) damage: Damage,
    /// Layered tissue.
    pub(crate) cells: Cells,
    /// Balls with which tools collide on organs without a contact skin.
    pub(crate) beads: Beads,
    /// Sutures that hang organs on the abdominal wall.
    pub(crate) sutures: Sutures,
    ties: TieSchedule,
    pub(crate) warm_start: WarmStart,
    /// Compliance that one pass adds to the links of tubes.
    pub(crate) one_pass: OnePass,
    /// Low-pass filtered displacement of each sphere, m: the trail that sleep compares with.
    trail_m: PerSphere<Lanes>,
}

impl Bodies {
    /// An empty state, before a scene is loaded.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            nodes: PerSphere::new(Node::ZERO),
            radius_m: PerSphere::new(0.0),
            bits: PerSphere::new(SphereBits(0)),
            organ: PerSphere::new(0),
            adjacency: Adjacency::new(),
            damage: Damage::NONE,
            cells: Cells::new(),
            beads: Beads::new(),
            sutures: Sutures::NONE,
            ties: TieSchedule::NONE,
            warm_start: WarmStart::REST,
            one_pass: OnePass::NONE,
            trail_m: PerSphere::new(Lanes::ZERO),
        }
    }

    /// Loads `scene`, at rest.
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
        self.warm_start.build(scene);
        self.one_pass.build(scene, &mut self.trail_m);
        self.reset(scene);
    }

    /// Starts a tick: if `is_awake`, marks every organ as simulated and draws sutures in. Clears
    /// the contact flags.
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
            let kept = SphereBits::GRASPED.with(SphereBits::REMOVED);
            *bits = SphereBits(bits.0 & kept.0).with(awake);
        }
    }

    /// Marks an organ as not simulated in this tick.
    pub(crate) fn mark_asleep(&mut self, organ: &Organ) {
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

    /// Bounding box of an organ in its present shape.
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

    /// Puts every sphere back to rest, and removes all damage.
    pub(crate) fn reset(&mut self, scene: &Scene<'_>) {
        self.damage.heal(scene);
        self.cells.reset(scene);
        self.sutures.reset(scene);
        for (i, rest) in (0u32..).zip(scene.spheres) {
            let node = self.nodes.at_mut(i);
            node.put(&Vec3::zeros(), &Vec3::zeros());
            node.set_inverse_mass_per_kg(inverse_mass_per_kg(rest));
            *self.trail_m.at_mut(i) = node.moved_m;
            *self.radius_m.at_mut(i) = rest.radius_m;
            *self.bits.at_mut(i) = SphereBits(0);
        }
        for organ in scene.organs {
            self.warm_start.reset(scene, organ);
            self.warm_start.set_masses(scene, organ, &self.nodes);
        }
    }
}

impl Default for Bodies {
    fn default() -> Self {
        Self::new()
    }
}

/// Inverse mass of a sphere, 1/kg; 0 if the scene holds it in place.
pub(crate) fn inverse_mass_per_kg(rest: &RestSphere) -> f32 {
    if rest.held { 0.0 } else { rest.mass_kg.recip() }
}
