//! `calot devices characterise`: measures a haptic device and compares it with what it declares.

mod clock;
mod page;
mod place;
mod table;

use std::path::Path;
use std::process::ExitCode;

use hardware::HardwareError;
use hardware::characterise::{
    Characterised, FORCE_N, Halt, Options, Place, Records, Wall, echo_s, measure, wall,
};
use hardware::rig::RigHaptic;
use hardware::station::{HapticDriver, HapticSpec, Limits, StationFile};
use rt_core::port::HapticDevice;
use rt_process::realtime;
use rt_process::time_driver::now_ns;

use self::clock::RealClock;
use super::args::{AxisName, CharacteriseArgs};
use super::open::haptic_spec;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// `SCHED_FIFO` priority of the measurement: the default of the tick.
const PRIORITY: u8 = 80;
/// Time that a person gets to let the handle go, s.
const LET_GO_S: f64 = 3.0;
/// File in the folder of `--out` with the charts.
const PAGE: &str = "characterise.html";
/// File in the folder of `--out` with all figures.
const FIGURES: &str = "characterise.json";

pub(super) fn run(args: &CharacteriseArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    say::keep_answers_apart()?;
    let folder = args
        .out
        .as_deref()
        .map(|folder| output::folder(Some(folder), "", format_of, args.overwrite));
    let folder = folder.transpose()?;
    let spec = spec(args)?;
    let mut clock = RealClock::new(stop);
    // The experiments have a thread of their own, so that only they have the tick's priority.
    let experiments = std::thread::scope(|scope| {
        let experiments = scope.spawn(|| {
            // If Linux refuses the priority, steps may be late. The records hold their real times.
            let _ = realtime::take_fifo(PRIORITY);
            experiments(args, &spec, &mut clock)
        });
        experiments.join()
    });
    let made = match experiments
        .map_err(|_| "the thread of the experiments panicked; please report this")?
    {
        Ok(Some(made)) => made,
        Ok(None) | Err(HardwareError::Halted(Halt::Asked)) => {
            say::note("Stopped. The force is zero.");
            return Ok(ExitCode::FAILURE);
        }
        Err(HardwareError::Halted(halt)) => {
            return Err(format!("{}: {halt}", spec.path.display()).into());
        }
        Err(error) => return Err(error.into()),
    };
    say::note("Fitting the models.");
    let found = made.analyse();
    let json = document::CHARACTERISTICS.of(table::json(&spec.path, &found));
    let json = serde_json::to_string(&json)?;
    if args.json {
        say::answer(&json);
    } else {
        say::answer(table::text(&found));
    }
    if let Some(folder) = folder {
        save(&folder, &page::html(&spec.path, &found)?, &json)?;
    }
    let walls = [&found.wall, &found.opening_wall].into_iter().flatten();
    let measured_any = found.measured().next().is_some()
        || matches!(found.opening, Some(Ok(_)))
        || walls.map(|wall| wall.trials.len()).sum::<usize>() > 0;
    Ok(if measured_any {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Format of a file that the command writes under this name.
fn format_of(name: &str) -> Option<Format> {
    match name {
        PAGE => Some(Format::Page),
        FIGURES => Some(Format::Json),
        _ => None,
    }
}

fn save(folder: &Path, page: &str, json: &str) -> Result<(), Problem> {
    for (name, text) in [(PAGE, page), (FIGURES, json)] {
        let path = folder.join(name);
        output::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// The device that the arguments name, with the damping and delay that it declares itself and
/// without a motion scale.
fn spec(args: &CharacteriseArgs) -> Result<HapticSpec, Problem> {
    if let Some(file) = &args.station_file {
        let named = StationFile::read(file)?.haptic;
        let named = named
            .ok_or_else(|| format!("{}: names no haptic device; add a [haptic]", file.display()))?;
        return Ok(HapticSpec {
            motion_scale: None,
            limits: Limits {
                damping_n_s_m: None,
                delay_s: None,
                ..named.limits
            },
            ..named
        });
    }
    let path = args.path.as_deref();
    let path = path.ok_or("name a PATH, or a --station-file")?;
    Ok(haptic_spec(path, args.driver)?)
}

/// Records of all experiments.
struct Made {
    records: Records,
    echo_s: Option<f64>,
    wall: Option<Wall>,
    opening_wall: Option<Wall>,
}

impl Made {
    fn analyse(self) -> Characterised {
        Characterised {
            echo_s: self.echo_s,
            wall: self.wall,
            opening_wall: self.opening_wall,
            ..self.records.analyse()
        }
    }
}

/// Runs all experiments. Returns `None` if nobody pressed Enter to begin.
fn experiments(
    args: &CharacteriseArgs,
    spec: &HapticSpec,
    clock: &mut RealClock,
) -> Result<Option<Made>, HardwareError> {
    let mut tell = |line: &str| say::note(line);
    let mut echo = None;
    if spec.driver == HapticDriver::Rig {
        let mut rig = RigHaptic::open(&spec.path)?;
        echo = echo_s(&mut rig, clock)?;
    }
    spec.check_felt()?;
    let mut device = spec.open()?;
    let is_asked = |axis: AxisName| args.axis.is_empty() || args.axis.contains(&axis);
    let options = Options {
        axes: [AxisName::X, AxisName::Y, AxisName::Z].map(is_asked),
        opening: is_asked(AxisName::Opening),
        force_n: args.force,
        let_go_s: if args.yes { 0.0 } else { LET_GO_S },
        ..Options::default()
    };
    let can = device.capabilities();
    if args.axis.contains(&AxisName::Opening) && !can.opening.is_measured() {
        say::note("This handle declares no opening.");
    }
    let mut made = Made {
        records: Records::none(device.as_ref()),
        echo_s: echo,
        wall: None,
        opening_wall: None,
    };
    if !args.only_wall {
        explain(device.as_mut(), &options, &spec.path);
        if !args.yes && !is_begun(device.as_mut(), clock) {
            return Ok(None);
        }
        made.records = measure(device.as_mut(), clock, &options, &mut tell)?;
    }
    if !(args.wall || args.only_wall) {
        return Ok(Some(made));
    }
    if options.axes.contains(&true) {
        let Some(found) = pressed(args, device.as_mut(), clock, Place::Workspace)? else {
            return Ok(None);
        };
        made.wall = Some(found);
    }
    if options.opening && can.opening.is_rendered() {
        let Some(found) = pressed(args, device.as_mut(), clock, Place::Opening)? else {
            return Ok(None);
        };
        made.opening_wall = Some(found);
    }
    Ok(Some(made))
}

/// Lets a person press walls. Returns `None` if nobody pressed Enter to begin.
fn pressed(
    args: &CharacteriseArgs,
    device: &mut dyn HapticDevice,
    clock: &mut RealClock,
    place: Place,
) -> Result<Option<Wall>, Halt> {
    say::note(match place {
        Place::Workspace => {
            "Now a hand: hold the handle lightly, above the middle of its workspace. Tap the wall in the \
             middle, press it gently for a second, lift the handle. Each wall is stiffer. A wall that buzzes is \
             gone at once. Enter or Ctrl-C ends everything."
        }
        Place::Opening => {
            "Now fingers: open the handle, shut it to its half, and squeeze the wall there gently for a second. \
             Open it again. Each wall is stiffer. A wall that buzzes is gone at once. Enter or Ctrl-C ends \
             everything."
        }
    });
    if !args.yes {
        say::note("Press Enter to begin.");
        if !is_begun(device, clock) {
            return Ok(None);
        }
    }
    let found = wall(device, clock, place, args.force, &mut |line| {
        say::note(line);
    })?;
    Ok(Some(found))
}

/// Tells the person what will happen, for how long, and what to do.
fn explain(device: &mut dyn HapticDevice, options: &Options, path: &Path) {
    let can = device.capabilities();
    let allowed_n = f64::from(can.force_continuous_n.min(0.5 * can.force_max_n));
    let force_n = options.force_n.unwrap_or(FORCE_N.min(allowed_n));
    let opens = options.opening && can.opening.is_measured();
    let seconds = 12
        + 14 * options
            .axes
            .iter()
            .chain([&opens])
            .filter(|it| **it)
            .count();
    say::note(format_args!(
        "Measures {}: about {seconds} s.\n\
         Forces up to {force_n:.2} N will move the handle by a few centimetres. Keep the switch of the device \
         within reach, and hands and faces away.\n\
         Put the handle in the middle of its workspace. If it falls, hold it there until you are asked to let go.\n\
         Enter or Ctrl-C ends everything at any time, without force.",
        path.display()
    ));
    if opens {
        say::note("The handle will open and shut by itself: keep fingers out of it.");
    }
    if options.let_go_s > 0.0 {
        say::note("Press Enter to begin.");
    }
}

/// Waits for Enter, and drops the samples that came during the wait. Returns false on Ctrl-C, and
/// if nobody can press Enter.
fn is_begun(device: &mut dyn HapticDevice, clock: &RealClock) -> bool {
    let begins = clock.wait_for_enter();
    device.poll(now_ns());
    begins
}

#[cfg(test)]
mod tests;
