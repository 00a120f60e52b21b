//! Devices on the start screen: those that the station file names, with their state, and those
//! plugged in.

use std::path::Path;

use display_host::ui::launcher::{DeviceLine, DeviceState, Start};
use display_host::words::Words;
use hardware::list::Found;
use hardware::station::StationFile;

use super::problem;

/// Updates the devices on the start screen.
pub(super) fn look(start: &mut Start, words: &Words) {
    let form = &start.form;
    let file = match (form.emulated, form.station_file.trim()) {
        (true, _) => Ok(StationFile::default()),
        (false, "") => Err(words.say("start-no-file")),
        (false, path) => {
            StationFile::read(Path::new(path)).map_err(|it| problem::of_station_file(words, &it))
        }
    };
    start.station_file_problem = file.as_ref().err().cloned();
    start.devices = file.as_ref().map(lines).unwrap_or_default();
    start.plugged_in = hardware::list::devices()
        .iter()
        .map(path_in_words)
        .collect();
}

/// Path of a device. If udev has a stable path for it, also the name in that path.
fn path_in_words(found: &Found) -> String {
    let path = found.path.display();
    match found.stable_path {
        Some(_) => format!("{} ({path})", found.name),
        None => path.to_string(),
    }
}

fn lines(file: &StationFile) -> Vec<DeviceLine> {
    let paths = [
        ("device-haptic", file.haptic.as_ref().map(|it| &it.path)),
        ("device-tracker", file.tracker.as_ref().map(|it| &it.path)),
        ("device-pedal", file.pedal.as_ref().map(|it| &it.path)),
    ];
    let line = |(name, path): (&'static str, Option<&std::path::PathBuf>)| DeviceLine {
        name,
        state: path.map_or(DeviceState::Emulated, |path| state(path)),
    };
    paths.into_iter().map(line).collect()
}

fn state(path: &Path) -> DeviceState {
    let shown = path.display().to_string();
    // A service address and a USB unit number are no paths.
    match (path.is_absolute(), path.exists()) {
        (false, _) => DeviceState::Named(shown),
        (true, true) => DeviceState::There(shown),
        (true, false) => DeviceState::Missing(shown),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_device_is_there_or_missing_and_an_unnamed_one_is_emulated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("station.toml");
        let there = folder.path().join("ttyRIG");
        std::fs::write(&there, "").unwrap();
        let text = format!(
            "[haptic]\ndriver = \"rig\"\npath = \"{}\"\n\n[tracker]\ndriver = \"bird\"\npath = \"/nowhere/bird\"\n",
            there.display()
        );
        std::fs::write(&path, text).unwrap();
        let words = Words::default();
        let mut start = Start::default();
        start.form.station_file = path.display().to_string();
        look(&mut start, &words);
        let states: Vec<_> = start.devices.iter().map(|it| it.state.clone()).collect();
        assert_eq!(
            states,
            [
                DeviceState::There(there.display().to_string()),
                DeviceState::Missing("/nowhere/bird".to_owned()),
                DeviceState::Emulated
            ]
        );
        assert_eq!(start.station_file_problem, None);

        std::fs::write(&path, "[haptic]\ndriver = \"magic\"\n").unwrap();
        look(&mut start, &words);
        assert!(
            start
                .station_file_problem
                .as_ref()
                .is_some_and(|it| it.contains("magic"))
        );
        // Never read a file that blocks or has no end.
        for path in ["/dev/zero", "/dev/ptmx", "/"] {
            start.form.station_file = path.to_owned();
            look(&mut start, &words);
            let problem = start.station_file_problem.take().unwrap();
            assert!(problem.contains("not a station file"), "{problem}");
        }
        start.form.station_file.clear();
        look(&mut start, &words);
        let no_file = words.say("start-no-file");
        assert_eq!(start.station_file_problem, Some(no_file));
        start.form.emulated = true;
        look(&mut start, &words);
        assert_eq!(start.station_file_problem, None);
        assert!(
            start
                .devices
                .iter()
                .all(|it| it.state == DeviceState::Emulated)
        );
    }
}
