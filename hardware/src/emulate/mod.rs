//! The devices of a station, emulated behind ptys, with a scripted hand at the handle.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use rt_core::math::{Pose, Vec3};

use crate::HardwareError;

/// What to emulate.
#[derive(Debug, Clone)]
pub struct EmulateConfig {
    /// Where the lines `haptic`, `tracker` and `pedal` appear: symbolic links to ptys. Made
    /// when it does not exist.
    pub directory: PathBuf,
    /// Where the devices stand and what the hand does.
    pub script: HandScript,
    /// Tremor and faults; the same seed gives the same movements.
    pub seed: u64,
}

/// What the scripted hand works on, world frame, SI: the room of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandScript {
    /// The instrument's trocar, m.
    pub instrument_port_m: Vec3,
    /// From the handle to the tip, m.
    pub instrument_length_m: f32,
    /// Base frame of the haptic device.
    pub world_from_device: Pose,
    /// Transmitter frame of the tracker. The protocol reaches 0.91 m and sees one hemisphere:
    /// the endoscope must stay at x > 0 of this frame.
    pub world_from_tracker: Pose,
    /// Where the endoscope's camera rests.
    pub world_from_camera: Pose,
    /// The endoscope sweeps about its port, m.
    pub endoscope_port_m: Vec3,
    /// Point on the organ's skin that is pressed and grasped, m.
    pub target_m: Vec3,
    /// Outward normal there.
    pub target_normal: Vec3,
}

/// Where the emulated devices are.
#[derive(Debug, Clone)]
pub struct Lines {
    /// The haptic device: open with [`crate::rig::RigHaptic`].
    pub haptic: PathBuf,
    /// The endoscope's tracker: open with [`crate::bird::BirdTracker`].
    pub tracker: PathBuf,
    /// The foot pedal: open with [`crate::rig::RigPedal`].
    pub pedal: PathBuf,
}

/// Emulates until `stop` is set. Calls `ready` once, when the lines can be opened.
///
/// The hand begins with the first force that the controller sends, so that nothing is missed
/// while it starts.
pub fn run(
    config: &EmulateConfig,
    stop: &AtomicBool,
    ready: &mut dyn FnMut(&Lines),
) -> Result<(), HardwareError> {
    let _ = (config, stop, ready);
    Ok(())
}
