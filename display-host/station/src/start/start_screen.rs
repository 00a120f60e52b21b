//! The first screen: choices, trainees, scenes, devices, and the trainee's progress.

use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use assess::report::PICTURES_MIN;
use assess::{Difficulty, Task};
use display_host::ui::Settings;
use display_host::ui::launcher::{ProgressView, Screen, Start, StartForm};
use display_host::words::Words;

use super::{Desk, choices, problem, stations};
use crate::curriculum::Progress;
use crate::settings;

/// Largest number of earlier operations whose summaries are searched for a picture rate.
const LOOKED_THROUGH: usize = 20;

impl Desk {
    pub(super) fn show_start(&mut self) {
        let names = |all: &[&str]| all.iter().map(|it| (*it).to_owned()).collect();
        let words = &self.view.words;
        let kept = self.open_store().and_then(|store| {
            let trainees = store.trainees();
            trainees.map_err(|it| problem::of_store(words, &it))
        });
        let mut start = Start {
            form: self.form.clone(),
            trainees: Vec::new(),
            tasks: names(&Task::ALL.map(Task::name)),
            difficulties: names(&Difficulty::ALL.map(Difficulty::name)),
            scopes: choices::SCOPES.to_vec(),
            scenes: choices::scenes(),
            hanging: names(&choices::hanging()),
            shown: names(&choices::shown()),
            store: self.store.as_ref().map_or_else(
                || words.say("store-no-home"),
                |path| path.display().to_string(),
            ),
            problem: None,
            ..Start::default()
        };
        if let Some(own) = self.args.scene.as_ref()
            && !start.scenes.contains(own)
        {
            start.scenes.push(own.clone());
        }
        match kept {
            Ok(trainees) => start.trainees = trainees.into_iter().map(|it| it.name).collect(),
            Err(problem) => start.problem = Some(problem),
        }
        start.is_first = start.trainees.is_empty() && !self.has_sessions();
        start.progress = self.progress(&self.form.trainee);
        start.slow_per_second = too_few(&self.sessions());
        stations::look(&mut start, words);
        self.looked = Instant::now();
        self.view.screen = Screen::Start(start);
    }

    pub(super) fn choose(&mut self, form: StartForm) {
        let form = choices::fitting(&self.form, form);
        let devices = |it: &StartForm| (it.emulated, it.station_file.clone());
        let look = devices(&form) != devices(&self.form);
        let speaks_anew = form.language != self.form.language;
        let is_another = form.trainee != self.form.trainee;
        let changes = speaks_anew || form.look != self.form.look;
        self.form = form;
        self.view.look = self.form.look;
        if changes {
            settings::keep(&Settings {
                language: self.form.language,
                look: self.form.look,
                sound: settings::kept().sound,
            });
        }
        let progress = match is_another {
            true => self.progress(&self.form.trainee),
            false => None,
        };
        if speaks_anew {
            self.view.words = Words::new(self.form.language);
            // The messages on the screen are in the old language: build them again.
            self.show_start();
        } else if let Screen::Start(start) = &mut self.view.screen {
            start.form = self.form.clone();
            if is_another {
                start.progress = progress;
            }
            if look {
                stations::look(start, &self.view.words);
            }
        }
    }

    /// Takes the settings that an operation's window has changed.
    pub(super) fn take_settings(&mut self) {
        let kept = settings::kept();
        if kept == self.kept {
            return;
        }
        self.kept = kept;
        if kept.language != self.form.language {
            self.view.words = Words::new(kept.language);
        }
        (self.form.language, self.form.look) = (kept.language, kept.look);
        self.view.look = kept.look;
    }

    /// Folder of the sessions: that of `--sessions`, or `sessions` next to the store, or `out`.
    pub(super) fn sessions(&self) -> PathBuf {
        let beside = self.store.as_ref().and_then(|store| store.parent());
        let sessions = self.args.sessions.clone();
        let sessions = sessions.or_else(|| Some(beside?.join("sessions")));
        sessions.unwrap_or_else(|| "out".into())
    }

    /// True if the folder of the sessions holds something.
    fn has_sessions(&self) -> bool {
        let entries = std::fs::read_dir(self.sessions());
        entries.is_ok_and(|mut it| it.next().is_some())
    }

    /// Progress of a trainee in the curriculum. Returns `None` for a guest, for a name that the
    /// store does not know, and if the store cannot be read.
    pub(super) fn progress(&self, trainee: &str) -> Option<ProgressView> {
        Some(self.whole_progress(trainee)?.view())
    }

    /// Progress with the times at which the trainee became proficient. Otherwise like
    /// [`Self::progress`].
    pub(super) fn whole_progress(&self, trainee: &str) -> Option<Progress> {
        if trainee.trim().is_empty() {
            return None;
        }
        let store = self.open_store().ok()?;
        let sessions = store.sessions(trainee.trim(), None).ok()?;
        let language = self.form.language;
        Some(
            self.curriculum
                .progress(trainee.trim(), &sessions, language),
        )
    }
}

/// Pictures a second of the newest operation in this folder that had a window, if they were too few
/// to train with.
fn too_few(sessions: &Path) -> Option<f64> {
    let entries = std::fs::read_dir(sessions).ok()?.flatten();
    let summaries = entries.map(|it| it.path().join("summary.json"));
    let mut summaries: Vec<(SystemTime, PathBuf)> = summaries
        .filter_map(|it| Some((it.metadata().ok()?.modified().ok()?, it)))
        .collect();
    summaries.sort();
    let rate = |path: &PathBuf| {
        let text = std::fs::read(path).ok()?;
        let summary: serde_json::Value = serde_json::from_slice(&text).ok()?;
        summary.get("pictures_per_second")?.as_f64()
    };
    let newest = summaries.iter().rev().take(LOOKED_THROUGH);
    let newest = newest.filter_map(|(_, path)| rate(path)).next();
    newest.filter(|it| *it < PICTURES_MIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_operation_with_a_window_shows_if_the_computer_is_too_slow() {
        let folder = tempfile::tempdir().unwrap();
        let ended = |name: &str, rate: &str, seconds: u64| {
            let path = folder.path().join(name).join("summary.json");
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let text = format!("{{\"pictures_per_second\": {rate}}}");
            std::fs::write(&path, text).unwrap();
            let at = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
            let file = std::fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(at).unwrap();
        };
        let bits = || too_few(folder.path()).map(f64::to_bits);
        assert_eq!(bits(), None);
        ended("a", "2.5", 10);
        assert_eq!(bits(), Some(2.5f64.to_bits()));
        ended("b", "null", 20);
        assert_eq!(bits(), Some(2.5f64.to_bits()), "b had no window");
        ended("c", "14.5", 30);
        assert_eq!(bits(), None, "the newest window was fast enough");
        assert_eq!(too_few(Path::new("/nowhere")), None);
    }
}
