//! What `calot start` understands.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::args::StoreFile;
use crate::args::{LanguageName, parse_station};

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Every operation is a `calot run` of its own: --station, --task, --difficulty, --scene, --scope, --language,
--trainee, --store, --station-file, --rules and --out come from what is chosen or given here, and whatever stands after `--` is added.

Examples:
  calot start
  calot start --station-file station.toml --scene tests/assets/hra-female.toml -- --meshes DIR
  calot start --sessions monday -- --mute")]
pub(crate) struct StartArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// File that names the devices, to begin with [default: emulated devices]
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: Option<PathBuf>,
    /// A scene to choose beside the built-in ones: a recipe (.toml), a mesh, or a compiled scene
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<String>,
    /// Pass rules and weights (TOML) [default: the built-in ones]
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Questionnaire (TOML) [default: the paper's fourteen items]
    #[arg(long, value_name = "FILE")]
    pub(crate) questionnaire: Option<PathBuf>,
    /// Where each session gets a folder [default: `sessions` beside the store]
    #[arg(long, value_name = "DIR")]
    pub(crate) sessions: Option<PathBuf>,
    /// The interface's language [default: the one of LANG]
    #[arg(long, value_enum)]
    pub(crate) language: Option<LanguageName>,
    #[command(flatten)]
    pub(crate) store: StoreFile,
    /// More for every `calot run`
    #[arg(last = true, value_name = "RUN ARGS")]
    pub(crate) more: Vec<OsString>,
}

impl Default for StartArgs {
    fn default() -> Self {
        /// `calot` alone on a screen is `calot start` alone.
        #[derive(clap::Parser)]
        struct Alone {
            #[command(flatten)]
            start: StartArgs,
        }
        <Alone as clap::Parser>::parse_from(["calot"]).start
    }
}
