//! The compiled scene as the core takes it.

use std::path::Path;

use hardware::station::StationFile;
use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use rt_core::scene::{Link, Organ, PbdMaterial, RestSphere, Room, Scene};
use shared_mem::message::PoseMsg;
use shared_mem::scene::{OrganRecord, RoomRecord, SceneFile};

use crate::error::RtError;

/// A compiled scene, converted once.
#[derive(Debug)]
pub(crate) struct LoadedScene {
    pub(crate) name: String,
    /// First half of the identity, as frames carry it.
    pub(crate) short_id: [u8; 16],
    /// The whole identity, hexadecimal.
    pub(crate) id: String,
    organs: Vec<Organ>,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    room: Room,
}

impl LoadedScene {
    /// Reads and checks a compiled scene.
    /// Devices stand where the station file says, or else where the scene says.
    pub(crate) fn load(path: &Path, station: &StationFile) -> Result<Self, RtError> {
        Self::from_file(&SceneFile::open(path)?, station)
    }

    /// Keeps it for as long as the process lives, as the simulation does.
    pub(crate) fn keep(self) -> &'static Self {
        Box::leak(Box::new(self))
    }

    fn from_file(file: &SceneFile, station: &StationFile) -> Result<Self, RtError> {
        let sphere = |s: &shared_mem::scene::SphereRecord| RestSphere {
            center_m: Vec3::from(s.center_m),
            radius_m: s.radius_m,
            mass_kg: s.mass_kg,
            held: s.held != 0,
        };
        let link = |l: &shared_mem::scene::LinkRecord| Link {
            a: l.a,
            b: l.b,
            rest_length_m: l.rest_length_m,
        };
        let loaded = Self {
            name: file.name().to_owned(),
            short_id: file.short_id(),
            id: file.id().iter().map(|byte| format!("{byte:02x}")).collect(),
            organs: file.organs().iter().map(organ).collect(),
            spheres: file.spheres().iter().map(sphere).collect(),
            links: file.links().iter().map(link).collect(),
            room: room(file.room(), station),
        };
        loaded.scene()?;
        Ok(loaded)
    }

    /// The scene, checked by the core.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, RtError> {
        Scene::new(&self.organs, &self.spheres, &self.links, self.room).map_err(RtError::Core)
    }

    /// How many spheres.
    pub(crate) fn sphere_count(&self) -> usize {
        self.spheres.len()
    }
}

fn organ(record: &OrganRecord) -> Organ {
    let material = &record.material;
    Organ {
        sphere_start: record.spheres[0],
        sphere_count: record.spheres[1],
        link_start: record.links[0],
        link_count: record.links[1],
        material: PbdMaterial {
            stretch_stiffness: material.stretch_stiffness,
            laplacian_stiffness: material.laplacian_stiffness,
            damping_per_s: material.damping_per_s,
            contact_stiffness_n_m: material.contact_stiffness_n_m,
        },
    }
}

fn room(record: &RoomRecord, station: &StationFile) -> Room {
    let or_scene = |own: Option<Pose>, scene| own.unwrap_or_else(|| pose(scene));
    Room {
        gravity_m_s2: Vec3::from(record.gravity_m_s2),
        world_from_device: or_scene(station.world_from_device, &record.world_from_device),
        world_from_tracker: or_scene(station.world_from_tracker, &record.world_from_tracker),
        instrument_port_m: Vec3::from(record.instrument_port_m),
        instrument_length_m: record.instrument_length_m,
        endoscope_port_m: Vec3::from(record.endoscope_port_m),
        world_from_camera: pose(&record.world_from_camera),
    }
}

fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    // The file's check has made sure that the length is near one.
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}
