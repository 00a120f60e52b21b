//! Tests of the course, of gaps, and of reading by other programs.

use prost_reflect::{DescriptorPool, DynamicMessage, Value};

use super::*;

/// A message as another program decodes it: with nothing but the description that its channel
/// embeds. `None` if only Calot reads the channel.
pub(super) fn decoded(message: &mcap::Message<'_>) -> Option<DynamicMessage> {
    let schema = message.channel.schema.as_ref().unwrap();
    (message.channel.message_encoding == "protobuf").then(|| {
        let pool = DescriptorPool::decode(&*schema.data).unwrap();
        let described = pool.get_message_by_name(&schema.name).unwrap();
        DynamicMessage::decode(described, &*message.data).unwrap()
    })
}

/// The field of a decoded message, `a.b` for a field in a message.
pub(super) fn field(message: &DynamicMessage, path: &str) -> Value {
    let mut value = Value::Message(message.clone());
    for name in path.split('.') {
        let message = value.as_message().unwrap();
        value = message.get_field_by_name(name).unwrap().into_owned();
    }
    value
}

/// Messages of a topic in a session, decoded.
fn on(bytes: &[u8], topic: &str) -> Vec<DynamicMessage> {
    let messages = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap);
    let of_topic = messages.filter(|it| it.channel.topic == topic);
    of_topic.filter_map(|it| decoded(&it)).collect()
}

/// Foxglove and other viewers need an index, descriptions of the messages, and wall-clock times.
#[test]
fn other_programs_can_open_a_session() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 2);
    file.tools(&tools(5_000_000_500)).unwrap();
    let event = EventMsg {
        kind: EventKind::Fault.number(),
        value: 2.0,
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
    let channels = summary.channels.values();
    let mut topics: Vec<(&str, &str)> = channels
        .map(|it| (it.topic.as_str(), it.schema.as_ref().unwrap().name.as_str()))
        .collect();
    topics.sort_unstable();
    assert_eq!(
        topics,
        [
            ("/course", "calot.Course.v1"),
            ("/events", "calot.Event"),
            ("/gaps", "calot.Gap"),
            ("/inputs", "calot.Inputs.v3"),
            ("/log", "foxglove.Log"),
            ("/setup", "calot.RunSetup.v2"),
            ("/stages", "calot.Stages"),
            ("/tf", "foxglove.FrameTransforms"),
            ("/timing", "calot.Timing"),
            ("/tip", "foxglove.PoseInFrame"),
            ("/tool", "calot.Tool"),
        ]
    );
    let mut seen = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert!(message.publish_time > 5_000_001_000 - 1, "wall clock");
        seen += usize::from(decoded(&message).is_some());
    }
    assert_eq!(
        seen,
        2 + 2 + 2 + 2,
        "timing, /tool, /tf and /tip, the event and its line"
    );
    let [fault] = &on(&bytes, "/events")[..] else {
        panic!("one event");
    };
    assert_eq!(field(fault, "kind"), Value::String("fault".into()));
    assert_ne!(field(fault, "fault"), Value::String(String::new()));
    let [line] = &on(&bytes, "/log")[..] else {
        panic!("one line");
    };
    assert_eq!(field(line, "level"), Value::EnumNumber(4), "an error");
    let tool = &on(&bytes, "/tool")[0];
    assert_eq!(field(tool, "force_xyz_n.y"), Value::F32(0.5));
    assert_eq!(field(tool, "jaw"), Value::F32(0.25));
}

#[test]
fn times_of_ticks_are_recorded_for_each_stage() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 0);
    let mut batch = TimingBatch::zeroed();
    batch.count = 5;
    for (i, record) in (0..).zip(&mut batch.records) {
        // Tick 3 is missing.
        record.tick = i + u64::from(i > 2);
        record.tick_ns = 1000 + i as u32;
        record.stage_ns[3] = 70;
    }
    file.timing(&batch).unwrap();
    batch.count = u32::MAX;
    file.timing(&batch).unwrap();
    file.finish().unwrap();
    let found = on(&disk.bytes(), "/stages");
    let firsts: Vec<Value> = found.iter().map(|it| field(it, "first_tick")).collect();
    assert_eq!(firsts, [Value::U64(0), Value::U64(4)]);
    let lists = |name| found.iter().map(move |it| field(it, name));
    let list = |of: std::ops::Range<u32>| Value::List(of.map(Value::U32).collect());
    assert_eq!(
        lists("tick_ns").collect::<Vec<_>>(),
        [list(1000..1003), list(1003..1005)]
    );
    let solve: Vec<Value> = lists("solve_ns").collect();
    assert_eq!(solve[1], Value::List(vec![Value::U32(70); 2]));
}

#[test]
fn messages_of_a_channel_are_in_the_order_of_their_times() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 0);
    for at_ns in [5_000_000_300, 5_000_000_100, 5_000_000_200, 5_000_000_400] {
        file.moved(&tools(at_ns)).unwrap();
        file.event(&EventMsg {
            at_ns: at_ns - 50,
            ..EventMsg::zeroed()
        })
        .unwrap();
    }
    file.finish().unwrap();
    let bytes = disk.bytes();
    let mut newest = std::collections::BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let before = newest.insert(message.channel.id, message.log_time);
        assert!(before.is_none_or(|it| it <= message.log_time));
        assert_eq!(message.publish_time, message.log_time);
    }
    let source = Box::new(Cursor::new(bytes));
    let operation = Operation::read(Path::new("test.mcap"), 1, source).unwrap();
    let moved = operation.filter(|it| matches!(it.what, EntryContent::Moved(_)));
    let times: Vec<u64> = moved.map(|it| it.at_ns - 5_000_000_000).collect();
    assert_eq!(times, [300, 100, 200, 400], "their own times stay");
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
fn the_course_is_read_as_it_was_written() {
    let disk = Disk::with_room(usize::MAX);
    let (sender, entries) = std::sync::mpsc::channel();
    let mut file = SessionFile::begin(Box::new(disk.clone()), &info(), &scene()).unwrap();
    file.tell(sender);
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
    let sent: Vec<Entry> = entries.iter().collect();
    let bytes = disk.bytes();
    let length = bytes.len() as u64;
    let source = Box::new(Cursor::new(bytes));
    let mut operation = Operation::read(Path::new("test.mcap"), length, source).unwrap();
    let read: Vec<Entry> = operation.by_ref().collect();
    assert_eq!(read, sent);
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
fn a_gap_is_counted_and_recorded() {
    let disk = Disk::with_room(usize::MAX);
    let mut file = record(&disk, 1);
    file.inputs(&batch(100)).unwrap();
    file.finish().unwrap();
    assert_eq!(file.ticks.recorded, 2 * INPUT_BATCH as u64);
    assert_eq!(file.ticks.missing, 100 - INPUT_BATCH as u64);
    let (ticks, _) = read(disk.bytes()).unwrap();
    assert_eq!(ticks[INPUT_BATCH].tick, 100);
    let [gap] = &on(&disk.bytes(), "/gaps")[..] else {
        panic!("one gap");
    };
    let names = ["of", "from", "to"];
    let found = names.map(|name| field(gap, name));
    let first = INPUT_BATCH as u64;
    let ticks = [Value::EnumNumber(0), Value::U64(first), Value::U64(100)];
    assert_eq!(found, ticks);
}

#[test]
fn missing_events_are_counted_and_recorded() {
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
    let [gap] = &on(&disk.bytes(), "/gaps")[..] else {
        panic!("one gap");
    };
    let found = ["of", "from", "to"].map(|name| field(gap, name));
    assert_eq!(found, [Value::EnumNumber(1), Value::U64(2), Value::U64(4)]);
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
