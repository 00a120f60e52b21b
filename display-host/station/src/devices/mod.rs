//! `calot devices`: lists devices, shows their samples, tests and measures them, and finds their
//! positions.

pub(crate) mod args;
mod calibrate;
mod characterise;
mod conformance;
mod feel;
mod open;
mod samples;
mod sections;
mod typed;
mod watch;

use std::process::ExitCode;

use hardware::list::{Found, devices};
use serde_json::json;

use crate::document;
use crate::problem::Problem;
use crate::say;
use args::{DevicesArgs, DevicesCommand, DevicesListArgs};

pub(crate) fn run(args: &DevicesArgs) -> Result<ExitCode, Problem> {
    match &args.command {
        None => list(&args.list),
        Some(DevicesCommand::List(args)) => list(args),
        Some(DevicesCommand::Watch(args)) => watch::run(args),
        Some(DevicesCommand::Conformance(args)) => conformance::run(args),
        Some(DevicesCommand::Feel(args)) => feel::run(args),
        Some(DevicesCommand::Calibrate(args)) => calibrate::run(args),
        Some(DevicesCommand::Characterise(args)) => characterise::run(args),
    }
}

fn list(args: &DevicesListArgs) -> Result<ExitCode, Problem> {
    let found = devices();
    if args.json {
        let found: Vec<_> = found.iter().map(as_json).collect();
        document::DEVICES.line(json!({ "devices": found }))?;
        return Ok(ExitCode::SUCCESS);
    }
    for device in &found {
        let guess = device.guess.unwrap_or("not known to Calot");
        say::answer(format_args!(
            "{}\n  {}\n  {guess}",
            name_that_stays(device),
            device.name
        ));
    }
    if found.is_empty() {
        say::note(
            "found no serial line and no input device that this user may open. Plug one in. If you lack rights \
             to it: `sudo usermod -aG dialout,input $USER`, then log in again",
        );
    } else {
        say::note(
            "\nNext: `calot devices watch PATH` shows a device live, `calot devices conformance PATH` tests its \
             protocol, `calot devices feel PATH` its axes and forces",
        );
    }
    Ok(ExitCode::SUCCESS)
}

/// Path for a station file: udev's stable path, if there is one, which does not depend on the order
/// of plugging in.
fn name_that_stays(device: &Found) -> String {
    let now = device.path.display();
    match &device.stable_path {
        Some(stable) => format!("{} (now {now})", stable.display()),
        None => now.to_string(),
    }
}

fn as_json(device: &Found) -> serde_json::Value {
    json!({
        "path": device.path,
        "stable_path": device.stable_path,
        "name": device.name,
        "guess": device.guess,
    })
}
