//! Options of `calot start`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::args::StoreFile;
use crate::args::{LanguageName, parse_station};

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Each operation is a `calot run`. The launcher sets --station, --task, --difficulty, --scene,
--scope, --language, --trainee, --store, --station-file, --rules and --out. Arguments after `--`
are added.

Examples:
  calot start
  calot start --station-file station.toml --scene tests/assets/hra-female.toml -- --meshes DIR
  calot start --sessions monday -- --mute")]
pub(crate) struct StartArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// File that names the devices at the start [default: emulated devices]
    #[arg(long, value_name = "FILE")]
    pub(crate) station_file: Option<PathBuf>,
    /// Scene to offer in addition to the built-in ones: a recipe (.toml), a mesh or a compiled
    /// scene (.calot)
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<String>,
    /// Pass rules and weights (TOML) [default: the built-in ones]
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Curriculum (TOML) [default: the built-in one; `calot store curriculum` prints it]
    #[arg(long, value_name = "FILE")]
    pub(crate) curriculum: Option<PathBuf>,
    /// Questionnaire (TOML) [default: the paper's fourteen items]
    #[arg(long, value_name = "FILE")]
    pub(crate) questionnaire: Option<PathBuf>,
    /// Folder in which each session gets its own folder [default: `sessions` next to the store]
    #[arg(long, value_name = "DIR")]
    pub(crate) sessions: Option<PathBuf>,
    /// Language of the interface [default: that of LANG]
    #[arg(long, value_enum)]
    pub(crate) language: Option<LanguageName>,
    #[command(flatten)]
    pub(crate) store: StoreFile,
    /// Additional arguments of every `calot run`, e.g. -- --mute
    #[arg(last = true, value_name = "RUN ARGS")]
    pub(crate) more: Vec<OsString>,
}

impl Default for StartArgs {
    fn default() -> Self {
        /// Takes the defaults that `calot start` has without arguments.
        #[derive(clap::Parser)]
        struct Alone {
            #[command(flatten)]
            start: StartArgs,
        }
        <Alone as clap::Parser>::parse_from(["calot"]).start
    }
}
