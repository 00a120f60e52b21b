//! Messages for viewers and other programs: Foxglove's own schemas for poses and the log, and
//! Calot's, described in `proto/calot.proto`.

use foxglove::messages::{
    FrameTransform, FrameTransforms, Log, Pose, PoseInFrame, Quaternion, Timestamp, Vector3, log,
};
use shared_mem::message::{ActMsg, Event, EventMsg, PoseMsg, TickRecord, TimingBatch, ToolFrame};
use shared_mem::words::{ActKind, EventKind, Switches};

use crate::course::Movement;
use crate::proto;

/// Frame in which all poses are given: the scene's.
pub(crate) const WORLD: &str = "world";

/// Time since 1970, as Foxglove's messages have it.
pub(crate) fn timestamp(wall_ns: u64) -> Option<Timestamp> {
    let sec = u32::try_from(wall_ns / 1_000_000_000).ok()?;
    Timestamp::new_checked(sec, (wall_ns % 1_000_000_000) as u32)
}

fn vector([x, y, z]: [f32; 3]) -> Vector3 {
    Vector3 {
        x: x.into(),
        y: y.into(),
        z: z.into(),
    }
}

fn rotation([x, y, z, w]: [f32; 4]) -> Quaternion {
    Quaternion {
        x: x.into(),
        y: y.into(),
        z: z.into(),
        w: w.into(),
    }
}

/// The pose of the world frame in itself.
pub(crate) fn origin() -> Pose {
    Pose {
        position: Some(vector([0.0; 3])),
        orientation: Some(rotation([0.0, 0.0, 0.0, 1.0])),
    }
}

/// Poses of the handle, the instrument and the camera.
pub(crate) fn poses(tools: &ToolFrame, wall_ns: u64) -> FrameTransforms {
    let transform = |name: &str, pose: &PoseMsg| FrameTransform {
        timestamp: timestamp(wall_ns),
        parent_frame_id: WORLD.to_owned(),
        child_frame_id: name.to_owned(),
        translation: Some(vector(pose.position_m)),
        rotation: Some(rotation(pose.orientation)),
    };
    let transforms = vec![
        transform("handle", &tools.world_from_handle),
        transform("instrument", &tools.world_from_instrument),
        transform("camera", &tools.world_from_camera),
    ];
    FrameTransforms { transforms }
}

/// The instrument's tip, turned as the instrument is.
pub(crate) fn tip(moved: &Movement, wall_ns: u64) -> PoseInFrame {
    PoseInFrame {
        timestamp: timestamp(wall_ns),
        frame_id: WORLD.to_owned(),
        pose: Some(Pose {
            position: Some(vector(moved.tip_m)),
            orientation: Some(rotation(moved.world_from_instrument.orientation)),
        }),
    }
}

fn own([x, y, z]: [f32; 3]) -> proto::Vector {
    proto::Vector { x, y, z }
}

/// Instrument and force.
pub(crate) fn tool(tools: &ToolFrame, moved: &Movement) -> proto::Tool {
    let has = |switch: Switches| moved.switches().contains(switch);
    proto::Tool {
        tick: tools.tick,
        force_n: moved.force_n.iter().map(|x| x * x).sum::<f32>().sqrt(),
        force_xyz_n: Some(own(moved.force_n)),
        tip_m: Some(own(moved.tip_m)),
        jaw: moved.jaw,
        instrument: moved.instrument.into(),
        contacts: moved.contacts.into(),
        cut: has(Switches::CUT),
        coagulate: has(Switches::COAGULATE),
        camera_lock: has(Switches::CAMERA_LOCK),
        paused: has(Switches::PAUSED),
        force_enabled: has(Switches::FORCE_ENABLED),
        buttons: tools.buttons,
    }
}

/// An event of the operation.
pub(crate) fn event(event: &EventMsg, organs: &[String]) -> proto::Event {
    let fault = match event.decode() {
        Ok(Event::Fault(fault)) => fault.name(),
        _ => "",
    };
    let organ = organs.get(event.organ as usize);
    proto::Event {
        tick: event.tick,
        kind: event.name().to_owned(),
        organ: organ.cloned().unwrap_or_default(),
        at_m: Some(own(event.at_m)),
        value: event.value,
        fault: fault.to_owned(),
    }
}

/// An event as a line of the log. A fault is an error; harm to tissue is a warning.
pub(crate) fn line(event: &proto::Event, kind: Option<EventKind>, wall_ns: u64) -> Log {
    let level = match kind {
        Some(EventKind::Fault) => log::Level::Error,
        Some(
            EventKind::Tear
            | EventKind::Burn
            | EventKind::Perforation
            | EventKind::Leak
            | EventKind::Crush
            | EventKind::Slip
            | EventKind::Shake
            | EventKind::Opened
            | EventKind::Unclipped
            | EventKind::Seared
            | EventKind::StoneSpilled
            | EventKind::Buried,
        ) => log::Level::Warning,
        _ => log::Level::Info,
    };
    let about = [&event.organ, &event.fault].map(String::as_str);
    let words = [event.kind.as_str()].into_iter().chain(about);
    let words: Vec<&str> = words.filter(|it| !it.is_empty()).collect();
    Log {
        timestamp: timestamp(wall_ns),
        level: level.into(),
        message: format!("{} ({})", words.join(" "), event.value),
        name: "calot".to_owned(),
        file: String::new(),
        line: 0,
    }
}

/// An act of an instructor as a line of the log: its name and, for a remark, the text.
pub(crate) fn act(act: &ActMsg, wall_ns: u64) -> Log {
    let kind = act.kind().map_or("unknown", ActKind::name);
    let remark = act.text().unwrap_or_default();
    Log {
        timestamp: timestamp(wall_ns),
        level: log::Level::Info.into(),
        message: format!("{kind} {remark}").trim_end().to_owned(),
        name: "instructor".to_owned(),
        file: String::new(),
        line: 0,
    }
}

/// Times of ticks, up to a gap between their numbers, and the number of records taken. Returns
/// `None` without records.
pub(crate) fn stages(records: &[TickRecord]) -> Option<(proto::Stages, usize)> {
    let first = records.first()?;
    let expected = (0..).map(|i| first.tick.wrapping_add(i));
    let together = records.iter().zip(expected);
    let together = together.take_while(|(record, tick)| record.tick == *tick);
    let mut stages = proto::Stages {
        first_tick: first.tick,
        ..proto::Stages::default()
    };
    for (record, _) in together {
        let [sample, tool, contact, solve, force, procedure, publish] = record.stage_ns;
        stages.wake_ns.push(record.wake_latency_ns);
        stages.tick_ns.push(record.tick_ns);
        stages.motion_to_force_ns.push(record.motion_to_force_ns);
        stages.sample_ns.push(sample);
        stages.tool_ns.push(tool);
        stages.contact_ns.push(contact);
        stages.solve_ns.push(solve);
        stages.force_ns.push(force);
        stages.procedure_ns.push(procedure);
        stages.publish_ns.push(publish);
        stages.missed.push(record.missed);
    }
    let count = stages.wake_ns.len();
    Some((stages, count))
}

/// Timing of one second.
#[derive(Debug, Default)]
pub(crate) struct Second {
    ticks: u64,
    missed_periods: u64,
    late_ticks: u64,
    realtime: bool,
    tick_ns_max: u32,
    wake_ns_max: u32,
}

impl Second {
    pub(crate) fn take(&mut self, batch: &TimingBatch) {
        self.ticks = batch.ticks;
        self.missed_periods = batch.missed_periods;
        self.late_ticks = batch.late_ticks;
        let all = TimingBatch::FIFO | TimingBatch::LOCKED | TimingBatch::PINNED;
        self.realtime = batch.realtime & all == all;
        for record in batch.records().unwrap_or_default() {
            self.tick_ns_max = self.tick_ns_max.max(record.tick_ns);
            self.wake_ns_max = self.wake_ns_max.max(record.wake_latency_ns);
        }
    }

    pub(crate) fn message(&self) -> proto::Timing {
        proto::Timing {
            ticks: self.ticks,
            deadline_misses: self.missed_periods,
            overruns: self.late_ticks,
            realtime: self.realtime,
            tick_us_max: self.tick_ns_max as f32 / 1e3,
            wake_us_max: self.wake_ns_max as f32 / 1e3,
        }
    }
}
