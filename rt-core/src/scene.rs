//! The immutable scene: validated slices, no file format.

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
}

/// Everything that does not change while the simulation runs. Build it with [`Scene::new`].
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub(crate) organs: &'a [Organ],
    pub(crate) spheres: &'a [RestSphere],
    pub(crate) links: &'a [Link],
    pub(crate) room: Room,
}
