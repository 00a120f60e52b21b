//! Options of `calot emulate`.

use std::path::PathBuf;

use clap::Args;

use crate::args::{GamepadArgs, parse_station};

#[derive(Debug, Clone, Args)]
pub(crate) struct EmulateArgs {
    /// Folder for the devices `haptic`, `tracker` and `pedal` (links to ptys)
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: PathBuf,
    /// Compiled scene (.calot) that the scripted hand works in
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// Seed of the hand's tremor and of injected faults
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Station whose displays may lead the hand by mouse and keyboard
    #[arg(long, value_name = "NAME", value_parser = parse_station)]
    pub(crate) station: Option<String>,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}
