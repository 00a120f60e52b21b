//! What the services carry.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Spheres that a [`StateFrame`] holds. Equals `rt_core::capacity::MAX_SPHERES` (asserted there
/// where both are seen, in `rt-process`).
pub const MAX_SPHERES: usize = 4096;
/// Cells of layered tissue that a [`StateFrame`] holds. Equals `rt_core::capacity::MAX_CELLS`.
pub const MAX_CELLS: usize = 8192;
/// Records that one [`TimingBatch`] holds.
pub const TIMING_BATCH: usize = 64;
/// Stages of a tick, in order: sample, tool, contact, solve, force, procedure, publish.
pub const STAGES: usize = 7;
/// Names of the faults, in the order of [`TimingBatch::faults`]. Equal to the names of
/// `rt_core::fault::Fault` (tested where both are seen, in `rt-process`).
pub const FAULT_NAMES: [&str; 20] = [
    "bad_sample",
    "bad_force",
    "bad_sphere",
    "stale_device",
    "lost_device",
    "speed_trip",
    "clamped",
    "slewed",
    "stiffness_capped",
    "thermal_limited",
    "contact_overflow",
    "pair_overflow",
    "grasp_overflow",
    "event_overflow",
    "overrun",
    "bad_clock",
    "damped",
    "both_electrodes",
    "not_enabled",
    "ramped",
];
/// Capsules that a [`ToolFrame`] shows.
pub const MAX_CAPSULES: usize = 16;

/// A rigid transform: position in m, unit quaternion x y z w.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct PoseMsg {
    /// Translation, m.
    pub position_m: [f32; 3],
    /// Rotation, x y z w.
    pub orientation: [f32; 4],
}

impl PoseMsg {
    /// No rotation, no translation.
    pub const IDENTITY: Self = Self {
        position_m: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };

    /// Whether it is finite, within 1000 m, and its quaternion of unit length.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let length2: f32 = self.orientation.iter().map(|x| x * x).sum();
        self.position_m.iter().all(|x| x.abs() < 1e3) && (length2 - 1.0).abs() < 1e-3
    }
}

/// One sphere's state.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct SphereState {
    /// Centre, world frame, m.
    pub center_m: [f32; 3],
    /// Bit set of [`SphereState::AWAKE`], [`SphereState::CONTACT`], [`SphereState::GRASPED`].
    pub bits: u32,
}

impl SphereState {
    /// Its organ is simulated this tick.
    pub const AWAKE: u32 = 1;
    /// A tool touches it.
    pub const CONTACT: u32 = 2;
    /// Between closed jaws.
    pub const GRASPED: u32 = 4;
    /// Layered tissue of which nothing is left.
    pub const GONE: u32 = 8;
}

/// Clips on tubes that a [`StateFrame`] holds. Equals `rt_core::capacity::MAX_CLIPPED` (asserted in
/// `rt-process`).
pub const MAX_CLIPPED: usize = 24;

/// A clip on a vessel or duct. It lies across it, between two of its spheres.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct ClipMsg {
    /// The two spheres, in the scene's order.
    pub spheres: [u32; 2],
    /// How far it lies from the first to the second, 0 to 1.
    pub share: f32,
    /// Share of the inside that it closes, 0 to 1.
    pub closed: f32,
    /// Along its legs, from the bend to the open ends: a unit vector, world frame.
    pub legs: [f32; 3],
    /// The clip's number, from 0; one that is on two tubes has two records.
    pub number: u32,
}

impl ClipMsg {
    /// Whether it lies between spheres that there are, and is finite.
    fn is_sane(&self, sphere_count: u32) -> bool {
        let share = |x: f32| (0.0..=1.0).contains(&x);
        self.spheres.iter().all(|it| *it < sphere_count)
            && share(self.share)
            && share(self.closed)
            && self.legs.iter().all(|x| x.abs() < 2.0)
    }
}

/// Sutures that a [`StateFrame`] holds. Equals `rt_core::capacity::MAX_SUTURES` (asserted in `rt-process`).
pub const MAX_SUTURES: usize = 8;

/// A suture that hangs an organ on the abdominal wall.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct SutureMsg {
    /// The sphere that it goes through, in the scene's order.
    pub sphere: u32,
    /// One of the `SutureMsg` constants.
    pub placed: u32,
    /// Where its other end is, in the wall or at the instrument's tip, world frame, m.
    pub at_m: [f32; 3],
    /// How long it is once it is drawn in, m.
    pub length_m: f32,
}

impl SutureMsg {
    /// It is not placed yet.
    pub const AWAY: u32 = 0;
    /// It goes through the organ and to the instrument's tip.
    pub const AT_HAND: u32 = 1;
    /// It hangs the organ on the wall.
    pub const HUNG: u32 = 2;
    /// It did, and is cut through.
    pub const CUT: u32 = 3;

    /// Whether it goes through a sphere that there is, and is finite.
    fn is_sane(&self, sphere_count: u32) -> bool {
        self.sphere < sphere_count
            && self.placed <= Self::CUT
            && self.at_m.iter().all(|x| x.abs() < 1e3)
            && (0.0..=10.0).contains(&self.length_m)
    }
}

/// Service `state`: the newest wins.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.StateFrame.v4")]
pub struct StateFrame {
    /// Tick that wrote it.
    pub tick: u64,
    /// When that tick's sample was read from the device (`CLOCK_MONOTONIC`).
    pub sample_ns: u64,
    /// When the frame was filled.
    pub at_ns: u64,
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// How many of `spheres` are used.
    pub sphere_count: u32,
    /// How many of `clips` are used.
    pub clip_count: u32,
    /// How many of `cells` are used.
    pub cell_count: u32,
    /// How many of `sutures` are used.
    pub suture_count: u32,
    /// The sutures to the world (`AttachmentRecord::is_thread`), in the scene's order.
    pub sutures: [SutureMsg; MAX_SUTURES],
    /// The spheres, in the scene's order.
    pub spheres: [SphereState; MAX_SPHERES],
    /// The clips, in the order in which they were closed.
    pub clips: [ClipMsg; MAX_CLIPPED],
    /// Cells of layered tissue, in the scene's order: the share of the heat that removes each, 0 to 254,
    /// or [`StateFrame::GONE`].
    pub cells: [u8; MAX_CELLS],
}

impl StateFrame {
    /// A cell that is gone.
    pub const GONE: u8 = u8::MAX;

    /// The used cells, or `None` if the frame is malformed.
    #[must_use]
    pub fn cells(&self) -> Option<&[u8]> {
        self.cells.get(..self.cell_count as usize)
    }

    /// The used spheres, or `None` if the frame is malformed: too many, or a centre that is not
    /// finite or lies beyond 1000 m.
    #[must_use]
    pub fn spheres(&self) -> Option<&[SphereState]> {
        let spheres = self.spheres.get(..self.sphere_count as usize)?;
        let sane = |s: &SphereState| s.center_m.iter().all(|x| x.abs() < 1e3);
        spheres.iter().all(sane).then_some(spheres)
    }

    /// The used sutures, or `None` if the frame is malformed: too many, one through a sphere that there is not, or
    /// one that is not finite.
    #[must_use]
    pub fn sutures(&self) -> Option<&[SutureMsg]> {
        let sutures = self.sutures.get(..self.suture_count as usize)?;
        let sane = |it: &SutureMsg| it.is_sane(self.sphere_count.min(MAX_SPHERES as u32));
        sutures.iter().all(sane).then_some(sutures)
    }

    /// The used clips, or `None` if the frame is malformed: too many, one between spheres that there
    /// are not, or one that is not finite.
    #[must_use]
    pub fn clips(&self) -> Option<&[ClipMsg]> {
        let clips = self.clips.get(..self.clip_count as usize)?;
        let sane = |clip: &ClipMsg| clip.is_sane(self.sphere_count.min(MAX_SPHERES as u32));
        clips.iter().all(sane).then_some(clips)
    }
}

impl ToolFrame {
    /// The used capsules, or `None` if the frame is malformed.
    #[must_use]
    pub fn capsules(&self) -> Option<&[CapsuleMsg]> {
        let poses = [
            self.world_from_handle,
            self.world_from_instrument,
            self.world_from_camera,
        ];
        let sane = |x: &f32| x.abs() < 1e3;
        let poses_ok = poses.iter().all(PoseMsg::is_sane);
        let capsules = self.capsules.get(..self.capsule_count as usize)?;
        let capsules_ok = capsules
            .iter()
            .all(|c| c.a_m.iter().chain(&c.b_m).chain([&c.radius_m]).all(sane));
        let force_ok = self.force_n.iter().all(sane) && self.jaw.is_finite();
        (poses_ok && capsules_ok && force_ok).then_some(capsules)
    }
}

impl TimingBatch {
    /// The used records, or `None` if the batch is malformed.
    #[must_use]
    pub fn records(&self) -> Option<&[TickRecord]> {
        self.records.get(..self.count as usize)
    }
}

/// Health of one device as the controller sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
pub struct DeviceHealth {
    /// One of [`DeviceHealth::ABSENT`], `LIVE`, `STALE`, `LOST`.
    pub status: u32,
    /// Age of the newest sample, µs, saturating.
    pub age_us: u32,
    /// Good frames.
    pub frames: u64,
    /// Rejected frames.
    pub bad_frames: u64,
    /// Lost frames by sequence number.
    pub lost_frames: u64,
}

impl DeviceHealth {
    /// Not configured.
    pub const ABSENT: u32 = 0;
    /// Samples arrive in time.
    pub const LIVE: u32 = 1;
    /// The newest sample is older than its limit.
    pub const STALE: u32 = 2;
    /// The line is gone.
    pub const LOST: u32 = 3;
}

/// A capsule of an instrument, world frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct CapsuleMsg {
    /// One end of the axis, m.
    pub a_m: [f32; 3],
    /// Radius, m.
    pub radius_m: f32,
    /// Other end of the axis, m.
    pub b_m: [f32; 3],
    /// Role: 0 shaft, 1 upper jaw, 2 lower jaw, 3 tip.
    pub role: u32,
}

/// Service `tools`: the newest wins.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ToolFrame.v2")]
pub struct ToolFrame {
    /// Tick that wrote it.
    pub tick: u64,
    /// When that tick's sample was read from the device.
    pub sample_ns: u64,
    /// When the frame was filled.
    pub at_ns: u64,
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// Handle, world frame.
    pub world_from_handle: PoseMsg,
    /// Instrument, world frame: origin at the jaw joint, −z along the shaft towards the tip. A proxy:
    /// it stays behind the hand where the device cannot push as hard as the tissue.
    pub world_from_instrument: PoseMsg,
    /// Endoscope's camera, world frame: looks along −z, y up.
    pub world_from_camera: PoseMsg,
    /// Opening of the jaws: 0 closed, 1 open.
    pub jaw: f32,
    /// Instrument: 0 grasper, 1 cautery hook, 2 scissors, 3 clip applier.
    pub instrument: u32,
    /// Force on the hand, world frame, N, as sent to the device.
    pub force_n: [f32; 3],
    /// Contacts in that tick.
    pub contact_count: u32,
    /// Bits: 1 cut, 2 coagulate, 4 camera lock, 8 paused, 16 force enabled.
    pub switches: u32,
    /// Device buttons.
    pub buttons: u32,
    /// How many of `capsules` are used.
    pub capsule_count: u32,
    /// Clips left in the applier.
    pub clips_left: u32,
    /// Zero.
    pub reserved: u32,
    /// Capsules of the instrument.
    pub capsules: [CapsuleMsg; MAX_CAPSULES],
    /// Haptic device, tracker, pedal.
    pub health: [DeviceHealth; 3],
}

/// Service `events`: sequence-numbered; a gap in `sequence` is a loss that the reader must show.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.EventMsg.v1")]
pub struct EventMsg {
    /// Counts up by one an event, from 0 at the controller's start.
    pub sequence: u64,
    /// Tick that raised it.
    pub tick: u64,
    /// When.
    pub at_ns: u64,
    /// One of the `EventMsg` constants.
    pub kind: u32,
    /// Organ's index in the scene, or `u32::MAX`.
    pub organ: u32,
    /// Where, world frame, m.
    pub at_m: [f32; 3],
    /// Depends on the kind: force in N, fault code, button.
    pub value: f32,
}

impl EventMsg {
    /// An instrument began to touch an organ; value: force, N.
    pub const CONTACT: u32 = 1;
    /// It left it.
    pub const RELEASE: u32 = 2;
    /// Jaws closed on tissue; value: spheres held.
    pub const GRASP: u32 = 3;
    /// Jaws let go.
    pub const LET_GO: u32 = 4;
    /// A fault was raised; value: its code (`rt_core::fault::Fault`).
    pub const FAULT: u32 = 5;
    /// Electrosurgery on (value 1 cut, 2 coagulate) or off (0).
    pub const ELECTRO: u32 = 6;
    /// What the jaws hold has slipped; value: what it pulls with, N.
    pub const SLIP: u32 = 7;
    /// A band between organs, or a link of a tube, has torn; value: the energy it took, J.
    pub const TEAR: u32 = 8;
    /// Scissors or current have cut a band, a suture, or a link of a tube; value: the energy of a tear of it, J.
    pub const CUT: u32 = 9;

    /// A clip has closed, on this organ or, if none is named, on nothing; value: the clip's number,
    /// from 0. One that closes on two organs raises two.
    pub const CLIP: u32 = 10;
    /// An electrode has burnt an organ; value: the energy since that was last told, J.
    pub const BURN: u32 = 11;
    /// A vessel, duct or bag leaks; value: its flow as a share of what runs in it whole, 0: stopped. Every
    /// event of one leak has the place where it began.
    pub const LEAK: u32 = 12;
    /// A cell of layered tissue is gone; value: its index in the scene.
    pub const REMOVED: u32 = 13;
    /// Jaws have crushed what they hold; value: their force, N.
    pub const CRUSH: u32 = 14;
    /// A wall is burnt through or torn open; value: the energy it took, J.
    pub const PERFORATION: u32 = 15;
    /// A tube is divided, or off what it was grown to; value: share of its inside that clips leave open on
    /// the worse of both sides, up to where it ends or is divided already. 0: between clips that close it.
    pub const DIVIDED: u32 = 16;
    /// Everything is as it was at the start, or as a task begins; what was told before is void.
    pub const RESET: u32 = 17;
    /// A suture goes through an organ, there; value: the suture's number in the scene, from 0.
    pub const STITCH: u32 = 18;
    /// A suture hangs an organ on the abdominal wall, there; value: the suture's number in the scene, from 0.
    pub const HUNG: u32 = 19;

    /// Its kind's name, for reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.kind {
            Self::CONTACT => "contact",
            Self::RELEASE => "release",
            Self::GRASP => "grasp",
            Self::LET_GO => "let_go",
            Self::FAULT => "fault",
            Self::ELECTRO => "electro",
            Self::SLIP => "slip",
            Self::TEAR => "tear",
            Self::CUT => "cut",
            Self::CLIP => "clip",
            Self::BURN => "burn",
            Self::LEAK => "leak",
            Self::REMOVED => "removed",
            Self::CRUSH => "crush",
            Self::PERFORATION => "perforation",
            Self::DIVIDED => "divided",
            Self::RESET => "reset",
            Self::STITCH => "stitch",
            Self::HUNG => "hung",
            _ => "unknown",
        }
    }
}

/// One tick's timing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
pub struct TickRecord {
    /// Tick's number.
    pub tick: u64,
    /// When it should have started (`CLOCK_MONOTONIC`): the first deadline that no tick served.
    pub scheduled_ns: u64,
    /// Actual start − scheduled start, saturating.
    pub wake_latency_ns: u32,
    /// Start to end of the tick.
    pub tick_ns: u32,
    /// Device sample arrived at the host → force written. 0: no fresh sample this tick.
    pub motion_to_force_ns: u32,
    /// Whole periods between scheduled and actual start: skipped (deadline misses).
    pub missed: u32,
    /// Time of each stage.
    pub stage_ns: [u32; STAGES],
    /// Bit set of [`TickRecord::OVERRAN`], `NOT_PUBLISHED`, `STALE`, `CONTACT`, `DROPPED_…`.
    pub bits: u32,
}

impl TickRecord {
    /// It ended after its deadline.
    pub const OVERRAN: u32 = 1;
    /// A frame was due and no slot was free.
    pub const NOT_PUBLISHED: u32 = 2;
    /// The device sample was older than its limit, or the device lost.
    pub const STALE: u32 = 4;
    /// The instrument touched something.
    pub const CONTACT: u32 = 8;
    /// There was no time for self-collision.
    pub const DROPPED_SELF_COLLISION: u32 = 32;
    /// There was no time for organs far from the instrument.
    pub const DROPPED_FAR_ORGANS: u32 = 64;
    /// A frame was due and there was no time for it.
    pub const DROPPED_PUBLISH: u32 = 16;
}

/// Service `timing`: batches of records, with the thread's counters since its start.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.TimingBatch.v4")]
pub struct TimingBatch {
    /// Batch number; a gap is a loss.
    pub sequence: u64,
    /// Heap allocations of the realtime thread since it was armed; `u64::MAX`: not counted.
    pub allocations: u64,
    /// Page faults (minor and major) of the realtime thread since it was armed.
    pub page_faults: u64,
    /// Involuntary context switches since it was armed.
    pub involuntary_switches: u64,
    /// Times since it was armed that it waited for anything but its next tick.
    pub blocks: u64,
    /// Ticks so far.
    pub ticks: u64,
    /// Periods skipped so far.
    pub deadline_misses: u64,
    /// Ticks so far that ended after their deadline.
    pub overruns: u64,
    /// Faults of each kind so far (`rt_core::fault::Fault`).
    pub faults: [u64; 20],
    /// Bits: 1 SCHED_FIFO, 2 memory locked, 4 pinned, realtime only with all three.
    pub realtime: u32,
    /// How many of `records` are used.
    pub count: u32,
    /// The records, oldest first.
    pub records: [TickRecord; TIMING_BATCH],
}

impl TimingBatch {
    /// `realtime` bit: the thread runs under SCHED_FIFO or SCHED_DEADLINE.
    pub const FIFO: u32 = 1;
    /// `realtime` bit: all memory is locked.
    pub const LOCKED: u32 = 2;
    /// `realtime` bit: the thread is pinned to one core (or SCHED_DEADLINE guarantees its time).
    pub const PINNED: u32 = 4;
}

/// Service `hand`: what a person without a haptic device asks of the emulated hand. Movements are
/// sums since the sender began, so that a lost message loses nothing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.HandMsg.v1")]
pub struct HandMsg {
    /// When it was sent (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// When the sender began: another one's sums start from nothing.
    pub began_ns: u64,
    /// The instrument's tip, along the picture's right, its up, and towards the viewer, m.
    pub moved_m: [f64; 3],
    /// The instrument about its shaft, rad.
    pub rolled_rad: f64,
    /// The endoscope about its port, to the left and up, rad.
    pub scope_turned_rad: [f64; 2],
    /// The endoscope along its axis, inwards, m.
    pub scope_advanced_m: f64,
    /// Device buttons, as in [`ToolFrame::buttons`].
    pub buttons: u32,
    /// Bits: 1 cut, 2 coagulate, 4 camera lock.
    pub switches: u32,
}

/// Service `command` (request): what the host asks.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.CommandMsg.v1")]
pub struct CommandMsg {
    /// One of the `CommandMsg` constants.
    pub kind: u32,
    /// Instrument for [`CommandMsg::INSTRUMENT`], task for [`CommandMsg::START`], 1/0 for [`CommandMsg::PAUSE`] and
    /// [`CommandMsg::ENABLE_FORCE`], what else they say.
    pub argument: u32,
}

impl CommandMsg {
    /// Pause (1) or go on (0).
    pub const PAUSE: u32 = 1;
    /// Put every organ back to rest.
    pub const RESET: u32 = 2;
    /// Let force through again (1) after a trip, or cut it (0).
    pub const ENABLE_FORCE: u32 = 3;
    /// Choose the instrument.
    pub const INSTRUMENT: u32 = 4;
    /// End the controller cleanly.
    pub const STOP: u32 = 5;
    /// Put every organ to where a task begins: 0 hang (the sutures are not placed yet), 1 identify, 2 clamp (the triangle is cleared), 3 cut (duct and
    /// artery are clipped), 4 disconnect (both are divided).
    pub const START: u32 = 6;
    /// Of a replay: go to this time from its start, ms.
    pub const SEEK: u32 = 7;
    /// Of a replay: so many times as fast as it was, in thousandths, 10 to 100 000.
    pub const SPEED: u32 = 8;
}

/// Service `command` (response): what became of it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ReplyMsg.v1")]
pub struct ReplyMsg {
    /// One of [`ReplyMsg::DONE`], `UNKNOWN`, `OUT_OF_RANGE`, `BUSY`.
    pub outcome: u32,
    /// Zero.
    pub reserved: u32,
    /// Tick at which it took effect.
    pub tick: u64,
}

impl ReplyMsg {
    /// It was done.
    pub const DONE: u32 = 0;
    /// There is no such command.
    pub const UNKNOWN: u32 = 1;
    /// The argument is out of its range.
    pub const OUT_OF_RANGE: u32 = 2;
    /// Too many commands wait: try again.
    pub const BUSY: u32 = 3;
}

// The layout is the contract: a change of size is a change of version.
const _: () = {
    assert!(size_of::<SphereState>() == 16);
    assert!(size_of::<ClipMsg>() == 32);
    assert!(size_of::<SutureMsg>() == 24);
    let (spheres, clips, sutures) = (16 * MAX_SPHERES, 32 * MAX_CLIPPED, 24 * MAX_SUTURES);
    assert!(size_of::<StateFrame>() == 56 + spheres + clips + sutures + MAX_CELLS);
    assert!(size_of::<CapsuleMsg>() == 32);
    assert!(size_of::<DeviceHealth>() == 32);
    assert!(size_of::<ToolFrame>() == 168 + 32 * MAX_CAPSULES + 3 * 32);
    assert!(size_of::<EventMsg>() == 48);
    assert!(size_of::<TimingBatch>() == 232 + 64 * TIMING_BATCH);
    assert!(size_of::<TickRecord>() == 64);
    assert!(size_of::<HandMsg>() == 80);
};
