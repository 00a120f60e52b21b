//! Results of the run: summary, report, debrief, animation.

use std::path::{Path, PathBuf};

use display_host::headless::{Ended, RunOutcome};
use display_host::kept::VIEWS;
use display_host::report::{DeviceSummary, HeldBack, Summary, write};
use display_host::words::Language;
use figures::Machine;
use hardware::station::{HapticDriver, StationFile};
use rt_process::notice::{Held, Line};
use session::Recorded;

use super::show::Shown;
use crate::args::{DeviceArgs, LanguageName};
use crate::document;
use crate::problem::Problem;
use crate::report;
use crate::say;
use crate::task;

/// A finished run.
pub(super) struct Finished {
    /// True if the run reached its end, no process failed, and all results are written.
    pub(super) whole: bool,
}

impl Shown<'_> {
    pub(super) fn finish(mut self) -> Result<Finished, Problem> {
        let mut summary = self.summary()?;
        let is_lost = matches!(
            self.outcome.ended,
            Ended::ControllerGone | Ended::DisplayLost
        );
        // A requested recording that is missing or incomplete is a failure.
        let is_recorded = |it: &Recorded| it.problem.is_none();
        let mut whole = self.dead.is_empty()
            && !is_lost
            && !self.recorder_panicked
            && summary.recording.as_ref().is_none_or(is_recorded);
        whole &= self.keep(&mut summary);
        whole &= self.write(&summary)?;
        if let Some(told) = self.told.take() {
            told.end();
        }
        if self.args.json {
            document::SUMMARY.answer(&summary)?;
        }
        for warning in &self.outcome.warnings {
            say::note(format_args!("calot: {warning}"));
        }
        // The animation is written last, so that the other results do not wait for it.
        if let Some(gif) = &self.args.gif
            && let Err(problem) = animate(&self.outcome, gif)
        {
            say::note(format_args!("warning: no animation: {problem}"));
            whole = false;
        }
        Ok(Finished { whole })
    }

    fn summary(&mut self) -> Result<Summary, Problem> {
        let recorded = self.recorded.take();
        let outcome = &mut self.outcome;
        let warning = recorded.as_ref().and_then(Recorded::warning);
        outcome.warnings.extend(warning);
        if !self.dead.is_empty() {
            outcome.ended = Ended::ProcessDied;
        }
        outcome.warnings.extend(self.dead.iter().cloned());
        let mut summary = self.recorder.summary(&self.scene, outcome, Machine::read());
        summary.case = crate::scene::case(&summary.scene);
        let unrest = summary.unrest.iter().map(|it| it.warning.clone());
        outcome.warnings.extend(unrest);
        outcome.warnings.extend(self.recorder.standstills());
        if let Some(recorded) = &recorded {
            // A controller that died before the display saw a tick has still run these ticks.
            summary.ticks = summary.ticks.max(recorded.ticks);
        }
        for (device, opened) in by_kind(&mut summary.devices, &self.devices) {
            let driver = match opened.kind.as_str() {
                "haptic" => driver(&self.args.controller.devices),
                _ => String::new(),
            };
            *device = DeviceSummary {
                line: device.line,
                driver,
                ..opened.clone()
            };
        }
        let held: Vec<Held> = summary.force_held_back.iter().map(reason).collect();
        let line = summary.devices.iter().find(|it| it.kind == "haptic");
        let line = line.map(|it| Line {
            path: it.path.clone(),
            bad_frames: it.line.bad_frames,
            lost_frames: it.line.lost_frames,
            dropped_writes: it.line.dropped_writes,
            unread_bytes: it.line.unread_bytes,
        });
        if let Some(text) =
            rt_process::notice::held_back(summary.contact_ticks, &held, line.as_ref())
        {
            outcome.warnings.push(text.clone());
            summary.warnings.push(text);
        }
        let haptic = self.devices.iter().find(|it| it.kind == "haptic");
        let haptic = haptic.map(|it| it.path.as_path());
        for (fault, ticks) in &summary.faults {
            if let Some(text) = rt_process::notice::sentence(fault, haptic, 0) {
                summary
                    .warnings
                    .push(format!("{text} ({fault}: {ticks} ticks)"));
            }
        }
        summary.recording = recorded;
        summary.task = self.assessed.as_ref().map(|it| it.summary.clone());
        Ok(summary)
    }

    /// Keeps the session in the store. Returns false if that was requested and failed.
    fn keep(&mut self, summary: &mut Summary) -> bool {
        let Some(assessed) = &self.assessed else {
            return true;
        };
        let Err(problem) = assessed.keep(summary) else {
            return true;
        };
        let warning = format!(
            "not kept in the store: {problem}. The result is in summary.json and debrief.html"
        );
        summary.warnings.push(warning.clone());
        self.outcome.warnings.push(warning);
        false
    }

    /// Writes the files, if there is a folder for them. Returns false if the debrief is missing.
    fn write(&self, summary: &Summary) -> Result<bool, Problem> {
        let Some(out) = &self.out else {
            return Ok(true);
        };
        let json = serde_json::to_string_pretty(&document::SUMMARY.of(summary))?;
        let written = write(out, &json, summary, &self.recorder, &self.outcome)?;
        say::note(format_args!(
            "wrote {} and {}",
            written.summary.display(),
            written.report.display()
        ));
        let recording = summary.recording.as_ref().map(|it| it.file.clone());
        let language = LanguageName::or_users(self.args.language);
        let debriefed = |assessed| debrief(assessed, recording, language, out, &self.outcome);
        Ok(self.assessed.as_ref().is_none_or(debriefed))
    }
}

/// Pairs of the reported devices and the opened ones of the same kind.
fn by_kind<'a>(
    reported: &'a mut [DeviceSummary],
    opened: &'a [DeviceSummary],
) -> impl Iterator<Item = (&'a mut DeviceSummary, &'a DeviceSummary)> {
    reported.iter_mut().filter_map(|device| {
        let found = opened.iter().find(|it| it.kind == device.kind)?;
        Some((device, found))
    })
}

/// Driver of the haptic device, by its name in station files: `rig` for `--haptic`, `emulated` if
/// neither `--haptic` nor a station file names a haptic device, nothing if the station file cannot
/// be read any more.
fn driver(devices: &DeviceArgs) -> String {
    if devices.haptic.is_some() {
        return "rig".to_owned();
    }
    let file = devices.station_file.as_deref().map(StationFile::read);
    let Ok(file) = file.transpose() else {
        return String::new();
    };
    let haptic = file.and_then(|it| it.haptic);
    let name = haptic.map_or("emulated", |it| match it.driver {
        HapticDriver::Rig => "rig",
        HapticDriver::Woody => "woody",
        HapticDriver::Hapi(_) => "hapi",
        HapticDriver::Inverse3 { .. } => "inverse3",
        HapticDriver::Touch { .. } => "touch",
        HapticDriver::ForceDimension { .. } => "force-dimension",
    });
    name.to_owned()
}

fn reason(held: &HeldBack) -> Held {
    Held {
        fault: held.fault.clone(),
        ticks: held.ticks,
        times: held.times,
    }
}

/// Writes the run's evenly spaced pictures as an animation.
fn animate(outcome: &RunOutcome, gif: &Path) -> Result<(), Problem> {
    let is_of_course = |path: &PathBuf| {
        let name = path.file_name().and_then(|it| it.to_str());
        name.is_some_and(|it| it.starts_with("frame_"))
    };
    let pictures = outcome.frames.iter().filter_map(|it| it.path.clone());
    let mut pictures: Vec<PathBuf> = pictures.filter(is_of_course).collect();
    pictures.sort();
    display_host::animation::write_gif(&pictures, gif)?;
    say::note(format_args!(
        "wrote {}: {} pictures",
        gif.display(),
        pictures.len()
    ));
    Ok(())
}

/// Writes the debrief from the recording, as `calot report` does, with this run's pictures. Returns
/// true on success.
fn debrief(
    assessed: &task::Ended,
    session: Option<PathBuf>,
    language: Language,
    out: &Path,
    outcome: &RunOutcome,
) -> bool {
    let made = session
        .ok_or_else(|| Problem::from("nothing was recorded"))
        .and_then(|session| report::chapter(&session, None, None))
        .and_then(|report::Found { mut chapter, .. }| {
            let views = VIEWS.map(|name| out.join(name));
            let drawn = outcome.frames.iter().filter_map(|it| it.path.clone());
            let others = drawn.filter(|it| !views.contains(it));
            // Choose the pictures of the critical view separately, so that they are never left out.
            chapter.pictures = report::chosen(views.iter().cloned());
            chapter.pictures.extend(report::chosen(others));
            chapter.ticks = report::ticks(out);
            chapter.technical = Some("report.html".to_owned());
            if let Err(problem) = assessed.add_past(&mut chapter) {
                say::note(format_args!(
                    "calot: debrief.html without earlier sessions: {problem}"
                ));
            }
            report::write_close(&chapter, out);
            report::write(&[chapter], language, &out.join("debrief.html"))
        });
    if let Err(problem) = &made {
        say::note(format_args!("calot: no debrief.html: {problem}"));
    }
    made.is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_driver_of_a_haptic_device_that_nobody_names_is_emulated() {
        let folder = tempfile::tempdir().unwrap();
        let driver_of = |text: &str| {
            let path = folder.path().join("station.toml");
            std::fs::write(&path, text).unwrap();
            driver(&DeviceArgs {
                station_file: Some(path),
                ..DeviceArgs::default()
            })
        };
        assert_eq!(driver(&DeviceArgs::default()), "emulated");
        let pedal_only = "[pedal]\ndriver = \"rig\"\npath = \"/dev/ttyACM1\"\n";
        assert_eq!(driver_of(pedal_only), "emulated");
        let haptic = "[haptic]\ndriver = \"woody\"\npath = \"/dev/ttyACM0\"\n";
        assert_eq!(driver_of(haptic), "woody");
        let unreadable = DeviceArgs {
            station_file: Some(folder.path().join("none.toml")),
            ..DeviceArgs::default()
        };
        assert_eq!(driver(&unreadable), "");
    }
}
