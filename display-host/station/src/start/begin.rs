//! Starts an operation with the choices, and shows that it runs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use display_host::ui::launcher::{Running, Screen, StartForm};
use display_host::words::Words;

use super::operation::Operation;
use super::{Desk, choices, problem};
use crate::settings;

/// Prefix of the messages of `calot run` that the trainee sees. The others are for engineers.
const PREPARING: &str = "preparing";

impl Desk {
    /// Starts the task that the debrief names as the trainee's next.
    pub(super) fn begin_next(&mut self) {
        let debrief = self.debrief.as_ref();
        let next = debrief.and_then(|(it, _)| it.progress.as_ref()?.next.clone());
        if let Some((task, difficulty)) = next {
            let form = StartForm {
                task,
                difficulty,
                ..self.form.clone()
            };
            self.form = choices::fitting(&self.form, form);
            self.begin(false);
        }
    }

    /// Starts an operation, by the expert if `watched`. If that fails, shows the reason on the
    /// start screen.
    pub(super) fn begin(&mut self, watched: bool) {
        self.end_replay();
        let form = match watched {
            true => Ok(choices::of_expert(&self.form)),
            false => self.checked(),
        };
        let begun = form.and_then(|form| {
            let out = self.new_folder()?;
            let mut words = self.words_of_run(&form, &out);
            if watched {
                words.extend(["--hand", choices::EXPERT].map(Into::into));
            }
            Operation::begin(&words, form, watched, out.clone()).map_err(|error| {
                // The operation did not start, so remove its empty folder.
                let _ = std::fs::remove_dir(&out);
                problem::of_start(&self.view.words, &error)
            })
        });
        match begun {
            Ok(operation) => {
                self.kept = settings::kept();
                self.operation = Some(operation);
                self.show_running();
            }
            Err(problem) => {
                self.show_start();
                if let Screen::Start(start) = &mut self.view.screen {
                    start.problem = Some(problem);
                }
            }
        }
    }

    /// Checks the choices. Returns them with the trainee's name as the store writes it.
    fn checked(&self) -> Result<StartForm, String> {
        let mut form = self.form.clone();
        form.trainee = form.trainee.trim().to_owned();
        if !form.trainee.is_empty() {
            let name = store::check_name(&form.trainee)
                .map_err(|it| problem::of_name(&self.view.words, &it))?;
            let store = self.open_store()?;
            let alike = store.alike(&name);
            if let Some(known) = alike.map_err(|it| problem::of_store(&self.view.words, &it))? {
                return Err(problem::of_alike(&self.view.words, &name, &known));
            }
            form.trainee = name;
        }
        if !form.emulated && form.station_file.trim().is_empty() {
            return Err(self.view.words.say("start-no-file"));
        }
        Ok(form)
    }

    fn new_folder(&self) -> Result<PathBuf, String> {
        let out = self.sessions().join(store::new_id());
        std::fs::create_dir_all(&out)
            .map_err(|it| problem::of_folder(&self.view.words, &out, &it))?;
        Ok(out)
    }

    fn words_of_run(&self, form: &StartForm, out: &Path) -> Vec<OsString> {
        let scope = form.scope_degrees.to_string();
        let mut words: Vec<OsString> = [
            "run",
            "--station",
            &self.args.station,
            "--task",
            &form.task,
            "--difficulty",
            &form.difficulty,
            "--scene",
            &form.scene,
            "--scope",
            &scope,
            "--language",
            form.language.code(),
            "--out",
        ]
        .map(Into::into)
        .to_vec();
        words.push(out.into());
        words.extend(choices::look(&form.look));
        let mut option = |name: &str, value: &dyn AsRef<std::ffi::OsStr>| {
            words.extend([name.into(), value.as_ref().to_owned()]);
        };
        if !form.trainee.is_empty()
            && let Some(store) = &self.store
        {
            option("--store", store);
            // The option and the name are one word, because a name may begin with a hyphen.
            words.push(format!("--trainee={}", form.trainee).into());
        }
        let mut option = |name: &str, value: &dyn AsRef<std::ffi::OsStr>| {
            words.extend([name.into(), value.as_ref().to_owned()]);
        };
        if !form.emulated {
            option("--station-file", &form.station_file.trim());
        }
        if let Some(rules) = &self.args.rules {
            option("--rules", rules);
        }
        if form.own_sutures {
            option("--sutures", &"own");
        }
        words.extend(self.args.more.iter().cloned());
        words
    }

    pub(super) fn show_running(&mut self) {
        let Some(operation) = &self.operation else {
            return;
        };
        self.view.screen = Screen::Running(Running {
            trainee: operation.form.trainee.clone(),
            watched: operation.watched,
            task: operation.form.task.clone(),
            preparing: operation
                .last_lines()
                .pop()
                .and_then(|it| preparing(&self.view.words, &it)),
            ending: operation.is_ending(),
            overdue: operation.is_overdue(),
        });
    }
}

/// Progress of the preparation in the trainee's language. `None`: it is over, or the line says
/// something else.
fn preparing(words: &Words, line: &str) -> Option<String> {
    let (percent, _) = line.strip_prefix(PREPARING)?.split_once('%')?;
    let percent = percent.trim();
    let said = words.say_with("running-preparing", &[("percent", percent.into())]);
    (percent != "100").then_some(said)
}

#[cfg(test)]
mod tests {
    use display_host::words::Language;

    use super::*;

    #[test]
    fn the_preparation_is_told_in_the_trainee_s_language_without_the_spheres() {
        let german = Words::new(Language::German);
        let said = preparing(&german, "preparing  35 %  liver: packing 200 spheres");
        assert_eq!(said.as_deref(), Some("Die Organe werden vorbereitet: 35 %"));
        assert_eq!(preparing(&german, "wrote out/summary.json"), None);
        let over = preparing(&german, "preparing 100 %");
        assert_eq!(over, None, "the operation begins");
    }
}
