//! Bodies on which the device presses: a wall, and tissue.

use rt_core::math::{Pose, Vec3};
use rt_core::scene::{Inside, Material, Organ, Relaxation, RestSphere, Room, Scene, Trocar};
use scene_prepare::held::Plane;

use crate::body::Tissue;
use crate::methods::{Parts, Surroundings};
use crate::organ;
use crate::prepared::prepared;

/// A wall: the top of one held sphere of 50 mm radius, at height 0.
pub(super) struct Wall {
    organs: [Organ; 1],
    spheres: [RestSphere; 1],
}

impl Wall {
    pub(super) fn new(stiffness_n_m: f64) -> Self {
        let material = Material {
            young_pa: 5000.0,
            poisson: 0.45,
            retardation_s: 0.0,
            stretch_stiffness: 1.0,
            laplacian_stiffness: 1.0,
            damping_per_s: 0.0,
            contact_stiffness_n_m: stiffness_n_m as f32,
            friction: 0.0,
            toughness_j_m2: 0.0,
            relaxation: Relaxation::NONE,
        };
        Self {
            organs: [Organ {
                sphere_start: 0,
                sphere_count: 1,
                link_start: 0,
                link_count: 0,
                elastic_links: 0,
                batch_start: 0,
                batch_count: 0,
                substeps: 1,
                gravity_share: 0.0,
                breath_m: Vec3::zeros(),
                inside: Inside::Solid,
                material,
            }],
            spheres: [RestSphere {
                center_m: Vec3::new(0.0, 0.0, -0.05),
                radius_m: 0.05,
                mass_kg: 1.0,
                held: true,
            }],
        }
    }

    pub(super) fn scene(&self) -> Result<Scene<'_>, String> {
        Scene::new(&self.organs, &self.spheres, &[], room()).map_err(|e| e.to_string())
    }
}

/// A room without gravity in which the base frames of the devices are the world frame.
pub(super) fn room() -> Room {
    Room {
        gravity_m_s2: Vec3::zeros(),
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

/// Height below which the liver is held, m.
const HELD_BELOW_M: f64 = -0.02;

/// Part of a liver that the tip touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meets {
    /// The contact skin, as in Calot.
    Skin,
    /// The spheres, nearly rigid and so wide that there are no gaps.
    Spheres,
}

/// A liver with this number of spheres and this modulus, Pa, and the height at which the tip
/// touches it, m. The liver's lower part is held.
pub(super) fn liver(spheres: usize, young_pa: f64, meets: Meets) -> Result<(Parts, f64), String> {
    let tissue = Tissue {
        young_pa,
        ..Tissue::LIVER
    };
    let surface = organ::Organ::Liver.mesh()?;
    let plane = Plane {
        point_m: nalgebra::Vector3::z() * HELD_BELOW_M,
        normal: -nalgebra::Vector3::z(),
    };
    let (body, skin) = prepared(&surface, spheres, tissue, &[plane])?;
    let around = Surroundings::weightless(&tissue);
    let mut parts = Parts::new(&body, &around, None).map_err(|e| e.to_string())?;
    let highest = |tops: &mut dyn Iterator<Item = Vec3>, within_m: f32| {
        let under = tops.filter(|p| p.xy().norm() < within_m);
        f64::from(under.map(|p| p.z).fold(f32::MIN, f32::max))
    };
    Ok(match meets {
        Meets::Skin => {
            let mut tops = surface.vertices.iter().map(|p| p.cast());
            let top_m = highest(&mut tops, 0.003);
            (parts.with_skin(skin), top_m)
        }
        Meets::Spheres => {
            parts.widen(0.8 * body.spacing_m());
            parts.meet_with(1e6);
            let top = |s: &RestSphere| s.center_m + Vec3::z() * s.radius_m;
            let top_m = highest(&mut parts.spheres().iter().map(top), 0.5 * body.spacing_m());
            (parts, top_m)
        }
    })
}
