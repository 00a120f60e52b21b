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
use crate::{Assignment, End, Entry, Finish, Info, Operation, ReadError, Session, Storage, What};

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
        scene_id: "00".into(),
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
    let mut tools = ToolFrame::zeroed();
    tools.at_ns = 5_100_000_000;
    file.tools(&tools).unwrap();
    file.timing(&TimingBatch::zeroed());
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

/// Foxglove and other viewers need an index, schemas, valid JSON, and wall-clock times.
#[test]
fn other_programs_can_open_a_session() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 2);
    let mut tools = ToolFrame::zeroed();
    tools.at_ns = 5_000_000_500;
    file.tools(&tools).unwrap();
    let event = EventMsg {
        kind: EventKind::Contact.number(),
        at_ns: 5_000_000_600,
        ..EventMsg::zeroed()
    };
    file.event(&event).unwrap();
    file.finish().unwrap();
    let bytes = disk.bytes();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    assert_eq!(
        (statistics.attachment_count, statistics.metadata_count),
        (1, 2)
    );
    let mut topics: Vec<&str> = summary
        .channels
        .values()
        .map(|it| it.topic.as_str())
        .collect();
    topics.sort_unstable();
    assert_eq!(
        topics,
        [
            "/course", "/events", "/gaps", "/inputs", "/setup", "/tf", "/timing", "/tool"
        ]
    );
    for channel in summary.channels.values() {
        let schema = channel.schema.as_ref().unwrap();
        if schema.encoding == "jsonschema" {
            let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!(schema["type"], "object");
        }
    }
    let mut seen = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert!(message.log_time > 5_000_001_000 - 1, "wall clock");
        if message.channel.message_encoding == "json" {
            let _: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
            seen += 1;
        }
    }
    assert_eq!(seen, 2 + 2 + 1, "timing, /tf and /tool, the event");
}

/// The tools at this time.
fn tools(at_ns: u64) -> ToolFrame {
    ToolFrame {
        tick: at_ns / 1_000_000,
        at_ns,
        world_from_handle: PoseMsg::IDENTITY,
        world_from_instrument: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        jaw: 0.25,
        force_n: [0.0, 0.5, at_ns as f32 * 1e-9],
        ..ToolFrame::zeroed()
    }
}

#[test]
fn the_course_is_read_as_it_was_told() {
    let disk = Disk::with_room(usize::MAX);
    let (told, entries) = std::sync::mpsc::channel();
    let mut file = SessionFile::begin(Box::new(disk.clone()), &info(), &scene()).unwrap();
    file.tell(told);
    let assignment = Assignment {
        task: "cut".into(),
        difficulty: "exam".into(),
        rules: "a = 1\n".into(),
        id: "x".into(),
    };
    file.assignment(&assignment).unwrap();
    for i in 0..3 {
        let mut batch = batch(i * INPUT_BATCH as u64);
        batch.setup.device[0] = 3.3;
        batch.records[7].command = [0x36, 2, 1][i as usize];
        file.inputs(&batch).unwrap();
        file.moved(&tools(5_000_000_000 + i * 10_000_000)).unwrap();
        let event = EventMsg {
            kind: EventKind::Clip.number(),
            organ: 3,
            value: i as f32,
            ..EventMsg::zeroed()
        };
        file.event(&event).unwrap();
        file.flush().unwrap();
    }
    // A false frame and an invalid event leave nothing.
    let mut bad = tools(1);
    bad.force_n[0] = f32::NAN;
    file.moved(&bad).unwrap();
    let event = EventMsg {
        value: f32::NAN,
        ..EventMsg::zeroed()
    };
    file.event(&event).unwrap();
    file.finish().unwrap();
    drop(file);
    let told: Vec<Entry> = entries.iter().collect();
    let bytes = disk.bytes();
    let length = bytes.len() as u64;
    let source = Box::new(Cursor::new(bytes));
    let mut operation = Operation::read(Path::new("test.mcap"), length, source).unwrap();
    let read: Vec<Entry> = operation.by_ref().collect();
    assert_eq!(read, told);
    assert_eq!(operation.end(), Some(&End::Whole));
    assert_eq!(operation.assignment, Some(assignment));
    assert_eq!(operation.scene.name(), "nothing");
    let count = |wanted: fn(&What) -> bool| read.iter().filter(|it| wanted(&it.what)).count();
    assert_eq!(count(|what| matches!(what, What::Moved(_))), 3);
    assert_eq!(count(|what| matches!(what, What::Event(_))), 3);
    assert_eq!(count(|what| matches!(what, What::Reset)), 1);
    assert_eq!(count(|what| *what == What::Start { task: 3 }), 1);
    assert_eq!(count(|what| *what == What::Device { force_max_n: 3.3 }), 1);
    // Replay is not affected.
    assert_eq!(self::read(disk.bytes()).unwrap().0.len(), 3 * INPUT_BATCH);
}

#[test]
fn a_session_without_a_course_is_refused_with_a_reason() {
    let mut batch = batch(0);
    batch.setup.device[0] = f32::NAN;
    let disk = Disk::with_room(usize::MAX);
    let mut file = SessionFile::begin(Box::new(disk.clone()), &info(), &scene()).unwrap();
    file.inputs(&batch).unwrap();
    file.finish().unwrap();
    let source = Box::new(Cursor::new(disk.bytes()));
    let error = Operation::read(Path::new("old.mcap"), 1, source).unwrap_err();
    assert!(error.to_string().contains("no course"), "{error}");
}

#[test]
fn a_gap_is_counted_and_stands_in_the_session() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 1);
    file.inputs(&batch(100)).unwrap();
    file.finish().unwrap();
    assert_eq!(file.ticks.recorded, 2 * INPUT_BATCH as u64);
    assert_eq!(file.ticks.missing, 100 - INPUT_BATCH as u64);
    let (ticks, _) = read(disk.bytes()).unwrap();
    assert_eq!(ticks[INPUT_BATCH].tick, 100);
    let gaps = mcap::MessageStream::new(&disk.bytes())
        .unwrap()
        .filter(|it| it.as_ref().is_ok_and(|it| it.channel.topic == "/gaps"))
        .count();
    assert_eq!(gaps, 1);
}

#[test]
fn events_that_are_missing_are_counted_and_stand_in_the_session() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 1);
    // The second 0 comes from another controller.
    for sequence in [0, 1, 4, 0, 1] {
        let event = EventMsg {
            sequence,
            ..EventMsg::zeroed()
        };
        file.event(&event).unwrap();
    }
    file.heard_of(7);
    file.finish().unwrap();
    assert_eq!(file.events.missing, 2 + 5);
    let (_, session) = read(disk.bytes()).unwrap();
    let finish = session.finish().unwrap();
    assert_eq!((finish.missing, finish.missing_events), (0, 7));
    let gaps: Vec<serde_json::Value> = mcap::MessageStream::new(&disk.bytes())
        .unwrap()
        .filter_map(Result::ok)
        .filter(|it| it.channel.topic == "/gaps")
        .map(|it| serde_json::from_slice(&it.data).unwrap())
        .collect();
    assert_eq!(
        gaps,
        [serde_json::json!({ "from_event": 2, "to_event": 4 })]
    );
}

/// Shared memory may hold any number: the largest one stops no recorder.
#[test]
fn ticks_and_events_of_any_number_are_taken() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 0);
    for first in [u64::MAX - 2, 7, u64::MAX, 0, u64::MAX] {
        let mut batch = batch(0);
        for (i, record) in (0..).zip(&mut batch.records) {
            record.tick = first.wrapping_add(i);
        }
        file.inputs(&batch).unwrap();
        let event = EventMsg {
            sequence: first,
            ..EventMsg::zeroed()
        };
        file.event(&event).unwrap();
    }
    file.heard_of(u64::MAX);
    file.finish().unwrap();
    assert_eq!(
        (file.ticks.missing, file.events.missing),
        (u64::MAX, u64::MAX)
    );
    let (ticks, _) = read(disk.bytes()).unwrap();
    assert_eq!(ticks.len(), 5 * INPUT_BATCH);
}

#[test]
fn full_disk_leaves_a_readable_file_and_loses_nothing_once_it_has_room() {
    let whole = Disk::with_room(usize::MAX);
    let length = {
        record(&whole, 3).finish().unwrap();
        whole.bytes().len()
    };
    let disk = Disk::with_room(length * 2 / 3);
    let mut file = record(&disk, 3);
    assert!(file.outbox.failures > 0);
    let (ticks, session) = read(disk.bytes()).unwrap();
    assert!(!ticks.is_empty() && given(3).starts_with(&ticks));
    assert_eq!(file.ticks.on_disk, ticks.len() as u64);
    assert!(matches!(session.end(), Some(End::BrokenOff(_))));
    disk.set_room(usize::MAX);
    file.finish().unwrap();
    assert_eq!(file.outbox.given_up, None);
    assert_eq!(disk.bytes().len(), length);
    let (ticks, session) = read(disk.bytes()).unwrap();
    assert!(ticks == given(3) && session.end() == Some(&End::Whole));
}

#[test]
fn a_disk_that_stays_full_is_given_up_and_memory_stays_bounded() {
    let disk = Disk::with_room(100_000);
    let mut file = record(&disk, 1);
    let mut i = 1;
    while file.outbox.given_up.is_none() {
        file.inputs(&batch(i * INPUT_BATCH as u64)).unwrap();
        if i.is_multiple_of(16) {
            file.flush().unwrap();
        }
        i += 1;
        assert!(i < 10_000, "16 MB are waiting by now");
    }
    file.finish().unwrap();
    let (ticks, _) = read(disk.bytes()).unwrap();
    assert!(given(10_000).starts_with(&ticks) && ticks.len() >= INPUT_BATCH);
}

/// Start and end of each chunk.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let end = at + 9 + length as usize;
        if bytes[at] == 6 {
            found.push((at, end));
        }
        at = end;
    }
    found
}

fn why_damaged(bytes: Vec<u8>) -> String {
    match read(bytes) {
        Ok((_, session)) => match session.end() {
            Some(End::Damaged(why)) => why.clone(),
            end => panic!("{end:?}"),
        },
        Err(error) => error.to_string(),
    }
}

#[test]
fn lengths_that_lie_are_damage_and_cost_no_memory() {
    let whole = recorded();
    let (chunk, end) = chunks(&whole)[2];
    let body = chunk + 9;
    // (offset, bytes, error message)
    let lies: [(usize, &[u8], &str); 6] = [
        (chunk + 1, &[0xff; 8], "at most"),
        (chunk + 1, &1_000_000u64.to_le_bytes(), "length"),
        (chunk, &[0x86], "0x86"),
        (body + 28, &0xf000_0000u32.to_le_bytes(), "compressed"),
        (body + 32, &[0xff; 8], "length"),
        (
            body + 40 + 1,
            &10_000_000u64.to_le_bytes(),
            "exceeds its chunk",
        ),
    ];
    for (at, value, said) in lies {
        let mut bytes = whole.clone();
        bytes[body + 24..body + 28].fill(0);
        bytes[at..at + value.len()].copy_from_slice(value);
        let (ticks, _) = read(bytes.clone()).unwrap();
        assert_eq!(ticks, given(1), "{said}");
        let why = why_damaged(bytes);
        assert!(
            why.contains(said) && why.contains(&format!("byte {chunk}")),
            "{why}"
        );
    }
    // The chunk is cut although it claims to be longer.
    let (ticks, session) = read(whole[..end - 1].to_vec()).unwrap();
    assert!(ticks == given(1) && matches!(session.end(), Some(End::BrokenOff(_))));
    // Shorter than its own head, which the library does not expect.
    let mut attachment = mcap::MAGIC.to_vec();
    attachment.push(9);
    attachment.extend(32u64.to_le_bytes());
    attachment.extend([0; 32]);
    assert!(why_damaged(attachment).contains("exceed it"));
}

#[test]
fn texts_of_a_file_are_shown_without_control_characters() {
    let map = Info {
        build: "\u{1b}[31mred\u{7}".to_owned() + &"x".repeat(1000),
        ..info()
    }
    .to_map();
    let read = Info::from_map(&map).unwrap().build;
    assert!(read.starts_with("[31mredxx") && read.len() == 200, "{read}");
}

#[test]
fn ticks_that_are_missing_at_the_end_are_known() {
    let finish = |ran: u32, lost: u64| {
        let disk = Disk::with_room(usize::MAX);
        let mut file = record(&disk, 2);
        let mut last = InputBatch::zeroed();
        (last.ran, last.lost) = (ran, lost);
        file.inputs(&last).unwrap();
        file.finish().unwrap();
        let (ticks, session) = read(disk.bytes()).unwrap();
        assert_eq!(ticks, given(2));
        assert_eq!(
            session.finish().map(|it| it.missing),
            Some(file.ticks.missing)
        );
        session.finish().unwrap()
    };
    let ticks = 2 * INPUT_BATCH as u64;
    let ended = |ran, missing| Finish {
        ran,
        missing,
        missing_events: 0,
    };
    assert_eq!(finish(ticks as u32, 0), ended(Some(ticks), 0));
    assert_eq!(finish(ticks as u32 + 7, 5), ended(Some(ticks + 7), 7));
    assert_eq!(finish(0, 5), ended(None, 5));
    assert_eq!(finish(0, 0), ended(None, 0));
}

#[test]
fn a_file_is_nobody_elses_even_where_one_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    std::fs::write(&path, "old").unwrap();
    std::fs::set_permissions(&path, Permissions::from_mode(0o644)).unwrap();
    let file = crate::create_private(&path).unwrap();
    let found = file.metadata().unwrap();
    assert_eq!(
        (found.len(), found.permissions().mode() & 0o777),
        (0, 0o600)
    );
}

fn recorded() -> Vec<u8> {
    let disk = Disk::with_room(usize::MAX);
    record(&disk, 3).finish().unwrap();
    disk.bytes()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_session_that_is_cut_anywhere_gives_what_was_flushed(share in 0.0f64..1.0) {
        let disk = Disk::with_room(usize::MAX);
        let mut flushed = Vec::new();
        let mut file = record(&disk, 0);
        for i in 0..3 {
            file.inputs(&batch(i * INPUT_BATCH as u64)).unwrap();
            file.flush().unwrap();
            flushed.push(disk.bytes().len());
        }
        file.finish().unwrap();
        let mut bytes = disk.bytes();
        let cut = (share * bytes.len() as f64) as usize;
        bytes.truncate(cut);
        let whole = flushed.iter().filter(|&&end| end <= cut).count();
        match read(bytes) {
            // One more chunk may be complete: only its index is cut.
            Ok((ticks, _)) => {
                prop_assert!(given(3).starts_with(&ticks));
                prop_assert!(ticks.len() >= whole * INPUT_BATCH);
            }
            Err(_) => prop_assert_eq!(whole, 0),
        }
    }

    /// A disk may fill up in the middle of a chunk, of the final record, or of the index.
    #[test]
    fn a_disk_that_is_full_anywhere_leaves_what_is_said(share in 0.0f64..1.0) {
        let room = (share * recorded().len() as f64) as usize;
        let disk = Disk::with_room(room);
        let mut file = record(&disk, 3);
        file.finish().unwrap();
        prop_assert!(file.outbox.given_up.is_some());
        prop_assert_eq!(file.outbox.written, disk.bytes().len() as u64);
        match read(disk.bytes()) {
            Ok((ticks, session)) => {
                prop_assert!(given(3).starts_with(&ticks));
                prop_assert_eq!(ticks.len() as u64, file.ticks.on_disk);
                prop_assert!(matches!(session.end(), Some(End::BrokenOff(_))));
            }
            Err(_) => prop_assert_eq!(file.ticks.on_disk, 0),
        }
    }

    #[test]
    fn a_damaged_session_gives_true_ticks_or_none(
        flips in prop::collection::vec((0.0f64..1.0, 0u8..8), 1..6),
    ) {
        let mut bytes = recorded();
        for (share, bit) in flips {
            let at = (share * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << bit;
        }
        if let Ok((ticks, session)) = read(bytes) {
            prop_assert!(given(3).starts_with(&ticks));
            prop_assert!(ticks.len() == given(3).len() || session.end() != Some(&End::Whole));
        }
    }

    /// Without checksums flipped bits reach everything in a chunk: the content may be false, but
    /// nothing crashes.
    #[test]
    fn a_damaged_session_without_checksums_is_read_or_refused(
        flips in prop::collection::vec((0.0f64..1.0, any::<u8>()), 1..9),
        chunk in 0usize..3,
    ) {
        let mut bytes = recorded();
        let chunks = chunks(&bytes);
        for (at, _) in &chunks {
            bytes[at + 9 + 24..at + 9 + 28].fill(0);
        }
        let (from, to) = chunks[chunk];
        for (share, value) in flips {
            // Lengths are at the beginning of a chunk.
            let at = from + (share * share * (to - from) as f64) as usize;
            bytes[at] = value;
        }
        read_course(&bytes);
        let _ = read(bytes);
    }

    #[test]
    fn any_bytes_after_the_beginning_are_read_or_refused(
        kept in 0usize..200,
        noise in prop::collection::vec(any::<u8>(), 0..2000),
    ) {
        let mut bytes = recorded();
        bytes.truncate(kept);
        bytes.extend(noise);
        read_course(&bytes);
        let _ = read(bytes);
    }
}
