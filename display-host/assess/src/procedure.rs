//! Progress of a task: its finished steps, its errors, and its end.

use session::Movement;
use session::identity::Seen;
use shared_mem::scene::OrganKind;

use crate::alarm::{Alarm, AlarmKind};
use crate::anatomy::{Anatomy, Region};
use crate::basics::Basics;
use crate::hold::Hold;
use crate::injury::{Injuries, Injury, Severity};
use crate::means::Means;
use crate::metrics::{Metric, Values};
use crate::phantom::Phantom;
use crate::rules::Rules;
use crate::scope_drill::ScopeDrill;
use crate::steady::Steady;
use crate::step::Step;
use crate::tally::Tally;
use crate::task::Task;
use crate::vessel::Vessel;
use crate::view::{Cvs, Views};

mod event;
mod hint;
mod progress;

/// The vessels of the procedure and their names, in the order of [`Procedure::vessels`].
const VESSELS: [(OrganKind, &str); 2] = [
    (OrganKind::CysticDuct, "cystic duct"),
    (OrganKind::CysticArtery, "cystic artery"),
];

/// Task number in `CommandMsg::START` at which the trainee places the sutures.
const START_HANG: u8 = 0;
/// Least task number at which the controller has clipped both vessels.
const START_CUT: u8 = 3;
/// Least task number at which the controller has divided both vessels.
const START_DISCONNECT: u8 = 4;
/// Number of clips that the controller has put on each vessel from `START_CUT` on (`CLIPS_AT` in
/// `rt_core::sim`).
const GIVEN_CLIPS: usize = 3;

/// State of a running task.
#[derive(Debug, Clone)]
pub(crate) struct Procedure {
    task: Task,
    vessels: [Vessel; 2],
    /// True if the trainee places the sutures.
    hangs: bool,
    /// Placed sutures, one bit each.
    hung: u32,
    /// The critical view of safety has been achieved.
    had_view: bool,
    drill: ScopeDrill,
    basics: Basics,
    phantom: Phantom,
    views: Views,
    steady: Steady,
    touches: u32,
    touches_wrong: u32,
    /// Largest force on a protected structure, N.
    press_wrong_max_n: f64,
    /// Clips on the two vessels before the critical view was achieved.
    clips_early: u32,
    /// Clips on both vessels at once.
    clips_on_both: u32,
    /// Clips and divisions outside the picture that have raised an alarm.
    acts_unseen: u32,
    burns_wrong: u32,
    burn_wrong_j: f64,
    /// Index of each protected organ that took heat, and its heat since its last counted burn, J.
    warmed_j: Vec<(u32, f64)>,
    cuts_wrong: u32,
    tears: u32,
    unclamped: [bool; 2],
    injuries: Injuries,
    means: Means,
    /// Kind and organ of each raised alarm, and the time until which it is not repeated, s.
    quiet: Vec<(AlarmKind, u32, f64)>,
}

/// Errors of the trainee that an event shows.
#[derive(Debug, Default)]
pub(crate) struct Wrong(pub(crate) Vec<Alarm>);

impl Procedure {
    pub(crate) fn new(task: Task, anatomy: &Anatomy) -> Self {
        Self {
            task,
            vessels: Default::default(),
            hangs: false,
            hung: 0,
            had_view: false,
            drill: ScopeDrill::new(anatomy),
            basics: Basics::default(),
            phantom: Phantom::default(),
            views: Views::default(),
            steady: Steady::default(),
            touches: 0,
            touches_wrong: 0,
            press_wrong_max_n: 0.0,
            clips_early: 0,
            clips_on_both: 0,
            acts_unseen: 0,
            burns_wrong: 0,
            burn_wrong_j: 0.0,
            warmed_j: Vec::new(),
            cuts_wrong: 0,
            tears: 0,
            unclamped: [false; 2],
            injuries: Injuries::default(),
            means: Means::default(),
            quiet: Vec::new(),
        }
    }

    /// Takes over the state in which the controller has begun a task (`CommandMsg::START`).
    pub(crate) fn prepare(&mut self, task: u8) {
        self.hangs = task == START_HANG;
        for vessel in &mut self.vessels {
            if task >= START_CUT {
                vessel.given = GIVEN_CLIPS;
            }
            if task >= START_DISCONNECT {
                vessel.divided = Some((0.0, GIVEN_CLIPS));
            }
        }
    }

    /// Takes a movement of the hands. `seconds` is the counted time since the last one.
    pub(crate) fn moved(
        &mut self,
        moved: &Movement,
        seconds: f64,
        anatomy: &Anatomy,
        rules: &Rules,
    ) {
        self.means.moved(moved);
        self.steady.moved(moved, seconds, anatomy.up);
        if self.task == Task::Basics {
            self.basics.moved(moved, seconds, rules.done.look_s);
        }
    }

    /// Takes an identity image, `at_s` after the task began.
    pub(crate) fn look(&mut self, at_s: f64, seen: &Seen, anatomy: &Anatomy, rules: &Rules) {
        let held = self.steady.take();
        let look_s = rules.done.look_s;
        if self.task == Task::Scope {
            self.drill.look(seen, &held, &rules.show, look_s);
        } else if self.task == Task::Basics {
            self.basics.look(seen, &held, anatomy, &rules.show, look_s);
        } else if let Some(rule) = rules.view.as_ref().filter(|_| self.is_untouched()) {
            self.views
                .look(at_s, seen, &held, anatomy, (rule, &rules.done));
        }
    }

    /// Takes a movement of the hands at the phantom.
    pub(crate) fn drilled(&mut self, moved: &Movement, tally: &Tally, anatomy: &Anatomy) {
        if self.task == Task::Phantom {
            self.phantom.moved(moved, tally, anatomy);
        }
    }

    /// Notes the true state of the critical view in the model, until duct or artery is first
    /// clipped, divided or damaged.
    pub(crate) fn know(&mut self, tally: &Tally, anatomy: &Anatomy) {
        if self.is_untouched() {
            let removed = |region| tally.removed(anatomy, &[region]);
            let truth = [removed(Region::Triangle), removed(Region::LowerBed), 1.0];
            self.views.know(truth);
        }
    }

    /// The critical view, as far as it was achieved and shown.
    pub(crate) fn cvs(&self) -> Cvs {
        self.views.cvs()
    }

    /// True for each side from which the critical view was held.
    pub(crate) fn views_held(&self) -> [bool; 2] {
        self.views.held()
    }

    /// The running hold, if the next open step is to show something.
    pub(crate) fn hold(&self, steps: &[(Step, bool)], rules: &Rules) -> Option<Hold> {
        let mut open = steps.iter().filter(|(step, done)| {
            // `LeaveWhole` asks for no action.
            !done && *step != Step::LeaveWhole
        });
        match open.next()? {
            (Step::Show { .. }, _) if self.task == Task::Basics => {
                Some(self.basics.hold(rules.done.look_s))
            }
            (Step::Show { .. }, _) => self.drill.hold(rules.done.look_s),
            (Step::ShowView { .. }, _) => self.views.hold(rules.view.as_ref()?),
            _ => None,
        }
    }

    /// Injuries so far, the oldest first.
    pub(crate) fn injuries(&self) -> impl Iterator<Item = &Injury> {
        self.injuries.all()
    }

    /// Injuries that rule out a pass.
    pub(crate) fn serious(&self) -> impl Iterator<Item = &Injury> {
        self.injuries().filter(|it| it.severity > Severity::Minor)
    }

    /// Sets the metrics that the procedure counts.
    pub(crate) fn values(&self, values: &mut Values) {
        let [duct, artery] = &self.vessels;
        let one_sided = self.vessels.iter().filter(|it| it.one_sided).count();
        let spacings = self.vessels.iter().filter_map(Vessel::spacing_m);
        let spacing_m = spacings.min_by(f64::total_cmp).unwrap_or(f64::NAN);
        let rooms = self.vessels.iter().filter_map(Vessel::room_m);
        let room_m = rooms.min_by(f64::total_cmp).unwrap_or(f64::NAN);
        let whole = self.vessels.iter().filter(|it| it.is_whole()).count();
        let unclamped = self.unclamped.iter().filter(|it| **it).count();
        let held = self.views.held().into_iter().filter(|it| *it).count();
        for (metric, value) in [
            (Metric::Touches, self.touches.into()),
            (Metric::TouchesWrong, self.touches_wrong.into()),
            (Metric::PressWrongMax, self.press_wrong_max_n),
            (Metric::ClipsEarly, self.clips_early.into()),
            (Metric::BurnsWrong, self.burns_wrong.into()),
            (Metric::BurnWrong, self.burn_wrong_j),
            (Metric::CutsWrong, self.cuts_wrong.into()),
            (Metric::Tears, self.tears.into()),
            (Metric::ClipsDuct, duct.clips() as f64),
            (Metric::ClipsArtery, artery.clips() as f64),
            (Metric::ClipSpacing, spacing_m * 1e3),
            (Metric::ClipRoom, room_m * 1e3),
            (Metric::CutsOneSided, one_sided as f64),
            (Metric::Unclamped, unclamped as f64),
            (Metric::Injuries, self.serious().count() as f64),
            (Metric::CvsTwo, whole as f64 / 2.0),
            (Metric::ViewsHeld, held as f64),
            (Metric::ScopeSway, self.drill.sway_mm_s()),
            (
                Metric::ClipsMisplaced,
                values.get(Metric::ClipsMisplaced) + f64::from(self.clips_on_both),
            ),
        ] {
            values.set(metric, value);
        }
    }
}
