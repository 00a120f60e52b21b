//! Error messages of the launcher in the user's language. Messages from the system and about the
//! contents of a file are inserted untranslated.

use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::ExitStatus;

use display_host::words::Words;
use hardware::HardwareError;
use store::StoreError;

/// Message for an error of the store.
pub(super) fn of_store(words: &Words, error: &StoreError) -> String {
    let with = |id, path: &Path, problem: &dyn std::fmt::Display| {
        let path = path.display().to_string().into();
        let values = [("path", path), ("problem", problem.to_string().into())];
        words.say_with(id, &values)
    };
    match error {
        StoreError::Io { path, source } => with("store-io", path, source),
        StoreError::Missing { path } => with("store-missing", path, &""),
        StoreError::SameFile { other, .. } => with("store-same", other, &""),
        StoreError::NotAStore { path } => with("store-foreign", path, &""),
        StoreError::Version { path, found } => with("store-version", path, found),
        StoreError::Damaged { path, problem } => with("store-damaged", path, problem),
        StoreError::Busy { path } => with("store-busy", path, &""),
        StoreError::Log { path, mode } => with("store-log", path, mode),
        StoreError::Sqlite { path, source } => with("store-sqlite", path, source),
        StoreError::NoTrainee(name) => {
            words.say_with("store-no-trainee", &[("name", name.as_str().into())])
        }
        StoreError::NoSession(_) => words.say("store-no-session"),
        StoreError::Taken { .. } => words.say("store-taken"),
        StoreError::Forgotten { .. } => words.say("store-forgotten"),
        StoreError::Value { value, .. } => {
            words.say_with("store-value", &[("value", value.as_str().into())])
        }
        StoreError::Questionnaire(problem) => {
            words.say_with("store-questions", &[("problem", problem.as_str().into())])
        }
        StoreError::Sheet(problem) => {
            words.say_with("store-sheet", &[("problem", problem.as_str().into())])
        }
        StoreError::Rated {
            rater,
            sheet,
            session,
        } => {
            let values = [
                ("rater", rater.as_str().into()),
                ("sheet", sheet.as_str().into()),
                ("session", session.as_str().into()),
            ];
            words.say_with("store-rated", &values)
        }
    }
}

/// Message for a name that the store refuses.
pub(super) fn of_name(words: &Words, error: &StoreError) -> String {
    match error {
        StoreError::Value { value, .. } => {
            words.say_with("store-name", &[("name", value.as_str().into())])
        }
        other => of_store(words, other),
    }
}

/// Message for a new name that is easily confused with a known one.
pub(super) fn of_alike(words: &Words, name: &str, known: &str) -> String {
    let values = [("name", name.into()), ("known", known.into())];
    words.say_with("store-alike", &values)
}

/// Message for a station file that cannot be used.
pub(super) fn of_station_file(words: &Words, error: &HardwareError) -> String {
    match error {
        HardwareError::NoStationFile { path } => {
            let path = path.display().to_string().into();
            words.say_with("station-file-none", &[("path", path)])
        }
        HardwareError::Line { path, what, .. } => {
            let path = path.display().to_string().into();
            let values = [("path", path), ("problem", what.as_str().into())];
            words.say_with("station-file-unread", &values)
        }
        HardwareError::Station { path, line, what } => {
            let values = [
                ("path", path.display().to_string().into()),
                ("line", line.to_string().into()),
                ("problem", what.as_str().into()),
            ];
            words.say_with("station-file-wrong", &values)
        }
        other => other.to_string(),
    }
}

/// Message for a session's folder that cannot be made.
pub(super) fn of_folder(words: &Words, path: &Path, error: &std::io::Error) -> String {
    let path = path.display().to_string().into();
    let values = [("path", path), ("problem", error.to_string().into())];
    words.say_with("start-no-folder", &values)
}

/// Message for a process that cannot start.
pub(super) fn of_start(words: &Words, error: &std::io::Error) -> String {
    words.say_with("start-no-process", &[("problem", error.to_string().into())])
}

/// Message for an operation without debrief: the path of its recording, and the command that adds
/// it to the store.
pub(super) fn of_recorded(words: &Words, path: &Path) -> String {
    let path = path.display().to_string().into();
    words.say_with("failed-recorded", &[("path", path)])
}

/// Message for the exit status of a process.
pub(super) fn of_end(words: &Words, status: ExitStatus) -> String {
    let (id, number) = match (status.code(), status.signal()) {
        (Some(code), _) => ("failed-code", code),
        (None, signal) => ("failed-signal", signal.unwrap_or(0)),
    };
    words.say_with(id, &[("number", number.to_string().into())])
}

#[cfg(test)]
mod tests {
    use display_host::words::Language;

    use super::*;

    #[test]
    fn every_problem_has_a_message_with_its_values_in_every_language() {
        let path = || Path::new("/here").to_owned();
        let io = || std::io::Error::other("the system's words");
        let stores = [
            StoreError::Io {
                path: path(),
                source: io(),
            },
            StoreError::Missing { path: path() },
            StoreError::NotAStore { path: path() },
            StoreError::Version {
                path: path(),
                found: 7,
            },
            StoreError::Damaged {
                path: path(),
                problem: "page 3".to_owned(),
            },
            StoreError::Busy { path: path() },
            StoreError::Log {
                path: path(),
                mode: "wal".to_owned(),
            },
            StoreError::NoTrainee("Ada".to_owned()),
            StoreError::NoSession("s".to_owned()),
            StoreError::Taken {
                session: "s".to_owned(),
            },
            StoreError::Forgotten {
                session: "s".to_owned(),
            },
            StoreError::Questionnaire("line 3".to_owned()),
            StoreError::Sheet("line 3".to_owned()),
            StoreError::SameFile {
                into: path(),
                other: path(),
            },
            StoreError::Rated {
                rater: "Bo".to_owned(),
                sheet: "goals".to_owned(),
                session: "s".to_owned(),
            },
            store::check_name("").expect_err("no name"),
        ];
        let files = [
            HardwareError::NoStationFile { path: path() },
            HardwareError::Line {
                path: path(),
                doing: "reading",
                what: "gone".to_owned(),
            },
            HardwareError::Station {
                path: path(),
                line: 12,
                what: "magic".to_owned(),
            },
        ];
        let said = |language| {
            let words = &Words::new(language);
            let mut said: Vec<String> = stores.iter().map(|it| of_store(words, it)).collect();
            said.extend(files.iter().map(|it| of_station_file(words, it)));
            said.push(of_folder(words, Path::new("/here"), &io()));
            said.push(of_start(words, &io()));
            said.push(of_alike(words, "ada", "Ada"));
            said.push(of_recorded(words, Path::new("/here")));
            said.push(of_end(words, ExitStatus::from_raw(1 << 8)));
            said.push(of_end(words, ExitStatus::from_raw(9)));
            said.push(of_name(words, &store::check_name("").expect_err("no name")));
            said
        };
        let (english, german) = (said(Language::English), said(Language::German));
        for (english, german) in english.iter().zip(&german) {
            assert_ne!(english, german);
            for id in ["store-", "station-file-", "start-no", "failed-"] {
                assert!(!english.contains(id), "{english}");
            }
        }
        for (number, named) in [
            (0, "/here"),
            (0, "the system's words"),
            (3, "7"),
            (13, "/here"),
            (14, "Bo"),
            (18, "12"),
        ] {
            assert!(german[number].contains(named), "{}", german[number]);
        }
    }
}
