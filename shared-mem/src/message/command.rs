//! Services `command` and `hand`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Service `hand`: a person without a haptic device moves the emulated hand with mouse and
/// keyboard. Each movement is the total since the sender started, so that a lost message loses no
/// movement.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.HandMsg.v1")]
pub struct HandMsg {
    /// Time of sending (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// Time at which the sender started. A new value means a new sender, whose totals start from
    /// zero.
    pub began_ns: u64,
    /// Movement of the instrument's tip in the picture: to the right, up, and towards the viewer,
    /// m.
    pub moved_m: [f64; 3],
    /// Rotation of the instrument about its shaft, rad.
    pub rolled_rad: f64,
    /// Rotation of the endoscope about its port, to the left and upwards, rad.
    pub scope_turned_rad: [f64; 2],
    /// Movement of the endoscope along its axis, inwards, m.
    pub scope_advanced_m: f64,
    /// Device buttons, as in [`crate::message::ToolFrame::buttons`].
    pub buttons: u32,
    /// Pressed pedals, as bits of [`crate::words::Switches`].
    pub switches: u32,
}

/// Service `command`, request of a host.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.CommandMsg.v1")]
pub struct CommandMsg {
    /// One of the `CommandMsg` constants.
    pub kind: u32,
    /// Argument of the command; `RESET` and `STOP` use none.
    pub argument: u32,
}

impl CommandMsg {
    /// Pause the simulation (argument 1) or continue it (0).
    pub const PAUSE: u32 = 1;
    /// Reset every organ to its state at the start of the run.
    pub const RESET: u32 = 2;
    /// Enable the force, also after a speed trip (argument 1), or cut it (0).
    pub const ENABLE_FORCE: u32 = 3;
    /// Change the instrument. The argument is the number of a [`crate::words::Instrument`].
    pub const INSTRUMENT: u32 = 4;
    /// End the controller with an orderly shutdown.
    pub const STOP: u32 = 5;
    /// Put every organ into the state in which a task begins. The argument is the task: 0 hang (no
    /// suture is placed), 1 identify (as after `RESET`), 2 clamp (Calot's triangle is cleared), 3
    /// cut (cystic duct and artery are clipped), 4 disconnect (both are divided).
    pub const START: u32 = 6;
    /// Replay only: go to a time. The argument is the time after the start of the recording, ms.
    pub const SEEK: u32 = 7;
    /// Replay only: set the speed. The argument is the speed in thousandths of real time, 10 to
    /// 100 000.
    pub const SPEED: u32 = 8;
    /// Trigger a complication for an instructor. The argument is the number of a
    /// [`crate::words::Complication`]. If the complication is impossible, nothing happens, and no
    /// event is raised.
    pub const COMPLICATION: u32 = 9;
}

/// Service `command`, reply of the controller.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ReplyMsg.v1")]
pub struct ReplyMsg {
    /// One of [`ReplyMsg::DONE`], `UNKNOWN`, `OUT_OF_RANGE`, `BUSY`.
    pub outcome: u32,
    /// Zero.
    pub reserved: u32,
    /// Tick at which the command took effect or was refused.
    pub tick: u64,
}

impl ReplyMsg {
    /// The command was carried out.
    pub const DONE: u32 = 0;
    /// The controller does not know the command.
    pub const UNKNOWN: u32 = 1;
    /// The argument is out of its range.
    pub const OUT_OF_RANGE: u32 = 2;
    /// Too many commands are waiting; the host may try again.
    pub const BUSY: u32 = 3;
}

// Both processes rely on this size. A change of it needs a new version.
const _: () = {
    assert!(size_of::<HandMsg>() == 80);
};
