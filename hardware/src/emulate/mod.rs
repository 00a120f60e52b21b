//! The devices of a station, emulated behind ptys, with a scripted hand at the handle.
//!
//! Each device is a pty and the device's side of its protocol: the very code that a rig's
//! firmware would run ([`crate::rig::device`]), a bird ([`crate::bird::device`]) and, for the
//! haptic device, a body with mass and friction between the motors and the hand. A controller
//! opens them as it opens real ones.

mod bulk;
mod electronics;
mod fault;
mod gamepad;
mod hand;
mod inverse3;
mod led;
mod operated;
mod played;
mod pty;
mod random;
mod station;
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
pub use inverse3::{EmulatedInverse3, Misbehaviour};
pub use led::{LedHand, Measured};
pub use operated::Wish;
pub use played::Played;
pub use touch::{Body, Grip, Touch};

#[cfg(test)]
pub(crate) use random::Random;
use station::Station;

/// What to emulate.
#[derive(Debug, Clone)]
pub struct EmulateConfig {
    /// Where the lines `haptic`, `tracker` and `pedal` appear: symbolic links to ptys. Made
    /// when it does not exist.
    pub directory: PathBuf,
    /// Where the devices stand and what the hand does.
    pub script: HandScript,
    /// Which haptic device.
    pub haptic: HapticModel,
    /// Tremor and faults; the same seed gives the same movements.
    pub seed: u64,
    /// What goes wrong on each line.
    pub faults: LineFaults,
}

/// The faults of each line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LineFaults {
    /// The haptic device's.
    pub haptic: Faults,
    /// The tracker's.
    pub tracker: Faults,
    /// The pedal's.
    pub pedal: Faults,
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

/// What happens inside of the emulated devices, which no controller sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inside {
    /// Since the emulator began, in its own milliseconds, s.
    pub time_s: f32,
    /// Force that the haptic device's motors are told, its base frame, N.
    pub force_n: rt_core::math::Vec3,
    /// What they are told as a share of the most that they may be told.
    pub strain: f32,
}

const MILLISECOND: Duration = Duration::from_millis(1);
/// A machine that was asleep for longer than this has not lived through the time: the hand
/// goes on where it was.
const CATCH_UP_LIMIT: Duration = Duration::from_millis(200);

/// Emulates until `stop` is set. Calls `ready` once, when the lines can be opened.
///
/// The hand begins with the first force that the controller sends, so that nothing is missed
/// while it starts, and begins anew after the controller was silent for a second. A second
/// emulator in the same directory is refused.
pub fn run(
    config: &EmulateConfig,
    stop: &AtomicBool,
    ready: &mut dyn FnMut(&Lines),
) -> Result<(), HardwareError> {
    emulate(config, stop, &mut || None, ready, &mut |_| {})
}

/// The same with a person who leads the hand: from the first wish on the script is over. `wish`
/// is asked every millisecond; none means that nobody leads just now.
pub fn run_led(
    config: &EmulateConfig,
    stop: &AtomicBool,
    wish: &mut dyn FnMut() -> Option<Wish>,
    ready: &mut dyn FnMut(&Lines),
) -> Result<(), HardwareError> {
    emulate(config, stop, wish, ready, &mut |_| {})
}

/// The same with the script; `watch` is told every millisecond what happens inside.
pub fn run_watched(
    config: &EmulateConfig,
    stop: &AtomicBool,
    ready: &mut dyn FnMut(&Lines),
    watch: &mut dyn FnMut(Inside),
) -> Result<(), HardwareError> {
    emulate(config, stop, &mut || None, ready, watch)
}

fn emulate(
    config: &EmulateConfig,
    stop: &AtomicBool,
    wish: &mut dyn FnMut() -> Option<Wish>,
    ready: &mut dyn FnMut(&Lines),
    watch: &mut dyn FnMut(Inside),
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
        // u32: 49 days of emulation, then a new start.
        match tick.checked_add(1) {
            Some(next) => tick = next,
            None => (start, tick) = (Instant::now(), 0),
        }
    }
    Ok(())
}
