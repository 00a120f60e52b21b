//! Describes the channels of a session: topics, encodings and schemas.

use std::borrow::Cow;

use foxglove::Encode;

use crate::proto::DESCRIPTION;

/// A channel's topic, encoding, and schema.
pub(crate) struct Topic {
    pub(crate) name: &'static str,
    pub(crate) encoding: &'static str,
    pub(crate) schema_name: Cow<'static, str>,
    pub(crate) schema_encoding: &'static str,
    pub(crate) schema: Cow<'static, [u8]>,
}

/// Encoding of the messages that other programs read.
pub(crate) const PROTOBUF: &str = "protobuf";

/// Channel of messages that `proto/calot.proto` describes.
const fn own(name: &'static str, schema_name: &'static str) -> Topic {
    Topic {
        name,
        encoding: PROTOBUF,
        schema_name: Cow::Borrowed(schema_name),
        schema_encoding: PROTOBUF,
        schema: Cow::Borrowed(DESCRIPTION),
    }
}

/// Channel of messages that Foxglove describes.
pub(crate) fn foxglove<T: Encode>(name: &'static str) -> Topic {
    let schema = T::get_schema();
    let (schema_name, schema) = schema.map_or_else(Default::default, |it| (it.name, it.data));
    Topic {
        name,
        encoding: PROTOBUF,
        schema_name: schema_name.into(),
        schema_encoding: PROTOBUF,
        schema,
    }
}

/// Channel of packed messages, which only Calot reads.
const fn packed(name: &'static str, schema_name: &'static str, schema: &'static str) -> Topic {
    Topic {
        name,
        encoding: OWN,
        schema_name: Cow::Borrowed(schema_name),
        schema_encoding: "x-text",
        schema: Cow::Borrowed(schema.as_bytes()),
    }
}

/// Encoding of the messages that `calot replay` reads.
pub(crate) const OWN: &str = "x-calot";

pub(crate) const SETUP: Topic = packed(
    "/setup",
    "calot.RunSetup.v2",
    "u8[16] scene identity, u64 period ns, world_from_device and world_from_tracker (3 f32 \
             position m, 4 f32 quaternion x y z w), 3 f32 instrument port m, 3 f32 endoscope port m, 9 \
             f32 device: force max N, continuous N, torque max N m, stiffness max N/m, damping max \
             N s/m, damping N s/m, delay s, workspace m, rate Hz; 3 f32 its opening: travel m, force max N, \
             stiffness max N/m; f32 force ramp s, u32 force \
             enabled, u32 iterations of the paper's method, u32 0. Little-endian.",
);

pub(crate) const INPUTS: Topic = packed(
    "/inputs",
    "calot.Inputs.v3",
    "u16 ticks, u64 first tick, u64 time before the first distance, ns. Each tick: u32 bits \
             (1 device fresh, 2 device lost, 4 tracker fresh, 8 tracker lost, 16 pedal fresh, 32 pedal \
             lost, 64 velocity, 128 cut, 256 coagulate, 512 camera lock, 1024 no self-collision, 2048 \
             no far organs, 4096 leapt, 8192 device failed, 16384 opening, 1 << 29 organs, 1 << 30 command, 1 << 31 long times), u32 ns since the tick before, u32 hash \
             of the tools, u32 hash of spheres, [16 u8 of each organ's hash, else as in the tick before, first 0], [u8 command: \
             kind + 16 argument: 1 pause (1 on), 2 reset, 3 enable force (1 on), 4 instrument (0 \
             grasper, 1 hook, 2 scissors, 3 clip applier, 4 irrigator), 6 task (0 hang, 1 identify, 2 clamp, 3 \
             cut, 4 disconnect), 9 complication (0 bleeding, 1 slipped clip)], [device: u32 age ns, \
             3 f32 m, 4 f32 x y z w, [3 f32 m/s], u16 number, u8 buttons, [f32 opening]], [tracker: u32 age ns, 3 f32 \
             m, 4 f32 x y z w], [pedal: u32 age ns]; times are u64 with long times. Little-endian.",
);

pub(crate) const COURSE: Topic = packed(
    "/course",
    "calot.Course.v1",
    "u8 kind, u64 tick, u64 host time ns. Kind 1, where the hands are: handle, instrument, camera \
             (each 3 f32 m, 4 f32 quaternion x y z w, world frame), 3 f32 tip m, 3 f32 force on the hand \
             N, f32 jaw (0 closed), u8 instrument (0 grasper, 1 hook, 2 scissors, 3 clip applier, 4 irrigator), u8 \
             switches (1 cut, 2 coagulate, 4 camera lock, 8 paused, 16 force enabled), u8 devices live \
             (1 haptic, 2 tracker, 4 pedal), u16 contacts. Kind 2, an event: u64 sequence, u32 kind, u32 \
             organ, 3 f32 place m, f32 value. Kind 3: f32 greatest force of the haptic device, N. Kind \
             4: the organs were put back to rest. Kind 5: they were put to where a task begins, u8 task (0 \
             hang, 1 identify, 2 clamp, 3 cut, 4 disconnect). Kind 6, the endoscope's view: f32 \
             angle between view and shaft, rad, f32 turn of the light cable about the shaft, rad. Kind \
             7, what the endoscope's picture shows: f32 angle between the line of sight and the plane of \
             cystic duct and artery, rad, positive on the side of the port; f32 share of the triangle \
             and f32 share of the lower bed that are clear; for each of 16 organs, in the scene's order, \
             4 u8: share in view, share of this that nothing hides, root of its size, distance from the \
             middle, each times 255. Kind 8, an act of the instructor: u8 what (0 point, 1 pause, 2 \
             resume, 3 remark, 4 fog, 5 bleeding, 6 slipped clip), 3 f32 place at which the \
             instructor points, m, the remark in UTF-8. Little-endian.",
);

/// Poses, `foxglove.FrameTransforms`.
pub(crate) const POSES: &str = "/tf";
/// The instrument's tip, `foxglove.PoseInFrame`.
pub(crate) const TIP: &str = "/tip";
/// Events as lines of text, `foxglove.Log`.
pub(crate) const LOG: &str = "/log";
pub(crate) const TOOL: Topic = own("/tool", "calot.Tool");
pub(crate) const EVENTS: Topic = own("/events", "calot.Event");
pub(crate) const TIMING: Topic = own("/timing", "calot.Timing");
pub(crate) const STAGES: Topic = own("/stages", "calot.Stages");
pub(crate) const GAPS: Topic = own("/gaps", "calot.Gap");
