//! `calot emulate`: emulates the devices of a station.

pub(crate) mod args;
mod steering;

use std::process::ExitCode;

use hardware::emulate::EmulateConfig;
use rt_process::{realtime, rehearsal};
use shared_mem::scene::SceneFile;

use self::args::EmulateArgs;
use crate::children::READY;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// `SCHED_FIFO` priority of the emulated devices. It is below the tick's default, in case they
/// share a core.
const EMULATOR_PRIORITY: u8 = 70;

/// Emulates the devices until a signal ends the command.
pub(crate) fn run(args: &EmulateArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    let scene = SceneFile::open(&args.scene)?;
    let config = EmulateConfig {
        directory: args.dir.clone(),
        script: rehearsal::script(scene.room()),
        seed: args.seed,
        haptic: args.handle.into(),
        mistake: args.mistake,
        holding: args.hand.into(),
        faults: hardware::emulate::LineFaults::default(),
    };
    // A real device has its own processor, so leave the tick's core alone. If Linux refuses, the
    // emulated devices answer later.
    let cores = realtime::allowed_cores();
    let tick_core = args.tick_core.or(cores.last().copied()).unwrap_or(0);
    let _ = realtime::work_beside_tick(&cores, tick_core, EMULATOR_PRIORITY);
    let mut steering = steering::Steering::new(args)?;
    hardware::emulate::run_steered(&config, &stop, &mut || steering.wish(), &mut |lines| {
        say::answer(format_args!(
            "{READY} {} {} {}",
            lines.haptic.display(),
            lines.tracker.display(),
            lines.pedal.display()
        ));
    })?;
    Ok(ExitCode::SUCCESS)
}
