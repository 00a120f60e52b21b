//! Check that the realtime process takes the scene: it checks more than the file's layout does.

use rt_core::math::{Pose, Vec3};
use rt_core::scene::{
    Anchor, Attachment, Cell, Column, Inside, Layers, Link, Material, Organ, RestSphere, Room,
    Scene, SceneError, Skin, SkinVertex, Tetra, TetraBatch, batches,
};
use shared_mem::scene::{OrganRecord, RoomRecord, SceneData, SceneError as FileError, WORLD};

use crate::error::PrepareError;
use crate::mesh::Mesh;
use crate::recipe::OrganPlan;

/// Refuses a scene that the realtime process would refuse. `skins` are those of the `organs`.
pub(crate) fn check(
    scene: &SceneData,
    organs: &[OrganPlan],
    skins: &[Mesh],
) -> Result<(), PrepareError> {
    let Err(error) = Loaded::new(scene).and_then(|loaded| loaded.check()) else {
        return Ok(());
    };
    if let SceneError::TooMany { what, count, limit } = error {
        let (found, min, max) = (count, 0, limit);
        return Err(PrepareError::Scene(FileError::Count {
            what,
            found,
            min,
            max,
        }));
    }
    let Some((plan, skin)) = organ_of(&error, scene).and_then(|i| organs.get(i).zip(skins.get(i)))
    else {
        return Err(PrepareError::Refused(error));
    };
    let [low, high] = skin.bounds();
    let problem = format!(
        "the realtime process would refuse it: {error}; the organ is {:.1} mm across: check its unit, or \
         give it fewer spheres",
        1e3 * (high - low).max()
    );
    Err(PrepareError::Organ {
        organ: plan.name.clone(),
        problem,
    })
}

/// The organ that an error concerns, if the error says so.
fn organ_of(error: &SceneError, scene: &SceneData) -> Option<usize> {
    let of_sphere = |sphere: u32| {
        let mut organs = scene.organs.iter();
        organs.position(|it| (it.spheres[0]..it.spheres[0] + it.spheres[1]).contains(&sphere))
    };
    let of_vertex = |index: usize| {
        let vertex = scene.contact_vertices.get(index)?;
        of_sphere(u32::from(vertex.spheres[0]))
    };
    match *error {
        SceneError::Range { organ, .. } => Some(organ),
        SceneError::Link { first, .. } => of_sphere(first),
        SceneError::Value { what, index, .. } => match what {
            "sphere centre" | "sphere radius" | "sphere mass" => of_sphere(index as u32),
            "vertex of the contact skin" => of_vertex(index),
            "Young's modulus" | "Poisson's ratio" | "retardation" | "damping" | "friction"
            | "toughness" | "substeps" | "gravity share" => Some(index),
            _ => None,
        },
        SceneError::Foreign { what, index, .. } => match what {
            "nearest vertex" => of_sphere(index as u32),
            "vertex of the contact skin" | "triangle of the contact skin" => of_vertex(index),
            _ => None,
        },
        SceneError::TooMany { .. } => None,
    }
}

/// The scene in the form of the core.
struct Loaded {
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

impl Loaded {
    fn new(data: &SceneData) -> Result<Self, SceneError> {
        let spheres = data.spheres.iter().map(|it| RestSphere {
            center_m: Vec3::from(it.center_m),
            radius_m: it.radius_m,
            mass_kg: it.mass_kg,
            held: it.held != 0,
        });
        let spheres: Vec<_> = spheres.collect();
        let (mut packed, mut organs) = (Vec::new(), Vec::new());
        for record in &data.organs {
            let [first, count] = record.tetrahedra.map(|n| n as usize);
            let own = data.tetrahedra.iter().skip(first).take(count);
            let own: Vec<_> = own
                .map(|it| Tetra {
                    spheres: it.spheres.map(u32::from),
                    volume_m3: it.volume_m3,
                })
                .collect();
            let start = packed.len() as u32;
            batches(&own, &spheres, |batch| packed.push(batch))?;
            organs.push(organ(record, start, packed.len() as u32 - start));
        }
        let link = data.links.iter().map(|it| Link {
            a: it.a,
            b: it.b,
            rest_length_m: it.rest_length_m,
            compliance_m_n: it.compliance_m_n,
        });
        let attachment = data.attachments.iter().map(|it| Attachment {
            sphere: it.a,
            to: match it.b {
                WORLD => Anchor::World(Vec3::from(it.anchor_m)),
                b => Anchor::Sphere(b),
            },
            rest_length_m: it.rest_length_m,
            compliance_m_n: it.compliance_m_n,
            is_thread: it.is_thread != 0,
            tear_j: it.tear_j,
        });
        let vertex = data.contact_vertices.iter().map(|it| SkinVertex {
            spheres: it.spheres,
            weights: it.weights,
            fan_start: it.fan[0],
            fan_count: it.fan[1],
            patch_m: it.patch_m,
            curvature_per_m: it.curvature_per_m,
        });
        let cell = data.cells.iter().map(|it| Cell {
            spheres: it.spheres,
            weights: it.weights,
            neighbours: it.neighbours,
            center_m: Vec3::from(it.center_m),
            extent_m: it.extent_m,
            volume_m3: it.volume_m3,
            energy_j: it.energy_j,
        });
        let column = data.cell_columns.iter().map(|it| Column {
            cells: it.cells,
            inwards: it.inwards,
        });
        Ok(Self {
            links: link.collect(),
            attachments: attachment.collect(),
            skin_vertices: vertex.collect(),
            skin_fans: data.contact_fans.clone(),
            skin_nearest: data.contact_nearest.clone(),
            cells: cell.collect(),
            columns: column.collect(),
            room: room(data.room.as_ref()),
            organs,
            spheres,
            batches: packed,
        })
    }

    fn check(&self) -> Result<(), SceneError> {
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
            })?;
        Ok(())
    }
}

fn organ(record: &OrganRecord, batch_start: u32, batch_count: u32) -> Organ {
    let m = &record.material;
    Organ {
        sphere_start: record.spheres[0],
        sphere_count: record.spheres[1],
        link_start: record.links[0],
        link_count: record.links[1],
        elastic_links: record.elastic_links,
        batch_start,
        batch_count,
        substeps: record.substeps,
        gravity_share: record.gravity_share,
        breath_m: Vec3::from(record.breath_m),
        inside: Inside::Solid,
        material: Material {
            young_pa: m.young_pa,
            poisson: m.poisson,
            retardation_s: m.retardation_s,
            stretch_stiffness: m.stretch_stiffness,
            laplacian_stiffness: m.laplacian_stiffness,
            damping_per_s: m.damping_per_s,
            contact_stiffness_n_m: m.contact_stiffness_n_m,
            friction: m.friction,
            toughness_j_m2: m.toughness_j_m2,
        },
    }
}

/// The room, without the poses: `room::place` makes them of rotations that the recipe's check let
/// through.
fn room(record: Option<&RoomRecord>) -> Room {
    let at =
        |place: fn(&RoomRecord) -> [f32; 3]| record.map_or(Vec3::zeros(), |it| place(it).into());
    Room {
        gravity_m_s2: at(|it| it.gravity_m_s2),
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: at(|it| it.instrument_port_m),
        instrument_length_m: record.map_or(0.33, |it| it.instrument_length_m),
        endoscope_port_m: at(|it| it.endoscope_port_m),
        world_from_camera: Pose::identity(),
        breath_s: record.map_or(0.0, |it| it.breath_s),
    }
}
