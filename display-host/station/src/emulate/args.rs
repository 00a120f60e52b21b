//! Options of `calot emulate`.

use std::path::PathBuf;

use clap::Args;
use hardware::emulate::Mistake;

use crate::args::{GamepadArgs, parse_station};

fn parse_mistake(name: &str) -> Result<Mistake, String> {
    let found = Mistake::ALL.into_iter().find(|it| it.name() == name);
    found.ok_or_else(|| {
        let names = Mistake::ALL.map(Mistake::name).join(", ");
        format!("one of: {names}")
    })
}

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
    /// Give the haptic device's firmware a mistake, to see what the tests of devices say
    #[arg(long, value_name = "NAME", value_parser = parse_mistake)]
    pub(crate) mistake: Option<Mistake>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}
