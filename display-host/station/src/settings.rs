//! Settings that last from one start to the next: language, look, mouse and keyboard, sound. A file
//! in the user's configuration folder keeps them. Options of the command line override it.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use display_host::ui::{Look, Settings};
use display_host::words::Language;

use crate::home;
use crate::say;

/// Allowed sizes of text, per cent.
const TEXT_PERCENT: RangeInclusive<u16> = 80..=200;
/// Allowed sensitivities, per cent.
const SENSITIVITY_PERCENT: RangeInclusive<u16> = 25..=400;

/// Content of the file. A missing setting has its default.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
struct Written {
    language: Option<String>,
    text_percent: Option<u16>,
    high_contrast: Option<bool>,
    left_handed: Option<bool>,
    sensitivity_percent: Option<u16>,
    sound: Option<bool>,
}

/// The default settings, overridden by those of the file.
pub(crate) fn kept() -> Settings {
    let kept = path().map(|path| read(&path)).unwrap_or_default();
    let usual = Settings::default();
    let within = |value: Option<u16>, range: RangeInclusive<u16>, usual: u16| {
        value.filter(|it| range.contains(it)).unwrap_or(usual)
    };
    Settings {
        language: kept.language().unwrap_or(usual.language),
        look: Look {
            text_percent: within(kept.text_percent, TEXT_PERCENT, usual.look.text_percent),
            high_contrast: kept.high_contrast == Some(true),
            left_handed: kept.left_handed == Some(true),
            sensitivity_percent: within(
                kept.sensitivity_percent,
                SENSITIVITY_PERCENT,
                usual.look.sensitivity_percent,
            ),
        },
        sound: kept.sound != Some(false),
    }
}

/// Language of the file, if it names one.
pub(crate) fn language() -> Option<Language> {
    path().and_then(|path| read(&path).language())
}

impl Written {
    fn language(&self) -> Option<Language> {
        let code = self.language.as_deref()?;
        Language::ALL.into_iter().find(|it| it.code() == code)
    }
}

/// Writes the settings to the file. A failure is only a warning: the settings then end with the
/// window.
pub(crate) fn keep(settings: &Settings) {
    let Some(path) = path() else { return };
    if let Err(error) = write(&path, settings) {
        say::note(format_args!(
            "warning: {}: {error}; the settings end with this window",
            path.display()
        ));
    }
}

fn path() -> Option<PathBuf> {
    Some(home::config()?.join("settings.toml"))
}

/// Content of the file. A file that cannot be used gives a warning and counts as empty.
fn read(path: &Path) -> Written {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Written::default(),
        Err(error) => return unused(path, &error),
    };
    toml::from_str(&text).unwrap_or_else(|error| unused(path, &error))
}

fn unused(path: &Path, why: &dyn core::fmt::Display) -> Written {
    let why = why.to_string();
    say::note(format_args!(
        "warning: {}: {}; the default settings apply. Remove the file, or mend it",
        path.display(),
        why.trim_end()
    ));
    Written::default()
}

/// Replaces the file by a rename, so that a reader finds the whole old file or the whole new one.
fn write(path: &Path, settings: &Settings) -> Result<(), String> {
    let look = settings.look;
    let written = Written {
        language: Some(settings.language.code().to_owned()),
        text_percent: Some(look.text_percent),
        high_contrast: Some(look.high_contrast),
        left_handed: Some(look.left_handed),
        sensitivity_percent: Some(look.sensitivity_percent),
        sound: Some(settings.sound),
    };
    let text = toml::to_string(&written).map_err(|error| error.to_string())?;
    let said = |error: std::io::Error| error.to_string();
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(said)?;
    }
    let new = path.with_extension(format!("new-{}", std::process::id()));
    std::fs::write(&new, text).map_err(said)?;
    std::fs::rename(&new, path).map_err(said)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calot").join("settings.toml");
        assert_eq!(read(&path), Written::default(), "there is none yet");
        let own = Settings {
            language: Language::German,
            look: Look {
                text_percent: 150,
                high_contrast: true,
                left_handed: true,
                sensitivity_percent: 75,
            },
            sound: false,
        };
        write(&path, &own).unwrap();
        let kept = read(&path);
        assert_eq!(kept.language.as_deref(), Some("de"));
        assert_eq!(
            (kept.text_percent, kept.sensitivity_percent),
            (Some(150), Some(75))
        );
        assert_eq!([kept.high_contrast, kept.left_handed], [Some(true); 2]);
        assert_eq!(kept.sound, Some(false));
        assert_eq!(
            std::fs::read_dir(folder.path().join("calot"))
                .unwrap()
                .count(),
            1
        );
    }

    #[test]
    fn a_file_that_cannot_be_used_counts_as_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        std::fs::write(&path, "text_percent = \"large\"").unwrap();
        assert_eq!(read(&path), Written::default());
        std::fs::write(&path, "of_a_later_version = 1\nsound = false").unwrap();
        assert_eq!(read(&path).sound, Some(false));
        let taken = folder.path().join("settings.toml").join("below");
        assert!(write(&taken, &Settings::default()).is_err());
    }
}
