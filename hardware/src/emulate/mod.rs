//! Emulates the devices of a station behind ptys, with a scripted hand on the handle.
//!
//! Behind each pty runs the device's side of its protocol. For a rig and a pedal this is the
//! firmware library ([`crate::rig::device`]), for a bird [`crate::bird::device`]. [`HapticModel`]
//! lists the haptic devices. A haptic device also has a body with mass and friction between its
//! motors and the hand. A controller opens these devices like real ones.

mod bulk;
mod electronics;
mod fault;
mod fingers;
mod gamepad;
mod hand;
mod holding;
mod inverse3;
mod mistake;
mod operated;
mod pty;
mod random;
mod simulated;
mod station;
mod steered;
mod touch;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::HardwareError;

pub use bulk::EmulatedBulk;
pub use electronics::HapticModel;
pub use fault::Faults;
pub use gamepad::Gamepad;
pub use hand::{Hand, HandScript, Intent, ROUND_S};
pub use holding::Holding;
#[cfg(test)]
pub(crate) use holding::pressing_m;
pub use inverse3::{EmulatedInverse3, ServiceFault};
pub use mistake::Mistake;
pub use operated::Wish;
pub use simulated::{SimulatedBody, SimulatedDevice};
pub use steered::{Measured, SteeredHand};
pub use touch::{Body, Grip, Touch};

#[cfg(test)]
pub(crate) use random::Random;
use station::Station;

/// Settings of the emulation.
#[derive(Debug, Clone)]
pub struct EmulateConfig {
    /// Directory in which the symbolic links `haptic`, `tracker` and `pedal` lead to the devices'
    /// ptys. It is made if it does not exist.
    pub directory: PathBuf,
    /// Places of the devices in the scene, and the point at which the hand works.
    pub script: HandScript,
    /// Emulated haptic device.
    pub haptic: HapticModel,
    /// Mistake in the firmware of an emulated rig.
    pub mistake: Option<Mistake>,
    /// Hand at the handle of the haptic device.
    pub holding: Holding,
    /// Seed of tremor and faults; equal seeds give equal movements.
    pub seed: u64,
    /// Faults of each line.
    pub faults: LineFaults,
}

/// Faults of each line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LineFaults {
    /// Faults of the haptic device's line.
    pub haptic: Faults,
    /// Faults of the tracker's line.
    pub tracker: Faults,
    /// Faults of the pedal's line.
    pub pedal: Faults,
}

/// Paths of the emulated devices.
#[derive(Debug, Clone)]
pub struct Lines {
    /// The haptic device: open with [`crate::rig::RigHaptic`].
    pub haptic: PathBuf,
    /// The endoscope's tracker: open with [`crate::bird::BirdTracker`].
    pub tracker: PathBuf,
    /// The foot pedal: open with [`crate::rig::RigPedal`].
    pub pedal: PathBuf,
}

/// State inside the emulated devices, which no controller sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerState {
    /// Emulated time since the start, s.
    pub time_s: f32,
    /// Force commanded to the motors of the haptic device, in its base frame, N.
    pub force_n: rt_core::math::Vec3,
    /// Motor command as a share of the largest permitted command.
    pub motor_load: f32,
}

const MILLISECOND: Duration = Duration::from_millis(1);
/// Longest delay for which the emulation catches up, by steps without a pause. After a longer delay
/// (the machine slept) it does not catch up: the hand continues where it was.
const CATCH_UP_LIMIT: Duration = Duration::from_millis(200);

/// Emulates until `stop` is set. Calls `ready` once the lines can be opened.
///
/// The hand starts its script with the controller's first force, so that the controller sees the
/// whole script. If the controller is silent for a second, the script goes back to its start and
/// waits for the next force. A second emulator in the same directory is refused.
pub fn run(
    config: &EmulateConfig,
    stop: &AtomicBool,
    ready: &mut dyn FnMut(&Lines),
) -> Result<(), HardwareError> {
    emulate(config, stop, &mut || None, ready, &mut |_| {})
}

/// Like [`run`], with a person who can steer the hand. `wish` is called every millisecond and
/// returns the person's steering command. The first command ends the script. From then on the hand
/// holds still while `wish` returns `None`.
pub fn run_steered(
    config: &EmulateConfig,
    stop: &AtomicBool,
    wish: &mut dyn FnMut() -> Option<Wish>,
    ready: &mut dyn FnMut(&Lines),
) -> Result<(), HardwareError> {
    emulate(config, stop, wish, ready, &mut |_| {})
}

/// Like [`run`]; `watch` receives the state inside the devices every millisecond.
pub fn run_watched(
    config: &EmulateConfig,
    stop: &AtomicBool,
    ready: &mut dyn FnMut(&Lines),
    watch: &mut dyn FnMut(InnerState),
) -> Result<(), HardwareError> {
    emulate(config, stop, &mut || None, ready, watch)
}

fn emulate(
    config: &EmulateConfig,
    stop: &AtomicBool,
    wish: &mut dyn FnMut() -> Option<Wish>,
    ready: &mut dyn FnMut(&Lines),
    watch: &mut dyn FnMut(InnerState),
) -> Result<(), HardwareError> {
    let mut station = Station::new(config)?;
    ready(station.lines());
    let mut start = Instant::now();
    let mut tick = 0;
    while !stop.load(Ordering::Relaxed) {
        let due = start + MILLISECOND * tick;
        match due.checked_duration_since(Instant::now()) {
            Some(early) => thread::sleep(early),
            None => {
                let late = due.elapsed();
                if late > CATCH_UP_LIMIT {
                    start += late;
                }
            }
        }
        station.tick(wish())?;
        watch(station.inside());
        // A u32 counts the milliseconds of 49 days. Then the count restarts at 0.
        match tick.checked_add(1) {
            Some(next) => tick = next,
            None => (start, tick) = (Instant::now(), 0),
        }
    }
    Ok(())
}
