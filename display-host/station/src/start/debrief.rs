//! The debrief of an operation, its report, and replays of its moments.

use std::process::{Command, ExitStatus, Stdio};

use display_host::ui::launcher::{Debrief, Failed, Screen};
use display_host::words::Words;

use super::operation::Operation;
use super::{Desk, choices, outcome, problem};

impl Desk {
    /// Shows the debrief of an operation that has ended, or the reason why there is none.
    pub(super) fn debrief(&mut self, operation: &Operation, status: ExitStatus) {
        self.take_settings();
        let store = self.open_store();
        let form = &operation.form;
        let found = outcome::read(
            &operation.out,
            &form.trainee,
            &self.rules,
            &store,
            &self.view.words,
        );
        match found {
            Some((debrief, session)) => {
                let progress = self.progress(&form.trainee);
                self.debrief = Some((
                    Debrief {
                        progress,
                        ..debrief
                    },
                    session,
                ));
                self.folder = Some(operation.out.clone());
                self.show_debrief();
            }
            None => {
                // Remove the folder only if it is empty: its files may tell the reason.
                let _ = std::fs::remove_dir(&operation.out);
                let mut said = operation.last_lines();
                if crate::report::recording(&operation.out).exists() {
                    said.push(problem::of_recorded(&self.view.words, &operation.out));
                }
                self.view.screen = Screen::Failed(Failed {
                    status: problem::of_end(&self.view.words, status),
                    said,
                    had_devices: !form.emulated,
                });
            }
        }
    }

    pub(super) fn show_debrief(&mut self) {
        match &self.debrief {
            Some((debrief, _)) => self.view.screen = Screen::Debrief(debrief.clone()),
            None => self.show_start(),
        }
    }

    pub(super) fn note(&mut self, notice: String) {
        if let Some((debrief, _)) = &mut self.debrief {
            debrief.notice = Some(notice);
        }
        if let Screen::Debrief(_) = self.view.screen {
            self.show_debrief();
        }
    }

    /// Replays a moment of the debriefed session in its own window, in place of an earlier replay.
    pub(super) fn replay(&mut self, at_s: f64) {
        let Some(folder) = self.folder.clone() else {
            return;
        };
        self.end_replay();
        let begun = std::env::current_exe().and_then(|calot| {
            Command::new(calot)
                .args(["replay", "--at", &format!("{at_s:.1}"), "--language"])
                .arg(self.form.language.code())
                .args(choices::look(&self.form.look))
                .args(["--station", &format!("replay-{}", std::process::id()), "--"])
                .arg(folder)
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
        });
        let notice = match begun {
            Ok(child) => {
                self.replay = Some(child);
                self.view.words.say("debrief-replays")
            }
            Err(error) => problem::of_start(&self.view.words, &error),
        };
        self.note(notice);
    }

    pub(super) fn end_replay(&mut self) {
        if let Some(mut child) = self.replay.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    pub(super) fn open_report(&mut self) {
        let report = self.debrief.as_ref().and_then(|(it, _)| it.report.clone());
        let Some(path) = report else { return };
        let opened = Command::new("xdg-open")
            .arg(&path)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let words = &self.view.words;
        let notice = match opened {
            Ok(child) => {
                self.opening = Some(child);
                words.say_with("debrief-report-opened", &[("path", path.into())])
            }
            Err(error) => path_of_unopened_report(words, &path, &format!("xdg-open: {error}")),
        };
        self.note(notice);
    }
}

pub(super) fn path_of_unopened_report(words: &Words, path: &str, problem: &str) -> String {
    let values = [("path", path.into()), ("problem", problem.into())];
    words.say_with("debrief-report-lies", &values)
}
