//! Options of `calot run`.

use std::path::{Path, PathBuf};

use clap::{Args, Parser};

use crate::args::{
    ControllerArgs, GamepadArgs, LanguageName, LookArgs, SceneArgs, ScopeName, parse_seconds,
    parse_size, parse_station,
};
use crate::output::Overwrite;
use crate::task::args::TaskArgs;

/// Default length of a headless run, s.
const HEADLESS_SECONDS: f64 = 10.0;
/// Default length of a headless run in which a scripted surgeon works, s. The run ends as soon as
/// the task is decided. The whole procedure takes the careful surgeon about 330 s of simulated
/// time, which last twice as long on a slow computer.
const SURGEON_SECONDS: f64 = 900.0;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot run                                      open the station in a window
  calot run --headless --seconds 10 --out out    pictures, summary.json, report.html
  calot run --scene tests/assets/hra-female.toml --meshes DIR
  calot run --task clamp --difficulty beginner   a task, assessed while it runs
  calot run --task clamp --centre 10.0.0.2:7448  the same, shown at a centre (calot centre --help)
  calot run --attach                             show a station that is already running")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the station; two stations on one machine need two names
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// Open no window; write pictures and a report to --out
    #[arg(long)]
    pub(crate) headless: bool,
    /// End after this time, s [default with --headless: 10, or with --hand when the task is
    /// decided; otherwise when the window is closed]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Folder for summary.json, report.html and pictures [default with --task: a new folder in out;
    /// with --headless: out, or out-2, out-3, … if it holds a run]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Number of pictures in a headless run, spread evenly over its time; 0 for none
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(crate) frames: u32,
    /// Also write the pictures of a headless run as an animated GIF at ten pictures per second
    #[arg(long, value_name = "FILE.gif", requires = "headless")]
    pub(crate) gif: Option<PathBuf>,
    /// Size of pictures or window, pixels, e.g. 1280x720
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Record the session to this file, for `calot replay` [default with --out: DIR/session.mcap]
    #[arg(long, value_name = "FILE", conflicts_with = "attach")]
    pub(crate) record: Option<PathBuf>,
    /// Endoscope of the window, by the angle between its view and its shaft, degrees; the key S
    /// changes it
    #[arg(long, value_enum, default_value_t = ScopeName::Straight, conflicts_with = "headless")]
    pub(crate) scope: ScopeName,
    /// Language of the interface and of the debrief [default: that of LANG]
    #[arg(long, value_enum)]
    pub(crate) language: Option<LanguageName>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Play no sound
    #[arg(long)]
    pub(crate) mute: bool,
    /// Start with a cold endoscope: its lens fogs until it is wiped (key W) or warm
    #[arg(long, conflicts_with = "headless")]
    pub(crate) cold_lens: bool,
    /// Seed of the scripted hand; equal seeds give equal hands
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) task: TaskArgs,
    #[command(flatten)]
    pub(crate) centre: CentreEntry,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// Start no processes; show the running station named by --station
    #[arg(long)]
    pub(crate) attach: bool,
    /// Print summary.json on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

/// A centre that hears of this station.
#[derive(Debug, Clone, Args)]
pub(crate) struct CentreEntry {
    /// Tell this centre of the station: presence, task, score, alarms, pictures, results [default:
    /// that of the station file]
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "attach")]
    pub(crate) centre: Option<String>,
    /// Folder with NAME.pem, NAME.key and ca.pem; NAME is the station's name at the centre
    /// [default: that of the station file, or calot/centre-keys in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "DIR", conflicts_with = "attach")]
    pub(crate) centre_keys: Option<PathBuf>,
}

impl RunArgs {
    /// Length of a headless run, s.
    pub(super) fn headless_s(&self) -> f64 {
        let works = self.task.hand.is_some();
        let default = if works {
            SURGEON_SECONDS
        } else {
            HEADLESS_SECONDS
        };
        self.seconds.unwrap_or(default)
    }
}

impl Default for RunArgs {
    fn default() -> Self {
        /// Takes the defaults that `calot run` has without arguments.
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            run: RunArgs,
        }
        Alone::parse_from(["calot"]).run
    }
}

/// File of the recording, if there is one. With `--attach` nothing is recorded: a session without
/// its beginning cannot be replayed.
pub(super) fn session_path(args: &RunArgs, out: Option<&Path>) -> Option<PathBuf> {
    let beside = out.filter(|_| !args.attach);
    args.record
        .clone()
        .or_else(|| beside.map(|out| out.join("session.mcap")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        run: RunArgs,
    }

    #[test]
    fn a_headless_run_lasts_as_long_as_its_surgeon_needs() {
        let length = |words: &str| {
            let words = format!("calot --headless {words}");
            Alone::parse_from(words.split_whitespace()).run.headless_s()
        };
        let worked = length("--task cut --hand unclamped");
        assert!(worked > length("--task cut") && length("") > 0.0);
        let asked = length("--task cut --hand unclamped --seconds 3");
        assert_eq!(asked.to_bits(), 3.0f64.to_bits());
    }
}
