//! Interface of a tick to the world: samples, commands, stages, ports.

use crate::port::{DeviceSample, Findings, ForceCommand, PedalSample, Polled, TrackerSample};
use crate::sim::TickView;
use crate::time::TimeNs;
use crate::tool::Instrument;

/// Command of the host; at most one a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Pauses (true) or resumes.
    Pause(bool),
    /// Puts every organ back to rest, releases grasped tissue, and removes all clips.
    Reset,
    /// Resets, then prepares the start of this task.
    Start(Task),
    /// Enables the force (true), also after a trip, or cuts it.
    EnableForce(bool),
    /// Changes the instrument on the shaft.
    Instrument(Instrument),
    /// Triggers a complication for an instructor. Nothing happens if the complication is
    /// impossible, as without a clip that could slip.
    Complication(Complication),
}

/// A complication that an instructor can trigger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Complication {
    /// The artery that leaves the gallbladder bleeds from a hole in its wall.
    Bleeding = 0,
    /// The newest clip on a tube slips off.
    SlippedClip = 1,
}

impl Complication {
    /// The complication with this number.
    #[must_use]
    pub const fn from_number(number: u32) -> Option<Self> {
        Some(match number {
            0 => Self::Bleeding,
            1 => Self::SlippedClip,
            _ => return None,
        })
    }
}

/// A task of the operation. The comment of each task gives the state in which it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Task {
    /// Nothing is done: the organ is not hung.
    Hang = 0,
    /// The organ is hung.
    Identify = 1,
    /// The organ is hung, and Calot's triangle is cleared of tissue.
    Clamp = 2,
    /// As `Clamp`, and duct and artery are clipped.
    Cut = 3,
    /// As `Cut`, and duct and artery are divided.
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

/// Inputs of stage `sample`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// Present host time.
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

/// Work that a late tick may omit, in order of omission. The force is never omitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optional {
    /// Contact of organs with each other and themselves: without it, organs may overlap for one
    /// more tick.
    SelfCollision,
    /// Motion of organs that are neither near a tool nor in the jaws: without it, they stand still
    /// for a tick.
    FarOrgans,
}

/// Connection of the tick to the world. No call may block or allocate.
pub trait Ports {
    /// Returns time, newest samples and command.
    fn sample(&mut self) -> Samples;
    /// Returns the findings of the device's driver about these samples. The findings are an input
    /// like a sample: a replay returns the recorded findings.
    fn findings(&mut self) -> Findings {
        Findings::default()
    }
    /// Sends the force to the device; called once a tick, as soon as stage `force` has computed it.
    fn send_force(&mut self, command: ForceCommand);
    /// Publishes the results of the tick.
    fn publish(&mut self, view: &TickView<'_>);
    /// Returns true if there is time for optional work; called once a tick for each kind, in the
    /// order of [`Optional`]. The answer is an input like a sample: a replay returns the recorded
    /// answer.
    fn may(&mut self, _work: Optional) -> bool {
        true
    }
    /// Marks the end of a stage, at which the process reads its clock.
    fn stamp(&mut self, stage: Stage);
}
