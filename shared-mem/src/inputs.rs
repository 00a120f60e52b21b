//! Service `inputs`: everything that a tick took from the world, and hashes of its results. A
//! replay feeds the same inputs and compares the hashes.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::message::PoseMsg;

/// Records that one [`InputBatch`] holds.
pub const INPUT_BATCH: usize = 64;

/// Inputs of one tick, and hashes of its results. An absent input (no fresh sample, no command) is
/// zero.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct InputRecord {
    /// Tick's number; a gap is a loss.
    pub tick: u64,
    /// The tick's time (`CLOCK_MONOTONIC`).
    pub now_ns: u64,
    /// When the haptic device's sample was read.
    pub device_at_ns: u64,
    /// When the tracker's sample was read.
    pub tracker_at_ns: u64,
    /// When the pedal's sample was read.
    pub pedal_at_ns: u64,
    /// Handle in the haptic device's base frame.
    pub device_from_handle: PoseMsg,
    /// Its velocity there, m/s, with [`InputRecord::HAS_VELOCITY`].
    pub velocity_m_s: [f32; 3],
    /// Sensor in the tracker's frame.
    pub tracker_from_sensor: PoseMsg,
    /// Hash of the tools (`rt_core::sim::Digest`).
    pub tools_hash: u32,
    /// Hash of the spheres.
    pub spheres_hash: u32,
    /// Bits of [`InputRecord`].
    pub bits: u32,
    /// The sample's number on the haptic device.
    pub sequence: u16,
    /// Buttons of the handle.
    pub buttons: u8,
    /// The command, a kind of [`crate::message::CommandMsg`] in the low four bits and its argument
    /// in the high four; 0: none.
    pub command: u8,
    /// Opening of the handle, 0 shut to 1 wide open, with [`InputRecord::HAS_OPENING`].
    pub opening: f32,
    /// Eight bits of the hash of each organ.
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
    /// The pedal said how it is.
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
    /// There was no time for self-collision.
    pub const NO_SELF_COLLISION: u32 = 1 << 10;
    /// There was no time for far organs.
    pub const NO_FAR_ORGANS: u32 = 1 << 11;
    /// The haptic device's sample does not continue those before.
    pub const LEAPT: u32 = 1 << 12;
    /// The haptic device reported a fault of its own.
    pub const DEVICE_FAILED: u32 = 1 << 13;
    /// The haptic device measured its opening.
    pub const HAS_OPENING: u32 = 1 << 14;
}

/// Setup of a run. With the scene and the inputs it decides all results.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct RunSetup {
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// Control period, ns.
    pub period_ns: u64,
    /// Base of the haptic device, world frame.
    pub world_from_device: PoseMsg,
    /// Transmitter of the tracker, world frame.
    pub world_from_tracker: PoseMsg,
    /// The instrument's port, m.
    pub instrument_port_m: [f32; 3],
    /// The endoscope's, m.
    pub endoscope_port_m: [f32; 3],
    /// Capabilities of the haptic device, in the order of `rt_core::port::DeviceCapabilities`,
    /// without its opening.
    pub device: [f32; 9],
    /// Its opening: travel, m, peak force, N, stiffness, N/m.
    pub opening: [f32; 3],
    /// Time over which the force rises, s.
    pub force_ramp_s: f32,
    /// 1: the force is enabled from the start.
    pub force_enabled: u32,
    /// Iterations of the paper's method; 0: neo-Hookean tetrahedra.
    pub paper_iterations: u32,
    /// Zero.
    pub reserved: u32,
}

/// Service `inputs`: batches of records. Complete to itself: a recorder may join at any time.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.InputBatch.v3")]
pub struct InputBatch {
    /// Setup of the run.
    pub setup: RunSetup,
    /// Records so far that did not fit their queue.
    pub lost: u64,
    /// Number of `records` in use.
    pub count: u32,
    /// In the last batch of a controller that ends in order: ticks that it ran. Else zero.
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

// The layout is the contract: a change of size is a change of version.
const _: () = {
    assert!(size_of::<InputRecord>() == 144);
    assert!(size_of::<RunSetup>() == 168);
    assert!(size_of::<InputBatch>() == 184 + 144 * INPUT_BATCH);
};
