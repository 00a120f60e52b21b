//! Options of `calot emulate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hardware::emulate::{HapticModel, Holding, Mistake};

use crate::args::{GamepadArgs, parse_station};

/// Person at the emulated handle.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum HandName {
    /// Scripted hand that works in the scene, or a person who steers it
    Script,
    /// Hand that rests until a person steers it
    Parked,
    /// Nobody: the handle is free, as `calot devices characterise` requires
    None,
    /// Two fingers that tap the middle of the workspace and press it, again and again
    Press,
}

impl From<HandName> for Holding {
    fn from(name: HandName) -> Self {
        match name {
            HandName::Script => Self::Script,
            HandName::Parked => Self::Parked,
            HandName::None => Self::Nobody,
            HandName::Press => Self::Press,
        }
    }
}

/// Handle of the emulated haptic device.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum HandleName {
    /// Stylus with two buttons, one of which closes the jaws
    Stylus,
    /// Handle that opens and shuts: the jaws follow it, and the fingers feel what they hold
    Opening,
}

impl From<HandleName> for HapticModel {
    fn from(name: HandleName) -> Self {
        match name {
            HandleName::Stylus => Self::TouchRig,
            HandleName::Opening => Self::HandleRig,
        }
    }
}

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
    /// Hand at the handle
    #[arg(long, value_enum, value_name = "WHO", default_value_t = HandName::Script)]
    pub(crate) hand: HandName,
    /// Handle of the haptic device
    #[arg(long, value_enum, value_name = "KIND", default_value_t = HandleName::Stylus)]
    pub(crate) handle: HandleName,
    /// Station whose displays may lead the hand by mouse and keyboard
    #[arg(long, value_name = "NAME", value_parser = parse_station)]
    pub(crate) station: Option<String>,
    #[command(flatten)]
    pub(crate) gamepad: GamepadArgs,
    /// Give the haptic device's firmware a mistake, to see how `calot devices` reports it
    #[arg(long, value_name = "NAME", value_parser = parse_mistake)]
    pub(crate) mistake: Option<Mistake>,
    /// Core of the controller's tick. The emulated devices run on other cores [default: the last
    /// core, as of `calot rt`]
    #[arg(long, value_name = "N")]
    pub(crate) tick_core: Option<usize>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}
