//! A prepared scene as the core's records.

use rt_core::math::{Pose, Vec3};
use rt_core::scene::{
    Anchor, Attachment, Cell, Column, Inside, Layers, Link, Material, Organ, Relaxation,
    RestSphere, Room, Scene, Skin, SkinVertex, Tetra, TetraBatch, Trocar, batches,
};
use shared_mem::scene::{SceneData, WORLD};

pub(crate) struct LoadedScene {
    pub(crate) organs: Vec<Organ>,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    batches: Vec<TetraBatch>,
    attachments: Vec<Attachment>,
    pub(crate) skin_vertices: Vec<SkinVertex>,
    pub(crate) skin_fans: Vec<[u16; 2]>,
    skin_nearest: Vec<u16>,
    cells: Vec<Cell>,
    columns: Vec<Column>,
    room: Room,
}

impl LoadedScene {
    pub(crate) fn new(data: &SceneData) -> Self {
        let spheres: Vec<RestSphere> = data
            .spheres
            .iter()
            .map(|s| RestSphere {
                center_m: Vec3::from(s.center_m),
                radius_m: s.radius_m,
                mass_kg: s.mass_kg,
                held: s.held != 0,
            })
            .collect();
        let mut packed = Vec::new();
        let mut organs = Vec::new();
        for o in &data.organs {
            let [first, count] = o.tetrahedra.map(|n| n as usize);
            let own: Vec<Tetra> = data.tetrahedra[first..first + count]
                .iter()
                .map(|t| Tetra {
                    spheres: t.spheres.map(u32::from),
                    volume_m3: t.volume_m3,
                })
                .collect();
            let batch_start = packed.len() as u32;
            batches(&own, &spheres, |batch| packed.push(batch)).expect("sound tetrahedra");
            let material = &o.material;
            organs.push(Organ {
                sphere_start: o.spheres[0],
                sphere_count: o.spheres[1],
                link_start: o.links[0],
                link_count: o.links[1],
                elastic_links: o.elastic_links,
                batch_start,
                batch_count: packed.len() as u32 - batch_start,
                substeps: o.substeps,
                gravity_share: o.gravity_share,
                breath_m: Vec3::from(o.breath_m),
                inside: Inside::Solid,
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
                    relaxation: Relaxation::NONE,
                },
            });
        }
        let room = data.room.expect("a room");
        Self {
            organs,
            spheres,
            batches: packed,
            links: data
                .links
                .iter()
                .map(|l| Link {
                    a: l.a,
                    b: l.b,
                    rest_length_m: l.rest_length_m,
                    compliance_m_n: l.compliance_m_n,
                })
                .collect(),
            attachments: data
                .attachments
                .iter()
                .map(|tie| Attachment {
                    sphere: tie.a,
                    to: match tie.b {
                        WORLD => Anchor::World(Vec3::from(tie.anchor_m)),
                        b => Anchor::Sphere(b),
                    },
                    rest_length_m: tie.rest_length_m,
                    compliance_m_n: tie.compliance_m_n,
                    is_thread: tie.is_thread != 0,
                    tear_j: tie.tear_j,
                })
                .collect(),
            skin_vertices: data
                .contact_vertices
                .iter()
                .map(|v| SkinVertex {
                    spheres: v.spheres,
                    weights: v.weights,
                    fan_start: v.fan[0],
                    fan_count: v.fan[1],
                    patch_m: v.patch_m,
                    curvature_per_m: v.curvature_per_m,
                })
                .collect(),
            skin_fans: data.contact_fans.clone(),
            skin_nearest: data.contact_nearest.clone(),
            cells: data
                .cells
                .iter()
                .map(|cell| Cell {
                    spheres: cell.spheres,
                    weights: cell.weights,
                    neighbours: cell.neighbours,
                    center_m: Vec3::from(cell.center_m),
                    extent_m: cell.extent_m,
                    volume_m3: cell.volume_m3,
                    energy_j: cell.energy_j,
                })
                .collect(),
            columns: data
                .cell_columns
                .iter()
                .map(|column| Column {
                    cells: column.cells,
                    inwards: column.inwards,
                })
                .collect(),
            room: Room {
                gravity_m_s2: Vec3::from(room.gravity_m_s2),
                world_from_device: Pose::identity(),
                world_from_tracker: Pose::identity(),
                instrument_port_m: Vec3::from(room.instrument_port_m),
                instrument_length_m: room.instrument_length_m,
                endoscope_port_m: Vec3::from(room.endoscope_port_m),
                world_from_camera: Pose::identity(),
                breath_s: room.breath_s,
                trocar: Trocar::NONE,
            },
        }
    }

    pub(crate) fn scene(&self) -> Scene<'_> {
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
            .expect("the core takes what preparation makes")
    }
}
