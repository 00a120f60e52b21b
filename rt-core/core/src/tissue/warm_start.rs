//! Warm start: every tetrahedron, and every link of an organ without tetrahedra, keeps the impulse
//! of its last projection. An impulse in this module is a positional one: force times dt², m kg.
//!
//! A substep begins with all impulses of the last substep. Each constraint then removes its own
//! impulse, solves for a new one, and applies the difference. At rest nothing changes, so the
//! impulses balance exactly, in one pass and with any number of substeps. Without warm start,
//! tissue would be too soft after one pass: each constraint would see the corrections of the
//! constraints before it, but not of those after it.
//!
//! The impulses of the later constraints come from the last substep, so they act like explicit
//! forces. Such forces are stable while the stiffness of a sphere times `dt²` over its mass is not
//! too large. Stiffer organs keep a smaller share of their impulses ([`Limits`]). This makes them
//! softer than their material, but stable at any stiffness.
//!
//! Attachments, contacts and grip act after these constraints, and so do the links of an organ that
//! has tetrahedra too. Their impulses of the last substep act already before the organ's elastic
//! constraints are solved, and are removed again afterwards. Without these impulses, the solver
//! would find pressed tissue sprung back, and it would resist too little. The contact between
//! organs also acts before the tools, so it begins with the tools' impulses of the last substep.
//! Otherwise a fold in the jaws would spring back by millimetres, press its neighbours away, and
//! never come to rest.
//!
//! Viscosity also needs memory. A constraint resists the change of its strain since its last
//! projection, so viscosity vanishes at rest.

use crate::capacity::{MAX_BATCHES, MAX_LINKS, MAX_ORGANS, MAX_TUBE_LINKS};
use crate::math;
use crate::scene::{LANES, Organ, Scene, TetraBatch};
use crate::tissue::Node;
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::relaxation::{Lost, NOTHING_LOST};

/// Share of the impulses with which the next substep begins. The missing 1 ‰ lets rounding errors
/// decay. A smaller share makes tissue softer.
const KEPT_SHARE: f32 = 0.999;
/// Share, relative to `KEPT_SHARE`, that the stiffest organ keeps. Tissue of up to 50 MPa is stable
/// with it (`stiff_tissue_comes_to_rest`).
const KEPT_SHARE_MIN: f32 = 0.5;
/// Stiffness number of a sphere (stiffness times `dt²` over mass) up to which an organ keeps
/// `KEPT_SHARE`. Tissue stays stable at 86 while it is shaken, and at 34 while it is squeezed to 40
/// % of its height (`squeezed_tissue_stays_whole`).
const STIFFNESS_NUMBER_MAX: f32 = 34.0;

/// The same for an organ of links. Each sphere of a tube has only a few links, which pass a wave
/// on; at 5.8 a stretched tube rests, at 6.9 it shakes (`a_stretched_tube_has_its_materials_force`).
const LINKS_STIFFNESS_NUMBER_MAX: f32 = 4.0;

/// Largest product of two numbers: the stiffness number (see [`STIFFNESS_NUMBER_MAX`]), and the
/// weight of the strain rate relative to the strain. Viscosity is part of the impulses of the last
/// substep, so a larger product would shake the tissue (`viscosity_does_not_change_a_sag`: 3.4 is
/// stable, 8.5 is not).
const VISCOSITY_NUMBER_MAX: f32 = 3.0;
/// The same for an organ of links: five is stable in the order of solution that preparation chooses
/// (`a_viscous_tube_rests`), one if the links follow each other along the tube.
const LINKS_VISCOSITY_NUMBER_MAX: f32 = 1.5;

/// Memory of a batch of tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchMemory {
    /// Volume after the last projection, as a share of the volume at rest: the determinant of the
    /// deformation.
    pub(crate) volume: [f32; LANES],
    /// Negative first Piola–Kirchhoff stress divided by the shear modulus μ, by row, column and
    /// lane. The kernel calls it `P`. The impulse on a corner is `μ dt² V` times this matrix times
    /// the corner's shape gradient.
    pub(crate) stress: [[[f32; LANES]; 3]; 3],
    /// `V Σ w b bᵀ` over the corners, entries xx, yy, zz, xy, xz, yz, m/kg. V is the volume, w a
    /// corner's inverse mass, b its shape gradient. The matrix follows from the scene and the
    /// masses.
    pub(crate) mobility_m_kg: [[f32; LANES]; 6],
}

impl BatchMemory {
    /// No deformation.
    pub(crate) const REST: Self = Self {
        volume: [1.0; LANES],
        stress: [[[0.0; LANES]; 3]; 3],
        mobility_m_kg: [[0.0; LANES]; 6],
    };

    /// No deformation and no impulse.
    pub(crate) fn reset(&mut self) {
        self.volume = Self::REST.volume;
        self.stress = Self::REST.stress;
    }

    /// Adopts the present masses of the corners.
    pub(crate) fn set_masses(&mut self, batch: &TetraBatch, nodes: &PerSphere<Node>) {
        self.mobility_m_kg = Self::REST.mobility_m_kg;
        batch.each_corner(|lane, sphere, b, volume_m3| {
            let share = volume_m3 * nodes.at(sphere).inverse_mass_per_kg();
            let products = [
                b.x * b.x,
                b.y * b.y,
                b.z * b.z,
                b.x * b.y,
                b.x * b.z,
                b.y * b.z,
            ];
            for (entry, product) in self.mobility_m_kg.iter_mut().zip(products) {
                if let Some(slot) = entry.get_mut(lane) {
                    *slot += share * product;
                }
            }
        });
    }
}

/// Impulses on a sphere in the last substep, m kg.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SphereMemory {
    /// Impulse of all tetrahedra; in an organ without tetrahedra, of all links.
    pub(crate) elastic: Lanes,
    /// Impulse of everything that acts after these: attachments, contacts, grip, and the links of
    /// an organ with tetrahedra.
    pub(crate) outer: Lanes,
    /// Impulse of the tools alone: clips, grip and contacts with instruments. Late in a substep, it
    /// holds the sphere's step before the tools instead, m.
    /// [`crate::tissue::Bodies::store_steps_before_tools`] stores this step, and the end of the
    /// substep replaces it by the impulse.
    pub(crate) tools: Lanes,
    /// Step of the sphere after the elastic constraints, without the outer impulses, m.
    pub(crate) step_after_elastic_m: Lanes,
}

impl SphereMemory {
    /// No impulse.
    const REST: Self = Self {
        elastic: Lanes::ZERO,
        outer: Lanes::ZERO,
        tools: Lanes::ZERO,
        step_after_elastic_m: Lanes::ZERO,
    };
}

/// Memory of all tetrahedra and links.
#[derive(Debug, Clone)]
pub(crate) struct WarmStart {
    batches: [BatchMemory; MAX_BATCHES],
    /// Length of each link after its last projection, m.
    links_m: [f32; MAX_LINKS],
    /// Impulse of each link of the organs without tetrahedra on its first sphere, m kg. Spare lane:
    /// its size, positive if the link pushes its spheres apart.
    link_impulses: [Lanes; MAX_TUBE_LINKS],
    spheres: PerSphere<SphereMemory>,
    /// Impulses that the spheres of relaxing organs have lost.
    lost: PerSphere<Lost>,
    /// Bounds of each organ, from its stiffness and substeps.
    limits: [Limits; MAX_ORGANS],
}

/// Bounds within which an organ is stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Share of its impulses that the organ keeps.
    pub(crate) kept_share: f32,
    /// Largest weight of the strain rate relative to the strain (retardation time divided by dt).
    pub(crate) rate_max: f32,
}

impl Limits {
    /// No warm start and no viscosity.
    pub(crate) const NONE: Self = Self {
        kept_share: 0.0,
        rate_max: 0.0,
    };

    /// Bounds of an organ with tetrahedra for this stiffness number. NaN gets the tightest bounds.
    fn of_tetrahedra(stiffness: f32) -> Self {
        let margin = (STIFFNESS_NUMBER_MAX / stiffness).max(0.0);
        Self {
            kept_share: KEPT_SHARE * (KEPT_SHARE_MIN + (1.0 - KEPT_SHARE_MIN) * margin.min(1.0)),
            rate_max: (VISCOSITY_NUMBER_MAX / stiffness).max(0.0),
        }
    }

    /// Bounds of an organ of links. One that is too stiff keeps nothing, and nor does one without
    /// room in `link_impulses`.
    fn of_links(stiffness: f32) -> Self {
        let keeps = stiffness <= LINKS_STIFFNESS_NUMBER_MAX;
        Self {
            kept_share: if keeps { KEPT_SHARE } else { 0.0 },
            rate_max: if keeps {
                (LINKS_VISCOSITY_NUMBER_MAX / stiffness).max(0.0)
            } else {
                f32::MAX
            },
        }
    }
}

/// Memory of an organ.
#[derive(Debug)]
pub(crate) struct OrganMemory<'a> {
    /// Memory of its batches.
    pub(crate) batches: &'a mut [BatchMemory],
    /// Length of each of its elastic links after its last projection, m.
    pub(crate) links_m: &'a mut [f32],
    /// Memory of its spheres.
    pub(crate) spheres: &'a mut [SphereMemory],
    /// Impulses that its spheres have lost.
    pub(crate) lost: &'a mut [Lost],
}

impl WarmStart {
    pub(crate) const REST: Self = Self {
        batches: [BatchMemory::REST; MAX_BATCHES],
        links_m: [0.0; MAX_LINKS],
        link_impulses: [Lanes::ZERO; MAX_TUBE_LINKS],
        spheres: PerSphere::new(SphereMemory::REST),
        lost: PerSphere::new(NOTHING_LOST),
        limits: [Limits::NONE; MAX_ORGANS],
    };

    /// Computes the bounds of each organ of `scene`. Overwrites the memory of its spheres.
    pub(crate) fn build(&mut self, scene: &Scene<'_>) {
        for ((i, organ), limits) in (0u8..).zip(scene.organs).zip(&mut self.limits) {
            let step_s = scene.step_s_of(i);
            let number = stiffest_n_m_kg(scene, organ, &mut self.spheres) * step_s * step_s;
            let links = scene
                .tube_links_before(organ)
                .saturating_add(organ.elastic_links);
            *limits = match organ.is_tube() {
                true if links as usize > MAX_TUBE_LINKS => Limits::of_links(f32::INFINITY),
                true => Limits::of_links(number),
                false => Limits::of_tetrahedra(number),
            };
        }
    }

    /// True if an organ, which has this index, keeps impulses.
    pub(crate) fn keeps(&self, organ: &Organ, index: u8) -> bool {
        organ.batch_count > 0 || (organ.is_tube() && self.limits(index).kept_share > 0.0)
    }

    /// Bounds of an organ.
    pub(crate) fn limits(&self, organ: u8) -> Limits {
        let tightest = Limits::of_tetrahedra(f32::INFINITY);
        self.limits
            .get(usize::from(organ))
            .copied()
            .unwrap_or(tightest)
    }

    /// Length of the link with this index after its last projection, m.
    #[inline(always)]
    pub(crate) fn link_m(&mut self, link: u32) -> Option<&mut f32> {
        self.links_m.get_mut(link as usize)
    }

    /// Length of the link with this index after its last projection, m, and impulse of the link
    /// with this number among those of organs without tetrahedra ([`Scene::tube_links_before`]).
    #[inline(always)]
    pub(crate) fn tube_link(&mut self, link: u32, number: u32) -> Option<(&mut f32, &mut Lanes)> {
        let impulse = self.link_impulses.get_mut(number as usize)?;
        Some((self.links_m.get_mut(link as usize)?, impulse))
    }

    /// Impulse of the tools on a sphere in its last substep, m kg.
    #[inline(always)]
    pub(crate) fn tools(&self, sphere: u32) -> Lanes {
        self.spheres.at(sphere).tools
    }

    /// Memory of an organ.
    pub(crate) fn of(&mut self, organ: &Organ) -> OrganMemory<'_> {
        OrganMemory {
            batches: range(&mut self.batches, organ.batch_start, organ.batch_count),
            links_m: range(&mut self.links_m, organ.link_start, organ.elastic_links),
            spheres: self
                .spheres
                .range_mut(organ.sphere_start, organ.sphere_count),
            lost: self.lost.range_mut(organ.sphere_start, organ.sphere_count),
        }
    }

    /// Puts every constraint of an organ to rest, without impulses. This also removes NaN, which
    /// would otherwise spread to every later substep.
    pub(crate) fn reset(&mut self, scene: &Scene<'_>, organ: &Organ) {
        self.forget_links(scene, organ);
        let memory = self.of(organ);
        memory.spheres.fill(SphereMemory::REST);
        memory.batches.iter_mut().for_each(BatchMemory::reset);
        memory.lost.fill(NOTHING_LOST);
        let at_m = |sphere: u32| scene.spheres.get(sphere as usize).map(|it| it.center_m);
        for (length_m, link) in memory.links_m.iter_mut().zip(scene.elastic_links_of(organ)) {
            *length_m = match (at_m(link.a), at_m(link.b)) {
                (Some(a_m), Some(b_m)) => math::norm(&(a_m - b_m)),
                _ => 0.0,
            };
        }
    }

    /// Removes the impulses of the links of an organ without tetrahedra.
    fn forget_links(&mut self, scene: &Scene<'_>, organ: &Organ) {
        if organ.is_tube() {
            let start = scene.tube_links_before(organ);
            range(&mut self.link_impulses, start, organ.elastic_links).fill(Lanes::ZERO);
        }
    }

    /// Adopts the present masses of an organ's spheres, and forgets its impulses.
    pub(crate) fn set_masses(&mut self, scene: &Scene<'_>, organ: &Organ, nodes: &PerSphere<Node>) {
        self.forget_links(scene, organ);
        let memory = self.of(organ);
        memory.spheres.fill(SphereMemory::REST);
        for (memory, batch) in memory.batches.iter_mut().zip(scene.batches_of(organ)) {
            memory.stress = BatchMemory::REST.stress;
            memory.set_masses(batch, nodes);
        }
    }
}

/// Largest ratio of stiffness to mass among the free spheres of an organ, N/(m kg). The stiffness
/// of a sphere is that of its tetrahedra; in an organ without tetrahedra, of its links. The spare
/// lane of `elastic` in `scratch` sums it up, and `scratch` is overwritten for the organ's spheres.
fn stiffest_n_m_kg(scene: &Scene<'_>, organ: &Organ, scratch: &mut PerSphere<SphereMemory>) -> f32 {
    let (start, count) = (organ.sphere_start, organ.sphere_count);
    scratch.range_mut(start, count).fill(SphereMemory::REST);
    let modulus_pa = super::neo_hookean::wave_modulus_pa(&organ.material);
    for batch in scene.batches_of(organ) {
        batch.each_corner(|_, sphere, gradient_per_m, volume_m3| {
            let stiffness_n_m = modulus_pa * volume_m3 * gradient_per_m.norm_squared();
            let sum = &mut scratch.at_mut(sphere).elastic;
            *sum = sum.with_spare(sum.spare() + stiffness_n_m);
        });
    }
    let is_tube = organ.is_tube();
    for link in scene.elastic_links_of(organ).iter().filter(|_| is_tube) {
        for sphere in [link.a, link.b] {
            let sum = &mut scratch.at_mut(sphere).elastic;
            *sum = sum.with_spare(sum.spare() + link.compliance_m_n.recip());
        }
    }
    let sums = scratch.range(start, count).iter();
    let free = sums.zip(scene.spheres_of(organ)).filter(|(_, it)| !it.held);
    free.map(|(sum, it)| sum.elastic.spare() / it.mass_kg)
        .fold(0.0, f32::max)
}

/// Keeps the prediction in `step_after_elastic_m`, and adds the impulses of the last substep to the
/// steps.
pub(crate) fn begin(
    nodes: &mut PerSphere<Node>,
    organ: &Organ,
    kept_share: f32,
    memory: &mut [SphereMemory],
) {
    let nodes = nodes.range_mut(organ.sphere_start, organ.sphere_count);
    for (node, last) in nodes.iter_mut().zip(memory) {
        let weight = kept_share * node.inverse_mass_per_kg();
        last.step_after_elastic_m = node.step_m;
        node.step_m = node.step_m + (last.elastic + last.outer).scaled(weight);
    }
}

/// Subtracts the outer impulses from the steps, and stores the impulses of the elastic constraints
/// in this substep.
pub(crate) fn end(
    nodes: &mut PerSphere<Node>,
    organ: &Organ,
    kept_share: f32,
    memory: &mut [SphereMemory],
) {
    let nodes = nodes.range_mut(organ.sphere_start, organ.sphere_count);
    for (node, last) in nodes.iter_mut().zip(memory) {
        let weight = node.inverse_mass_per_kg();
        node.step_m = node.step_m - last.outer.scaled(kept_share * weight);
        last.elastic = impulse(node.step_m - last.step_after_elastic_m, weight);
        last.step_after_elastic_m = node.step_m;
    }
}

/// Positional impulse, m kg, that moves a sphere of this inverse mass by `step_m`.
pub(crate) fn impulse(step_m: Lanes, weight_per_kg: f32) -> Lanes {
    if weight_per_kg > 0.0 {
        step_m.scaled(weight_per_kg.recip())
    } else {
        Lanes::ZERO
    }
}

fn range<T>(all: &mut [T], start: u32, count: u32) -> &mut [T] {
    let (start, count) = (start as usize, count as usize);
    all.get_mut(start..start.saturating_add(count))
        .unwrap_or(&mut [])
}
