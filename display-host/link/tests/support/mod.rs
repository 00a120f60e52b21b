//! A station of one organ that nobody simulates, and keys.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use link::Keys;
use shared_mem::message::{EventMsg, PoseMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::{
    LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData, SceneFile,
    SphereRecord, VertexRecord, name_from_str,
};

/// How long anything may take before a test gives up on it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub(crate) fn scene() -> SceneFile {
    let sphere = |x: f32| SphereRecord {
        center_m: [x, 0.0, 0.0],
        radius_m: 0.01,
        mass_kg: 0.01,
        held: 0,
    };
    let vertex = |x: f32| VertexRecord {
        position_m: [x, 0.01, 0.0],
        normal: [0.0, 1.0, 0.0],
        spheres: [0; 8],
        weights: [65_535, 0, 0, 0, 0, 0, 0, 0],
    };
    let room = RoomRecord {
        name: name_from_str("two spheres"),
        world_from_device: PoseMsg::IDENTITY,
        world_from_tracker: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        instrument_length_m: 0.33,
        ..RoomRecord::zeroed()
    };
    let organ = OrganRecord {
        name: name_from_str("liver"),
        kind: OrganKind::Liver as u32,
        spheres: [0, 2],
        links: [0, 1],
        elastic_links: 1,
        substeps: 1,
        gravity_share: 1.0,
        vertices: [0, 3],
        triangles: [0, 1],
        volume_m3: 1e-5,
        material: MaterialRecord {
            density_kg_m3: 1060.0,
            young_pa: 5000.0,
            poisson: 0.45,
            contact_stiffness_n_m: 200.0,
            toughness_j_m2: 100.0,
            ..MaterialRecord::zeroed()
        },
        ..OrganRecord::zeroed()
    };
    let data = SceneData {
        room: Some(room),
        organs: vec![organ],
        spheres: vec![sphere(0.0), sphere(0.01)],
        links: vec![LinkRecord {
            a: 0,
            b: 1,
            rest_length_m: 0.01,
            compliance_m_n: 1e-3,
        }],
        vertices: vec![vertex(0.0), vertex(0.01), vertex(0.02)],
        triangles: vec![[0, 1, 2]],
        ..SceneData::default()
    };
    SceneFile::from_bytes(&data.to_bytes().expect("a scene")).expect("a scene")
}

pub(crate) fn state(tick: u64, at_ns: u64, scene_id: [u8; 16]) -> Box<StateFrame> {
    let mut frame: Box<StateFrame> = bytemuck::zeroed_box();
    (frame.tick, frame.at_ns, frame.sample_ns) = (tick, at_ns, at_ns - 100);
    frame.scene_id = scene_id;
    frame.sphere_count = 2;
    frame.cell_count = 3;
    frame.cells[..3].copy_from_slice(&[1, 2, 255]);
    frame.spheres[1].center_m = [tick as f32 * 1e-6, 0.5, 0.25];
    frame
}

pub(crate) fn tools(tick: u64, at_ns: u64, scene_id: [u8; 16]) -> ToolFrame {
    let mut frame = ToolFrame::zeroed();
    (frame.tick, frame.at_ns, frame.scene_id) = (tick, at_ns, scene_id);
    frame.world_from_handle = PoseMsg::IDENTITY;
    frame.world_from_instrument = PoseMsg::IDENTITY;
    frame.world_from_camera = PoseMsg::IDENTITY;
    frame.capsule_count = 1;
    frame
}

pub(crate) fn event(sequence: u64) -> EventMsg {
    EventMsg {
        sequence,
        at_ns: 1_000_000 + sequence,
        kind: EventMsg::CONTACT,
        ..EventMsg::zeroed()
    }
}

pub(crate) fn batch(sequence: u64) -> TimingBatch {
    let mut batch = TimingBatch::zeroed();
    (batch.sequence, batch.count) = (sequence, 5);
    batch.records[4].tick = sequence * 5 + 4;
    batch
}

/// Runs the script that `calot link keys` prints.
pub(crate) fn make_keys(folder: &Path, words: &[&str]) {
    let script = folder.join("make_keys.sh");
    std::fs::write(&script, link::MAKE_KEYS).expect("written");
    let made = Command::new("sh")
        .arg(&script)
        .args(words)
        .current_dir(folder)
        .output()
        .expect("sh runs");
    let said = String::from_utf8_lossy(&made.stderr);
    assert!(
        made.status.success(),
        "{words:?} (openssl 3 is needed): {said}"
    );
}

/// The keys of `name` in a folder.
pub(crate) fn keys(folder: &Path, name: &str) -> Keys {
    let path = |file: String| -> PathBuf { folder.join(file) };
    Keys {
        certificate: path(format!("{name}.pem")),
        key: path(format!("{name}.key")),
        authority: path("ca.pem".into()),
    }
}
