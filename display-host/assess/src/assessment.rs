//! Assessment of an operation. It takes the recorded entries of the session one after the other. It
//! gives a status at any time, and a result at the end.

use session::identity::Seen;
use session::{Entry, EntryContent, Movement};
use shared_mem::message::{EventMsg, PoseMsg};
use shared_mem::words::EventKind;

use crate::act::Act;
use crate::alarm::Alarm;
use crate::anatomy::{Anatomy, Region};
use crate::hold::Hold;
use crate::injury::Injury;
use crate::metrics::{Metric, Values};
use crate::procedure::Procedure;
use crate::rules::{Lost, Rules};
use crate::step::{Hint, Reason, Step, plain_steps, plainly};
use crate::tally::Tally;
use crate::task::{Difficulty, Outcome, Task};
use crate::vector::{Vec3, axis, distance, looking_off, wide};
use crate::view::Cvs;

/// Version of the metrics' definitions and of the tasks' built-in requirements.
pub const VERSION: u32 = 17;
/// Least task number in `CommandMsg::START` at which the controller has cleared the triangle.
const START_CLAMP: u8 = 2;
/// Largest number of alarms that are kept. The same limit holds for moments and for acts.
const KEPT_MAX: usize = 5000;
/// Least distance between neighbouring points of a path that is kept for pictures, m.
const PATH_STEP_M: f64 = 2e-3;
/// Largest number of points in a path that is kept for pictures.
const PATH_MAX: usize = 20_000;

/// An event on the time line.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Moment {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// The event's name.
    pub what: String,
    /// The organ concerned, if any.
    pub organ: Option<String>,
    /// The event's value.
    pub value: f32,
}

/// Hands at the moment of an alarm, for a close picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hands {
    /// View of the endoscope: it looks along −z, with y up.
    pub world_from_camera: PoseMsg,
    /// Middle of the instrument's tips, world frame, m.
    pub tip_m: [f32; 3],
    /// Direction of the instrument's shaft, from the tip to the handle, world frame.
    pub shaft: [f64; 3],
}

/// A path for pictures. Each point has x, y and z in the world frame, m, and the time since the
/// first movement, s.
pub type Path = Vec<[f32; 4]>;

/// Present status of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// Counted time, s.
    pub time_s: f64,
    /// Outcome so far.
    pub outcome: Outcome,
    /// Score so far.
    pub score: f64,
    /// The task's steps, and whether each is done.
    pub steps: Vec<(Step, bool)>,
    /// The newest alarm.
    pub alarm: Option<Alarm>,
    /// Number of alarms.
    pub alarms: usize,
    /// Next thing to do, for beginners.
    pub hint: Option<Hint>,
    /// The running hold, while the next step is to show something and hold it.
    pub hold: Option<Hold>,
    /// True for each side, front and behind, from which the critical view was held.
    pub views_held: [bool; 2],
    /// Reasons why the task is over.
    pub reasons: Vec<Reason>,
}

/// Result of an operation.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Assessed {
    /// [`VERSION`] of the assessment.
    pub version: u32,
    /// The task.
    pub task: Task,
    /// Degree of help that the trainee gets.
    pub difficulty: Difficulty,
    /// Outcome of the task.
    pub outcome: Outcome,
    /// Reasons for the outcome.
    #[serde(serialize_with = "plainly")]
    pub reasons: Vec<Reason>,
    /// Score, 0 to 100.
    pub score: f64,
    /// Lost points, by metric.
    pub lost: Vec<Lost>,
    /// The task's steps, and whether each was done.
    #[serde(serialize_with = "plain_steps")]
    pub steps: Vec<(Step, bool)>,
    /// All alarms, the oldest first.
    pub alarms: Vec<Alarm>,
    /// Acts of an instructor, the oldest first, also those before a restart.
    pub acts: Vec<Act>,
    /// Injuries, the oldest first.
    pub injuries: Vec<Injury>,
    /// The critical view of safety; `None` in the tasks `scope`, `basics` and `phantom`, and for a
    /// scene without Calot's triangle.
    pub cvs: Option<Cvs>,
    /// All metrics; `null` where a metric has no value.
    pub metrics: Values,
    /// Time for which the instrument touched with a force in each bin, s. A bin is [`crate::BIN_N`]
    /// wide. The first begins at 0 N.
    pub force_histogram_s: Vec<f64>,
    /// Events for the time line.
    pub moments: Vec<Moment>,
    /// Paths of instrument and endoscope.
    #[serde(skip)]
    pub paths: [Path; 2],
    /// Hands at the moment of each alarm; `None` before their first movement.
    #[serde(skip)]
    pub hands: Vec<Option<Hands>>,
}

/// The running assessment of an operation.
#[derive(Debug, Clone)]
pub struct Assessment {
    task: Task,
    difficulty: Difficulty,
    rules: Rules,
    anatomy: Anatomy,
    tally: Tally,
    procedure: Procedure,
    alarms: Vec<Alarm>,
    /// Hands at each alarm.
    hands: Vec<Option<Hands>>,
    moments: Vec<Moment>,
    acts: Vec<Act>,
    paths: [Path; 2],
    /// Time of the first entry, ns.
    first_ns: Option<u64>,
    began_ns: Option<u64>,
    newest: Option<Movement>,
    /// Angle between the endoscope's view and its shaft, and the turn of the view about the shaft,
    /// rad.
    sight_rad: [f64; 2],
    restarts: u32,
    is_prepared: bool,
    /// Number that the next event should have. `None` before the first event.
    next_event: Option<u64>,
    lost_events: u64,
    /// Counted time at which all steps but the collection of stones were done, s.
    collects_since_s: Option<f64>,
    over: Option<(Outcome, Vec<Reason>)>,
}

impl Assessment {
    /// Begins an assessment. The task begins with the first movement of the hands.
    #[must_use]
    pub fn new(task: Task, difficulty: Difficulty, rules: Rules, anatomy: Anatomy) -> Self {
        Self {
            task,
            difficulty,
            rules,
            tally: Tally::default(),
            procedure: Procedure::new(task, &anatomy),
            anatomy,
            alarms: Vec::new(),
            hands: Vec::new(),
            moments: Vec::new(),
            acts: Vec::new(),
            paths: [Vec::new(), Vec::new()],
            first_ns: None,
            began_ns: None,
            newest: None,
            sight_rad: [0.0; 2],
            restarts: 0,
            is_prepared: false,
            next_event: None,
            lost_events: 0,
            collects_since_s: None,
            over: None,
        }
    }

    /// Takes the next entry. After the end of the task only an instructor's acts are kept.
    pub fn take(&mut self, entry: &Entry) {
        let first_ns = *self.first_ns.get_or_insert(entry.at_ns);
        // Acts are kept even after the outcome is decided: a remark may follow it.
        if let EntryContent::Act(act) = &entry.what {
            let session_s = entry.at_ns.saturating_sub(first_ns) as f64 * 1e-9;
            if self.acts.len() < KEPT_MAX {
                self.acts
                    .extend(Act::of(self.tally.time_s(), session_s, act));
            }
            return;
        }
        if self.over.is_some() {
            return;
        }
        match &entry.what {
            EntryContent::Device { force_max_n } => self.tally.device(f64::from(*force_max_n)),
            EntryContent::Reset => {
                // Before the first movement no attempt has begun, so a reset is no restart.
                self.restarts += u32::from(self.began_ns.is_some());
                self.restart();
            }
            EntryContent::Start { task } => {
                // The first start prepares the task. A later start counts as a restart if the hands
                // have moved since the last start or reset.
                self.restarts += u32::from(self.is_prepared && self.began_ns.is_some());
                self.is_prepared = true;
                self.restart();
                self.procedure.prepare(*task);
                if *task >= START_CLAMP {
                    self.tally.clear(&self.anatomy);
                }
            }
            EntryContent::Sight {
                off_rad,
                turned_rad,
            } => self.sight_rad = [*off_rad, *turned_rad].map(f64::from),
            EntryContent::Seen(seen) => self.seen(seen),
            EntryContent::Act(_) => {} // taken above
            EntryContent::Moved(moved) => self.moved(entry.at_ns, moved),
            EntryContent::Event(event) => {
                let session_s = entry.at_ns.saturating_sub(first_ns) as f64 * 1e-9;
                self.event(session_s, event);
            }
        }
        self.judge();
    }

    fn restart(&mut self) {
        self.tally = self.tally.again();
        self.procedure = Procedure::new(self.task, &self.anatomy);
        self.alarms.clear();
        self.hands.clear();
        self.moments.clear();
        self.paths = [Vec::new(), Vec::new()];
        self.began_ns = None;
        self.lost_events = 0;
        self.collects_since_s = None;
    }

    fn seconds(&self, at_ns: u64) -> f64 {
        let began_ns = self.began_ns.unwrap_or(at_ns);
        at_ns.saturating_sub(began_ns) as f64 * 1e-9
    }

    fn moved(&mut self, at_ns: u64, moved: &Movement) {
        self.began_ns.get_or_insert(at_ns);
        // The recorded pose is the shaft's. The endoscope's view may be inclined to the shaft.
        let moved = &Movement {
            world_from_camera: looking_off(&moved.world_from_camera, self.sight_rad),
            ..*moved
        };
        let (rules, anatomy) = (&self.rules, &self.anatomy);
        let seconds = self.tally.moved(at_ns, moved, anatomy, rules);
        self.procedure.moved(moved, seconds, anatomy, rules);
        self.procedure.drilled(moved, &self.tally, anatomy);
        self.procedure.know(&self.tally, &self.anatomy);
        let at_s = self.seconds(at_ns) as f32;
        let places = [moved.tip_m, moved.world_from_camera.position_m];
        for (path, place) in self.paths.iter_mut().zip(places) {
            let far = |last: &[f32; 4]| distance(first_three(last), wide(place)) >= PATH_STEP_M;
            if path.len() < PATH_MAX && path.last().is_none_or(far) {
                let [x, y, z] = place;
                path.push([x, y, z, at_s]);
            }
        }
        self.newest = Some(*moved);
    }

    /// Takes an identity image, if the hands have moved already.
    fn seen(&mut self, seen: &Seen) {
        if self.began_ns.is_some() {
            let at_s = self.tally.time_s();
            self.procedure.look(at_s, seen, &self.anatomy, &self.rules);
        }
    }

    fn event(&mut self, session_s: f64, event: &EventMsg) {
        // A restarted controller numbers its events from 0 again. Then no event is lost.
        let expected = self.next_event.unwrap_or(event.sequence);
        let lost = event.sequence.saturating_sub(expected);
        self.lost_events = self.lost_events.saturating_add(lost);
        self.next_event = Some(event.sequence.saturating_add(1));
        self.tally.event(event, &self.anatomy);
        // All assessed times leave out pauses and gaps.
        let at_s = self.tally.time_s();
        let wrong = self
            .procedure
            .event(at_s, event, &self.anatomy, &self.rules, &self.tally);
        let room = KEPT_MAX.saturating_sub(self.alarms.len());
        let wrong = wrong.0.into_iter().take(room);
        self.alarms
            .extend(wrong.map(|alarm| Alarm { session_s, ..alarm }));
        let hands = self.newest.as_ref().map(|moved| Hands {
            world_from_camera: moved.world_from_camera,
            tip_m: moved.tip_m,
            shaft: axis(&moved.world_from_instrument, 2),
        });
        self.hands.resize(self.alarms.len(), hands);
        let shown = [
            EventKind::Hung,
            EventKind::Grasp,
            EventKind::Electro,
            EventKind::Tear,
            EventKind::Cut,
            EventKind::Clip,
            EventKind::Leak,
            EventKind::Crush,
            EventKind::Perforation,
            EventKind::Fall,
            EventKind::Shake,
            EventKind::Buried,
            EventKind::Opened,
            EventKind::Unclipped,
            EventKind::Seared,
            EventKind::StoneSpilled,
            EventKind::StoneRetrieved,
        ];
        if shown.iter().any(|kind| event.is(*kind)) && self.moments.len() < KEPT_MAX {
            let organ = self.anatomy.organ(event.organ);
            self.moments.push(Moment {
                at_s,
                what: event.name().to_owned(),
                organ: organ.map(|organ| organ.name.clone()),
                value: event.value,
            });
        }
    }

    fn judge(&mut self) {
        let time_s = self.tally.time_s();
        let steps = self.steps();
        let collects = |(step, _): &(Step, bool)| matches!(step, Step::Collect { .. });
        self.collects_since_s = match steps.iter().all(|it| it.1 || collects(it)) {
            true => self.collects_since_s.or(Some(time_s)),
            false => None,
        };
        // The time limit ends the collection of stones, and not the task before it.
        let is_late = match self.procedure.failure(time_s, &self.rules) {
            Some(Reason::TooLong { .. }) if self.collects_since_s.is_some() => true,
            Some(why) => {
                self.over = Some((Outcome::Failed, vec![why]));
                return;
            }
            None => false,
        };
        let Some(since_s) = self.collects_since_s.filter(|_| !steps.is_empty()) else {
            return;
        };
        let has_waited = time_s - since_s >= self.rules.done.collect_s;
        if is_late || has_waited || !steps.iter().any(collects) {
            self.over = Some(self.verdict());
        }
    }

    /// Outcome of a task all steps of which are done. Stones may be left.
    fn verdict(&self) -> (Outcome, Vec<Reason>) {
        let values = self.values();
        let (score, _) = self.rules.score(self.task, &values);
        let injuries = self.procedure.serious().map(Reason::injured);
        let mut unmet: Vec<Reason> = injuries.collect();
        unmet.extend(self.rules.unmet(self.task, self.difficulty, score, &values));
        match unmet.is_empty() {
            true => (Outcome::Passed, Vec::new()),
            false => (Outcome::Failed, unmet),
        }
    }

    fn steps(&self) -> Vec<(Step, bool)> {
        let at_s = self.tally.time_s();
        let mut steps = self
            .procedure
            .steps(at_s, &self.anatomy, &self.rules, &self.tally);
        let left = self.tally.stones_left();
        if left > 0 && !steps.is_empty() {
            steps.push((Step::Collect { left }, false));
        }
        steps
    }

    fn values(&self) -> Values {
        let mut values = self.tally.values(&self.anatomy);
        self.procedure.values(&mut values);
        values.set(Metric::Alarms, self.alarms.len() as f64);
        values.set(Metric::Restarts, self.restarts.into());
        values.set(Metric::LostEvents, self.lost_events as f64);
        let complications = self.acts.iter().filter(|it| it.complicates()).count();
        values.set(Metric::Complications, complications as f64);
        values
    }

    /// Counted time since the task began, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.tally.time_s()
    }

    /// True once the hands have moved in this attempt.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.began_ns.is_some()
    }

    /// True if the critical view of safety is present, or has been since the task began.
    #[must_use]
    pub fn has_critical_view(&self) -> bool {
        self.procedure
            .has_view(&self.anatomy, &self.rules, &self.tally)
    }

    /// True once the outcome is decided.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over.is_some()
    }

    /// True for each side, front and behind, from which the critical view was held.
    #[must_use]
    pub fn views_held(&self) -> [bool; 2] {
        self.procedure.views_held()
    }

    /// The metrics so far.
    #[must_use]
    pub fn metrics(&self) -> Values {
        self.values()
    }

    /// Alarms so far, the oldest first.
    #[must_use]
    pub fn alarms(&self) -> &[Alarm] {
        &self.alarms
    }

    /// Present status.
    #[must_use]
    pub fn status(&self) -> Status {
        let steps = self.steps();
        let is_beginner = self.difficulty == Difficulty::Beginner && self.over.is_none();
        let hint = is_beginner.then(|| {
            let state = (&self.anatomy, &self.rules, &self.tally);
            self.procedure.hint(&steps, self.newest.as_ref(), state)
        });
        let is_open = self.over.is_none();
        let hold = is_open.then(|| self.procedure.hold(&steps, &self.rules));
        let (outcome, reasons) = self.over.clone().unwrap_or((Outcome::Running, Vec::new()));
        Status {
            time_s: self.tally.time_s(),
            outcome,
            score: self.rules.score(self.task, &self.values()).0,
            steps,
            alarm: self.alarms.last().cloned(),
            alarms: self.alarms.len(),
            hint: hint.flatten(),
            hold: hold.flatten(),
            views_held: self.procedure.views_held(),
            reasons,
        }
    }

    /// Ends the assessment. A task that is not over is aborted and scores 0. It has failed if an
    /// injury rules out a pass, and it is judged if only stones are left to pick up. Free practice
    /// is never aborted, and keeps its score.
    #[must_use]
    pub fn end(self) -> Assessed {
        let metrics = self.values();
        let (score, lost) = self.rules.score(self.task, &metrics);
        let steps = self.steps();
        let only_stones_are_left = !steps.is_empty() && self.collects_since_s.is_some();
        let (outcome, reasons) = self.over.clone().unwrap_or_else(|| match self.task {
            Task::Free => (Outcome::Practised, Vec::new()),
            _ if only_stones_are_left => self.verdict(),
            _ => {
                let open = steps.iter().filter(|(_, done)| !done);
                let open = open.map(|(step, _)| Reason::NotDone { step: step.clone() });
                let injuries = self.procedure.serious().map(Reason::injured);
                let mut reasons: Vec<Reason> = injuries.collect();
                let outcome = match reasons.is_empty() {
                    true => Outcome::Aborted,
                    false => Outcome::Failed,
                };
                reasons.extend(open);
                (outcome, reasons)
            }
        });
        let has_view = !matches!(self.task, Task::Scope | Task::Basics | Task::Phantom);
        let has_view = has_view && self.anatomy.has_cells(Region::Triangle);
        let cvs = has_view.then(|| self.procedure.cvs());
        let score = match outcome {
            Outcome::Aborted => 0.0,
            _ => score,
        };
        Assessed {
            version: VERSION,
            task: self.task,
            difficulty: self.difficulty,
            outcome,
            reasons,
            score,
            lost,
            steps,
            alarms: self.alarms,
            acts: self.acts,
            injuries: self.procedure.injuries().cloned().collect(),
            cvs,
            metrics,
            force_histogram_s: self.tally.force_histogram(),
            moments: self.moments,
            paths: self.paths,
            hands: self.hands,
        }
    }
}

fn first_three([x, y, z, _]: &[f32; 4]) -> Vec3 {
    wide([*x, *y, *z])
}
