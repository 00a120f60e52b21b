//! Tools: the lever about the port, the capsules, and their state in a tick.
//!
//! The instrument frame has its origin at the jaw joint and −z along the shaft towards the tip. The
//! frame rolls about the shaft with the handle.

pub mod cylinder;
mod instrument;
mod kinematics;

pub use instrument::{Capsule, Instrument, Role, Tool, capsules, endoscope};
pub use kinematics::{Kinematics, Wrench};

use heapless::Vec;

use crate::capacity::MAX_CAPSULES;
use crate::math::{Pose, Quat, Vec3};
use crate::port::{Buttons, PedalSample};

/// Switches set by a person or the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Switches {
    /// Foot pedal.
    pub pedal: PedalSample,
    /// True while the simulation is paused.
    pub paused: bool,
    /// True if force may go to the device: it is enabled, and no limit has tripped.
    pub force_enabled: bool,
}

/// State of the tools in a tick. World frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolState {
    /// Device pose: the handle in the hand.
    pub world_from_handle: Pose,
    /// Proxy pose of the instrument: origin at the jaw joint, −z along the shaft towards the tip.
    /// The pose lags behind the handle while the tissue pushes harder than the device can, so that
    /// the instrument does not press harder than the hand feels.
    pub world_from_instrument: Pose,
    /// The endoscope's camera: looks along −z, y up.
    pub world_from_camera: Pose,
    /// Tip of the instrument, m.
    pub tip_m: Vec3,
    /// Velocity of the handle, m/s.
    pub handle_velocity_m_s: Vec3,
    /// Instrument on the shaft.
    pub instrument: Instrument,
    /// Opening of the jaws: 0 closed, 1 open.
    pub jaw: f32,
    /// Buttons of the handle.
    pub buttons: Buttons,
    /// Collision shapes of the instrument.
    pub capsules: Vec<Capsule, MAX_CAPSULES>,
    /// Capsule of the endoscope, once its tracker has reported a pose.
    pub endoscope: Option<Capsule>,
    /// Force of tissue on the hand as sent to the device, N, without the force of the trocar.
    pub force_n: Vec3,
    /// Torque on the hand as sent to the device, N m.
    pub torque_nm: Vec3,
    /// Force that opens the handle as sent to the device, N.
    pub opening_n: f32,
    /// Contacts of the instrument, with tissue or with the endoscope.
    pub contact_count: u32,
    /// Spheres between closed jaws.
    pub grasped_count: u32,
    /// Switches.
    pub switches: Switches,
}

impl ToolState {
    /// State before the first sample: handle and instrument are in the port, without capsules, so
    /// they touch nothing.
    pub(crate) fn new(port_m: Vec3, world_from_camera: Pose) -> Self {
        let at_port = Pose::from_parts(port_m.into(), Quat::identity());
        Self {
            world_from_handle: at_port,
            world_from_instrument: at_port,
            world_from_camera,
            tip_m: port_m,
            handle_velocity_m_s: Vec3::zeros(),
            instrument: Instrument::default(),
            jaw: 1.0,
            buttons: Buttons::default(),
            capsules: Vec::new(),
            endoscope: None,
            force_n: Vec3::zeros(),
            torque_nm: Vec3::zeros(),
            opening_n: 0.0,
            contact_count: 0,
            grasped_count: 0,
            switches: Switches::default(),
        }
    }
}
