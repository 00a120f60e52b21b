//! The station file: the devices, their drivers and their poses.
//!
//! ```toml
//! [haptic]
//! driver = "rig"                      # rig, woody, hapi, inverse3, touch or force-dimension
//! path = "/dev/serial/by-id/my-rig"   # a name that udev keeps stable
//! force_max_n = 2.5                   # never more than this, even if the device can give more
//! damping_n_s_m = 1.8                 # measured by `characterise`; replaces the declared value
//! delay_s = 0.002                     # measured by `characterise`; replaces the declared value
//! motion_scale = 1.5                  # the simulation's handle goes 1.5 times as far
//!
//! [haptic.felt]                       # `calot devices feel` writes this
//! passed = true
//! on = "2026-11-27"
//! device = "my rig, serial 7"
//!
//! [tracker]
//! driver = "bird"                     # bird, or trakstar with path = "usb"
//! path = "/dev/serial/by-id/my-tracker"
//! hemisphere = "upper"
//! full_scale_in = 36                  # or 72: reaches twice as far, in steps twice as large
//! birds = 1                           # number of units on the tracker's bus
//! bird = 1                            # address of the unit on the endoscope
//! filter_rest_hz = 3.0                # a lower value is steadier at rest; 0: no filter
//!
//! [pedal]
//! driver = "evdev"                    # rig, evdev or modem
//! path = "/dev/input/by-id/my-pedal-event-kbd"
//! cut_key = 256
//!
//! [second_pedal]                      # a switch is pressed if either pedal presses it
//! driver = "modem"
//! path = "/dev/serial/by-id/my-switches"
//!
//! [handle_buttons]                    # buttons of the haptic device that act as pedal switches
//! coagulate = 2
//!
//! [ports]                             # where the trocars are, world frame
//! instrument_m = [0.0, 0.03, 0.18]
//! endoscope_m = [0.05, -0.1, 0.1]
//! trocar = "real"                     # a real one rubs by itself; or "dry", "wet": rendered
//!
//! [frames.world_from_device]          # `calot devices calibrate` finds these two
//! position_m = [0.1, 0.0, 0.2]
//! rotation_xyzw = [0.0, 0.0, 0.0, 1.0]
//!
//! [[landmarks]]                       # three or more places to touch for `calibrate`
//! name = "left rim"
//! position_m = [0.1, 0.0, 0.0]
//!
//! [centre]                            # a centre of many stations; `calot run` reports to it
//! address = "10.0.0.2:7448"
//! keys = "/etc/calot/keys"            # left out: calot/centre-keys in ~/.config
//! ```
//!
//! Every section may be left out. A wrong key, type or range is an error that names the line.

pub mod calibration;
mod open;
mod raw;
mod scaled;

use std::path::{Path, PathBuf};

use rt_core::math::{Pose, Vec3};
use rt_core::scene::TrocarChoice;

use crate::HardwareError;
use crate::bird::BirdSetup;
use crate::hapi::pantograph::Pantograph;
use crate::pedal::Roles;

/// Contents of a station file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationFile {
    /// The haptic device.
    pub haptic: Option<HapticSpec>,
    /// The endoscope's tracker.
    pub tracker: Option<TrackerSpec>,
    /// The foot pedal.
    pub pedal: Option<PedalSpec>,
    /// Buttons of the haptic device that act as a pedal.
    pub handle_buttons: HandleButtons,
    /// Base frame of the haptic device; `None`: the scene's.
    pub world_from_device: Option<Pose>,
    /// Frame of the tracker's transmitter; `None`: the scene's.
    pub world_from_tracker: Option<Pose>,
    /// The instrument's trocar, world frame, m; `None`: the scene's.
    pub instrument_port_m: Option<Vec3>,
    /// The endoscope's trocar, world frame, m; `None`: the scene's.
    pub endoscope_port_m: Option<Vec3>,
    /// The instrument's trocar; by default the scene's.
    pub trocar: TrocarChoice,
    /// Places of the station that the devices can touch, for calibration.
    pub landmarks: Vec<Landmark>,
    /// The centre that hears of this station.
    pub centre: Option<CentreSpec>,
}

/// A centre of many stations.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CentreSpec {
    /// Host and port.
    pub address: String,
    /// Folder of the station's keys; `None`: that of the user's settings.
    pub keys: Option<PathBuf>,
}

/// A place of the station with a known position.
#[derive(Debug, Clone, PartialEq)]
pub struct Landmark {
    /// Name for people.
    pub name: String,
    /// Position, world frame, m.
    pub position_m: Vec3,
}

/// Access to the haptic device.
#[derive(Debug, Clone, PartialEq)]
pub struct HapticSpec {
    /// Driver.
    pub driver: HapticDriver,
    /// Path of the line; for a Touch or a Force Dimension device the vendor's library, for an
    /// Inverse3 the address of its service.
    pub path: PathBuf,
    /// Limits below the device's own.
    pub limits: Limits,
    /// Movement of the simulation's handle per movement of the device's; `None`: 1.
    pub motion_scale: Option<f32>,
    /// True if the device has passed `calot devices feel`.
    pub is_felt: bool,
    /// Names of the checks of that test that the device did not pass; `None` without such a
    /// record.
    pub failed_felt: Option<Vec<String>>,
}

/// Limits that a person sets below the device's own, and measured values that replace the declared
/// ones. `None`: the device's own value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Peak force, N.
    pub force_max_n: Option<f32>,
    /// Continuous force, N.
    pub force_continuous_n: Option<f32>,
    /// Stiffness, N/m.
    pub stiffness_max_n_m: Option<f32>,
    /// Damping of the device itself, N s/m, as measured.
    pub damping_n_s_m: Option<f32>,
    /// Delay of the device, s, as measured.
    pub delay_s: Option<f32>,
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
        /// `None`: the first.
        device: Option<String>,
    },
    /// 3D Systems' Touch, by its name in the vendor's set-up.
    Touch {
        /// `None`: the default device.
        device: Option<String>,
    },
    /// A device of Force Dimension, or a Falcon, by its serial number.
    ForceDimension {
        /// `None`: the first that is free.
        serial: Option<u16>,
    },
}

/// Buttons of the haptic device that act as a pedal, counted from 1; `None`: no button.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HandleButtons {
    /// Electrosurgery: cut.
    pub cut: Option<u8>,
    /// Electrosurgery: coagulate.
    pub coagulate: Option<u8>,
    /// Holds the camera.
    pub camera_lock: Option<u8>,
}

impl HandleButtons {
    /// Bits of these buttons in a sample: cut, coagulate, camera lock; 0 without a button.
    #[must_use]
    pub fn bits(&self) -> [u8; 3] {
        [self.cut, self.coagulate, self.camera_lock].map(|number| match number {
            Some(number @ 1..=8) => 1 << (number - 1),
            _ => 0,
        })
    }
}

/// Access to the tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSpec {
    /// Driver.
    pub driver: TrackerDriver,
    /// Path of the line; for a trakSTAR `usb` or its serial number.
    pub path: PathBuf,
    /// Settings of the tracker.
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

/// Access to the pedal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PedalSpec {
    /// Driver.
    pub driver: PedalDriver,
    /// Path of the line or of the input device.
    pub path: PathBuf,
    /// A second pedal. A switch counts as pressed if it is pressed on either pedal.
    pub second: Option<Box<PedalSpec>>,
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
    ///
    /// # Errors
    /// When it is not a regular file, cannot be read, or [`StationFile::parse`] refuses its text.
    pub fn read(path: &Path) -> Result<Self, HardwareError> {
        // Reading a line, a pipe or an endless device would block or never end.
        if std::fs::metadata(path).is_ok_and(|it| !it.is_file()) {
            return Err(HardwareError::NoStationFile {
                path: path.to_path_buf(),
            });
        }
        let text = std::fs::read_to_string(path).map_err(|error| HardwareError::Line {
            path: path.to_path_buf(),
            doing: "reading the station file",
            what: error.to_string(),
        })?;
        Self::parse(&text, path)
    }

    /// Parses the text of a station file; `path` appears in errors.
    pub fn parse(text: &str, path: &Path) -> Result<Self, HardwareError> {
        raw::parse(text, path)
    }
}
