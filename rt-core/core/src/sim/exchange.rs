//! What a tick takes from the world and asks of it.

use crate::port::{DeviceSample, ForceCommand, PedalSample, Polled, TrackerSample};
use crate::sim::TickView;
use crate::time::TimeNs;
use crate::tool::Instrument;

/// What the world asks of the simulation; at most one a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Stand still (true) or go on.
    Pause(bool),
    /// Put every organ back to rest and let go.
    Reset,
    /// Put every organ to where this task begins, and let go.
    Start(Task),
    /// Let force through (true; also after a trip) or cut it.
    EnableForce(bool),
    /// Put another instrument on the shaft.
    Instrument(Instrument),
}

/// A task of the operation, by what is done before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Task {
    /// Nothing; not even the sutures are placed that hang an organ.
    Hang = 0,
    /// They are.
    Identify = 1,
    /// The triangle is cleared.
    Clamp = 2,
    /// Duct and artery are clipped.
    Cut = 3,
    /// Both are divided.
    Disconnect = 4,
}

impl Task {
    /// The task with this number.
    #[must_use]
    pub const fn from_number(number: u32) -> Option<Self> {
        Some(match number {
            0 => Self::Hang,
            1 => Self::Identify,
            2 => Self::Clamp,
            3 => Self::Cut,
            4 => Self::Disconnect,
            _ => return None,
        })
    }
}

/// What stage `sample` brings in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// Host time now.
    pub now_ns: TimeNs,
    /// Haptic device.
    pub device: Polled<DeviceSample>,
    /// Endoscope's tracker.
    pub tracker: Polled<TrackerSample>,
    /// Foot pedal.
    pub pedal: Polled<PedalSample>,
    /// Next command of the host.
    pub command: Option<Command>,
}

/// Stages of a tick, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum Stage {
    Sample = 0,
    Tool = 1,
    Contact = 2,
    Solve = 3,
    Force = 4,
    Procedure = 5,
    Publish = 6,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 7] = [
        Self::Sample,
        Self::Tool,
        Self::Contact,
        Self::Solve,
        Self::Force,
        Self::Procedure,
        Self::Publish,
    ];
}

/// Work that a late tick may leave out, in the order in which it is left out. Never the force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optional {
    /// Organs against each other and themselves: they may overlap for a tick more.
    SelfCollision,
    /// Organs that the instrument neither touches nor holds: they stand still for a tick.
    FarOrgans,
}

/// How the tick meets the world. No call may block or allocate.
pub trait Ports {
    /// Time, newest samples, command.
    fn sample(&mut self) -> Samples;
    /// Sends the force to the device; called once a tick, as soon as stage `force` knows it.
    fn send_force(&mut self, command: ForceCommand);
    /// Shows what the tick did.
    fn publish(&mut self, view: &TickView<'_>);
    /// Whether there is time for optional work; asked once a tick for each, in their order. The
    /// answer is an input like a sample: a replay gives the same.
    fn may(&mut self, _work: Optional) -> bool {
        true
    }
    /// Called at the end of each stage: the process reads its clock.
    fn stamp(&mut self, stage: Stage);
}
