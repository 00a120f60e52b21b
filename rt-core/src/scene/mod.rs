//! The immutable scene: validated slices, no file format.

mod check;

pub use check::SceneError;

use crate::math::{Pose, Vec3};

/// How the paper's method treats one organ. Dimensionless stiffness in 0..=1 (its known fault:
/// it depends on iterations and time step); replaced by SI material values later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PbdMaterial {
    /// Share of a link's stretch corrected in an iteration (paper Eq. 4–5).
    pub stretch_stiffness: f32,
    /// Share of the way to the Laplacian target moved in an iteration (paper Eq. 8).
    pub laplacian_stiffness: f32,
    /// Fraction of velocity lost per second.
    pub damping_per_s: f32,
    /// Hooke constant of the haptic force on penetration, N/m.
    pub contact_stiffness_n_m: f32,
}

impl PbdMaterial {
    /// Neither holds together nor pushes back.
    const NONE: Self = Self {
        stretch_stiffness: 0.0,
        laplacian_stiffness: 0.0,
        damping_per_s: 0.0,
        contact_stiffness_n_m: 0.0,
    };
}

/// An organ: ranges into the scene's arrays, and its material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Organ {
    /// First sphere.
    pub sphere_start: u32,
    /// How many spheres.
    pub sphere_count: u32,
    /// First link.
    pub link_start: u32,
    /// How many links.
    pub link_count: u32,
    /// Material.
    pub material: PbdMaterial,
}

/// A sphere at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestSphere {
    /// Centre, world frame, m.
    pub center_m: Vec3,
    /// Radius, m.
    pub radius_m: f32,
    /// Mass, kg. Positive.
    pub mass_kg: f32,
    /// Attached to its surroundings: never moves.
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
}

/// Where things stand in the room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// Gravity, m/s².
    pub gravity_m_s2: Vec3,
    /// Base frame of the haptic device in the world.
    pub world_from_device: Pose,
    /// Transmitter frame of the tracker in the world.
    pub world_from_tracker: Pose,
    /// The instrument's trocar: the shaft always passes through it, world frame, m.
    pub instrument_port_m: Vec3,
    /// From the handle to the tip, along the shaft, m.
    pub instrument_length_m: f32,
    /// The endoscope's port, world frame, m.
    pub endoscope_port_m: Vec3,
    /// Camera before the first tracker sample: looks along −z, y up.
    pub world_from_camera: Pose,
}

/// Everything that does not change while the simulation runs. Build it with [`Scene::new`].
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub(crate) organs: &'a [Organ],
    pub(crate) spheres: &'a [RestSphere],
    pub(crate) links: &'a [Link],
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

    /// The links, in the order in which they are solved.
    #[must_use]
    pub const fn links(&self) -> &'a [Link] {
        self.links
    }

    /// The links of `organ`.
    pub(crate) fn links_of(&self, organ: &Organ) -> &'a [Link] {
        let start = organ.link_start as usize;
        self.links
            .get(start..start.saturating_add(organ.link_count as usize))
            .unwrap_or(&[])
    }

    /// The material of the organ with this index; one that does nothing if there is none.
    pub(crate) fn material_of(&self, organ: u8) -> PbdMaterial {
        self.organs
            .get(usize::from(organ))
            .map_or(PbdMaterial::NONE, |organ| organ.material)
    }

    /// Where things stand.
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
        let material = PbdMaterial {
            stretch_stiffness: 0.5,
            laplacian_stiffness: 0.1,
            damping_per_s: 1.0,
            contact_stiffness_n_m: 500.0,
        };
        Organ {
            sphere_start,
            sphere_count,
            link_start,
            link_count,
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
        }
    }
}
