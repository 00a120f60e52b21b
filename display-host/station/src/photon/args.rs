//! Options of `calot photon`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::{ControllerArgs, SceneArgs, parse_seconds, parse_size, parse_station};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
A square at the left edge of the screen changes twice a second with the tick, and then with each
2 cm that the handle moves. A light sensor on the square shows when a change is seen. Calot names the
place, goes on by itself once the sensor sees the square, and measures three places in turn.

What you need is one photodiode or phototransistor, and one of these inputs:
  a UART's pin    --pin /dev/ttyS0:cts   exact to 0.1 ms; behind USB to its latency timer only
  a sound card    --audio -              exact to 0.1 ms, plus the card's buffer: keep it short
  a rig's board   --board /dev/ttyACM1   a pedal of the rig protocol; exact to half its report's period
  a rig's button  --button 2             a spare button of the haptic device itself, 2 to 7

Examples:
  calot photon --pin /dev/ttyS0:cts
  arecord -q -f S16_LE -r 48000 -c 1 -t raw --buffer-time=4000 | calot photon --audio -
  calot photon --board /dev/ttyACM1 --haptic /dev/ttyACM0 --seconds 120
  calot photon --button 2 --haptic /dev/ttyACM0 --place top

A motion counts from the arrival of its sample at this computer. Time in the device and its cable
comes on top: `calot devices characterise` measures it. Move a real handle back and forth by
some cm, slower than two changes a second.")]
pub(crate) struct PhotonArgs {
    #[command(flatten)]
    pub(crate) sensor: SensorArgs,
    /// Places to measure, in turn
    #[arg(long, value_name = "PLACE", value_delimiter = ',', value_enum,
        default_values = ["top", "middle", "bottom"])]
    pub(crate) place: Vec<PlaceName>,
    /// Time to measure each place, s: half by the tick, half by motion
    #[arg(long, value_name = "N", default_value = "60", value_parser = parse_seconds)]
    pub(crate) seconds: f64,
    /// Longest time from a change to its light, ms. The next change comes 99 ms after
    /// this time
    #[arg(long, value_name = "ms", default_value_t = 400,
        value_parser = clap::value_parser!(u64).range(100..=2000))]
    pub(crate) longest: u64,
    /// Time to wait at each place until the sensor sees the square, s
    #[arg(long, value_name = "N", default_value = "120", value_parser = parse_seconds)]
    pub(crate) patience: f64,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the measured station
    #[arg(long, value_name = "NAME", default_value = "photon", value_parser = parse_station)]
    pub(crate) station: String,
    /// Measure in a window of this size, pixels, e.g. 1280x720 [default: the whole screen]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Folder for photon.json and photon.html [default: photon, or photon-2, photon-3, … if it
    /// holds a report]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Print photon.json on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

/// The light sensor.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Light sensor")]
pub(crate) struct SensorArgs {
    /// Input pin of a serial port that the sensor switches: cts, dsr, dcd or ri; RTS and DTR feed
    /// it
    #[arg(long, value_name = "TTY:PIN", value_parser = parse_pin,
        required_unless_present_any = ["audio", "board", "button"],
        conflicts_with_all = ["audio", "board", "button"])]
    pub(crate) pin: Option<PinPath>,
    /// Sound from standard input (-) or a pipe: 16 bit, little-endian, one channel, no header
    #[arg(long, value_name = "-|PIPE", conflicts_with_all = ["board", "button"])]
    pub(crate) audio: Option<PathBuf>,
    /// Sample rate of --audio, Hz
    #[arg(long, value_name = "Hz", default_value_t = 48_000, requires = "audio",
        value_parser = clap::value_parser!(u32).range(4000..=384_000))]
    pub(crate) rate: u32,
    /// Board that speaks the rig protocol as a pedal; any of its switches is the sensor
    #[arg(long, value_name = "TTY", conflicts_with = "button")]
    pub(crate) board: Option<PathBuf>,
    /// Button of the haptic device that is the sensor; 0 and 1 are the handle's own
    #[arg(long, value_name = "2-7", value_parser = clap::value_parser!(u8).range(2..=7))]
    pub(crate) button: Option<u8>,
    /// Known delay of the sensor, ms, which the figures leave out
    #[arg(long, value_name = "ms", default_value_t = 0.0, value_parser = parse_delay)]
    pub(crate) sensor_delay: f64,
}

/// Place of the square, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlaceName {
    /// Upper left corner
    Top,
    /// Left edge, half way down
    Middle,
    /// Lower left corner
    Bottom,
}

/// A pin, as typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PinPath {
    pub(crate) tty: PathBuf,
    pub(crate) pin: hardware::light::Pin,
}

fn parse_pin(text: &str) -> Result<PinPath, String> {
    use hardware::light::Pin;
    let (tty, pin) = text.rsplit_once(':').unwrap_or((text, "cts"));
    let pin = match pin.to_ascii_lowercase().as_str() {
        "cts" => Pin::Cts,
        "dsr" => Pin::Dsr,
        "dcd" => Pin::Dcd,
        "ri" => Pin::Ri,
        other => return Err(format!("'{other}' is no pin: cts, dsr, dcd or ri")),
    };
    Ok(PinPath {
        tty: tty.into(),
        pin,
    })
}

fn parse_delay(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(ms) if (0.0..=1000.0).contains(&ms) => Ok(ms),
        _ => Err("a delay is 0 to 1000 ms".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use hardware::light::Pin;

    use super::*;

    #[derive(Debug, Parser)]
    struct Alone {
        #[command(flatten)]
        photon: PhotonArgs,
    }

    fn typed(words: &str) -> Result<PhotonArgs, String> {
        let words = format!("photon {words}");
        let parsed = Alone::try_parse_from(words.split_whitespace());
        parsed.map(|it| it.photon).map_err(|it| it.to_string())
    }

    #[test]
    fn a_pin_has_a_port_and_a_name() {
        let pin = |text: &str| parse_pin(text).map(|it| (it.tty, it.pin));
        assert_eq!(pin("/dev/ttyS0"), Ok(("/dev/ttyS0".into(), Pin::Cts)));
        assert_eq!(pin("/dev/ttyS0:RI"), Ok(("/dev/ttyS0".into(), Pin::Ri)));
        assert!(pin("/dev/ttyS0:rts").is_err_and(|it| it.contains("'rts' is no pin")));
    }

    #[test]
    fn exactly_one_sensor_is_named() {
        assert!(typed("").is_err_and(|it| it.contains("--pin")));
        assert!(typed("--pin /dev/ttyS0 --audio -").is_err());
        assert!(typed("--button 1").is_err(), "the handle's own");
        for one in ["--pin /dev/ttyS0", "--audio -", "--board x", "--button 2"] {
            let args = typed(one).unwrap();
            assert_eq!(args.place.len(), 3, "{one}");
        }
        assert!(typed("--audio - --sensor-delay -1").is_err());
    }
}
