//! What is pressed: a wall, and tissue.

use rt_core::math::{Pose, Vec3};
use rt_core::scene::{Material, Organ, RestSphere, Room, Scene};

use crate::body::{Body, Tissue};
use crate::methods::{Parts, Surroundings};
use crate::organ;

/// A wall: one sphere of 50 mm that is held, its top at 0.
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
        let room = Room {
            gravity_m_s2: Vec3::zeros(),
            world_from_device: Pose::identity(),
            world_from_tracker: Pose::identity(),
            instrument_port_m: Vec3::new(0.0, 0.0, 0.2),
            instrument_length_m: 0.33,
            endoscope_port_m: Vec3::new(0.1, 0.0, 0.2),
            world_from_camera: Pose::identity(),
            breath_s: 0.0,
        };
        Scene::new(&self.organs, &self.spheres, &[], room).map_err(|e| e.to_string())
    }
}

/// A liver, its lower part held, of so many spheres and this modulus; and the height at which the
/// tip meets it, m.
pub(super) fn liver(spheres: usize, young_pa: f64) -> Result<(Parts, f64), String> {
    let tissue = Tissue {
        young_pa,
        ..Tissue::LIVER
    };
    let surface = organ::Organ::Liver.mesh()?;
    let body = Body::packed(&surface, spheres, tissue).ok_or("the liver cannot be packed")?;
    let around = Surroundings {
        gravity_m_s2: Vec3::zeros(),
        damping_per_s: 5.0,
    };
    let mut parts = Parts::new(&body, &around, None).map_err(|e| e.to_string())?;
    // Without gaps: no contact skin here, so that the tool meets the spheres themselves.
    parts.settle(-0.02, 0.8 * body.spacing_m(), 0.002);
    let under = |s: &&RestSphere| s.center_m.xy().norm() < 0.5 * body.spacing_m();
    let tops = parts.spheres().iter().filter(under);
    let top_m = tops
        .map(|s| s.center_m.z + s.radius_m)
        .fold(f32::MIN, f32::max);
    Ok((parts, f64::from(top_m)))
}
