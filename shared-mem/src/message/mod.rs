//! Messages, one module per service.

mod acts;
mod command;
mod events;
mod state;
mod timing;
mod tools;

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

pub use acts::{ActMsg, ActReply, REMARK_BYTES};
pub use command::{CommandMsg, HandMsg, ReplyMsg};
pub use events::{Event, EventMsg, UnknownEvent};
pub use state::{ClipMsg, SphereState, StateFrame, StoneMsg, SutureMsg};
pub use timing::{STAGE_NAMES, TickRecord, TimingBatch};
pub use tools::{CapsuleMsg, DentMsg, DeviceHealth, ToolFrame};

pub use crate::limits::{
    MAX_CAPSULES, MAX_CELLS, MAX_CLIPPED, MAX_DENTS, MAX_SPHERES, MAX_STONES, MAX_SUTURES,
    MAX_TUBE_LINKS, STAGES, TIMING_BATCH,
};

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

    /// True if each coordinate is finite and within 1000 m of the origin, and the quaternion has
    /// unit length.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let length2: f32 = self.orientation.iter().map(|x| x * x).sum();
        self.position_m.iter().all(|x| x.abs() < 1e3) && (length2 - 1.0).abs() < 1e-3
    }
}
