//! A task while it runs. A thread assesses the entries that the recorder writes, so that the live
//! view of the trainee equals the assessment of the recording.

pub(crate) mod args;
mod board;
mod view;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use assess::report::Chapter;
use assess::{Anatomy, Assessed, Assessment, Difficulty, Reason, Rules, Task};
use display_host::report::{Summary, TaskAlarm, TaskLost, TaskSummary};
use display_host::ui::TaskView;
use session::{Assignment, Entry};
use shared_mem::message::{CommandMsg, ReplyMsg};
use shared_mem::scene::SceneFile;
use shared_mem::service::{Host, Station};

use store::Store;

use self::args::{Sutures, TaskArgs};
use self::board::Board;
use self::view::view_of;
use crate::build::build;
use crate::clock::now_unix_s;
use crate::problem::Problem;
use crate::report;
use crate::say;
use crate::store::{Made, SessionCriteria, circumstances_of, past, record};

/// Interval at which the panel's view is updated.
const VIEW_EVERY: Duration = Duration::from_millis(50);
/// Time that the controller may take to prepare a task.
const START_PATIENCE: Duration = Duration::from_secs(20);

/// A task to assess.
#[derive(Debug, Clone)]
pub(crate) struct Assigned {
    task: Task,
    sutures: Sutures,
    difficulty: Difficulty,
    rules: Rules,
    /// Id of the session.
    id: String,
    /// Trainee and path of the store, if the result is to be kept.
    keep: Option<(String, PathBuf)>,
    /// True if a scripted hand works.
    is_scripted: bool,
}

impl Assigned {
    /// Reads the requested task, if any. Checks rules and trainee before anything starts.
    /// `is_scripted`: no person works.
    pub(crate) fn read(args: &TaskArgs, is_scripted: bool) -> Result<Option<Self>, Problem> {
        let Some(task) = args.task else {
            return Ok(None);
        };
        if args.sutures == Sutures::Own && !task.may_hang() {
            return Err(format!(
                "--sutures own: task '{}' begins with the gallbladder hung; choose identify, full or free to place them yourself",
                task.name()
            )
            .into());
        }
        let rules = args.rules.as_deref().map(Rules::read).transpose()?;
        let keep = match &args.trainee {
            Some(name) => {
                // Open the store before anything starts, to report a refusal early.
                let store = args.store.open()?;
                args.new_trainee.confirm(&store, name)?;
                Some((name.clone(), store.path().to_owned()))
            }
            None => None,
        };
        Ok(Some(Self {
            task,
            sutures: args.sutures,
            difficulty: args.difficulty.unwrap_or_default(),
            rules: rules.unwrap_or_default(),
            id: store::new_id(),
            keep,
            is_scripted,
        }))
    }

    pub(crate) fn task(&self) -> Task {
        self.task
    }

    pub(crate) fn difficulty(&self) -> Difficulty {
        self.difficulty
    }

    /// State in which the task begins, as [`CommandMsg::START`] numbers it. `None`: the state in
    /// which the run begins.
    pub(crate) fn start(&self) -> Option<u32> {
        match self.sutures {
            Sutures::Own => Some(0),
            Sutures::Given => begins(self.task),
        }
    }

    pub(crate) fn id(&self) -> &str {
        &self.id
    }

    /// The assignment as the session stores it.
    pub(crate) fn assignment(&self) -> Assignment {
        Assignment {
            task: self.task.name().to_owned(),
            difficulty: self.difficulty.name().to_owned(),
            rules: self.rules.text().to_owned(),
            id: self.id.clone(),
            is_scripted: self.is_scripted,
        }
    }

    /// Starts a thread that assesses the entries passed to the returned sender.
    pub(crate) fn begin(
        self,
        scene: &SceneFile,
        station: &Station,
    ) -> Result<(Live, Sender<Entry>), Problem> {
        let anatomy = Anatomy::of(scene);
        if let Some(what) = self.task.lacks(&anatomy) {
            return Err(format!(
                "task '{}' needs what scene '{}' lacks: {what}. Choose another scene with --scene, e.g. \
                 triangle, or --task free",
                self.task.name(),
                scene.name()
            )
            .into());
        }
        if self.sutures == Sutures::Own && anatomy.sutures() == 0 {
            return Err(format!(
                "--sutures own: scene '{}' hangs no organ by sutures. Choose another with --scene, e.g. triangle",
                scene.name()
            )
            .into());
        }
        let (sender, course) = mpsc::channel();
        let view = Arc::new(Mutex::new(TaskView {
            task: self.task.name().to_owned(),
            start: self.start(),
            ..TaskView::default()
        }));
        let over = Arc::new(AtomicBool::new(false));
        let (shown, decided) = (view.clone(), over.clone());
        let assignment = self.assignment();
        let (task, difficulty, start) = (self.task, self.difficulty, self.start());
        let assessment = Assessment::new(self.task, self.difficulty, self.rules, anatomy);
        let station = station.clone();
        let thread = Builder::new()
            .name("calot-assess".to_owned())
            .spawn(move || {
                let board = Board::open(&station);
                follow(assessment, &course, &decided, |assessment| {
                    board.post(task, difficulty, assessment);
                    let view = TaskView {
                        start,
                        ..view_of(task, difficulty, assessment.status())
                    };
                    *shown.lock().unwrap_or_else(PoisonError::into_inner) = view;
                })
            })
            .map_err(|error| format!("cannot start the assessment's thread: {error}"))?;
        let live = Live {
            thread,
            view,
            over,
            assignment,
            keep: self.keep,
            began_unix_s: now_unix_s(),
        };
        Ok((live, sender))
    }
}

/// A running task.
pub(crate) struct Live {
    thread: JoinHandle<Assessed>,
    /// View for the panel.
    pub(crate) view: Arc<Mutex<TaskView>>,
    /// Set once the task is decided.
    pub(crate) over: Arc<AtomicBool>,
    assignment: Assignment,
    keep: Option<(String, PathBuf)>,
    began_unix_s: i64,
}

/// Result of a task.
pub(crate) struct Ended {
    pub(crate) assessed: Assessed,
    pub(crate) summary: TaskSummary,
    is_scripted: bool,
    keep: Option<(String, PathBuf)>,
    /// Start of the session, s since 1970. It is read at the start, because somebody may set the
    /// time of day while the session runs.
    began_unix_s: i64,
}

impl Ended {
    /// Puts the result into the store, if it is to be kept.
    pub(crate) fn keep(&self, run: &Summary) -> Result<(), Problem> {
        let Some((name, path)) = &self.keep else {
            return Ok(());
        };
        let id = &self.summary.session;
        let program = build();
        let recording = run.recording.as_ref().map(|it| it.file.as_path());
        let made = Made {
            id,
            began_unix_s: self.began_unix_s,
            scene: &run.scene,
            program: &program,
            file: recording,
            hand: report::hand(self.is_scripted),
            circumstances: circumstances_of(run),
        };
        let record = record(&self.assessed, made);
        Store::open(path)?.add_session(name, &record)?;
        say::note(format_args!("kept as {name}'s session {id}"));
        Ok(())
    }

    /// Adds the trainee's past and the instructor's sheet to the debrief. A scripted hand has no
    /// past.
    pub(crate) fn add_past(&self, chapter: &mut Chapter) -> Result<(), Problem> {
        if let Some((name, path)) = self.keep.as_ref().filter(|_| !self.is_scripted) {
            let store = Store::read(path)?;
            let it = &self.summary;
            let criteria = SessionCriteria {
                task: &it.task,
                difficulty: &it.difficulty,
                version: it.metrics_version,
            };
            let before = past(&store, name, criteria, &it.session)?;
            (chapter.past, chapter.sheet) = (before.past, before.sheet);
            chapter.trainee = Some(name.clone());
        }
        Ok(())
    }
}

impl Live {
    /// Waits for the end of the recording and returns the result. `None`: the thread panicked.
    pub(crate) fn end(self) -> Option<Ended> {
        let assessed = self.thread.join().ok()?;
        Some(Ended {
            summary: summary(&assessed, &self.assignment),
            assessed,
            is_scripted: self.assignment.is_scripted,
            keep: self.keep,
            began_unix_s: self.began_unix_s,
        })
    }
}

/// Assesses the entries of `course` until it ends. Shows the assessment at intervals, and at once
/// when the task is decided.
fn follow(
    mut assessment: Assessment,
    course: &Receiver<Entry>,
    over: &AtomicBool,
    mut show: impl FnMut(&Assessment),
) -> Assessed {
    let mut shown: Option<Instant> = None;
    loop {
        match course.recv_timeout(VIEW_EVERY) {
            Ok(entry) => assessment.take(&entry),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let decided = assessment.is_over() && !over.swap(assessment.is_over(), Ordering::Relaxed);
        if decided || shown.is_none_or(|at| at.elapsed() >= VIEW_EVERY) {
            show(&assessment);
            shown = Some(Instant::now());
        }
    }
    show(&assessment);
    assessment.end()
}

/// State in which a task with given sutures begins, as [`CommandMsg::START`] numbers it. `None`:
/// the state in which the run begins.
pub(crate) fn begins(task: Task) -> Option<u32> {
    match task {
        Task::Identify => Some(1),
        Task::Clamp | Task::Basics => Some(2),
        Task::Cut => Some(3),
        Task::Disconnect => Some(4),
        Task::Full | Task::Free | Task::Scope | Task::Phantom => None,
    }
}

/// Makes the controller prepare the organs for a task.
pub(crate) fn start(argument: u32, station: &Station) -> Result<(), Problem> {
    let kind = CommandMsg::START;
    let command = CommandMsg { kind, argument };
    let reply = Host::open(station)?.command(command, START_PATIENCE)?;
    match reply.outcome {
        ReplyMsg::DONE => Ok(()),
        other => Err(format!("the controller did not prepare the task (answer {other})").into()),
    }
}

/// The result as `summary.json` holds it.
pub(crate) fn summary(assessed: &Assessed, assignment: &Assignment) -> TaskSummary {
    let alarm = |alarm: &assess::Alarm| TaskAlarm {
        at_s: alarm.at_s,
        session_s: alarm.session_s,
        kind: alarm.kind.name().to_owned(),
        organ: alarm.organ.clone(),
    };
    let lost = assessed.lost.iter().map(|it| TaskLost {
        metric: it.metric.to_owned(),
        value: it.value,
        points: it.points,
    });
    TaskSummary {
        task: assessed.task.name().to_owned(),
        difficulty: assessed.difficulty.name().to_owned(),
        outcome: assessed.outcome.name().to_owned(),
        reasons: assessed.reasons.iter().map(Reason::to_string).collect(),
        reason_kinds: assessed.reasons.clone(),
        score: assessed.score,
        alarms: assessed.alarms.iter().map(alarm).collect(),
        lost: lost.collect(),
        acts: assessed.acts.clone(),
        injuries: assessed.injuries.clone(),
        cvs: assessed.cvs,
        metrics: serde_json::to_value(assessed.metrics).unwrap_or_default(),
        metrics_version: assessed.version,
        session: assignment.id.clone(),
        hand: assignment.hand().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use assess::{Outcome, Status};

    use super::*;

    fn status(outcome: Outcome) -> Status {
        Status {
            time_s: 65.0,
            outcome,
            score: 80.0,
            steps: vec![(assess::Step::Triangle, false)],
            alarm: None,
            alarms: 3,
            hint: None,
            hold: None,
            views_held: [false; 2],
            reasons: vec![Reason::NotWhole],
        }
    }

    #[test]
    fn an_exam_shows_only_the_time_until_it_is_over() {
        let view = view_of(Task::Cut, Difficulty::Exam, status(Outcome::Running));
        assert_eq!((view.steps.len(), view.score, view.end), (0, None, None));
        let view = view_of(Task::Cut, Difficulty::Exam, status(Outcome::Failed));
        assert_eq!((view.steps.len(), view.score), (1, Some(80.0)));
        assert_eq!(view.end.unwrap().reasons, [Reason::NotWhole]);
        assert!(
            !view_of(Task::Cut, Difficulty::Trainee, status(Outcome::Running))
                .steps
                .is_empty()
        );
    }

    #[test]
    fn a_summary_says_why_in_english_and_by_kind() {
        let (rules, anatomy) = (Rules::default(), Anatomy::default());
        let assessment = Assessment::new(Task::Clamp, Difficulty::Exam, rules, anatomy);
        let scripted = Assignment {
            is_scripted: true,
            ..Assignment::default()
        };
        let summary = serde_json::to_value(summary(&assessment.end(), &scripted)).unwrap();
        assert_eq!(summary["hand"], "scripted");
        assert_eq!(
            summary["reasons"][0],
            "not done: Place 2 clips on the cystic duct"
        );
        let kind = serde_json::json!({
            "kind": "not-done",
            "step": {"kind": "clip", "organ": "cystic duct", "count": 2}
        });
        assert_eq!(summary["reason_kinds"][0], kind);
    }

    #[test]
    fn without_a_task_nothing_is_assessed_and_rules_are_read_first() {
        assert!(
            Assigned::read(&TaskArgs::default(), false)
                .unwrap()
                .is_none()
        );
        let args = TaskArgs {
            task: Some(Task::Free),
            rules: Some("/nowhere/rules.toml".into()),
            ..TaskArgs::default()
        };
        let error = Assigned::read(&args, false).unwrap_err().to_string();
        assert!(error.contains("/nowhere/rules.toml"), "{error}");
    }
}
