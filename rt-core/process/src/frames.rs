//! Conversion of a tick's results to the messages for other processes. It runs in the tick and
//! fills the messages in place.

use rt_core::math::{Pose, Vec3};
use rt_core::port::LineCounters;
use rt_core::sim::TickView;
use rt_core::tissue::suture::Placed;
use rt_core::tool::{Capsule, Switches};
use rt_core::words::{Event, EventKind, Status};
use shared_mem::message::{
    CapsuleMsg, ClipMsg, DentMsg, EventMsg, MAX_STONES, MAX_TUBE_LINKS, PoseMsg, SphereState,
    StateFrame, StoneMsg, SutureMsg, TickRecord, ToolFrame,
};
use shared_mem::words::{self, EventKind as MessageKind};

use crate::devices;

/// Fills a state frame: clips, cells, sutures, parted links and spheres.
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
    let mut link_count = 0;
    frame.parted = [0; MAX_TUBE_LINKS / 8];
    for is_severed in view.severed_links() {
        if let Some(bits) = frame.parted.get_mut(link_count / 8) {
            *bits |= u8::from(is_severed) << (link_count % 8);
        }
        link_count += 1;
    }
    frame.link_count = link_count as u32;
    frame.stone_count = fill_stones(&mut frame.stones, view);
    let mut count = 0;
    for (to, from) in frame.spheres.iter_mut().zip(view.spheres()) {
        *to = SphereState {
            center_m: from.center_m.into(),
            bits: u32::from_le_bytes([
                from.bits.0,
                from.heat.rise_k,
                from.heat.denatured,
                from.heat.dried,
            ]),
        };
        count += 1;
    }
    frame.sphere_count = count;
}

/// Fills in the stones outside of the gallbladder. Returns their number.
fn fill_stones(to: &mut [StoneMsg; MAX_STONES], view: &TickView<'_>) -> u32 {
    let mut count = 0;
    let loose = (0u32..).zip(view.stones()).filter(|(_, it)| it.is_loose());
    for (to, (number, stone)) in to.iter_mut().zip(loose) {
        let q = stone.turn.coords;
        *to = StoneMsg {
            at_m: stone.at_m.into(),
            radius_m: view.stone_radius_m(),
            orientation: [q.x, q.y, q.z, q.w],
            number,
            is_held: u32::from(stone.is_held()),
        };
        count += 1;
    }
    count
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
    let mut dent_count = 0;
    for (to, from) in frame.dents.iter_mut().zip(view.dents()) {
        *to = DentMsg {
            center_m: from.center_m.into(),
            radius_m: from.radius_m,
            half_m: from.half_m.into(),
            depth_m: from.depth_m,
            normal: from.normal.into(),
            organ: from.organ.into(),
        };
        dent_count += 1;
    }
    frame.dent_count = dent_count;
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
        kind: kind(event.kind).number(),
        organ: event.organ.unwrap_or(u32::MAX),
        at_m: event.at_m.into(),
        value: event.value,
    }
}

/// Kind of an event as messages carry it.
fn kind(kind: EventKind) -> MessageKind {
    match kind {
        EventKind::Contact => MessageKind::Contact,
        EventKind::Release => MessageKind::Release,
        EventKind::Grasp => MessageKind::Grasp,
        EventKind::LetGo => MessageKind::LetGo,
        EventKind::Slip => MessageKind::Slip,
        EventKind::Tear => MessageKind::Tear,
        EventKind::Cut => MessageKind::Cut,
        EventKind::Fault => MessageKind::Fault,
        EventKind::Electro => MessageKind::Electro,
        EventKind::Clip => MessageKind::Clip,
        EventKind::Burn => MessageKind::Burn,
        EventKind::Leak => MessageKind::Leak,
        EventKind::Removed => MessageKind::Removed,
        EventKind::Crush => MessageKind::Crush,
        EventKind::Perforation => MessageKind::Perforation,
        EventKind::Divided => MessageKind::Divided,
        EventKind::Stitch => MessageKind::Stitch,
        EventKind::Hung => MessageKind::Hung,
        EventKind::Reset => MessageKind::Reset,
        EventKind::Fall => MessageKind::Fall,
        EventKind::Shake => MessageKind::Shake,
        EventKind::Buried => MessageKind::Buried,
        EventKind::Press => MessageKind::Press,
        EventKind::Opened => MessageKind::Opened,
        EventKind::Unclipped => MessageKind::Unclipped,
        EventKind::Seared => MessageKind::Seared,
        EventKind::StoneSpilled => MessageKind::StoneSpilled,
        EventKind::StoneHeld => MessageKind::StoneHeld,
        EventKind::StoneDropped => MessageKind::StoneDropped,
        EventKind::StoneRetrieved => MessageKind::StoneRetrieved,
        EventKind::ClipCloses => MessageKind::ClipCloses,
        EventKind::ClipAlong => MessageKind::ClipAlong,
    }
}

/// Bits of a tick's timing record that come from its results: stale sample, and contact.
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
    let all = words::Switches::CUT.when(pedal.cut)
        | words::Switches::COAGULATE.when(pedal.coagulate)
        | words::Switches::CAMERA_LOCK.when(pedal.camera_lock)
        | words::Switches::PAUSED.when(switches.paused)
        | words::Switches::FORCE_ENABLED.when(switches.force_enabled);
    all.bits()
}
