//! Conversion of a tick's results to the messages that cross the process border. Runs in the tick
//! and fills in place.

use rt_core::math::{Pose, Vec3};
use rt_core::port::LineCounters;
use rt_core::sim::TickView;
use rt_core::tissue::suture::Placed;
use rt_core::tool::{Capsule, Switches};
use rt_core::words::{Event, EventKind, Status};
use shared_mem::message::{
    CapsuleMsg, ClipMsg, EventMsg, MAX_CAPSULES, MAX_CELLS, MAX_CLIPPED, MAX_SPHERES, MAX_SUTURES,
    PoseMsg, SphereState, StateFrame, SutureMsg, TickRecord, ToolFrame,
};

use crate::devices;

// Both sides agree on limits and bits.
const _: () = {
    assert!(MAX_SPHERES == rt_core::capacity::MAX_SPHERES);
    assert!(MAX_CLIPPED == rt_core::capacity::MAX_CLIPPED);
    assert!(MAX_SUTURES == rt_core::capacity::MAX_SUTURES);
    assert!(MAX_CELLS == rt_core::capacity::MAX_CELLS);
    assert!(StateFrame::GONE == rt_core::tissue::cells::GONE);
    assert!(SphereState::GONE == rt_core::words::SphereBits::GONE.0 as u32);
    assert!(MAX_CAPSULES == rt_core::capacity::MAX_CAPSULES);
    assert!(crate::shared::FAULTS == rt_core::fault::FAULT_COUNT);
    assert!(shared_mem::message::STAGES == rt_core::sim::Stage::ALL.len());
    assert!(SphereState::AWAKE == rt_core::words::SphereBits::AWAKE.0 as u32);
    assert!(SphereState::CONTACT == rt_core::words::SphereBits::CONTACT.0 as u32);
    assert!(SphereState::GRASPED == rt_core::words::SphereBits::GRASPED.0 as u32);
};

/// Fills a sphere frame.
pub(crate) fn fill_state(
    frame: &mut StateFrame,
    view: &TickView<'_>,
    scene_id: [u8; 16],
    now_ns: u64,
) {
    frame.tick = view.tick;
    frame.sample_ns = view.sample_ns;
    frame.at_ns = now_ns;
    frame.scene_id = scene_id;
    let mut clip_count = 0;
    for (to, from) in frame.clips.iter_mut().zip(view.clips) {
        *to = ClipMsg {
            spheres: from.spheres,
            share: from.share,
            closed: from.closed,
            legs: from.legs.into(),
            number: from.number,
        };
        clip_count += 1;
    }
    frame.clip_count = clip_count;
    let cells = view.cells();
    for (to, from) in frame.cells.iter_mut().zip(cells) {
        *to = *from;
    }
    frame.cell_count = cells.len() as u32;
    let mut suture_count = 0;
    for (to, (from, is_cut)) in frame.sutures.iter_mut().zip(view.sutures()) {
        let (placed, at_m) = match from.placed {
            Placed::Away => (SutureMsg::AWAY, from.at_m),
            Placed::AtHand => (SutureMsg::AT_HAND, view.tool.tip_m),
            Placed::Hung if is_cut => (SutureMsg::CUT, from.at_m),
            Placed::Hung => (SutureMsg::HUNG, from.at_m),
        };
        *to = SutureMsg {
            sphere: from.sphere,
            placed,
            at_m: at_m.into(),
            length_m: from.length_m,
        };
        suture_count += 1;
    }
    frame.suture_count = suture_count;
    let mut count = 0;
    for (to, from) in frame.spheres.iter_mut().zip(view.spheres()) {
        *to = SphereState {
            center_m: from.center_m.into(),
            bits: from.bits.0.into(),
        };
        count += 1;
    }
    frame.sphere_count = count;
}

/// Fills a tool frame.
pub(crate) fn fill_tools(
    frame: &mut ToolFrame,
    view: &TickView<'_>,
    lines: [Option<LineCounters>; 3],
    scene_id: [u8; 16],
    now_ns: u64,
) {
    let tool = view.tool;
    frame.tick = view.tick;
    frame.sample_ns = view.sample_ns;
    frame.at_ns = now_ns;
    frame.scene_id = scene_id;
    frame.world_from_handle = pose(&tool.world_from_handle);
    frame.world_from_instrument = pose(&tool.world_from_instrument);
    frame.world_from_camera = pose(&tool.world_from_camera);
    frame.jaw = tool.jaw;
    frame.instrument = u32::from(tool.instrument as u8);
    frame.force_n = tool.force_n.into();
    frame.contact_count = tool.contact_count;
    frame.switches = switches(&tool.switches);
    frame.buttons = tool.buttons.0.into();
    frame.clips_left = view.clips_left;
    frame.reserved = 0;
    let mut count = 0;
    for (to, from) in frame.capsules.iter_mut().zip(&tool.capsules) {
        *to = capsule(from);
        count += 1;
    }
    frame.capsule_count = count;
    let [haptic, tracker, pedal] = lines;
    frame.health = [
        devices::health(view.device, haptic),
        devices::health(view.tracker, tracker),
        devices::health(view.pedal, pedal),
    ];
}

/// Message of an event.
pub(crate) fn event(event: &Event, sequence: u64, tick: u64, at_ns: u64) -> EventMsg {
    EventMsg {
        sequence,
        tick,
        at_ns,
        kind: match event.kind {
            EventKind::Contact => EventMsg::CONTACT,
            EventKind::Release => EventMsg::RELEASE,
            EventKind::Grasp => EventMsg::GRASP,
            EventKind::LetGo => EventMsg::LET_GO,
            EventKind::Slip => EventMsg::SLIP,
            EventKind::Tear => EventMsg::TEAR,
            EventKind::Cut => EventMsg::CUT,
            EventKind::Fault => EventMsg::FAULT,
            EventKind::Electro => EventMsg::ELECTRO,
            EventKind::Clip => EventMsg::CLIP,
            EventKind::Burn => EventMsg::BURN,
            EventKind::Leak => EventMsg::LEAK,
            EventKind::Removed => EventMsg::REMOVED,
            EventKind::Crush => EventMsg::CRUSH,
            EventKind::Perforation => EventMsg::PERFORATION,
            EventKind::Divided => EventMsg::DIVIDED,
            EventKind::Stitch => EventMsg::STITCH,
            EventKind::Hung => EventMsg::HUNG,
            EventKind::Reset => EventMsg::RESET,
        },
        organ: event.organ.unwrap_or(u32::MAX),
        at_m: event.at_m.into(),
        value: event.value,
    }
}

/// Content bits of a tick's record.
pub(crate) fn record_bits(view: &TickView<'_>) -> u32 {
    let stale = matches!(view.device.status, Status::Stale | Status::Lost);
    let contact = view.tool.contact_count > 0;
    (u32::from(stale) * TickRecord::STALE) | (u32::from(contact) * TickRecord::CONTACT)
}

fn pose(pose: &Pose) -> PoseMsg {
    let q = pose.rotation.coords;
    PoseMsg {
        position_m: pose.translation.vector.into(),
        orientation: [q.x, q.y, q.z, q.w],
    }
}

fn capsule(capsule: &Capsule) -> CapsuleMsg {
    let point = |v: Vec3| v.into();
    CapsuleMsg {
        a_m: point(capsule.a_m),
        radius_m: capsule.radius_m,
        b_m: point(capsule.b_m),
        role: u32::from(capsule.role as u8),
    }
}

fn switches(switches: &Switches) -> u32 {
    let pedal = &switches.pedal;
    [
        pedal.cut,
        pedal.coagulate,
        pedal.camera_lock,
        switches.paused,
        switches.force_enabled,
    ]
    .iter()
    .enumerate()
    .fold(0, |bits, (i, &on)| bits | (u32::from(on) << i))
}

#[cfg(test)]
mod tests {
    use rt_core::fault::Fault;
    use shared_mem::message::FAULT_NAMES;

    #[test]
    fn the_border_names_the_faults_as_the_core_does() {
        assert_eq!(Fault::ALL.map(Fault::name), FAULT_NAMES);
    }
}
