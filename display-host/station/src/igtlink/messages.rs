//! Messages about the tools and about events: poses, force, jaws, instrument, events.

use hardware::igtlink::message::{Message, Unit};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use shared_mem::message::{Event, EventMsg, PoseMsg, ToolFrame};

use super::frame::Frame;

/// Name of the device in messages about the whole station.
pub(super) const STATION: &str = "Calot";
/// Length of the transform that stands for a force of 1 N, m.
const FORCE_M_N: f32 = 1.0e-3;
const TOOL: &str = "ToolToReference";
const HANDLE: &str = "HandleToReference";
const ENDOSCOPE: &str = "EndoscopeToReference";

/// Messages of a frame of the tools. All have the same time stamp.
pub(super) fn moment(tools: &ToolFrame, frame: Frame, unix_ns: u64) -> Vec<Message> {
    let poses = [
        (TOOL, pose(&tools.world_from_instrument)),
        (HANDLE, pose(&tools.world_from_handle)),
        (ENDOSCOPE, pose(&tools.world_from_camera)),
    ]
    .map(|(name, pose)| (name, frame.pose(&pose)));
    let force_n = frame.vector(Vector3::from(tools.force_n));
    let force: Isometry3<f32> = Translation3::from(force_n * FORCE_M_N).into();
    // The reference library reads a name of 20 bytes, such as EndoscopeToReference, as empty. So
    // the tracking data have short names.
    let short = |(name, pose): (&'static str, _)| (name.trim_end_matches("ToReference"), pose);
    let tracked = poses.map(short);
    let transform = |(name, pose): &(&str, Isometry3<f32>)| Message::transform(name, pose, unix_ns);
    poses
        .iter()
        .chain([&("ForceToReference", force)])
        .filter_map(transform)
        .chain(Message::tracking(STATION, &tracked, unix_ns))
        .chain(Message::quaternions(STATION, &tracked, unix_ns))
        .chain(Message::sensor(
            "Force",
            force_n.as_slice(),
            Unit::Newton,
            unix_ns,
        ))
        .chain(Message::sensor("Jaw", &[tools.jaw], Unit::One, unix_ns))
        .collect()
}

/// The instrument in the hand, as text.
pub(super) fn instrument(tools: &ToolFrame, unix_ns: u64) -> Message {
    let name = tools.instrument().map_or("unknown", |it| it.name());
    Message::string("Instrument", name, unix_ns)
}

/// An event as text: its kind, the name of the fault or current, and the organ. The organ has the
/// name `organ`, or its number if the name is not known.
pub(super) fn event(message: &EventMsg, organ: Option<&str>, unix_ns: u64) -> Message {
    let mut text = match message.decode() {
        Ok(Event::Fault(fault)) => format!("alarm {}", fault.name()),
        Ok(Event::Electro(current)) => format!("electro {}", current.name()),
        _ => message.name().to_owned(),
    };
    match organ {
        Some(name) => text += &format!(" {name}"),
        None if message.organ != u32::MAX => text += &format!(" organ {}", message.organ),
        None => {}
    }
    Message::string("Event", &text, unix_ns)
}

fn pose(message: &PoseMsg) -> Isometry3<f32> {
    let [x, y, z, w] = message.orientation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(message.position_m), rotation)
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;
    use shared_mem::words::{EventKind, Fault};

    use super::*;

    fn tools() -> ToolFrame {
        let mut tools = ToolFrame::zeroed();
        tools.world_from_handle = PoseMsg::IDENTITY;
        tools.world_from_camera = PoseMsg::IDENTITY;
        tools.world_from_instrument = PoseMsg::IDENTITY;
        tools.world_from_instrument.position_m = [0.01, 0.02, 0.03];
        tools.force_n = [1.0, 2.0, 3.0];
        tools
    }

    #[test]
    fn a_moment_has_poses_force_and_jaws_with_one_stamp() {
        let sent = moment(&tools(), Frame::Ras, 7);
        let names: Vec<_> = sent.iter().map(|it| (it.kind, it.name.as_str())).collect();
        let expected = [
            ("TRANSFORM", TOOL),
            ("TRANSFORM", HANDLE),
            ("TRANSFORM", ENDOSCOPE),
            ("TRANSFORM", "ForceToReference"),
            ("TDATA", STATION),
            ("QTDATA", STATION),
            ("SENSOR", "Force"),
            ("SENSOR", "Jaw"),
        ];
        assert_eq!(names, expected);
        assert!(sent.iter().all(|it| it.unix_ns == 7));
        for (element, name) in sent[4]
            .content
            .chunks_exact(70)
            .zip(["Tool", "Handle", "Endoscope"])
        {
            assert_eq!(&element[..name.len()], name.as_bytes());
            assert_eq!(element[name.len()], 0, "a zero closes the name");
        }
    }

    #[test]
    fn the_force_is_in_newton_and_in_the_frame_of_the_poses() {
        let sent = moment(&tools(), Frame::Ras, 0);
        let force: Vec<f64> = sent[6].content[10..]
            .chunks_exact(8)
            .map(|it| f64::from_be_bytes(it.try_into().unwrap()))
            .collect();
        for (told, expected) in force.iter().zip([-1.0, 3.0, 2.0]) {
            assert!((told - expected).abs() < 1e-6, "{force:?}");
        }
        // The transform moves by 1 mm per newton.
        let millimetre = sent[3].content[36..].first_chunk::<4>().unwrap();
        assert!((f32::from_be_bytes(*millimetre) + 1.0).abs() < 1e-5);
    }

    #[test]
    fn instruments_and_events_are_sent_by_name() {
        let text = |message: Message| String::from_utf8(message.content[4..].to_vec()).unwrap();
        assert_eq!(text(instrument(&tools(), 0)), "grasper");
        let mut fault = EventMsg::zeroed();
        (fault.kind, fault.organ) = (EventKind::Fault.number(), u32::MAX);
        fault.value = Fault::SpeedTrip.number() as f32;
        assert_eq!(text(event(&fault, None, 0)), "alarm speed_trip");
        let mut cut = EventMsg::zeroed();
        (cut.kind, cut.organ) = (EventKind::Cut.number(), 3);
        assert_eq!(text(event(&cut, None, 0)), "cut organ 3");
        assert_eq!(text(event(&cut, Some("liver"), 0)), "cut liver");
    }
}
