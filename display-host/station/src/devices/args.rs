//! What `calot devices` understands.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::args::parse_seconds;

#[derive(Debug, Clone, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_long_help = "\
A station file, for --station-file of run, rt and watch; every part may be left out:
  [haptic]
  driver = \"rig\"                      # rig, woody, hapi, inverse3 or touch
  path = \"/dev/serial/by-id/my-rig\"   # a name that stays; for a Touch the vendor's libHD.so
  force_max_n = 2.5                   # never more than this, whatever the device can
  motion_scale = 1.5                  # the simulation's handle goes 1.5 times as far

  [tracker]
  driver = \"bird\"                     # or trakstar, with path = \"usb\"
  path = \"/dev/serial/by-id/my-tracker\"
  hemisphere = \"upper\"               # where the endoscope is, seen from the transmitter

  [pedal]
  driver = \"evdev\"                    # rig, evdev or modem
  path = \"/dev/input/by-id/my-pedal-event-kbd\"
  cut_key = 256                       # a [second_pedal] may have the other switches

  [handle_buttons]                    # buttons of the haptic device that are a pedal's, by number
  coagulate = 2

  [ports]                             # the trocars, where the scene's are not the station's
  instrument_m = [0.0, 0.03, 0.18]

  [frames.world_from_device]          # `calot devices calibrate` finds these
  position_m = [0.1, 0.0, 0.2]
  rotation_xyzw = [0.0, 0.0, 0.0, 1.0]

  [[landmarks]]                       # three or more places to touch, for that
  name = \"left rim\"
  position_m = [0.1, 0.0, 0.0]

Examples:
  calot devices
  calot devices watch /dev/ttyACM0
  calot devices watch --station-file station.toml
  calot devices conformance /dev/ttyACM0 --unplug
  calot run --station-file station.toml"
)]
pub(crate) struct DevicesArgs {
    #[command(subcommand)]
    pub(crate) command: Option<DevicesCommand>,
    #[command(flatten)]
    pub(crate) list: DevicesListArgs,
}

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum DevicesCommand {
    /// What is plugged in, under the name that stays, and which driver fits
    List(DevicesListArgs),
    /// What a device says, live
    Watch(WatchArgs),
    /// Test a device with the suite that the emulated ones pass; exits with 1 if a check fails
    Conformance(ConformanceArgs),
    /// Where haptic device and tracker stand: touch the station file's landmarks with each
    Calibrate(CalibrateArgs),
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Three landmarks or more, not on one line, that the devices reach, in the scene's frame:
  [[landmarks]]
  name = \"left rim of the phantom\"
  position_m = [0.1, 0.0, 0.0]

Example:
  calot devices calibrate --station-file station.toml --out station.toml")]
pub(crate) struct CalibrateArgs {
    /// File that names the devices and the landmarks
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: PathBuf,
    /// Write the station file with the frames that were found [default: print them]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Refuse a fit that leaves more than this at the landmarks, root mean square
    #[arg(long, value_name = "MM", default_value_t = 2.0)]
    pub(crate) residual_mm: f32,
    /// A JSON object for each frame
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct DevicesListArgs {
    /// One JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}

/// What speaks on a serial line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum LineDriver {
    /// Our rig protocol: a haptic device or a pedal, as it says of itself
    Rig,
    /// WoodenHaptics and Polhem
    Woody,
    /// Haply hAPI board, flat device of the second generation; the handle at home
    HapiGen2,
    /// Of the third
    HapiGen3,
    /// Of the third, revised
    HapiGen31,
    /// 3D Systems Touch, the default one; PATH is the vendor's libHD.so
    Touch,
    /// USB foot pedal with the keys of a VEC Infinity (others: by a station file)
    Evdev,
    /// Foot switches on a serial line's CTS and DSR
    Modem,
    /// Haply Inverse3 behind its service; PATH is the service's address, `localhost`
    Inverse3,
    /// Ascension Flock of Birds, serial
    Bird,
    /// Ascension trakSTAR on the USB; PATH is `usb`, or a unit's serial number
    Trakstar,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct WatchArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH", required_unless_present = "station_file")]
    pub(crate) path: Option<PathBuf>,
    /// What speaks there
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// Watch the devices that this file names
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub(crate) station_file: Option<PathBuf>,
    /// End after this time [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// A JSON object for each device each second
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ConformanceArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH")]
    pub(crate) path: PathBuf,
    /// What speaks there
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// How long its samples are watched, s
    #[arg(long, value_name = "N", default_value_t = 2.0, value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Ask for the plug to be pulled, and see that this is noticed
    #[arg(long)]
    pub(crate) unplug: bool,
    /// One JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}
