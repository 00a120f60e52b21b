//! The arguments of `calot run`.

use std::path::PathBuf;

use clap::{Args, Parser};

use crate::args::{
    ControllerArgs, GamepadArgs, LanguageName, SceneArgs, ScopeName, parse_seconds, parse_size,
    parse_station,
};
use crate::task::args::TaskArgs;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  calot run                                      the station in a window
  calot run --headless --seconds 10 --out out    pictures, summary.json, report.html
  calot run --scene tests/assets/hra-female.toml --meshes DIR
  calot run --task clamp --difficulty beginner   a task, assessed while it runs
  calot run --attach                             only the display of a station that runs")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Name of the station; two stations on one machine need two names
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// No window: watch, and leave pictures and a report in --out
    #[arg(long)]
    pub(crate) headless: bool,
    /// End after this time [default with --headless: 10; else when the window is closed]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Where summary.json, report.html and pictures go [default with --task: a new folder in out;
    /// with --headless: out]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Pictures of a headless run, spread over its time; 0: none
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(crate) frames: u32,
    /// Also put the pictures of a headless run into an animated GIF, ten a second
    #[arg(long, value_name = "FILE.gif", requires = "headless")]
    pub(crate) gif: Option<PathBuf>,
    /// Size of a picture or the window, e.g. 1280x720
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Record the session to this file, for `calot replay` [default with --out: DIR/session.mcap]
    #[arg(long, value_name = "FILE", conflicts_with = "attach")]
    pub(crate) record: Option<PathBuf>,
    /// The window's endoscope, by the angle that it looks off its shaft; S takes the next one
    #[arg(long, value_enum, default_value_t = ScopeName::Straight, conflicts_with = "headless")]
    pub(crate) scope: ScopeName,
    /// The interface's language [default: the one of LANG]
    #[arg(long, value_enum, conflicts_with = "headless")]
    pub(crate) language: Option<LanguageName>,
    /// No sound
    #[arg(long)]
    pub(crate) mute: bool,
    /// The endoscope comes cold: its lens fogs until it is wiped (W) or warm
    #[arg(long, conflicts_with = "headless")]
    pub(crate) cold_lens: bool,
    /// Seed of the scripted hand
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) task: TaskArgs,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// Start no processes: show the station that runs under this name
    #[arg(long)]
    pub(crate) attach: bool,
    /// Print summary.json on standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) controller: ControllerArgs,
}

impl Default for RunArgs {
    fn default() -> Self {
        /// `calot` alone without a screen is `calot run` alone: the same defaults, from the same
        /// place.
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            run: RunArgs,
        }
        Alone::parse_from(["calot"]).run
    }
}
