//! `calot devices feel`: a person, or a program with a sensor, tests axes, units and signs before
//! anybody trusts a device.

mod pace;
mod page;
mod script;
mod terminal;
mod weight;
mod window;

use std::path::Path;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

use hardware::conformance::{CheckOutcome, Report};
use hardware::feel::{Felt, Guide, feel};
use hardware::station::{HapticSpec, StationFile};
use rt_core::port::HapticDevice;

use super::args::FeelArgs;
use super::conformance::as_json;
use super::open::open_haptic;
use super::sections::{Section, with_sections};
use crate::args::LanguageName;
use crate::clock::now_unix_s;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::report::utc;
use crate::say;
use crate::stop;

pub(super) fn run(args: &FeelArgs) -> Result<ExitCode, Problem> {
    if args.window {
        window::check()?;
    }
    let stop = stop::flag()?;
    say::keep_answers_apart()?;
    if let Some(page) = &args.page {
        output::check("--page", page, Format::Page, args.overwrite)?;
    }
    if let Some(out) = &args.out {
        output::check("--out", out, Format::Station, args.overwrite)?;
    }
    let text = args.station_file.as_deref().map(read).transpose()?;
    let mut device = opened(args, text.as_deref())?;
    if args.script.is_none() && !args.json {
        say::note(
            "This takes about four minutes. Forces are 0.5 N at most, once 2 N, and 1 N on the fingers of a \
             handle that opens. Ctrl-C ends them at once.",
        );
    }
    let seed = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs();
    let passed = if args.window {
        let language = LanguageName::or_users(args.language);
        let bench = window::Bench { device, seed, stop };
        window::lead(bench, language, |felt| report(args, text.as_deref(), felt))?
    } else {
        let mut guide: Box<dyn Guide> = match &args.script {
            Some(program) => Box::new(script::Script::start(program, stop)?),
            None => Box::new(terminal::Terminal::new(stop)),
        };
        let felt = feel(&mut *device, &mut *guide, seed);
        drop(device);
        report(args, text.as_deref(), &felt)?;
        felt.report.passed()
    };
    Ok(match passed {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn read(file: &Path) -> Result<String, Problem> {
    Ok(std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?)
}

/// Opens the device that the arguments name, without a motion scale: the test measures real
/// distances.
fn opened(args: &FeelArgs, text: Option<&str>) -> Result<Box<dyn HapticDevice + Send>, Problem> {
    match (&args.path, &args.station_file, text) {
        (Some(path), _, _) => Ok(open_haptic(path, args.driver)?),
        (None, Some(file), Some(text)) => {
            let spec = StationFile::parse(text, file)?.haptic;
            let spec = spec.ok_or("the station file names no haptic device")?;
            let unscaled = HapticSpec {
                motion_scale: None,
                ..spec
            };
            Ok(unscaled.open()?)
        }
        _ => Err("name a PATH, or a --station-file".into()),
    }
}

fn report(args: &FeelArgs, text: Option<&str>, felt: &Felt) -> Result<(), Problem> {
    let section = section(&felt.report);
    if args.json {
        document::CONFORMANCE.line(as_json(&felt.report))?;
    } else {
        say::answer(felt.report.to_string().trim_end());
    }
    if let Some(path) = &args.page {
        output::write(path, &page::page(felt))?;
        say::note(format_args!("wrote {}", path.display()));
    }
    match (&args.out, text) {
        (Some(out), Some(text)) => {
            output::write(out, &with_sections(out, text, &[section])?)?;
            say::note(format_args!("wrote {}", out.display()));
        }
        _ if args.json => {}
        _ => say::note(format_args!(
            "\nFor the station file:\n{}",
            section.text().trim_end()
        )),
    }
    Ok(())
}

/// Section of the station file that keeps the result.
fn section(report: &Report) -> Section {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut body = format!(
        "passed = {}\non = {}\ndevice = {}\n",
        report.passed(),
        quoted(&utc(now_unix_s().cast_unsigned())),
        quoted(&report.device)
    );
    let mut failed = report.names(CheckOutcome::Fail);
    failed.extend(report.names(CheckOutcome::NotJudged));
    if !failed.is_empty() {
        let failed: Vec<String> = failed.into_iter().map(quoted).collect();
        body += &format!("failed = [{}]\n", failed.join(", "));
    }
    Section {
        head: "haptic.felt".to_owned(),
        body,
    }
}
