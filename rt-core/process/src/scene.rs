//! Conversion of the compiled scene for the core.

use std::path::Path;

use hardware::station::StationFile;
use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use rt_core::scene::{
    Anchor, Attachment, Cell, Column, Inside, Layers, Link, Material, Organ, RestSphere, Room,
    Scene, Skin, SkinVertex, Tetra, TetraBatch, batches,
};
use shared_mem::inputs::RunSetup;
use shared_mem::message::PoseMsg;
use shared_mem::scene::{
    AttachmentRecord, CellColumnRecord, CellRecord, ContactVertexRecord, LinkRecord, OrganKind,
    OrganRecord, RoomRecord, SceneFile, SphereRecord, TetraRecord, WORLD,
};

use crate::error::RtError;
use crate::inputs;

/// A compiled scene, converted once.
#[derive(Debug)]
pub(crate) struct LoadedScene {
    pub(crate) name: String,
    /// First half of the identity, as in frames.
    pub(crate) short_id: [u8; 16],
    /// The whole identity, hexadecimal.
    pub(crate) id: String,
    organs: Vec<Organ>,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    batches: Vec<TetraBatch>,
    attachments: Vec<Attachment>,
    skin_vertices: Vec<SkinVertex>,
    skin_fans: Vec<[u16; 2]>,
    skin_nearest: Vec<u16>,
    cells: Vec<Cell>,
    columns: Vec<Column>,
    room: Room,
}

impl LoadedScene {
    /// Reads and checks a compiled scene. The devices stand where the station file puts them, or
    /// else the scene.
    pub(crate) fn load(path: &Path, station: &StationFile) -> Result<Self, RtError> {
        Self::from_file(&SceneFile::open(path)?, station)
    }

    /// Uses the device poses of a recorded run.
    pub(crate) fn in_room_of(mut self, setup: &RunSetup) -> Self {
        self.room.world_from_device = inputs::pose(&setup.world_from_device);
        self.room.world_from_tracker = inputs::pose(&setup.world_from_tracker);
        self.room.instrument_port_m = Vec3::from(setup.instrument_port_m);
        self.room.endoscope_port_m = Vec3::from(setup.endoscope_port_m);
        self
    }

    /// Keeps it for as long as the process lives, as the simulation does.
    pub(crate) fn keep(self) -> &'static Self {
        Box::leak(Box::new(self))
    }

    pub(crate) fn from_file(file: &SceneFile, station: &StationFile) -> Result<Self, RtError> {
        let spheres: Vec<RestSphere> = file.spheres().iter().map(sphere).collect();
        let mut organs: Vec<Organ> = file.organs().iter().map(organ).collect();
        let mut packed = Vec::new();
        for (organ, record) in organs.iter_mut().zip(file.organs()) {
            let [first, count] = record.tetrahedra.map(|n| n as usize);
            let own: Vec<Tetra> = file.tetrahedra()[first..first + count]
                .iter()
                .map(tetra)
                .collect();
            organ.batch_start = packed.len() as u32;
            batches(&own, &spheres, |batch| packed.push(batch)).map_err(RtError::Core)?;
            organ.batch_count = packed.len() as u32 - organ.batch_start;
        }
        let loaded = Self {
            name: file.name().to_owned(),
            short_id: file.short_id(),
            id: file.id().iter().map(|byte| format!("{byte:02x}")).collect(),
            organs,
            spheres,
            links: file.links().iter().map(link).collect(),
            batches: packed,
            attachments: file.attachments().iter().map(attachment).collect(),
            skin_vertices: file.contact_vertices().iter().map(skin_vertex).collect(),
            skin_fans: file.contact_fans().to_vec(),
            skin_nearest: file.contact_nearest().to_vec(),
            cells: file.cells().iter().map(cell).collect(),
            columns: file.cell_columns().iter().map(column).collect(),
            room: room(file.room(), station),
        };
        loaded.scene()?;
        Ok(loaded)
    }

    /// The scene, checked by the core.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, RtError> {
        Scene::new(&self.organs, &self.spheres, &self.links, self.room)
            .and_then(|scene| scene.with_tetrahedra(&self.batches))
            .and_then(|scene| scene.with_attachments(&self.attachments))
            .and_then(|scene| {
                scene.with_skin(Skin {
                    vertices: &self.skin_vertices,
                    fans: &self.skin_fans,
                    nearest: &self.skin_nearest,
                })
            })
            .and_then(|scene| {
                scene.with_cells(Layers {
                    cells: &self.cells,
                    columns: &self.columns,
                })
            })
            .map_err(RtError::Core)
    }

    /// Number of spheres.
    pub(crate) fn sphere_count(&self) -> usize {
        self.spheres.len()
    }
}

fn sphere(record: &SphereRecord) -> RestSphere {
    RestSphere {
        center_m: Vec3::from(record.center_m),
        radius_m: record.radius_m,
        mass_kg: record.mass_kg,
        held: record.held != 0,
    }
}

fn link(record: &LinkRecord) -> Link {
    Link {
        a: record.a,
        b: record.b,
        rest_length_m: record.rest_length_m,
        compliance_m_n: record.compliance_m_n,
    }
}

fn tetra(record: &TetraRecord) -> Tetra {
    Tetra {
        spheres: record.spheres.map(u32::from),
        volume_m3: record.volume_m3,
    }
}

fn attachment(record: &AttachmentRecord) -> Attachment {
    let to = match record.b {
        WORLD => Anchor::World(Vec3::from(record.anchor_m)),
        sphere => Anchor::Sphere(sphere),
    };
    Attachment {
        sphere: record.a,
        to,
        rest_length_m: record.rest_length_m,
        compliance_m_n: record.compliance_m_n,
        is_thread: record.is_thread != 0,
        tear_j: record.tear_j,
    }
}

fn skin_vertex(record: &ContactVertexRecord) -> SkinVertex {
    SkinVertex {
        spheres: record.spheres,
        weights: record.weights,
        fan_start: record.fan[0],
        fan_count: record.fan[1],
        patch_m: record.patch_m,
        curvature_per_m: record.curvature_per_m,
    }
}

fn cell(record: &CellRecord) -> Cell {
    Cell {
        spheres: record.spheres,
        weights: record.weights,
        neighbours: record.neighbours,
        center_m: Vec3::from(record.center_m),
        extent_m: record.extent_m,
        volume_m3: record.volume_m3,
        energy_j: record.energy_j,
    }
}

fn column(record: &CellColumnRecord) -> Column {
    Column {
        cells: record.cells,
        inwards: record.inwards,
    }
}

/// Converts an organ; its batches of tetrahedra are not yet known.
fn organ(record: &OrganRecord) -> Organ {
    let material = &record.material;
    Organ {
        sphere_start: record.spheres[0],
        sphere_count: record.spheres[1],
        link_start: record.links[0],
        link_count: record.links[1],
        elastic_links: record.elastic_links,
        batch_start: 0,
        batch_count: 0,
        substeps: record.substeps,
        gravity_share: record.gravity_share,
        breath_m: Vec3::from(record.breath_m),
        inside: inside(OrganKind::from_u32(record.kind)),
        material: Material {
            young_pa: material.young_pa,
            poisson: material.poisson,
            retardation_s: material.retardation_s,
            stretch_stiffness: material.stretch_stiffness,
            laplacian_stiffness: material.laplacian_stiffness,
            damping_per_s: material.damping_per_s,
            contact_stiffness_n_m: material.contact_stiffness_n_m,
            friction: material.friction,
            toughness_j_m2: material.toughness_j_m2,
        },
    }
}

fn inside(kind: Option<OrganKind>) -> Inside {
    match kind {
        Some(OrganKind::Liver) => Inside::Liver,
        Some(OrganKind::Gallbladder | OrganKind::CysticDuct | OrganKind::BileDuct) => Inside::Bile,
        Some(OrganKind::CysticArtery | OrganKind::Vessel) => Inside::Blood,
        Some(OrganKind::Stomach | OrganKind::Intestine) => Inside::Food,
        Some(OrganKind::Fat | OrganKind::ConnectiveTissue | OrganKind::AbdominalWall) | None => {
            Inside::Solid
        }
    }
}

fn room(record: &RoomRecord, station: &StationFile) -> Room {
    let or_scene = |own: Option<Pose>, scene| own.unwrap_or_else(|| pose(scene));
    Room {
        gravity_m_s2: Vec3::from(record.gravity_m_s2),
        world_from_device: or_scene(station.world_from_device, &record.world_from_device),
        world_from_tracker: or_scene(station.world_from_tracker, &record.world_from_tracker),
        instrument_port_m: station
            .instrument_port_m
            .unwrap_or_else(|| Vec3::from(record.instrument_port_m)),
        instrument_length_m: record.instrument_length_m,
        endoscope_port_m: station
            .endoscope_port_m
            .unwrap_or_else(|| Vec3::from(record.endoscope_port_m)),
        world_from_camera: pose(&record.world_from_camera),
        breath_s: record.breath_s,
    }
}

fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    // The check of the file ensures a length near one.
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}
