//! The certificate of the trainee who is chosen or debriefed.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use display_host::ui::launcher::Screen;

use super::Desk;
use crate::output;

impl Desk {
    /// Writes the certificate and opens it. Shows its path, or the problem.
    pub(super) fn certify(&mut self) {
        let trainee = match (&self.view.screen, &self.debrief) {
            (Screen::Debrief(_), Some((debrief, _))) => debrief.trainee.clone(),
            _ => self.form.trainee.trim().to_owned(),
        };
        let progress = self.whole_progress(&trainee);
        let Some(page) = progress.and_then(|it| it.certificate(&self.view.words)) else {
            return;
        };
        let path = self.certificate_path(&trainee);
        let written = match path.parent().map(std::fs::create_dir_all) {
            Some(Err(error)) => Err(error),
            _ => output::write(&path, &page),
        };
        let shown = ("path", path.display().to_string().into());
        let words = &self.view.words;
        let told = match &written {
            Ok(()) => words.say_with("certificate-written", &[shown]),
            Err(error) => {
                let problem = ("problem", error.to_string().into());
                words.say_with("certificate-unwritten", &[shown, problem])
            }
        };
        if written.is_ok() {
            // The path is shown even if no program opens the page.
            self.opening = Command::new("xdg-open")
                .arg(&path)
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .ok()
                .or_else(|| self.opening.take());
        }
        match &mut self.view.screen {
            Screen::Start(start) if written.is_ok() => start.notice = Some(told),
            Screen::Start(start) => start.problem = Some(told),
            _ => self.note(told),
        }
    }

    /// File of a trainee's certificate, next to the sessions.
    fn certificate_path(&self, trainee: &str) -> PathBuf {
        let is_plain = |it: char| it.is_alphanumeric() || it == '-';
        let name = trainee
            .chars()
            .map(|it| if is_plain(it) { it } else { '_' });
        let name: String = name.collect();
        self.sessions()
            .join("certificates")
            .join(format!("{name}.html"))
    }
}
