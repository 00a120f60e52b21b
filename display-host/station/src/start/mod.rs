//! `calot start`: a window to choose an operation, start it, and read the debrief. Each operation
//! is a child process `calot run`, because a window system serves one event loop per process and a
//! run has one task.

pub(crate) mod args;
mod choices;
mod operation;
mod outcome;
mod problem;
mod stations;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use assess::{Difficulty, Rules, Task};
use display_host::ui::launcher::{
    Asking, Debrief, Failed, Launcher, Points, ProgressView, Running, Screen, Start, StartForm,
    Wish, launcher,
};
use display_host::window::{self, Page, show_page};
use display_host::words::Words;
use store::{GOALS, Questionnaire, Store};

use self::args::StartArgs;
use self::choices::TRIANGLE;
use self::operation::Operation;
use crate::args::LanguageName;
use crate::clock::now_unix_s;
use crate::curriculum::Curriculum;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Inner size of the window, pixels.
const SIZE: [u32; 2] = [1180, 720];
/// Prefix of the messages of `calot run` that the trainee sees. The others are for engineers.
const PREPARING: &str = "preparing";
/// Interval between two searches for devices.
const LOOK_EVERY: Duration = Duration::from_secs(3);
/// Time that the window may freeze while another program writes to the store.
const PATIENCE_FOR_STORE: Duration = Duration::from_millis(300);

/// Opens the launcher and runs it until it is closed. Then ends a running operation and replay.
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
    /// Path of the store. `None`: no `--store`, and no home folder.
    store: Option<PathBuf>,
    view: Launcher,
    /// The choices, which all screens share.
    form: StartForm,
    operation: Option<Operation>,
    /// The newest debrief, which other screens return to, and the id of its session.
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
        form.language = LanguageName::or_users(args.language);
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
            debrief: None,
            folder: None,
            looked: Instant::now(),
            opening: None,
            replay: None,
            over: false,
        };
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

    fn show_start(&mut self) {
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
            scenes: names(&choices::SCENES),
            hanging: names(&choices::hanging()),
            shown: names(&choices::shown()),
            store: self.store.as_ref().map_or_else(
                || words.say("store-no-home"),
                |path| path.display().to_string(),
            ),
            problem: None,
            ..Start::default()
        };
        let own = self.args.scene.iter();
        let own = own.filter(|it| !choices::SCENES.contains(&it.as_str()));
        start.scenes.extend(own.cloned());
        match kept {
            Ok(trainees) => start.trainees = trainees.into_iter().map(|it| it.name).collect(),
            Err(problem) => start.problem = Some(problem),
        }
        start.is_first = start.trainees.is_empty() && !self.has_sessions();
        start.progress = self.progress(&self.form.trainee);
        stations::look(&mut start, words);
        self.looked = Instant::now();
        self.view.screen = Screen::Start(start);
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
            Wish::Replay(at_s) => self.replay(at_s),
            Wish::Ask(asking) => self.ask(asking),
            Wish::Answer(_) | Wish::Previous => self.answer(&wish),
            Wish::Keep => self.keep(),
            Wish::Back => self.show_debrief(),
            Wish::Quit => self.over = true,
        }
    }

    fn choose(&mut self, form: StartForm) {
        let form = choices::fitting(&self.form, form);
        let devices = |it: &StartForm| (it.emulated, it.station_file.clone());
        let look = devices(&form) != devices(&self.form);
        let speaks_anew = form.language != self.form.language;
        let is_another = form.trainee != self.form.trainee;
        self.form = form;
        self.view.look = self.form.look;
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

    /// Folder of the sessions: `--sessions`, else `sessions` beside the store, else `out`.
    fn sessions(&self) -> PathBuf {
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

    /// Progress of a trainee in the curriculum. `None`: a guest, a name that the store does not
    /// know, or a store that cannot be read.
    fn progress(&self, trainee: &str) -> Option<ProgressView> {
        if trainee.trim().is_empty() {
            return None;
        }
        let store = self.open_store().ok()?;
        let sessions = store.sessions(trainee.trim(), None).ok()?;
        let language = self.form.language;
        Some(
            self.curriculum
                .progress(trainee, &sessions, language)
                .view(),
        )
    }

    /// Starts the task that the debrief names as the trainee's next.
    fn begin_next(&mut self) {
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
    fn begin(&mut self, watched: bool) {
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

    fn show_running(&mut self) {
        let Some(operation) = &self.operation else {
            return;
        };
        self.view.screen = Screen::Running(Running {
            trainee: operation.form.trainee.clone(),
            watched: operation.watched,
            task: operation.form.task.clone(),
            seconds: operation.seconds().floor(),
            said: operation
                .said()
                .pop()
                .filter(|it| it.starts_with(PREPARING)),
            ending: operation.is_ending(),
            overdue: operation.is_overdue(),
        });
    }

    /// Shows the debrief of an operation that has ended, or the reason why there is none.
    fn debrief(&mut self, operation: &Operation, status: ExitStatus) {
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
                let mut said = operation.said();
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

    fn show_debrief(&mut self) {
        match &self.debrief {
            Some((debrief, _)) => self.view.screen = Screen::Debrief(debrief.clone()),
            None => self.show_start(),
        }
    }

    fn note(&mut self, notice: String) {
        if let Some((debrief, _)) = &mut self.debrief {
            debrief.notice = Some(notice);
        }
        if let Screen::Debrief(_) = self.view.screen {
            self.show_debrief();
        }
    }

    /// Replays a moment of the debriefed session in its own window, in place of an earlier replay.
    fn replay(&mut self, at_s: f64) {
        let Some(folder) = self.folder.clone() else {
            return;
        };
        self.end_replay();
        let begun = std::env::current_exe().and_then(|calot| {
            Command::new(calot)
                .args(["replay", "--at", &format!("{at_s:.1}"), "--language"])
                .arg(self.form.language.code())
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

    fn end_replay(&mut self) {
        if let Some(mut child) = self.replay.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    fn open_report(&mut self) {
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
            Err(error) => report_lies(words, &path, &format!("xdg-open: {error}")),
        };
        self.note(notice);
    }

    fn ask(&mut self, asking: Asking) {
        let Some((debrief, _)) = &self.debrief else {
            return;
        };
        let items: Vec<_> = match asking {
            Asking::Questions => {
                let items = self.questions.items.iter();
                items.map(|it| (it.id.clone(), it.text.clone())).collect()
            }
            Asking::Sheet => GOALS
                .map(|(name, text)| (name.to_owned(), text.to_owned()))
                .to_vec(),
        };
        self.view.screen = Screen::Points(Points {
            asking,
            trainee: debrief.trainee.clone(),
            given: vec![None; items.len()],
            items,
            at: 0,
            problem: None,
        });
    }

    fn answer(&mut self, wish: &Wish) {
        let Screen::Points(points) = &mut self.view.screen else {
            return;
        };
        match wish {
            Wish::Answer(given) => {
                if let Some(slot) = points.given.get_mut(points.at) {
                    *slot = Some(*given);
                    points.at += 1;
                }
            }
            _ => points.at = points.at.saturating_sub(1),
        }
    }

    /// Stores the points. On failure the screen keeps them and shows the reason.
    fn keep(&mut self) {
        let Screen::Points(points) = &self.view.screen else {
            return;
        };
        let given: Vec<u8> = points.given.iter().flatten().copied().collect();
        let (asking, trainee) = (points.asking, points.trainee.clone());
        let kept = self.put(asking, &trainee, &given);
        match (kept, &mut self.debrief) {
            (Ok(()), Some((debrief, _))) => {
                match asking {
                    Asking::Questions => debrief.answered = true,
                    Asking::Sheet => {
                        debrief.sheet = Some(given.iter().map(|it| u32::from(*it)).sum());
                    }
                }
                self.show_debrief();
            }
            (Ok(()), None) => self.show_start(),
            (Err(problem), _) => {
                if let Screen::Points(points) = &mut self.view.screen {
                    points.problem = Some(problem);
                }
            }
        }
    }

    fn put(&self, asking: Asking, trainee: &str, given: &[u8]) -> Result<(), String> {
        let mut store = self.open_store()?;
        let words = &self.view.words;
        let kept = match asking {
            Asking::Questions => store.answer(trainee, &self.questions, given, now_unix_s()),
            Asking::Sheet => {
                let session = self.debrief.as_ref().map_or("", |(_, session)| session);
                let points = given.try_into();
                store.set_sheet(session, points.map_err(|_| words.say("sheet-not-whole"))?)
            }
        };
        kept.map_err(|it| problem::of_store(words, &it))
    }
}

fn report_lies(words: &Words, path: &str, problem: &str) -> String {
    let values = [("path", path.into()), ("problem", problem.into())];
    words.say_with("debrief-report-lies", &values)
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
                    self.note(report_lies(&self.view.words, &path, &problem));
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
