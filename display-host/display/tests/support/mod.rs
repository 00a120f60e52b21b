//! A small test scene: a liver-like and a gallbladder-like blob over their spheres, and frames as a
//! controller would publish them.

use glam::{Mat3, Quat, Vec3};
use shared_mem::message::{CapsuleMsg, DentMsg, PoseMsg, SphereState, StateFrame, ToolFrame};
use shared_mem::scene::{
    BINDINGS, LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData, SceneFile,
    SphereRecord, VertexRecord, WEIGHT_SUM, name_from_str,
};

const MATERIAL: MaterialRecord = MaterialRecord {
    density_kg_m3: 1060.0,
    young_pa: 3000.0,
    poisson: 0.45,
    stretch_stiffness: 0.5,
    laplacian_stiffness: 0.1,
    damping_per_s: 2.0,
    contact_stiffness_n_m: 200.0,
    retardation_s: 0.002,
    friction: 0.1,
    toughness_j_m2: 100.0,
};

/// Place of the press, on the liver's front.
pub(crate) const PRESSED_M: Vec3 = Vec3::new(-0.012, 0.008, 0.030);

/// The scene; `rings` sets the resolution of the skins.
pub(crate) fn scene(rings: usize) -> SceneFile {
    SceneFile::from_bytes(&scene_bytes(rings)).expect("the scene is valid")
}

/// Bytes of the compiled scene's file.
pub(crate) fn scene_bytes(rings: usize) -> Vec<u8> {
    let mut data = SceneData::default();
    let liver = |d: Vec3| {
        let thin = 1.0 - 0.25 * (d.x * 0.5 + 0.5);
        Vec3::new(0.085 * d.x, 0.034 * d.y * thin + 0.016, 0.038 * d.z * thin)
    };
    blob(&mut data, "liver", OrganKind::Liver, rings, 0.010, liver);
    let gallbladder = |d: Vec3| {
        let pear = 1.0 + 0.35 * d.z;
        Vec3::new(
            0.014 * d.x * pear + 0.012,
            0.013 * d.y * pear - 0.022,
            0.034 * d.z + 0.012,
        )
    };
    let rings = rings * 2 / 3;
    blob(
        &mut data,
        "gallbladder",
        OrganKind::Gallbladder,
        rings,
        0.006,
        gallbladder,
    );
    let eye = Vec3::new(0.0, 0.012, 0.125);
    data.room = Some(RoomRecord {
        name: name_from_str("blobs"),
        gravity_m_s2: [0.0, -9.81, 0.0],
        world_from_device: PoseMsg::IDENTITY,
        world_from_tracker: PoseMsg::IDENTITY,
        instrument_port_m: [0.10, 0.05, 0.16],
        instrument_length_m: 0.35,
        endoscope_port_m: [0.0, 0.05, 0.18],
        world_from_camera: looking(eye, Vec3::new(0.0, 0.0, 0.0)),
        target_m: PRESSED_M.to_array(),
        target_normal: [0.0, 0.0, 1.0],
        target_organ: 0,
        breath_s: 0.0,
    });
    data.to_bytes().expect("the scene is valid")
}

/// Pose of a camera at `eye` that looks at `at`.
pub(crate) fn looking(eye: Vec3, at: Vec3) -> PoseMsg {
    let back = (eye - at).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let turn = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back));
    PoseMsg {
        position_m: eye.to_array(),
        orientation: turn.to_array(),
    }
}

/// The scene at rest, pressed in by `dent_m` around [`PRESSED_M`].
pub(crate) fn state(scene: &SceneFile, dent_m: f32) -> Box<StateFrame> {
    let mut frame: Box<StateFrame> = bytemuck::allocation::zeroed_box();
    frame.scene_id = scene.short_id();
    frame.sphere_count = scene.spheres().len() as u32;
    for (out, sphere) in frame.spheres.iter_mut().zip(scene.spheres()) {
        let at = Vec3::from(sphere.center_m);
        let away = at.distance(PRESSED_M) / 0.013;
        let pushed = Vec3::new(0.0, 0.0, -dent_m) * (-away * away).exp();
        *out = SphereState {
            center_m: (at + pushed).to_array(),
            bits: SphereState::AWAKE,
        };
    }
    frame
}

/// A grasper with its tip on the skin pressed in by `dent_m`.
pub(crate) fn tools(scene: &SceneFile, dent_m: f32, jaw: f32) -> ToolFrame {
    let mut frame: ToolFrame = bytemuck::Zeroable::zeroed();
    let room = scene.room();
    frame.scene_id = scene.short_id();
    let tip = PRESSED_M + Vec3::new(0.0, 0.0, 0.004 - dent_m);
    let back = (Vec3::from(room.instrument_port_m) - tip).normalize();
    let joint = tip + back * 0.020;
    let turn = Quat::from_rotation_arc(Vec3::Z, back);
    frame.world_from_instrument = PoseMsg {
        position_m: joint.to_array(),
        orientation: turn.to_array(),
    };
    frame.world_from_handle = PoseMsg::IDENTITY;
    frame.world_from_camera = room.world_from_camera;
    frame.jaw = jaw;
    frame.contact_count = u32::from(dent_m > 0.0);
    frame.force_n = [0.0, 0.0, dent_m * 200.0];
    // The spheres have yielded by `dent_m`; the law adds a third of that.
    frame.dent_count = frame.contact_count;
    frame.dents[0] = DentMsg {
        center_m: tip.to_array(),
        radius_m: 0.0012,
        half_m: [0.0; 3],
        depth_m: dent_m / 3.0,
        normal: [0.0, 0.0, 1.0],
        organ: 0,
    };
    let opened = |sign: f32| turn * Quat::from_rotation_x(sign * 0.4 * jaw) * Vec3::NEG_Z;
    let capsule = |a: Vec3, b: Vec3, radius_m: f32, role: u32| CapsuleMsg {
        a_m: a.to_array(),
        radius_m,
        b_m: b.to_array(),
        role,
    };
    frame.capsule_count = 3;
    frame.capsules[0] = capsule(joint + back * 0.30, joint, 0.0025, 0);
    frame.capsules[1] = capsule(joint, joint + opened(1.0) * 0.020, 0.0012, 1);
    frame.capsules[2] = capsule(joint, joint + opened(-1.0) * 0.020, 0.0012, 2);
    frame
}

/// Adds an organ: a sphere's surface deformed by `shape`, filled with spheres `spacing` apart.
fn blob(
    data: &mut SceneData,
    name: &str,
    kind: OrganKind,
    rings: usize,
    spacing: f32,
    shape: impl Fn(Vec3) -> Vec3,
) {
    let first = [
        data.spheres.len(),
        data.vertices.len(),
        data.triangles.len(),
    ]
    .map(|n| n as u32);
    // `shape` also places the spheres that fill the inside.
    let steps = (0.09 / spacing) as i32;
    let mut places = Vec::new();
    for z in -steps..=steps {
        for y in -steps..=steps {
            for x in -steps..=steps {
                let d = Vec3::new(x as f32, y as f32, z as f32) * spacing / 0.045;
                if d.length() < 0.92 {
                    places.push(Vec3::new(x as f32, y as f32, z as f32));
                    data.spheres.push(SphereRecord {
                        center_m: shape(d).to_array(),
                        radius_m: spacing * 0.7,
                        mass_kg: 0.001,
                        held: 0,
                    });
                }
            }
        }
    }
    let own = &data.spheres[first[0] as usize..];
    let mut links = Vec::new();
    for (i, a) in own.iter().enumerate() {
        for (j, b) in own[..i].iter().enumerate() {
            if places[i].distance_squared(places[j]) < 1.5 {
                links.push(LinkRecord {
                    a: first[0] + j as u32,
                    b: first[0] + i as u32,
                    rest_length_m: Vec3::from(a.center_m).distance(b.center_m.into()),
                    compliance_m_n: 0.0,
                });
            }
        }
    }
    let linked = [data.links.len() as u32, links.len() as u32];
    data.links.extend(links);
    let around = rings * 2;
    let mut points = vec![shape(Vec3::Y)];
    for k in 1..rings {
        let height = (k as f32 / rings as f32 * core::f32::consts::PI).cos();
        let flat = (1.0 - height * height).sqrt();
        for i in 0..around {
            let turn = i as f32 / around as f32 * core::f32::consts::TAU;
            points.push(shape(Vec3::new(
                flat * turn.sin(),
                height,
                flat * turn.cos(),
            )));
        }
    }
    points.push(shape(Vec3::NEG_Y));
    let last = points.len() as u32 - 1;
    let n = around as u32;
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.push([0, 1 + i, 1 + j]);
        let base = last - n;
        triangles.push([last, base + j, base + i]);
        for k in 0..rings as u32 - 2 {
            let [a, b] = [1 + k * n + i, 1 + k * n + j];
            triangles.push([a, a + n, b + n]);
            triangles.push([a, b + n, b]);
        }
    }
    let mut normals = vec![Vec3::ZERO; points.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| points[v as usize]);
        t.iter()
            .for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
    }
    let spheres = &data.spheres[first[0] as usize..];
    for (point, normal) in points.iter().zip(normals) {
        let (indices, weights) = bind(*point, spheres, first[0]);
        data.vertices.push(VertexRecord {
            position_m: point.to_array(),
            normal: normal.normalize().to_array(),
            spheres: indices,
            weights,
        });
    }
    data.triangles
        .extend(triangles.iter().map(|t| t.map(|v| v + first[1])));
    data.organs.push(OrganRecord {
        name: name_from_str(name),
        kind: kind as u32,
        spheres: [first[0], data.spheres.len() as u32 - first[0]],
        links: linked,
        tetrahedra: [0, 0],
        elastic_links: 0,
        substeps: 1,
        gravity_share: 1.0,
        breath_m: [0.0; 3],
        vertices: [first[1], points.len() as u32],
        triangles: [first[2], triangles.len() as u32],
        volume_m3: 1e-4,
        material: MATERIAL,
    });
}

/// Spheres and weights of a vertex by Eq. 9 of the paper, for the eight nearest spheres.
fn bind(point: Vec3, spheres: &[SphereRecord], first: u32) -> ([u16; BINDINGS], [u16; BINDINGS]) {
    let mut near: Vec<(f32, u16)> = spheres
        .iter()
        .enumerate()
        .map(|(i, s)| {
            let d = point.distance(Vec3::from(s.center_m)) / (2.0 * s.radius_m);
            ((-d * d).exp(), (first as usize + i) as u16)
        })
        .collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    near.truncate(BINDINGS);
    let sum: f32 = near.iter().map(|n| n.0).sum();
    let mut indices = [near[0].1; BINDINGS];
    let mut weights = [0u16; BINDINGS];
    for (k, (weight, sphere)) in near.iter().enumerate() {
        indices[k] = *sphere;
        weights[k] = (weight / sum * WEIGHT_SUM as f32) as u16;
    }
    let rest: u32 = weights.iter().map(|&w| u32::from(w)).sum();
    weights[0] += (WEIGHT_SUM - rest) as u16;
    (indices, weights)
}
