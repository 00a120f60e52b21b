//! Service `inputs`: everything that a tick read from the devices and from hosts, and hashes of the
//! tick's results. A replay gives the simulation the same inputs and compares the hashes.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::message::PoseMsg;

/// Largest number of records in one [`InputBatch`].
pub const INPUT_BATCH: usize = 64;

/// Inputs of one tick, and hashes of its results. The fields of an absent input (no fresh sample,
/// no command) are zero.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct InputRecord {
    /// Number of the tick. A gap in the numbers means that records were lost.
    pub tick: u64,
    /// Time at which the tick read the devices (`CLOCK_MONOTONIC`).
    pub now_ns: u64,
    /// Time at which the haptic device's sample was read.
    pub device_at_ns: u64,
    /// Time at which the tracker's sample was read.
    pub tracker_at_ns: u64,
    /// Time at which the pedal's sample was read.
    pub pedal_at_ns: u64,
    /// Pose of the handle in the haptic device's base frame.
    pub device_from_handle: PoseMsg,
    /// Velocity of the handle in the device's base frame, m/s. Valid if `bits` has
    /// [`InputRecord::HAS_VELOCITY`].
    pub velocity_m_s: [f32; 3],
    /// Pose of the sensor in the tracker's frame.
    pub tracker_from_sensor: PoseMsg,
    /// Hash of the tools after the tick (`rt_core::sim::Digest`).
    pub tools_hash: u32,
    /// Hash of all spheres after the tick.
    pub spheres_hash: u32,
    /// Bits of the `InputRecord` constants.
    pub bits: u32,
    /// Sequence number that the haptic device gave its sample.
    pub sequence: u16,
    /// Pressed buttons of the handle, one bit each.
    pub buttons: u8,
    /// Command of a host: its kind ([`crate::message::CommandMsg`]) in the low four bits, its
    /// argument in the high four. 0: no command.
    pub command: u8,
    /// Opening of the handle, from 0 (shut) to 1 (wide open). Valid if `bits` has
    /// [`InputRecord::HAS_OPENING`].
    pub opening: f32,
    /// Hash of each organ's spheres, reduced to eight bits.
    pub organ_hashes: [u8; 16],
}

impl InputRecord {
    /// The haptic device brought a sample.
    pub const DEVICE_FRESH: u32 = 1;
    /// The haptic device is lost.
    pub const DEVICE_LOST: u32 = 1 << 1;
    /// The tracker brought a sample.
    pub const TRACKER_FRESH: u32 = 1 << 2;
    /// The tracker is lost.
    pub const TRACKER_LOST: u32 = 1 << 3;
    /// The pedal reported its state.
    pub const PEDAL_FRESH: u32 = 1 << 4;
    /// The pedal is lost.
    pub const PEDAL_LOST: u32 = 1 << 5;
    /// The haptic device measured its velocity.
    pub const HAS_VELOCITY: u32 = 1 << 6;
    /// Pedal: cut.
    pub const CUT: u32 = 1 << 7;
    /// Pedal: coagulate.
    pub const COAGULATE: u32 = 1 << 8;
    /// Pedal: camera lock.
    pub const CAMERA_LOCK: u32 = 1 << 9;
    /// The tick skipped self-collision, because too little time was left.
    pub const NO_SELF_COLLISION: u32 = 1 << 10;
    /// The tick skipped far organs, because too little time was left. A far organ is near no tool
    /// and not in the jaws.
    pub const NO_FAR_ORGANS: u32 = 1 << 11;
    /// The haptic device's sample does not continue the earlier samples. The handle may have moved
    /// any distance.
    pub const LEAPT: u32 = 1 << 12;
    /// The haptic device reported a fault of its own.
    pub const DEVICE_FAILED: u32 = 1 << 13;
    /// The haptic device measured the opening of its handle.
    pub const HAS_OPENING: u32 = 1 << 14;
}

/// Setup of a run. Setup, scene and inputs together determine every result.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct RunSetup {
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// Control period, ns.
    pub period_ns: u64,
    /// Pose of the haptic device's base, world frame.
    pub world_from_device: PoseMsg,
    /// Pose of the tracker's transmitter, world frame.
    pub world_from_tracker: PoseMsg,
    /// Port of the instrument, world frame, m.
    pub instrument_port_m: [f32; 3],
    /// Port of the endoscope, world frame, m.
    pub endoscope_port_m: [f32; 3],
    /// Capabilities of the haptic device: the fields of `rt_core::port::DeviceCapabilities` in
    /// their order, without `opening`.
    pub device: [f32; 9],
    /// Capabilities of the handle's opening: travel, m; peak force, N; largest stiffness, N/m.
    pub opening: [f32; 3],
    /// Time over which the force rises from zero to its full value, s.
    pub force_ramp_s: f32,
    /// 1: the force is enabled from the start.
    pub force_enabled: u32,
    /// Iterations of the inner-sphere paper's method; 0: the run solves neo-Hookean tetrahedra
    /// instead.
    pub paper_iterations: u32,
    /// Trocar of the station: 0 the scene's, 1 a real one (nothing is rendered), 2 dry, 3 wet.
    pub trocar: u32,
}

/// Service `inputs`: one batch of records. Each batch carries the setup, so that a recorder can
/// join at any time.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.InputBatch.v3")]
pub struct InputBatch {
    /// Setup of the run.
    pub setup: RunSetup,
    /// Number of records lost so far because the queue to the publishing thread was full.
    pub lost: u64,
    /// Number of `records` in use.
    pub count: u32,
    /// Number of ticks that the controller ran; set only in the last batch of an orderly shutdown,
    /// else zero.
    pub ran: u32,
    /// The records, oldest first.
    pub records: [InputRecord; INPUT_BATCH],
}

impl InputBatch {
    /// The used records, or `None` if the batch is malformed.
    #[must_use]
    pub fn records(&self) -> Option<&[InputRecord]> {
        self.records.get(..self.count as usize)
    }
}

// Both processes rely on these sizes. A change of one needs a new version.
const _: () = {
    assert!(size_of::<InputRecord>() == 144);
    assert!(size_of::<RunSetup>() == 168);
    assert!(size_of::<InputBatch>() == 184 + 144 * INPUT_BATCH);
};
