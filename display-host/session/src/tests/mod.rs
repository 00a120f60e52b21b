mod course;
mod damage;
mod repair;

use std::fs::Permissions;
use std::io::{self, Cursor};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::sync::{Arc, Mutex};

use bytemuck::Zeroable;
use proptest::prelude::*;
use shared_mem::inputs::{INPUT_BATCH, InputBatch, InputRecord};
use shared_mem::message::{EventMsg, PoseMsg, TimingBatch, ToolFrame};
use shared_mem::scene::{
    LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData, SceneFile,
    SphereRecord, VertexRecord, name_from_str,
};
use shared_mem::words::EventKind;

use crate::file::SessionFile;
use crate::{
    Assignment, End, Entry, EntryContent, Finish, Info, Operation, ReadError, Session, Storage,
};
use course::tools;

/// A disk in memory with limited room.
#[derive(Clone, Default)]
struct Disk(Arc<Mutex<DiskState>>);

#[derive(Default)]
struct DiskState {
    bytes: Vec<u8>,
    room: usize,
}

impl Disk {
    fn with_room(room: usize) -> Self {
        let disk = Self::default();
        disk.set_room(room);
        disk
    }

    fn set_room(&self, room: usize) {
        self.0.lock().unwrap().room = room;
    }

    fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().bytes.clone()
    }
}

impl Storage for Disk {
    fn put(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.0.lock().unwrap();
        let (offset, room) = (offset as usize, state.room);
        let fits = bytes.len().min(room.saturating_sub(offset));
        state.bytes.truncate(offset);
        state.bytes.extend_from_slice(&bytes[..fits]);
        match fits == bytes.len() {
            true => Ok(()),
            false => Err(io::ErrorKind::StorageFull.into()),
        }
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.0.lock().unwrap().bytes.truncate(length as usize);
        Ok(())
    }
}

pub(crate) fn scene() -> SceneFile {
    scene_of(0.01)
}

/// A scene with spheres of this mass.
fn scene_of(mass_kg: f32) -> SceneFile {
    let sphere = |x: f32| SphereRecord {
        center_m: [x, 0.0, 0.0],
        radius_m: 0.01,
        mass_kg,
        held: 0,
    };
    let vertex = |x: f32| VertexRecord {
        position_m: [x, 0.01, 0.0],
        normal: [0.0, 1.0, 0.0],
        spheres: [0; 8],
        weights: [65_535, 0, 0, 0, 0, 0, 0, 0],
    };
    let room = RoomRecord {
        name: name_from_str("nothing"),
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
    SceneFile::from_bytes(&data.to_bytes().unwrap()).unwrap()
}

fn info() -> Info {
    Info {
        scene: "nothing".into(),
        scene_id: crate::hex(scene().short_id()),
        build: "a test".into(),
        wall_from_host_ns: 1_000,
    }
}

fn batch(first_tick: u64) -> InputBatch {
    let mut batch = InputBatch::zeroed();
    batch.setup.period_ns = 1_000_000;
    batch.count = INPUT_BATCH as u32;
    for (i, record) in batch.records.iter_mut().enumerate() {
        record.tick = first_tick + i as u64;
        record.now_ns = 5_000_000_000 + record.tick * 1_000_000;
        record.bits = InputRecord::DEVICE_FRESH;
        record.device_at_ns = record.now_ns - 100_000;
        record.device_from_handle.position_m = [record.tick as f32, 0.5, -0.25];
        record.tools_hash = record.tick as u32 * 77;
    }
    batch
}

/// A session with this many batches, a chunk for each.
fn record(disk: &Disk, batches: u64) -> SessionFile {
    let mut file = SessionFile::begin(Box::new(disk.clone()), &info(), &scene()).unwrap();
    for i in 0..batches {
        file.inputs(&batch(i * INPUT_BATCH as u64)).unwrap();
        file.moved(&tools(5_000_000_000 + i)).unwrap();
        file.flush().unwrap();
    }
    file
}

fn read(bytes: Vec<u8>) -> Result<(Vec<InputRecord>, Session), ReadError> {
    let length = bytes.len() as u64;
    let source = Box::new(Cursor::new(bytes));
    let mut session = Session::read(Path::new("test.mcap"), length, source)?;
    let ticks = session.by_ref().collect();
    Ok((ticks, session))
}

/// Reads the course of any file; it may be refused.
fn read_course(bytes: &[u8]) {
    let source = Box::new(Cursor::new(bytes.to_vec()));
    if let Ok(operation) = Operation::read(Path::new("test.mcap"), bytes.len() as u64, source) {
        let _ = operation.count();
    }
}

fn given(batches: u64) -> Vec<InputRecord> {
    (0..batches)
        .flat_map(|i| batch(i * INPUT_BATCH as u64).records)
        .collect()
}

#[test]
fn a_session_is_read_as_it_was_written() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 3);
    file.tools(&tools(5_100_000_000)).unwrap();
    file.timing(&TimingBatch::zeroed()).unwrap();
    let event = EventMsg {
        kind: EventKind::Fault.number(),
        at_ns: 5_150_000_000,
        ..EventMsg::zeroed()
    };
    file.event(&event).unwrap();
    file.finish().unwrap();
    assert_eq!(file.outbox.written, disk.bytes().len() as u64);

    let (ticks, session) = read(disk.bytes()).unwrap();
    assert_eq!(ticks, given(3));
    assert_eq!(session.info, info());
    assert_eq!(session.setup.period_ns, 1_000_000);
    assert_eq!(session.scene.as_deref(), Some(scene().bytes()));
    assert_eq!(session.end(), Some(&End::Whole));
}
