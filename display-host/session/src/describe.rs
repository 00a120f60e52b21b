//! Describes the channels of a session: topics, schemas, and the messages for viewers.

use serde_json::{Value, json};
use shared_mem::message::{Event, EventMsg, PoseMsg, TimingBatch, ToolFrame};

/// A channel's topic, encoding, and schema.
pub(crate) struct Topic {
    pub(crate) name: &'static str,
    pub(crate) encoding: &'static str,
    pub(crate) schema_name: &'static str,
    pub(crate) schema_encoding: &'static str,
    pub(crate) schema: &'static str,
}

const fn json_topic(name: &'static str, schema_name: &'static str, schema: &'static str) -> Topic {
    Topic {
        name,
        encoding: "json",
        schema_name,
        schema_encoding: "jsonschema",
        schema,
    }
}

/// Encoding of the messages that `calot replay` reads.
pub(crate) const OWN: &str = "x-calot";

pub(crate) const SETUP: Topic = Topic {
    name: "/setup",
    encoding: OWN,
    schema_name: "calot.RunSetup.v2",
    schema_encoding: "x-text",
    schema: "u8[16] scene identity, u64 period ns, world_from_device and world_from_tracker (3 f32 \
             position m, 4 f32 quaternion x y z w), 3 f32 instrument port m, 3 f32 endoscope port m, 9 \
             f32 device: force max N, continuous N, torque max N m, stiffness max N/m, damping max \
             N s/m, damping N s/m, delay s, workspace m, rate Hz; 3 f32 its opening: travel m, force max N, \
             stiffness max N/m; f32 force ramp s, u32 force \
             enabled, u32 iterations of the paper's method, u32 0. Little-endian.",
};

pub(crate) const INPUTS: Topic = Topic {
    name: "/inputs",
    encoding: OWN,
    schema_name: "calot.Inputs.v3",
    schema_encoding: "x-text",
    schema: "u16 ticks, u64 first tick, u64 time before the first distance, ns. Each tick: u32 bits \
             (1 device fresh, 2 device lost, 4 tracker fresh, 8 tracker lost, 16 pedal fresh, 32 pedal \
             lost, 64 velocity, 128 cut, 256 coagulate, 512 camera lock, 1024 no self-collision, 2048 \
             no far organs, 4096 leapt, 8192 device failed, 16384 opening, 1 << 29 organs, 1 << 30 command, 1 << 31 long times), u32 ns since the tick before, u32 hash \
             of the tools, u32 hash of spheres, [16 u8 of each organ's hash, else as in the tick before, first 0], [u8 command: \
             kind + 16 argument: 1 pause (1 on), 2 reset, 3 enable force (1 on), 4 instrument (0 \
             grasper, 1 hook, 2 scissors, 3 clip applier), 6 task (0 hang, 1 identify, 2 clamp, 3 \
             cut, 4 disconnect)], [device: u32 age ns, \
             3 f32 m, 4 f32 x y z w, [3 f32 m/s], u16 number, u8 buttons, [f32 opening]], [tracker: u32 age ns, 3 f32 \
             m, 4 f32 x y z w], [pedal: u32 age ns]; times are u64 with long times. Little-endian.",
};

pub(crate) const COURSE: Topic = Topic {
    name: "/course",
    encoding: OWN,
    schema_name: "calot.Course.v1",
    schema_encoding: "x-text",
    schema: "u8 kind, u64 tick, u64 host time ns. Kind 1, where the hands are: handle, instrument, camera \
             (each 3 f32 m, 4 f32 quaternion x y z w, world frame), 3 f32 tip m, 3 f32 force on the hand \
             N, f32 jaw (0 closed), u8 instrument (0 grasper, 1 hook, 2 scissors, 3 clip applier), u8 \
             switches (1 cut, 2 coagulate, 4 camera lock, 8 paused, 16 force enabled), u8 devices live \
             (1 haptic, 2 tracker, 4 pedal), u16 contacts. Kind 2, an event: u64 sequence, u32 kind, u32 \
             organ, 3 f32 place m, f32 value. Kind 3: f32 greatest force of the haptic device, N. Kind \
             4: the organs were put back to rest. Kind 5: they were put to where a task begins, u8 task (0 \
             hang, 1 identify, 2 clamp, 3 cut, 4 disconnect). Kind 6, the endoscope's view: f32 \
             angle between view and shaft, rad, f32 turn of the light cable about the shaft, rad. \
             Little-endian.",
};

pub(crate) const POSES: Topic = json_topic(
    "/tf",
    "foxglove.FrameTransforms",
    r#"{"title":"foxglove.FrameTransforms","type":"object","properties":{"transforms":{"type":"array","items":{"type":"object","properties":{"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"parent_frame_id":{"type":"string"},"child_frame_id":{"type":"string"},"translation":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},"rotation":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}}}}}}}"#,
);

pub(crate) const TOOL: Topic = json_topic(
    "/tool",
    "calot.Tool",
    r#"{"title":"calot.Tool","type":"object","properties":{"tick":{"type":"integer"},"force_n":{"type":"number","description":"on the hand, N"},"force_xyz_n":{"type":"array","items":{"type":"number"},"description":"world frame, N"},"jaw":{"type":"number","description":"0 closed, 1 open"},"instrument":{"type":"integer","description":"0 grasper, 1 hook, 2 scissors, 3 clip applier"},"contacts":{"type":"integer"},"switches":{"type":"integer","description":"1 cut, 2 coagulate, 4 camera lock, 8 paused, 16 force enabled"},"buttons":{"type":"integer"}}}"#,
);

pub(crate) const EVENTS: Topic = json_topic(
    "/events",
    "calot.Event",
    r#"{"title":"calot.Event","type":"object","properties":{"tick":{"type":"integer"},"kind":{"type":"string"},"organ":{"type":["string","null"]},"at_m":{"type":"array","items":{"type":"number"}},"value":{"type":"number","description":"by kind: contact, slip, crush: force, N; grasp, let_go: number of spheres; fault: number of the fault; electro: current (0 off, 1 cut, 2 coagulate); tear, cut, burn, perforation: energy, J; clip: number of the clip; leak: flow as a share of the whole vessel's; removed: index of the cell; divided: open share of the lumen; stitch, hung: number of the suture; fall: distance, m; shake: speed, m/s; release, reset: no meaning"},"fault":{"type":["string","null"]}}}"#,
);

pub(crate) const TIMING: Topic = json_topic(
    "/timing",
    "calot.Timing",
    r#"{"title":"calot.Timing","type":"object","properties":{"ticks":{"type":"integer"},"deadline_misses":{"type":"integer"},"overruns":{"type":"integer"},"realtime":{"type":"boolean"},"tick_us_max":{"type":"number","description":"slowest of this second"},"wake_us_max":{"type":"number","description":"latest of this second"}}}"#,
);

pub(crate) const GAPS: Topic = json_topic(
    "/gaps",
    "calot.Gap",
    r#"{"title":"calot.Gap","type":"object","properties":{"from_tick":{"type":"integer"},"to_tick":{"type":"integer","description":"first that is there again"},"from_event":{"type":"integer","description":"a gap in the events, likewise"},"to_event":{"type":"integer"}}}"#,
);

pub(crate) fn poses(tools: &ToolFrame, wall_ns: u64) -> Value {
    let transform = |name: &str, pose: &PoseMsg| {
        let [x, y, z] = pose.position_m;
        let [qx, qy, qz, qw] = pose.orientation;
        json!({
            "timestamp": { "sec": wall_ns / 1_000_000_000, "nsec": wall_ns % 1_000_000_000 },
            "parent_frame_id": "world",
            "child_frame_id": name,
            "translation": { "x": x, "y": y, "z": z },
            "rotation": { "x": qx, "y": qy, "z": qz, "w": qw },
        })
    };
    json!({ "transforms": [
        transform("handle", &tools.world_from_handle),
        transform("instrument", &tools.world_from_instrument),
        transform("camera", &tools.world_from_camera),
    ] })
}

pub(crate) fn tool(tools: &ToolFrame) -> Value {
    let force_n = tools.force_n.iter().map(|x| x * x).sum::<f32>().sqrt();
    json!({
        "tick": tools.tick,
        "force_n": force_n,
        "force_xyz_n": tools.force_n,
        "jaw": tools.jaw,
        "instrument": tools.instrument,
        "contacts": tools.contact_count,
        "switches": tools.switches,
        "buttons": tools.buttons,
    })
}

pub(crate) fn event(event: &EventMsg, organs: &[String]) -> Value {
    let fault = match event.decode() {
        Ok(Event::Fault(fault)) => Some(fault.name()),
        _ => None,
    };
    json!({
        "tick": event.tick,
        "kind": event.name(),
        "organ": organs.get(event.organ as usize),
        "at_m": event.at_m,
        "value": event.value,
        "fault": fault,
    })
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

    pub(crate) fn value(&self) -> Value {
        json!({
            "ticks": self.ticks,
            "deadline_misses": self.missed_periods,
            "overruns": self.late_ticks,
            "realtime": self.realtime,
            "tick_us_max": f64::from(self.tick_ns_max) / 1e3,
            "wake_us_max": f64::from(self.wake_ns_max) / 1e3,
        })
    }
}
