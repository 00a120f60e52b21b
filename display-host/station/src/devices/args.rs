//! Options of `calot devices`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::args::{LanguageName, parse_seconds};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_long_help = "\
A station file, for --station-file of run, rt and watch. Every part is optional:
  [haptic]
  driver = \"rig\"                      # rig, woody, hapi, inverse3, touch or force-dimension
  path = \"/dev/serial/by-id/my-rig\"   # a stable name; for a Touch the vendor's libHD.so
  force_max_n = 2.5                   # force limit, below that of the device
  damping_n_s_m = 1.8                 # measured by `calot devices characterise`, …
  delay_s = 0.002                     # … instead of what the device declares
  motion_scale = 1.5                  # the simulated handle moves 1.5 times as far

  [tracker]
  driver = \"bird\"                     # or trakstar, with path = \"usb\"
  path = \"/dev/serial/by-id/my-tracker\"
  hemisphere = \"upper\"               # side of the transmitter on which the endoscope is

  [pedal]
  driver = \"evdev\"                    # rig, evdev or modem
  path = \"/dev/input/by-id/my-pedal-event-kbd\"
  cut_key = 256                       # a [second_pedal] may hold the other switches

  [handle_buttons]                    # buttons of the haptic device that act as pedal switches
  coagulate = 2

  [ports]                             # trocars, if they differ from the scene's
  instrument_m = [0.0, 0.03, 0.18]
  trocar = \"real\"                     # a real one on the rig; dry and wet render friction

  [frames.world_from_device]          # found by `calot devices calibrate`
  position_m = [0.1, 0.0, 0.2]
  rotation_xyzw = [0.0, 0.0, 0.0, 1.0]

  [[landmarks]]                       # three or more places to touch in calibration
  name = \"left rim\"
  position_m = [0.1, 0.0, 0.0]

Examples:
  calot devices
  calot devices watch /dev/ttyACM0
  calot devices watch --station-file station.toml
  calot devices conformance /dev/ttyACM0 --unplug
  calot devices characterise /dev/ttyACM0 --out measured
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
    /// Lists the devices plugged in, with their stable names and drivers
    List(DevicesListArgs),
    /// Shows the samples of a device live
    Watch(WatchArgs),
    /// Tests a device with the suite that the emulated devices pass; exit code 1 if a check fails
    Conformance(ConformanceArgs),
    /// Tests axes, units and signs of a haptic device with a person's hand; exit code 1 if a check
    /// fails. Forces are 0.5 N at most, except one push of 2 N, and 1 N at the fingers
    Feel(FeelArgs),
    /// Finds the positions of haptic device and tracker by touching the station file's landmarks
    /// with each
    Calibrate(CalibrateArgs),
    /// Measures friction, inertia, damping, delay and the stiffness limit of a haptic device, and
    /// compares them with what it declares
    Characterise(CharacteriseArgs),
}

/// Axis of the device's base frame, or the opening of its handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AxisName {
    /// To the right
    X,
    /// Up
    Y,
    /// To the user
    Z,
    /// Along the opening of a handle that opens
    Opening,
}

#[derive(Debug, Clone, Args)]
#[command(after_long_help = "\
Nobody holds the handle during the first part, which takes about a minute for three axes:
  1. A soft spring finds the force that carries the handle's weight.
  2. A force grows slowly until the handle moves: dry friction, and the direction of the force.
  3. A chirp from 4 to 50 Hz, and pushes after which the handle coasts. A model is fitted to these
     motions: mass, damping, friction and delay.
A handle that opens is measured along its opening too: it goes to both ends, then come the same
experiments. No fingers may be in it. The motions do not show how large its force is. They show only if
large forces are in proportion to small ones.
With --wall a second part follows. A wall lies across the middle of the workspace. Tap it from above,
press it gently for a second, and lift the handle again. Each wall is stiffer, until one buzzes.

Forces begin at zero and stay below half of the declared peak, the continuous force, and 1 N unless
--force allows more. The measurement ends, without force, when the handle leaves 60 % of the workspace or
moves faster than 0.5 m/s, when the device is lost or reports a fault, when the wall buzzes, and when
you press Enter or Ctrl-C. First make sure with `calot devices conformance` that the device obeys its
watchdog, and keep its switch within reach.

The reported damping is viscous damping plus 4 f / (pi v), with the dry friction f and v = 0.2 m/s. The
delay is the sum of the delay of a sample and that of a command. Calot renders contacts up to 0.7 of
K = damping / (half a sample's period + delay): with too much damping or too little delay declared, hard
contacts buzz. The printed lines belong into [haptic] of the station file. There they replace what the
device declares.

Examples:
  calot devices characterise /dev/ttyACM0 --out measured
  calot devices characterise --station-file station.toml --axis y --wall

Without a device:
  calot emulate --dir /tmp/rig --scene built-in.calot --hand none
  calot devices characterise /tmp/rig/haptic --yes
The emulator's `--handle opening` opens and shuts, and its `--hand press` taps the wall of --only-wall.")]
pub(crate) struct CharacteriseArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH", required_unless_present = "station_file")]
    pub(crate) path: Option<PathBuf>,
    /// Driver of the device at PATH
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// Measure the haptic device that this station file names
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub(crate) station_file: Option<PathBuf>,
    /// Measure along this axis only; may be repeated [default: x, y, z and the opening]
    #[arg(long, value_enum)]
    pub(crate) axis: Vec<AxisName>,
    /// Largest force, N: at most half of the declared peak and the continuous force [default: 1, or
    /// what the device allows]
    #[arg(long, value_name = "N")]
    pub(crate) force: Option<f64>,
    /// Also find the stiffest wall that does not buzz; needs a hand at the handle
    #[arg(long)]
    pub(crate) wall: bool,
    /// Only find that wall: skip the first part, in which nobody holds the handle
    #[arg(long)]
    pub(crate) only_wall: bool,
    /// Write a page with charts and a file with all figures to this folder
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Begin without waiting for Enter
    #[arg(long)]
    pub(crate) yes: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The station file needs at least three landmarks within reach of the devices, not on one line, in the
scene's frame:
  [[landmarks]]
  name = \"left rim of the phantom\"
  position_m = [0.1, 0.0, 0.0]

Example:
  calot devices calibrate --station-file station.toml --out station.toml --overwrite")]
pub(crate) struct CalibrateArgs {
    /// File that names the devices and the landmarks
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: PathBuf,
    /// Write the station file with the fitted frames to this file [default: print the frames]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Refuse a fit whose root mean square residual at the landmarks exceeds this, mm
    #[arg(long, value_name = "MM", default_value_t = 2.0)]
    pub(crate) residual_mm: f32,
    /// Print one JSON object per frame
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct DevicesListArgs {
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}

/// Driver of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LineDriver {
    /// Rig protocol of Calot: a haptic device or a pedal; the device says which
    Rig,
    /// WoodenHaptics
    Woody,
    /// Haply hAPI board, planar device of the second generation; begin with the handle in its home
    /// position
    HapiGen2,
    /// Haply hAPI board, third generation
    HapiGen3,
    /// Haply hAPI board, third generation, revised
    HapiGen31,
    /// 3D Systems Touch (its default device); PATH is the vendor's libHD.so
    Touch,
    /// Force Dimension omega, delta, sigma, lambda or Novint Falcon (the first that is free); PATH
    /// is the vendor's libdhd.so.3
    ForceDimension,
    /// USB foot pedal with the keys of a VEC Infinity; a station file describes others
    Evdev,
    /// Foot switches on CTS and DSR of a serial line
    Modem,
    /// Haply Inverse3 behind its service; PATH is the address of the service, e.g. localhost
    Inverse3,
    /// Ascension Flock of Birds, serial
    Bird,
    /// Ascension trakSTAR on USB; PATH is `usb` or the serial number of a unit
    Trakstar,
}

impl LineDriver {
    /// True if PATH is a serial line, on which another device may speak another protocol.
    pub(crate) fn is_serial(self) -> bool {
        match self {
            Self::Rig | Self::Woody | Self::HapiGen2 | Self::HapiGen3 | Self::HapiGen31 => true,
            Self::Bird => true,
            Self::Touch | Self::ForceDimension | Self::Inverse3 => false,
            Self::Evdev | Self::Modem | Self::Trakstar => false,
        }
    }
}

#[derive(Debug, Clone, Args)]
pub(crate) struct WatchArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH", required_unless_present = "station_file")]
    pub(crate) path: Option<PathBuf>,
    /// Driver of the device at PATH
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// Watch the devices that this station file names, e.g. station.toml
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub(crate) station_file: Option<PathBuf>,
    /// End after this time, s, e.g. 60 [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Write every sample of the haptic device to this table; units are in its first line. At the
    /// end, print how many sequence numbers are missing
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Print one JSON object per device and second
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
#[command(after_long_help = "\
The test leads you through these parts:
  1. Move the handle to the right, up and towards you: axes, units and the sign of velocity.
  2. The handle pushes with 0.3 N three times. You say which way: sign and axes of force.
  3. Shut and open a handle that opens; it pushes your fingers with 1 N: range and sign.
  4. The handle presses on a kitchen scale with 0.5 N: size of force. You may leave this out.
  5. It pushes to and fro for 9 s: steps, a sine, a chirp. `--page` draws the motion.
  6. You hold it firmly, and it pushes once with 2 N, or less if the device declares less.
  7. It pushes with 0.5 N, and then Calot sends nothing: the push must end by itself.

If the handle belongs to an instrument in a port, begin with the instrument half drawn out. If its
shaft points up or towards you, draw it farther out for the move in that direction.

The pushes rise and fall in 0.3 s. Every force ends at once when the handle moves off by 4 cm.

`--window` shows the same steps in a window, with the handle's position and force. Esc ends every
force and the test. So does closing the window.

A rig with a sensor of its own may do without a person: `--script PROGRAM`. The program reads one
JSON object per line, such as
  {\"step\": \"move\", \"direction\": \"right\", \"way_m\": 0.05}
and answers {\"done\": true}, also to the steps hold, shut, open, hold_fingers, scale and press. A move
goes along the base frame, whatever the shaft: \"towards\" draws a level instrument out of its port,
\"up\" an upright one. At hold it goes back to the middle, half drawn out. During {\"step\": \"push\"} it
measures, and answers {\"ask\": \"pushed\"} with {\"force_n\": [0.3, 0.0, 0.0]} (x right, y up, z towards
the user). {\"ask\": \"left\"} wants the force that is measured at that moment, in the same form, or
{\"felt\": \"nothing\"}. {\"ask\": \"scale\"} wants {\"scale\": true} or false.
{\"ask\": \"pushed_fingers\"} wants {\"opening_n\": 0.9} or {\"felt\": \"open\"}, \"shut\", \"nothing\".
{\"ask\": \"pressed\"} wants {\"pressed_n\": 0.5} or null.

Examples:
  calot devices feel /dev/ttyACM0 --page feel.html
  calot devices feel /dev/ttyACM0 --window
  calot devices feel --station-file station.toml --out station.toml --overwrite")]
pub(crate) struct FeelArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH", required_unless_present = "station_file")]
    pub(crate) path: Option<PathBuf>,
    /// Driver of the device at PATH
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// Test the haptic device that this station file names
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub(crate) station_file: Option<PathBuf>,
    /// Write the station file with the result to this file
    #[arg(long, value_name = "FILE", requires = "station_file")]
    pub(crate) out: Option<PathBuf>,
    /// Draw the results on a page, e.g. feel.html
    #[arg(long, value_name = "FILE")]
    pub(crate) page: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Program that moves the handle and measures its forces, instead of a person
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) script: Option<PathBuf>,
    /// Lead through the test in a window, instead of the terminal
    #[arg(long, conflicts_with = "script")]
    pub(crate) window: bool,
    /// Language of the window [default: that of LANG]
    #[arg(long, value_enum, requires = "window")]
    pub(crate) language: Option<LanguageName>,
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ConformanceArgs {
    /// Serial device, e.g. /dev/ttyACM0
    #[arg(value_name = "PATH")]
    pub(crate) path: PathBuf,
    /// Driver of the device at PATH
    #[arg(long, value_enum, default_value_t = LineDriver::Rig)]
    pub(crate) driver: LineDriver,
    /// Time to watch the samples, s
    #[arg(long, value_name = "N", default_value_t = 2.0, value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Ask to pull the plug, and check that the driver notices
    #[arg(long)]
    pub(crate) unplug: bool,
    /// Print one JSON object instead of a list
    #[arg(long)]
    pub(crate) json: bool,
}
