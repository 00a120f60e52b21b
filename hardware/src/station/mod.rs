//! The station file: which devices there are, how they are driven and where they stand.
//!
//! ```toml
//! [haptic]
//! driver = "rig"                      # rig, woody, hapi, inverse3 or touch
//! path = "/dev/serial/by-id/my-rig"   # a name that udev keeps stable
//! force_max_n = 2.5                   # never more than this, whatever the device can
//!
//! [tracker]
//! driver = "bird"                     # bird, or trakstar with path = "usb"
//! path = "/dev/serial/by-id/my-tracker"
//! hemisphere = "upper"
//! full_scale_in = 36                  # or 72: reaches twice as far, in steps twice as large
//! birds = 1                           # units on its bus, …
//! bird = 1                            # … and which of them is on the endoscope
//!
//! [pedal]
//! driver = "evdev"                    # rig, evdev or modem
//! path = "/dev/input/by-id/my-pedal-event-kbd"
//! cut_key = 256
//!
//! [frames.world_from_device]
//! position_m = [0.1, 0.0, 0.2]
//! rotation_xyzw = [0.0, 0.0, 0.0, 1.0]
//! ```
//!
//! Every section may be left out. A wrong key, type or range is an error that names the line.

mod open;
mod raw;

use std::path::{Path, PathBuf};

use rt_core::math::Pose;

use crate::HardwareError;
use crate::bird::BirdSetup;
use crate::hapi::pantograph::Pantograph;
use crate::pedal::Roles;

/// A station as its file describes it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationFile {
    /// The haptic device.
    pub haptic: Option<HapticSpec>,
    /// The endoscope's tracker.
    pub tracker: Option<TrackerSpec>,
    /// The foot pedal.
    pub pedal: Option<PedalSpec>,
    /// Base frame of the haptic device; else the scene's.
    pub world_from_device: Option<Pose>,
    /// The tracker's transmitter; else the scene's.
    pub world_from_tracker: Option<Pose>,
}

/// How the haptic device is reached.
#[derive(Debug, Clone, PartialEq)]
pub struct HapticSpec {
    /// Which driver.
    pub driver: HapticDriver,
    /// The line; for a Touch the vendor's library, for an Inverse3 the address of its service.
    pub path: PathBuf,
    /// Limits below those of the device.
    pub limits: Limits,
}

/// Limits that a person sets below what a device says of itself. None: the device's own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Peak force, N.
    pub force_max_n: Option<f32>,
    /// Force held for long, N.
    pub force_continuous_n: Option<f32>,
    /// Stiffness, N/m.
    pub stiffness_max_n_m: Option<f32>,
}

/// Drivers of haptic devices.
#[derive(Debug, Clone, PartialEq)]
pub enum HapticDriver {
    /// The rig protocol.
    Rig,
    /// WoodenHaptics.
    Woody,
    /// Haply's hAPI board with a linkage of this generation.
    Hapi(Pantograph),
    /// Haply's Inverse3 behind its service, by its number there.
    Inverse3 {
        /// None: the first.
        device: Option<String>,
    },
    /// 3D Systems' Touch, by the name in the vendor's set-up.
    Touch {
        /// None: the default device.
        device: Option<String>,
    },
}

/// How the tracker is reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrackerSpec {
    /// Which driver.
    pub driver: TrackerDriver,
    /// The line; for a trakSTAR `usb` or its serial number.
    pub path: PathBuf,
    /// How it is set up.
    pub setup: BirdSetup,
}

/// Drivers of trackers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackerDriver {
    /// A serial Flock of Birds.
    Bird,
    /// A trakSTAR on the USB.
    Trakstar,
}

/// How the pedal is reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PedalSpec {
    /// Which driver.
    pub driver: PedalDriver,
    /// The line or the input device.
    pub path: PathBuf,
}

/// Drivers of pedals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PedalDriver {
    /// The rig protocol.
    Rig,
    /// A USB pedal.
    Evdev(Roles),
    /// Switches on CTS and DSR.
    Modem,
}

impl StationFile {
    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Self, HardwareError> {
        let text = std::fs::read_to_string(path).map_err(|error| HardwareError::Line {
            path: path.to_path_buf(),
            doing: "reading the station file",
            what: error.to_string(),
        })?;
        Self::parse(&text, path)
    }

    /// Parses a station file's text; `path` is for errors.
    pub fn parse(text: &str, path: &Path) -> Result<Self, HardwareError> {
        raw::parse(text, path)
    }
}
