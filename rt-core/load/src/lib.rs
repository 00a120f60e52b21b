//! Converts the records of a compiled scene to the types of `rt_core`. The realtime process
//! simulates the converted scene. The preparation converts a scene as well, as a check that the
//! realtime process will accept it.

use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use rt_core::scene::{
    Anchor, Attachment, Bowl, Cell, Column, Inside, Layers, Link, Material, Organ, RestSphere,
    Room, Scene, SceneError, Skin, SkinVertex, Stones, Tetra, TetraBatch, Trocar, TrocarChoice,
    batches,
};
use shared_mem::message::PoseMsg;
use shared_mem::scene::{
    AttachmentRecord, CellColumnRecord, CellRecord, ContactVertexRecord, LinkRecord, OrganKind,
    OrganRecord, RoomRecord, SceneData, SceneFile, SphereRecord, StonesRecord, TetraRecord,
    TrocarRecord, WORLD,
};

/// The records of a scene that the core needs.
#[derive(Debug, Clone, Copy)]
pub struct Records<'a> {
    organs: &'a [OrganRecord],
    spheres: &'a [SphereRecord],
    links: &'a [LinkRecord],
    tetrahedra: &'a [TetraRecord],
    attachments: &'a [AttachmentRecord],
    contact_vertices: &'a [ContactVertexRecord],
    contact_fans: &'a [[u16; 2]],
    contact_nearest: &'a [u16],
    cells: &'a [CellRecord],
    columns: &'a [CellColumnRecord],
    room: &'a RoomRecord,
    trocar: Option<&'a TrocarRecord>,
    stones: Option<&'a StonesRecord>,
}

impl<'a> Records<'a> {
    /// Records of a checked file.
    #[must_use]
    pub fn of_file(file: &'a SceneFile) -> Self {
        Self {
            organs: file.organs(),
            spheres: file.spheres(),
            links: file.links(),
            tetrahedra: file.tetrahedra(),
            attachments: file.attachments(),
            contact_vertices: file.contact_vertices(),
            contact_fans: file.contact_fans(),
            contact_nearest: file.contact_nearest(),
            cells: file.cells(),
            columns: file.cell_columns(),
            room: file.room(),
            trocar: file.trocar(),
            stones: file.stones(),
        }
    }

    /// Records of a scene that is not in a file yet. `None` if the scene has no room.
    #[must_use]
    pub fn of_data(data: &'a SceneData) -> Option<Self> {
        Some(Self {
            organs: &data.organs,
            spheres: &data.spheres,
            links: &data.links,
            tetrahedra: &data.tetrahedra,
            attachments: &data.attachments,
            contact_vertices: &data.contact_vertices,
            contact_fans: &data.contact_fans,
            contact_nearest: &data.contact_nearest,
            cells: &data.cells,
            columns: &data.cell_columns,
            room: data.room.as_ref()?,
            trocar: data.trocar.as_ref(),
            stones: data.stones.as_ref(),
        })
    }
}

/// Owns the data that a scene of the core borrows.
#[derive(Debug)]
pub struct SceneStorage {
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
    stones: Stones,
    /// The room: gravity, breath, ports, and the poses of devices and camera. A caller may
    /// overwrite ports and poses before it calls `SceneStorage::scene`.
    pub room: Room,
    /// The trocar that the scene asks for.
    asked: Trocar,
    /// Place at which an untilted trocar points, m.
    target_m: Vec3,
}

impl SceneStorage {
    /// Converts the records. [`SceneStorage::scene`] checks them.
    ///
    /// # Errors
    /// If a tetrahedron is flat or inverted at rest, represents no volume, or names a sphere that
    /// does not exist.
    pub fn new(records: Records<'_>) -> Result<Self, SceneError> {
        let spheres: Vec<RestSphere> = records.spheres.iter().map(sphere).collect();
        let mut organs: Vec<Organ> = records.organs.iter().map(organ).collect();
        let mut packed = Vec::new();
        for (organ, record) in organs.iter_mut().zip(records.organs) {
            let [first, count] = record.tetrahedra.map(|n| n as usize);
            // Unchecked records may name tetrahedra beyond the last; those are left out.
            let own = records.tetrahedra.iter().skip(first).take(count);
            let own: Vec<Tetra> = own.map(tetra).collect();
            organ.batch_start = packed.len() as u32;
            batches(&own, &spheres, |batch| packed.push(batch))?;
            organ.batch_count = packed.len() as u32 - organ.batch_start;
        }
        Ok(Self {
            organs,
            spheres,
            links: records.links.iter().map(link).collect(),
            batches: packed,
            attachments: records.attachments.iter().map(attachment).collect(),
            skin_vertices: records.contact_vertices.iter().map(skin_vertex).collect(),
            skin_fans: records.contact_fans.to_vec(),
            skin_nearest: records.contact_nearest.to_vec(),
            cells: records.cells.iter().map(cell).collect(),
            columns: records.columns.iter().map(column).collect(),
            stones: records.stones.map_or(Stones::NONE, stones),
            room: room(records.room),
            asked: records.trocar.map_or(Trocar::NONE, trocar),
            target_m: Vec3::from(records.room.target_m),
        }
        .with_trocar(TrocarChoice::Scene))
    }

    fn with_trocar(mut self, choice: TrocarChoice) -> Self {
        self.choose_trocar(choice);
        self
    }

    /// Sets the trocar of the room. Untilted, it points from the instrument's port to the scene's
    /// target. Call this again after moving the port.
    pub fn choose_trocar(&mut self, choice: TrocarChoice) {
        let towards = self.target_m - self.room.instrument_port_m;
        let length = towards.norm();
        self.room.trocar = choice.of(self.asked);
        if length > f32::MIN_POSITIVE {
            self.room.trocar.axis = towards / length;
        } else {
            self.room.trocar.wall_nm_rad = 0.0; // a target in the port gives no direction
        }
    }

    /// The scene, checked by the core.
    ///
    /// # Errors
    /// The error names the value that the core refuses.
    pub fn scene(&self) -> Result<Scene<'_>, SceneError> {
        Scene::new(&self.organs, &self.spheres, &self.links, self.room)?
            .with_tetrahedra(&self.batches)?
            .with_attachments(&self.attachments)?
            .with_skin(Skin {
                vertices: &self.skin_vertices,
                fans: &self.skin_fans,
                nearest: &self.skin_nearest,
            })?
            .with_cells(Layers {
                cells: &self.cells,
                columns: &self.columns,
            })?
            .with_stones(self.stones)
    }

    /// Number of spheres.
    #[must_use]
    pub fn sphere_count(&self) -> usize {
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

/// Converts an organ. [`SceneStorage::new`] then fills in its batches of tetrahedra.
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

fn room(record: &RoomRecord) -> Room {
    Room {
        gravity_m_s2: Vec3::from(record.gravity_m_s2),
        world_from_device: pose(&record.world_from_device),
        world_from_tracker: pose(&record.world_from_tracker),
        instrument_port_m: Vec3::from(record.instrument_port_m),
        instrument_length_m: record.instrument_length_m,
        endoscope_port_m: Vec3::from(record.endoscope_port_m),
        world_from_camera: pose(&record.world_from_camera),
        breath_s: record.breath_s,
        trocar: Trocar::NONE,
    }
}

fn stones(record: &StonesRecord) -> Stones {
    Stones {
        count: record.count,
        diameter_m: record.diameter_m,
        room_m3: record.room_m3,
        bowl: Bowl {
            world_from_bowl: pose(&record.world_from_bowl),
            radii_m: record.bowl_radii_m,
        },
    }
}

/// Converts a trocar; [`SceneStorage::choose_trocar`] sets its axis.
fn trocar(record: &TrocarRecord) -> Trocar {
    Trocar {
        sliding_n: record.sliding_n,
        breakaway_n: record.breakaway_n,
        wall_nm_rad: record.wall_nm_rad,
        ..Trocar::NONE
    }
}

/// Converts a pose of a checked file.
#[must_use]
pub fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    // The quaternion can be normalised, because the check of the file ensures a length near one.
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}
