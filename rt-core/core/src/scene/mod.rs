//! The immutable scene: validated slices, no file format.

mod cell;
mod check;
mod skin;
mod stones;
mod suture;
mod tetra;
mod trocar;

pub use cell::{COLUMNS, Cell, Column, Layers, NO_CELL};
pub use check::SceneError;
pub use skin::{NO_VERTEX, SKIN_BINDINGS, Skin, SkinVertex};
pub use stones::{Bowl, Stones};
pub(crate) use suture::{is_suture, numbered};
pub use tetra::{LANES, Tetra, TetraBatch, batches};
pub use trocar::{Trocar, TrocarChoice};

use crate::math::{Pose, Vec3};
use crate::time::TICK_S;

/// Material of an organ. The two stiffnesses of the inner-sphere paper's method are shares, 0..=1.
/// The resulting stiffness of the tissue also depends on the number of iterations and the time
/// step, which is a known fault of this method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young_pa: f32,
    /// Poisson's ratio, 0..0.5.
    pub poisson: f32,
    /// Retardation time (Kelvin–Voigt), s: viscosity divided by modulus. A larger one damps strain
    /// rates more.
    pub retardation_s: f32,
    /// Share of a link's stretch corrected in an iteration (paper Eq. 4–5).
    pub stretch_stiffness: f32,
    /// Share of the distance to the Laplacian target by which a sphere moves in an iteration (paper
    /// Eq. 8).
    pub laplacian_stiffness: f32,
    /// Share of velocity lost per second (damping proportional to mass).
    pub damping_per_s: f32,
    /// Stiffness of a sphere's wall under a tool, N/m, in organs without a contact skin.
    pub contact_stiffness_n_m: f32,
    /// Coefficient of Coulomb friction on a moist steel tool.
    pub friction: f32,
    /// Energy of a tear or cut per area, J/m²; 0 if the organ cannot tear.
    pub toughness_j_m2: f32,
}

impl Material {
    /// A material without any stiffness.
    const NONE: Self = Self {
        young_pa: 0.0,
        poisson: 0.0,
        retardation_s: 0.0,
        stretch_stiffness: 0.0,
        laplacian_stiffness: 0.0,
        damping_per_s: 0.0,
        contact_stiffness_n_m: 0.0,
        friction: 0.0,
        toughness_j_m2: 0.0,
    };
}

/// An organ: ranges into the scene's arrays, and its material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Organ {
    /// First sphere.
    pub sphere_start: u32,
    /// Number of spheres.
    pub sphere_count: u32,
    /// First link.
    pub link_start: u32,
    /// Number of links.
    pub link_count: u32,
    /// Number of links, from the first, that carry load in addition to the tetrahedra. The paper's
    /// method uses all links.
    pub elastic_links: u32,
    /// First batch of tetrahedra.
    pub batch_start: u32,
    /// Number of batches.
    pub batch_count: u32,
    /// Substeps in a tick, 1 to [`SUBSTEPS_MAX`]: a power of two, so that the substeps of attached
    /// organs end together. Preparation chooses them by the organ's stiffness.
    pub substeps: u32,
    /// Share of gravity that acts on the organ: 0 if its rest shape is its shape in the body under
    /// its own weight; 1 if its rest shape is the unloaded shape.
    pub gravity_share: f32,
    /// Displacement of its held spheres at full inspiration, world frame, m.
    pub breath_m: Vec3,
    /// Content.
    pub inside: Inside,
    /// Material.
    pub material: Material,
}

impl Organ {
    /// True for a tube: it has elastic links and no tetrahedra.
    pub(crate) const fn is_tube(&self) -> bool {
        self.batch_count == 0 && self.elastic_links > 0
    }
}

/// Content of an organ. Blood and bile leak from a hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Inside {
    /// Solid tissue.
    #[default]
    Solid,
    /// Liver: tissue whose bile flows into attached ducts.
    Liver,
    /// Blood, which enters where the vessel is held, or attached to another vessel.
    Blood,
    /// Bile: bags (organs with tetrahedra) are full of bile, and ducts carry it.
    Bile,
    /// Food.
    Food,
}

/// Largest number of substeps in a tick.
pub const SUBSTEPS_MAX: u32 = 16;

/// A sphere at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestSphere {
    /// Centre, world frame, m.
    pub center_m: Vec3,
    /// Radius, m.
    pub radius_m: f32,
    /// Mass, kg. Positive.
    pub mass_kg: f32,
    /// True if the sphere is fixed to its surroundings: constraints do not move it.
    pub held: bool,
}

/// A distance constraint between two spheres of one organ (indices into the scene's spheres).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// First sphere.
    pub a: u32,
    /// Second sphere.
    pub b: u32,
    /// Distance at rest, m.
    pub rest_length_m: f32,
    /// Compliance of an elastic link, m/N.
    pub compliance_m_n: f32,
}

/// A distance constraint between spheres of two organs, or from a sphere to a point of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attachment {
    /// The sphere.
    pub sphere: u32,
    /// The other end.
    pub to: Anchor,
    /// Rest length, m; at 0, the two ends are held together.
    pub rest_length_m: f32,
    /// Compliance, m/N.
    pub compliance_m_n: f32,
    /// True for a thread, which pulls but does not push.
    pub is_thread: bool,
    /// Energy that tears it, J; 0 if it cannot tear.
    pub tear_j: f32,
}

impl Attachment {
    /// The sphere at the other end, if it is not a point of the world.
    #[inline]
    pub(crate) fn other_sphere(&self) -> Option<u32> {
        match self.to {
            Anchor::Sphere(sphere) => Some(sphere),
            Anchor::World(_) => None,
        }
    }
}

/// The other end of an [`Attachment`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Anchor {
    /// A sphere of another organ.
    Sphere(u32),
    /// A point, world frame, m.
    World(Vec3),
}

/// Layout of the operating room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// Gravity, m/s².
    pub gravity_m_s2: Vec3,
    /// Base frame of the haptic device in the world.
    pub world_from_device: Pose,
    /// Transmitter frame of the tracker in the world.
    pub world_from_tracker: Pose,
    /// Port of the instrument, through which the shaft always passes, world frame, m.
    pub instrument_port_m: Vec3,
    /// Distance from the handle to the tip, m.
    pub instrument_length_m: f32,
    /// The endoscope's port, world frame, m.
    pub endoscope_port_m: Vec3,
    /// Camera pose before the first tracker sample: looks along −z, y up.
    pub world_from_camera: Pose,
    /// Duration of a breath, s; 0: no breathing.
    pub breath_s: f32,
    /// Seal and wall at the instrument's port.
    pub trocar: Trocar,
}

/// Immutable data of a simulation. Build it with [`Scene::new`].
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub(crate) organs: &'a [Organ],
    pub(crate) spheres: &'a [RestSphere],
    pub(crate) links: &'a [Link],
    pub(crate) batches: &'a [TetraBatch],
    pub(crate) attachments: &'a [Attachment],
    pub(crate) skin: Skin<'a>,
    pub(crate) layers: Layers<'a>,
    pub(crate) stones: Stones,
    pub(crate) room: Room,
}

impl<'a> Scene<'a> {
    /// The organs.
    #[must_use]
    pub const fn organs(&self) -> &'a [Organ] {
        self.organs
    }

    /// The spheres at rest.
    #[must_use]
    pub const fn spheres(&self) -> &'a [RestSphere] {
        self.spheres
    }

    /// The links, in the order of solution.
    #[must_use]
    pub const fn links(&self) -> &'a [Link] {
        self.links
    }

    /// The spheres of `organ` at rest.
    pub(crate) fn spheres_of(&self, organ: &Organ) -> &'a [RestSphere] {
        let start = organ.sphere_start as usize;
        self.spheres
            .get(start..start.saturating_add(organ.sphere_count as usize))
            .unwrap_or(&[])
    }

    /// The links of `organ`.
    pub(crate) fn links_of(&self, organ: &Organ) -> &'a [Link] {
        let start = organ.link_start as usize;
        self.links
            .get(start..start.saturating_add(organ.link_count as usize))
            .unwrap_or(&[])
    }

    /// The links of `organ` that carry load in addition to its tetrahedra.
    pub(crate) fn elastic_links_of(&self, organ: &Organ) -> &'a [Link] {
        let links = self.links_of(organ);
        links.get(..organ.elastic_links as usize).unwrap_or(links)
    }

    /// The tetrahedra of `organ`.
    pub(crate) fn batches_of(&self, organ: &Organ) -> &'a [TetraBatch] {
        let start = organ.batch_start as usize;
        self.batches
            .get(start..start.saturating_add(organ.batch_count as usize))
            .unwrap_or(&[])
    }

    /// The material of the organ with this index, or one without stiffness.
    pub(crate) fn material_of(&self, organ: u8) -> Material {
        self.organs
            .get(usize::from(organ))
            .map_or(Material::NONE, |organ| organ.material)
    }

    /// Number of substeps of the organ with this index.
    pub(crate) fn substeps_of(&self, organ: u8) -> u32 {
        let organ = self.organs.get(usize::from(organ));
        organ.map_or(1, |organ| organ.substeps.max(1))
    }

    /// Length of a substep of the organ with this index, s.
    pub(crate) fn step_s_of(&self, organ: u8) -> f32 {
        TICK_S / self.substeps_of(organ) as f32
    }

    /// Largest number of substeps of any organ.
    pub(crate) fn finest(&self) -> u32 {
        let substeps = self.organs.iter().map(|organ| organ.substeps);
        substeps.fold(1, u32::max)
    }

    /// Layout of the room.
    #[must_use]
    pub const fn room(&self) -> &Room {
        &self.room
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn sphere(center_m: Vec3, radius_m: f32) -> RestSphere {
        RestSphere {
            center_m,
            radius_m,
            mass_kg: 0.002,
            held: false,
        }
    }

    pub(crate) fn organ(
        sphere_start: u32,
        sphere_count: u32,
        link_start: u32,
        link_count: u32,
    ) -> Organ {
        let material = Material {
            young_pa: 5000.0,
            poisson: 0.45,
            retardation_s: 0.0,
            stretch_stiffness: 0.5,
            laplacian_stiffness: 0.1,
            damping_per_s: 1.0,
            contact_stiffness_n_m: 500.0,
            friction: 0.0,
            toughness_j_m2: 0.0,
        };
        Organ {
            sphere_start,
            sphere_count,
            link_start,
            link_count,
            elastic_links: link_count,
            batch_start: 0,
            batch_count: 0,
            substeps: 1,
            gravity_share: 1.0,
            breath_m: Vec3::zeros(),
            inside: Inside::Solid,
            material,
        }
    }

    pub(crate) fn room() -> Room {
        Room {
            gravity_m_s2: Vec3::new(0.0, 0.0, -9.81),
            world_from_device: Pose::identity(),
            world_from_tracker: Pose::identity(),
            instrument_port_m: Vec3::new(0.0, 0.0, 0.2),
            instrument_length_m: 0.33,
            endoscope_port_m: Vec3::new(0.1, 0.0, 0.2),
            world_from_camera: Pose::identity(),
            breath_s: 0.0,
            trocar: Trocar::NONE,
        }
    }
}
