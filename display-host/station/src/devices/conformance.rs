//! `calot devices conformance`: tests a real device with the suite that the emulated devices pass.

use std::process::ExitCode;
use std::time::Duration;

use hardware::HardwareError;
use hardware::conformance::{self, Check, CheckOutcome, Options, Report};
use hardware::hapi::pantograph::Pantograph;
use hardware::pedal::{EvdevPedal, ModemPedal, Roles};
use serde_json::json;

use super::args::{ConformanceArgs, LineDriver};
use crate::document;
use crate::problem::Problem;
use crate::say;

pub(super) fn run(args: &ConformanceArgs) -> Result<ExitCode, Problem> {
    say::keep_answers_apart()?;
    let seconds = Duration::try_from_secs_f64(args.seconds)?;
    if !args.json {
        say::note(format_args!(
            "Testing {}: about {:.0} s. It commands no force except zero.",
            args.path.display(),
            args.seconds * 2.0 + 4.0
        ));
    }
    let mut ask = || say::note("Pull the plug now.");
    let mut options = Options {
        watch: seconds,
        unplug: args.unplug.then_some(&mut ask),
    };
    let path = &args.path;
    let report = match args.driver {
        LineDriver::Rig => match hardware::rig::RigHaptic::open(path).map(drop) {
            // The device reports its kind. If it is no haptic device, test a pedal.
            Err(HardwareError::WrongDevice { .. }) => conformance::pedal(path, &mut options),
            _ => conformance::haptic(path, &mut options),
        },
        LineDriver::Woody => conformance::woody(path, &mut options),
        LineDriver::HapiGen2 => conformance::hapi(path, Pantograph::GEN2, &mut options),
        LineDriver::HapiGen3 => conformance::hapi(path, Pantograph::GEN3, &mut options),
        LineDriver::HapiGen31 => conformance::hapi(path, Pantograph::GEN3_1, &mut options),
        LineDriver::Touch => conformance::touch(path, None, &mut options),
        LineDriver::ForceDimension => conformance::force_dimension(path, None, &mut options),
        LineDriver::Evdev => {
            let attempt = || EvdevPedal::open(path, Roles::default());
            conformance::pedal_by(&attempt, &mut options)
        }
        LineDriver::Modem => conformance::pedal_by(&|| ModemPedal::open(path), &mut options),
        LineDriver::Inverse3 => conformance::inverse3(path, &mut options),
        LineDriver::Bird => conformance::tracker(path, &mut options),
        LineDriver::Trakstar => conformance::trakstar(path, &mut options),
    };
    if args.json {
        document::CONFORMANCE.line(as_json(&report))?;
    } else {
        say::answer(report.to_string().trim_end());
        let open = report.names(CheckOutcome::NotJudged);
        let first = report.checks.first();
        if first
            .is_some_and(|it| it.outcome == CheckOutcome::Fail && it.detail.contains("no answer"))
            && args.driver.is_serial()
            && args.driver != LineDriver::Rig
        {
            say::note("The device may speak another protocol: try without `--driver`");
        } else if report.passed() {
            say::note(next_step(&report));
        } else if !open.is_empty() {
            say::note(format_args!(
                "Not judged, which is no pass: {}. Test again.",
                open.join(", ")
            ));
        }
    }
    Ok(if report.passed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Sentence about a device that passed, with the next command.
fn next_step(report: &Report) -> &'static str {
    let is_haptic = report.check("freedom").is_some();
    match is_haptic {
        true => {
            "It speaks the protocol as the station needs it. Next: `calot devices feel` tests axes and \
             forces"
        }
        false => {
            "It does what the station needs. Next: name it in a station file (`calot devices --help` has \
             an example)"
        }
    }
}

pub(super) fn as_json(report: &Report) -> serde_json::Value {
    let check = |check: &Check| {
        json!({
            "name": check.name,
            "result": match check.outcome {
                CheckOutcome::Pass => "pass",
                CheckOutcome::Fail => "fail",
                CheckOutcome::NotJudged => "not judged",
                CheckOutcome::Skipped => "skipped",
            },
            "said": check.detail,
        })
    };
    json!({
        "device": report.device,
        "passed": report.passed(),
        "checks": report.checks.iter().map(check).collect::<Vec<_>>(),
    })
}
