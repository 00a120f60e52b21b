//! `calot start`: a window to choose an operation, start it, and read the debrief. Each operation
//! is a child process `calot run`, because a window system serves one event loop per process and a
//! run has one task.

mod answers;
pub(crate) mod args;
mod begin;
mod certify;
mod choices;
mod debrief;
mod operation;
mod outcome;
mod problem;
mod start_screen;
mod stations;

use std::path::PathBuf;
use std::process::{Child, ExitCode};
use std::time::{Duration, Instant};

use assess::{Difficulty, Rules, Task};
use display_host::ui::Settings;
use display_host::ui::launcher::{Debrief, Launcher, Screen, Start, StartForm, Wish, launcher};
use display_host::window::{self, Page, show_page};
use display_host::words::Words;
use store::{Questionnaire, Store};

use self::args::StartArgs;
use self::choices::TRIANGLE;
use self::debrief::path_of_unopened_report;
use self::operation::Operation;
use crate::args::LookArgs;
use crate::curriculum::Curriculum;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Inner size of the window, pixels.
const SIZE: [u32; 2] = [1180, 720];
/// Interval between two searches for devices.
const LOOK_EVERY: Duration = Duration::from_secs(3);
/// Time that the window may freeze while another program writes to the store.
const PATIENCE_FOR_STORE: Duration = Duration::from_millis(300);

/// Opens the launcher and runs it until it is closed. Then it ends a running operation and replay.
pub(crate) fn run(args: &StartArgs) -> Result<ExitCode, Problem> {
    window::answers()?;
    let stop = stop::flag()?;
    let rules = args.rules.as_deref().map(Rules::read).transpose()?;
    let curriculum = Curriculum::read(args.curriculum.as_deref())?;
    let questions = args.questionnaire.as_deref().map(Questionnaire::read);
    let mut desk = Desk::new(
        args.clone(),
        rules.unwrap_or_default(),
        questions.transpose()?.unwrap_or_default(),
        curriculum,
    );
    let shown = show_page(SIZE, &stop, &mut desk);
    if let Some(operation) = &mut desk.operation {
        say::note("calot: asking the operation to end");
        operation.stop();
        operation.wait();
    }
    desk.end_replay();
    shown?;
    Ok(ExitCode::SUCCESS)
}

/// State of the launcher.
struct Desk {
    args: StartArgs,
    rules: Rules,
    questions: Questionnaire,
    curriculum: Curriculum,
    /// Path of the store. `None` if there is neither `--store` nor a home folder.
    store: Option<PathBuf>,
    view: Launcher,
    /// The choices, which all screens share.
    form: StartForm,
    operation: Option<Operation>,
    /// The settings that were kept when the operation began.
    kept: Settings,
    /// The newest debrief and the id of its session. The questionnaire and the sheet return to it.
    debrief: Option<(Debrief, String)>,
    /// Folder of the session of the debrief.
    folder: Option<PathBuf>,
    looked: Instant,
    opening: Option<Child>,
    /// The replay of a moment, if any.
    replay: Option<Child>,
    over: bool,
}

impl Desk {
    fn new(
        args: StartArgs,
        rules: Rules,
        questions: Questionnaire,
        curriculum: Curriculum,
    ) -> Self {
        let mut form = choices::usual();
        let kept = LookArgs::default().settings(args.language);
        (form.language, form.look) = (kept.language, kept.look);
        if let Some(file) = &args.station_file {
            form.station_file = file.display().to_string();
            form.emulated = false;
        }
        if let Some(scene) = &args.scene {
            form = choices::fitting(
                &form,
                StartForm {
                    scene: scene.clone(),
                    ..form.clone()
                },
            );
        }
        let store = args.store.path().ok();
        let mut desk = Self {
            view: Launcher {
                words: Words::new(form.language),
                look: form.look,
                screen: Screen::Start(Start::default()),
            },
            args,
            rules,
            questions,
            curriculum,
            store,
            form,
            operation: None,
            kept: Settings::default(),
            debrief: None,
            folder: None,
            looked: Instant::now(),
            opening: None,
            replay: None,
            over: false,
        };
        desk.form.trainee = desk.last_trainee();
        desk.show_start();
        desk
    }

    /// Opens the store. Waits for another program at most [`PATIENCE_FOR_STORE`].
    fn open_store(&self) -> Result<Store, String> {
        let words = &self.view.words;
        let path = self.store.as_ref();
        let path = path.ok_or_else(|| words.say("store-no-home"))?;
        Store::open_within(path, PATIENCE_FOR_STORE).map_err(|it| problem::of_store(words, &it))
    }

    /// Name of the trainee who was here last; empty, which stands for a guest, if nobody was.
    fn last_trainee(&self) -> String {
        let last = self.open_store().map(|store| store.last_trainee());
        last.ok().and_then(Result::ok).flatten().unwrap_or_default()
    }

    fn do_as(&mut self, wish: Wish) {
        match wish {
            Wish::Form(form) => self.choose(form),
            Wish::Begin | Wish::Again => self.begin(false),
            Wish::Guided => {
                Task::Basics.name().clone_into(&mut self.form.task);
                Difficulty::Beginner
                    .name()
                    .clone_into(&mut self.form.difficulty);
                TRIANGLE.clone_into(&mut self.form.scene);
                self.begin(false);
            }
            Wish::Next => self.begin_next(),
            Wish::Watch => self.begin(true),
            Wish::AgainEmulated => {
                self.form.emulated = true;
                self.begin(false);
            }
            Wish::Stop => {
                if let Some(operation) = &mut self.operation {
                    operation.stop();
                }
            }
            Wish::StopAtOnce => {
                if let Some(operation) = &mut self.operation {
                    operation.kill();
                }
            }
            Wish::Another => self.show_start(),
            Wish::OpenReport => self.open_report(),
            Wish::Certificate => self.certify(),
            Wish::Replay(at_s) => self.replay(at_s),
            Wish::Ask(asking) => self.ask(asking),
            Wish::Answer(_) | Wish::Previous | Wish::Rater(_) => self.answer(&wish),
            Wish::Keep => self.keep(),
            Wish::Back => self.show_debrief(),
            Wish::Quit => self.over = true,
        }
    }
}

impl Page for Desk {
    fn title(&self) -> String {
        self.view.title()
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        for wish in launcher(ui, &self.view) {
            self.do_as(wish);
            // Draw the new screen at once, so that no input for the old one reaches it.
            ui.ctx().request_repaint();
        }
    }

    fn look_about(&mut self) -> bool {
        if let Some(mut operation) = self.operation.take() {
            match operation.ended() {
                Some(status) => self.debrief(&operation, status),
                None => {
                    self.operation = Some(operation);
                    let before = self.view.screen.clone();
                    self.show_running();
                    return self.view.screen != before;
                }
            }
            return true;
        }
        if let Some(mut opening) = self.opening.take() {
            match opening.try_wait() {
                Ok(Some(status)) if !status.success() => {
                    let report = self.debrief.as_ref().and_then(|(it, _)| it.report.clone());
                    let path = report.unwrap_or_default();
                    let problem = format!("xdg-open: {status}");
                    self.note(path_of_unopened_report(&self.view.words, &path, &problem));
                    return true;
                }
                Ok(None) => self.opening = Some(opening),
                _ => {}
            }
        }
        if let Screen::Start(start) = &mut self.view.screen
            && self.looked.elapsed() >= LOOK_EVERY
        {
            self.looked = Instant::now();
            let before = (start.devices.clone(), start.plugged_in.clone());
            stations::look(start, &self.view.words);
            return before != (start.devices.clone(), start.plugged_in.clone());
        }
        false
    }

    fn is_over(&self) -> bool {
        self.over
    }
}
