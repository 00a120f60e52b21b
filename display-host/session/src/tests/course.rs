//! Tests of the course, of gaps, and of reading by other programs.

use super::*;

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
pub(super) fn tools(at_ns: u64) -> ToolFrame {
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
        is_scripted: true,
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
    let count =
        |wanted: fn(&EntryContent) -> bool| read.iter().filter(|it| wanted(&it.what)).count();
    assert_eq!(count(|what| matches!(what, EntryContent::Moved(_))), 3);
    assert_eq!(count(|what| matches!(what, EntryContent::Event(_))), 3);
    assert_eq!(count(|what| matches!(what, EntryContent::Reset)), 1);
    assert_eq!(count(|what| *what == EntryContent::Start { task: 3 }), 1);
    assert_eq!(
        count(|what| *what == EntryContent::Device { force_max_n: 3.3 }),
        1
    );
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
