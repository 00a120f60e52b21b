//! Progress of a task: its finished steps, its errors, and its end.

use session::Movement;
use session::identity::Seen;
use shared_mem::message::{Event, EventMsg};
use shared_mem::scene::OrganKind;

use crate::alarm::{Alarm, AlarmKind};
use crate::anatomy::{Anatomy, Region};
use crate::basics::Basics;
use crate::hold::Hold;
use crate::injury::{Injuries, Injury, InjuryKind, Severity};
use crate::means::Means;
use crate::metrics::{Metric, Values};
use crate::phantom::Phantom;
use crate::rules::Rules;
use crate::scope_drill::ScopeDrill;
use crate::steady::Steady;
use crate::step::{Reason, Step};
use crate::tally::{Tally, is_target};
use crate::task::Task;
use crate::vector::wide;
use crate::vessel::Vessel;
use crate::view::{Cvs, ViewSide, Views};

mod hint;

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

    /// Takes an event, `at_s` after the task began.
    pub(crate) fn event(
        &mut self,
        at_s: f64,
        event: &EventMsg,
        anatomy: &Anatomy,
        rules: &Rules,
        tally: &Tally,
    ) -> Wrong {
        self.had_view |= self.view(anatomy, rules, tally);
        match self.task {
            Task::Basics => self.basics.event(event, anatomy),
            Task::Phantom => self.phantom.event(event, tally, anatomy),
            _ => {}
        }
        let is_deep = self.find_injury(at_s, event, anatomy, rules);
        let mut wrong = Wrong::default();
        let kind = anatomy.kind(event.organ);
        let vessel = VESSELS.iter().position(|(of, _)| Some(*of) == kind);
        let is_opened = vessel.is_some_and(|which| self.is_opened(which));
        let mut say = |what| {
            wrong.0.push(Alarm {
                at_s,
                session_s: 0.0,
                kind: what,
                organ: (anatomy.organ(event.organ))
                    .filter(|_| what != AlarmKind::Unseen)
                    .map(|organ| organ.name.clone()),
                at_m: event.at_m,
            });
        };
        // A clip on two tubes has two events, and the tally counts it once.
        if tally.acts_blind() > self.acts_unseen {
            self.acts_unseen = tally.acts_blind();
            say(AlarmKind::Unseen);
        }
        match event.decode() {
            Ok(touch @ (Event::Contact { .. } | Event::Press { .. }))
                if rules.must_not_touch(kind) =>
            {
                self.touches += u32::from(matches!(touch, Event::Contact { .. }));
                if let Event::Press { force_n } = touch {
                    self.press_wrong_max_n = self.press_wrong_max_n.max(force_n.into());
                }
                if rules.is_hard(&touch)
                    && self.is_new(AlarmKind::Touched, event.organ, at_s, rules)
                {
                    self.touches_wrong += 1;
                    say(AlarmKind::Touched);
                }
            }
            // Whoever dissects the bed presses on the liver: only a hard press counts.
            Ok(press @ Event::Press { .. })
                if rules.is_deep(kind, &press)
                    && self.is_new(AlarmKind::Touched, event.organ, at_s, rules) =>
            {
                self.touches_wrong += 1;
                say(AlarmKind::Touched);
            }
            // Current closes a vessel that an instructor opened.
            Ok(Event::Burn { energy_j })
                if (is_deep || rules.must_not_burn(self.task, kind)) && !is_opened =>
            {
                let heat_j = f64::from(energy_j).max(0.0);
                self.burn_wrong_j += heat_j;
                if self.is_burnt(event.organ, heat_j, rules)
                    && self.is_new(AlarmKind::Burnt, event.organ, at_s, rules)
                {
                    self.burns_wrong += 1;
                    say(AlarmKind::Burnt);
                }
            }
            // Heat from beside has destroyed a wall that the tip need not have touched. Cystic duct
            // and artery are divided anyway, so only structures that can be injured count.
            Ok(Event::Seared { .. })
                if kind.is_some_and(|kind| rules.is_injured_by_heat(kind))
                    && !is_opened
                    && self.is_new(AlarmKind::Burnt, event.organ, at_s, rules) =>
            {
                self.burns_wrong += 1;
                say(AlarmKind::Burnt);
            }
            Ok(Event::Clip { number }) => match vessel {
                Some(which) => {
                    if self.task == Task::Full && !self.had_view && !is_opened {
                        self.clips_early += 1;
                        say(AlarmKind::TooEarly);
                    }
                    if let Some(vessel) = self.vessels.get_mut(which) {
                        vessel.clip(number, wide(event.at_m));
                    }
                }
                None if kind.is_none() => say(AlarmKind::ClipLost),
                None if is_target(kind) => {}
                None => say(AlarmKind::ClipMisplaced),
            },
            // An instructor did it, so it is no error. Its consequences are no errors either.
            Ok(Event::Opened { .. } | Event::Unclipped { .. }) => {
                if let Some(vessel) = vessel.and_then(|which| self.vessels.get_mut(which)) {
                    vessel.complicate(&event.decode());
                }
            }
            Ok(Event::Divided { open }) => {
                if let Some(which) = vessel {
                    let is_closed = f64::from(open) <= rules.done.leak;
                    self.divide(which, at_s, Some(is_closed));
                    let clips = self.vessels.get(which).map_or(0, Vessel::clips);
                    if (clips < rules.done.clips || !is_closed) && self.is_unclamped(which) {
                        say(AlarmKind::Unclamped);
                    }
                }
            }
            Ok(Event::Cut { .. }) => match vessel {
                // A cut of a vessel is no error yet: its division has an event of its own.
                Some(_) => {}
                // The event of a cut suture or band names an organ that the suture or band holds.
                None if is_target(kind) || kind.is_none() => {}
                None if matches!(kind, Some(OrganKind::Gallbladder | OrganKind::Liver)) => {}
                // One closing of the blades may cut a tube link by link.
                None if self.is_new(AlarmKind::Cut, event.organ, at_s, rules) => {
                    self.cuts_wrong += 1;
                    say(AlarmKind::Cut);
                }
                None => {}
            },
            Ok(Event::Tear { .. }) if !is_target(kind) => {
                // One pull may tear an organ link by link.
                if self.is_new(AlarmKind::Torn, event.organ, at_s, rules) {
                    self.tears += 1;
                    say(AlarmKind::Torn);
                }
                if let Some(which) = vessel {
                    self.divide(which, at_s, None);
                    self.injure(which);
                    if self.is_unclamped(which) {
                        say(AlarmKind::Unclamped);
                    }
                }
            }
            Ok(Event::Perforation { .. }) => {
                say(AlarmKind::Perforated);
                if let Some(which) = vessel {
                    self.injure(which);
                }
            }
            Ok(Event::Hung { suture }) => self.hung |= 1u32.checked_shl(suture).unwrap_or(0),
            Ok(Event::Crush { .. }) if !is_target(kind) => {
                // Jaws that crush press harder than any limit of a touch.
                self.touches_wrong += u32::from(rules.must_not_touch(kind));
                say(AlarmKind::Crushed);
            }
            Ok(Event::Leak { flow }) => {
                if let Some(which) = vessel
                    && let Some(vessel) = self.vessels.get_mut(which)
                {
                    vessel.leak(wide(event.at_m), f64::from(flow));
                }
            }
            _ => {}
        }
        // A leak may be reported before or after the cut that causes it.
        if let Some(which) = vessel
            && let Some(vessel) = self.vessels.get(which)
            && vessel.divided.is_some()
            && !vessel.is_excused()
            && vessel.leaks(rules.done.leak)
            && self.is_unclamped(which)
        {
            say(AlarmKind::Unclamped);
        }
        wrong
    }

    /// Notes an injury that an event shows. A torn or cut suture or band has the event of a tear or
    /// cut, and the event names an organ that it holds. So these events are left out. The division
    /// of a tube has an event of its own. Returns true for heat at a place that is burnt too deep.
    fn find_injury(
        &mut self,
        at_s: f64,
        event: &EventMsg,
        anatomy: &Anatomy,
        rules: &Rules,
    ) -> bool {
        self.means.event(at_s, event);
        let kind = anatomy.kind(event.organ);
        let rule = kind.and_then(|kind| rules.injury(kind));
        let (Some(rule), Some(organ)) = (rule, anatomy.organ(event.organ)) else {
            return false;
        };
        let organ = (event.organ, organ.name.as_str());
        let is_to_divide = VESSELS.iter().any(|(of, _)| Some(*of) == kind);
        let cause = self.means.cause(at_s, event);
        match event.decode() {
            Ok(Event::Divided { .. }) if !is_to_divide => {
                let what = (InjuryKind::Divided, cause);
                self.injuries.open(at_s, what, organ, rule);
            }
            Ok(Event::Perforation { .. }) => {
                let what = (InjuryKind::Perforated, cause);
                self.injuries.open(at_s, what, organ, rule);
            }
            Ok(Event::Burn { energy_j }) => {
                let heat = (f64::from(energy_j).max(0.0), wide(event.at_m));
                return self.injuries.heat(at_s, heat, organ, rule);
            }
            Ok(Event::Seared { .. }) => self.injuries.sear(at_s, organ, rule),
            _ => {}
        }
        false
    }

    /// Injuries so far, the oldest first.
    pub(crate) fn injuries(&self) -> impl Iterator<Item = &Injury> {
        self.injuries.all()
    }

    /// Injuries that rule out a pass.
    pub(crate) fn serious(&self) -> impl Iterator<Item = &Injury> {
        self.injuries().filter(|it| it.severity > Severity::Minor)
    }

    /// Adds heat to an organ. Returns true, and begins the sum anew, once the organ counts as
    /// burnt.
    fn is_burnt(&mut self, organ: u32, heat_j: f64, rules: &Rules) -> bool {
        let known = self.warmed_j.iter().position(|it| it.0 == organ);
        let place = known.unwrap_or_else(|| {
            self.warmed_j.push((organ, 0.0));
            self.warmed_j.len() - 1
        });
        let Some((_, warmed_j)) = self.warmed_j.get_mut(place) else {
            return false;
        };
        *warmed_j += heat_j;
        let is_burnt = *warmed_j >= rules.burn_j;
        if is_burnt {
            *warmed_j = 0.0;
        }
        is_burnt
    }

    /// Returns true if this alarm at this organ is not in its quiet time. Each call begins the
    /// quiet time anew.
    fn is_new(&mut self, kind: AlarmKind, organ: u32, at_s: f64, rules: &Rules) -> bool {
        let until_s = at_s + rules.quiet_s;
        let known = self
            .quiet
            .iter_mut()
            .find(|it| (it.0, it.1) == (kind, organ));
        match known {
            Some((_, _, until)) => at_s >= core::mem::replace(until, until_s),
            None => {
                self.quiet.push((kind, organ, until_s));
                true
            }
        }
    }

    fn divide(&mut self, which: usize, at_s: f64, is_closed: Option<bool>) {
        if let Some(vessel) = self.vessels.get_mut(which) {
            vessel.divide(at_s, is_closed);
        }
    }

    fn injure(&mut self, which: usize) {
        if let Some(vessel) = self.vessels.get_mut(which) {
            vessel.injured = true;
        }
    }

    /// Records an unclamped division. Returns true if it is new.
    fn is_unclamped(&mut self, which: usize) -> bool {
        let known = self.unclamped.get_mut(which);
        known.is_some_and(|known| !core::mem::replace(known, true))
    }

    /// True if an instructor opened this vessel.
    fn is_opened(&self, which: usize) -> bool {
        self.vessels.get(which).is_some_and(|it| it.opened)
    }

    /// True while cystic duct and artery are whole, and the trainee has put no clip on them. A clip
    /// on a vessel that an instructor opened does not count.
    pub(crate) fn is_untouched(&self) -> bool {
        self.are_whole() && self.vessels.iter().all(|it| !it.touched)
    }

    fn are_whole(&self) -> bool {
        self.vessels.iter().all(Vessel::is_whole)
    }

    /// True if the critical view of safety is present: enough tissue is removed, and both vessels
    /// are whole.
    fn view(&self, anatomy: &Anatomy, rules: &Rules, tally: &Tally) -> bool {
        let [triangle, lower_bed] = self.cleared(anatomy, rules, tally);
        triangle && lower_bed && self.are_whole()
    }

    /// True if the critical view of safety is present, or has been since the task began.
    pub(crate) fn has_view(&self, anatomy: &Anatomy, rules: &Rules, tally: &Tally) -> bool {
        self.had_view || self.view(anatomy, rules, tally)
    }

    fn cleared(&self, anatomy: &Anatomy, rules: &Rules, tally: &Tally) -> [bool; 2] {
        [
            tally.removed(anatomy, &[Region::Triangle]) >= rules.done.triangle,
            tally.removed(anatomy, &[Region::LowerBed]) >= rules.done.lower_bed,
        ]
    }

    fn is_clipped(&self, which: usize, rules: &Rules) -> bool {
        let vessel = self.vessels.get(which);
        vessel.is_some_and(|vessel| vessel.clips() >= rules.done.clips)
    }

    /// True if the vessel was divided between clips long enough ago and does not leak.
    fn is_divided(&self, which: usize, at_s: f64, rules: &Rules) -> bool {
        let Some(vessel) = self.vessels.get(which) else {
            return false;
        };
        let settled = |since_s: f64| at_s - since_s >= rules.done.settle_s;
        let is_clamped = self.unclamped.get(which) == Some(&false);
        is_clamped
            && !vessel.leaks(rules.done.leak)
            && vessel.divided.is_some_and(|(since_s, _)| settled(since_s))
    }

    /// Steps of the task, each with true if it is done.
    pub(crate) fn steps(
        &self,
        at_s: f64,
        anatomy: &Anatomy,
        rules: &Rules,
        tally: &Tally,
    ) -> Vec<(Step, bool)> {
        let mut steps = Vec::new();
        let wants = |task: Task| self.task == task || self.task == Task::Full;
        if self.hangs && wants(Task::Identify) {
            let count = anatomy.sutures;
            let hung = self.hung.count_ones() as usize;
            steps.push((Step::Hang { count }, hung >= count));
        }
        if wants(Task::Identify) {
            let [triangle, lower_bed] = self.cleared(anatomy, rules, tally);
            // The whole operation needs the view only once, because dividing the vessels ends it.
            let had = self.task == Task::Full && self.had_view;
            steps.push((Step::Triangle, triangle || had));
            steps.push((Step::LowerBed, lower_bed || had));
            // After the first clip of the whole operation the view cannot be shown any more, so
            // these steps count as done. A pass rule asks for the held views.
            if rules.view.is_some() && anatomy.has_cells(Region::Triangle) {
                let is_past = self.task == Task::Full && !self.is_untouched();
                for (side, held) in ViewSide::BOTH.into_iter().zip(self.views.held()) {
                    steps.push((Step::ShowView { side }, held || is_past));
                }
            }
            if self.task == Task::Identify {
                steps.push((Step::LeaveWhole, self.are_whole()));
            }
        }
        let vessels = || {
            VESSELS
                .iter()
                .map(|(_, name)| (*name).to_owned())
                .enumerate()
        };
        if wants(Task::Clamp) {
            let count = rules.done.clips;
            steps.extend(vessels().map(|(which, organ)| {
                let done = self.is_clipped(which, rules);
                (Step::Clip { organ, count }, done)
            }));
        }
        if wants(Task::Cut) {
            steps.extend(vessels().map(|(which, organ)| {
                let done = self.is_divided(which, at_s, rules);
                (Step::Divide { organ }, done)
            }));
        }
        if wants(Task::Disconnect) {
            let bed = tally.removed(anatomy, &[Region::LowerBed, Region::UpperBed]);
            steps.push((Step::Free, bed >= rules.done.bed));
        }
        if self.task == Task::Scope {
            steps = self.drill.steps(anatomy);
        }
        if self.task == Task::Basics {
            steps = Basics::steps(anatomy, self.basics.done());
        }
        if self.task == Task::Phantom {
            steps = self.phantom.steps();
        }
        steps
    }

    /// Reason for failure, if the task has failed.
    pub(crate) fn failure(&self, time_s: f64, rules: &Rules) -> Option<Reason> {
        if self.task == Task::Free {
            return None;
        }
        if let Some((_, name)) = self
            .unclamped
            .iter()
            .zip(VESSELS)
            .find_map(|(un, vessel)| un.then_some(vessel))
        {
            return Some(Reason::Unclamped {
                organ: name.to_owned(),
            });
        }
        if let Some(injury) = self.injuries().find(|it| it.ends_task) {
            return Some(Reason::injured(injury));
        }
        if self.task == Task::Identify && !self.are_whole() {
            return Some(Reason::NotWhole);
        }
        let most_s = rules.time_max_s(self.task);
        (time_s > most_s).then_some(Reason::TooLong { seconds: most_s })
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
        ] {
            values.set(metric, value);
        }
    }
}
