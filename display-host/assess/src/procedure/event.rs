//! Changes of a task by an event: counts, injuries, alarms.

use shared_mem::message::{Event, EventMsg};
use shared_mem::scene::OrganKind;

use super::{Procedure, VESSELS, Wrong};
use crate::alarm::{Alarm, AlarmKind};
use crate::anatomy::Anatomy;
use crate::injury::{Cause, InjuryKind};
use crate::rules::Rules;
use crate::tally::{Tally, is_target};
use crate::task::Task;
use crate::vector::wide;
use crate::vessel::Vessel;

/// An event, and where it happened.
struct Act<'a> {
    at_s: f64,
    event: &'a EventMsg,
    anatomy: &'a Anatomy,
    rules: &'a Rules,
    kind: Option<OrganKind>,
    /// Index of the vessel in [`VESSELS`].
    vessel: Option<usize>,
    /// True for a vessel that an instructor opened.
    is_opened: bool,
}

impl Act<'_> {
    fn alarm(&self, kind: AlarmKind) -> Alarm {
        let organ = self.anatomy.organ(self.event.organ);
        Alarm {
            at_s: self.at_s,
            session_s: 0.0,
            kind,
            organ: organ
                .filter(|_| kind != AlarmKind::Unseen)
                .map(|organ| organ.name.clone()),
            at_m: self.event.at_m,
        }
    }
}

impl Procedure {
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
        let is_burnt_deep = self.find_injury(at_s, event, anatomy, rules);
        let kind = anatomy.kind(event.organ);
        let vessel = VESSELS.iter().position(|(of, _)| Some(*of) == kind);
        let act = Act {
            at_s,
            event,
            anatomy,
            rules,
            kind,
            vessel,
            is_opened: vessel.is_some_and(|which| self.is_opened(which)),
        };
        let mut alarms = Vec::new();
        // A clip on two tubes has two events, and the tally counts it once.
        if tally.acts_blind() > self.acts_unseen {
            self.acts_unseen = tally.acts_blind();
            alarms.push(AlarmKind::Unseen);
        }
        match event.decode() {
            Ok(touch @ (Event::Contact { .. } | Event::Press { .. })) => {
                alarms.extend(self.touch(&act, &touch));
            }
            Ok(Event::Burn { energy_j }) => {
                alarms.extend(self.burn(&act, energy_j.into(), is_burnt_deep));
            }
            Ok(Event::Seared { .. }) => alarms.extend(self.sear(&act)),
            Ok(Event::Clip { number }) => alarms.extend(self.clip(&act, number)),
            Ok(seat @ (Event::ClipCloses { .. } | Event::ClipAlong { .. })) => {
                if let Some(vessel) = self.vessel_of(&act) {
                    vessel.clip_will(&seat, rules.done.leak);
                }
            }
            // An instructor did it, so it is no error. Its consequences are no errors either.
            Ok(complication @ (Event::Opened { .. } | Event::Unclipped { .. })) => {
                if let Some(vessel) = self.vessel_of(&act) {
                    vessel.complicate(&complication);
                }
            }
            Ok(Event::Divided { open }) => alarms.extend(self.divided(&act, open.into())),
            Ok(Event::Cut { .. }) => alarms.extend(self.cut(&act)),
            Ok(Event::Tear { .. }) if !is_target(kind) => alarms.extend(self.tear(&act)),
            Ok(Event::Perforation { .. }) => {
                alarms.push(AlarmKind::Perforated);
                if let Some(vessel) = self.vessel_of(&act) {
                    vessel.injured = true;
                }
            }
            Ok(Event::Hung { suture }) => self.hung |= 1u32.checked_shl(suture).unwrap_or(0),
            Ok(Event::Crush { .. }) if !is_target(kind) => {
                // Jaws that crush press harder than any limit of a touch.
                self.touches_wrong += u32::from(rules.must_not_touch(kind));
                alarms.push(AlarmKind::Crushed);
            }
            Ok(Event::Leak { flow }) => {
                if let Some(vessel) = self.vessel_of(&act) {
                    vessel.leak(wide(event.at_m), f64::from(flow));
                }
            }
            _ => {}
        }
        alarms.extend(self.leak_after_division(&act));
        Wrong(alarms.into_iter().map(|kind| act.alarm(kind)).collect())
    }

    /// Counts a touch of a structure that is protected from touch, and a hard press on any other.
    /// Whoever dissects the bed presses on the liver, so there only a hard press counts.
    fn touch(&mut self, act: &Act<'_>, touch: &Event) -> Option<AlarmKind> {
        if act.rules.must_not_touch(act.kind) {
            self.touches += u32::from(matches!(touch, Event::Contact { .. }));
            if let Event::Press { force_n } = touch {
                self.press_wrong_max_n = self.press_wrong_max_n.max(f64::from(*force_n));
            }
        }
        let is_wrong = act.rules.is_hard(act.kind, touch) && self.is_new(AlarmKind::Touched, act);
        self.touches_wrong += u32::from(is_wrong);
        is_wrong.then_some(AlarmKind::Touched)
    }

    /// Adds the heat of a burn to a structure that must not be burnt, or that is burnt too deep.
    /// Current closes a vessel that an instructor opened.
    fn burn(&mut self, act: &Act<'_>, energy_j: f64, is_deep: bool) -> Option<AlarmKind> {
        let is_wrong = is_deep || act.rules.must_not_burn(self.task, act.kind);
        if !is_wrong || act.is_opened {
            return None;
        }
        let heat_j = energy_j.max(0.0);
        self.burn_wrong_j += heat_j;
        let is_burnt = self.is_burnt(act.event.organ, heat_j, act.rules);
        self.count_burn(act, is_burnt)
    }

    /// Heat from beside has destroyed a wall that the tip need not have touched. Cystic duct and
    /// artery are divided anyway, so only structures that can be injured count.
    fn sear(&mut self, act: &Act<'_>) -> Option<AlarmKind> {
        let is_injured = |kind| act.rules.is_injured_by_heat(kind);
        let is_wrong = act.kind.is_some_and(is_injured) && !act.is_opened;
        self.count_burn(act, is_wrong)
    }

    fn count_burn(&mut self, act: &Act<'_>, is_wrong: bool) -> Option<AlarmKind> {
        let counts = is_wrong && self.is_new(AlarmKind::Burnt, act);
        self.burns_wrong += u32::from(counts);
        counts.then_some(AlarmKind::Burnt)
    }

    fn clip(&mut self, act: &Act<'_>, number: u32) -> Vec<AlarmKind> {
        let Some(which) = act.vessel else {
            return match act.kind {
                None => vec![AlarmKind::ClipLost],
                Some(_) if is_target(act.kind) => Vec::new(),
                Some(_) => vec![AlarmKind::ClipMisplaced],
            };
        };
        let is_early = self.task == Task::Full && !self.had_view && !act.is_opened;
        self.clips_early += u32::from(is_early);
        let is_on_both = (self.vessels.iter().enumerate())
            .any(|(other, vessel)| other != which && vessel.has_clip(number));
        self.clips_on_both += u32::from(is_on_both);
        let at_m = wide(act.event.at_m);
        let vessel = self.vessels.get_mut(which);
        let is_open = vessel.is_some_and(|vessel| vessel.clip(number, at_m));
        [
            is_early.then_some(AlarmKind::TooEarly),
            is_on_both.then_some(AlarmKind::ClipMisplaced),
            is_open.then_some(AlarmKind::ClipOpen),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn divided(&mut self, act: &Act<'_>, open: f64) -> Option<AlarmKind> {
        let is_closed = open <= act.rules.done.leak;
        let vessel = self.vessel_of(act)?;
        vessel.divide(act.at_s, is_closed);
        let clips = vessel.clips();
        let is_clamped = clips >= act.rules.done.clips && is_closed;
        (!is_clamped && self.is_unclamped(act)).then_some(AlarmKind::Unclamped)
    }

    /// Counts a cut of what must not be cut. A cut of a vessel is no error yet: its division has an
    /// event of its own. The event of a cut suture or band names an organ that it holds.
    fn cut(&mut self, act: &Act<'_>) -> Option<AlarmKind> {
        let kind = act.kind?;
        let may_be_cut = matches!(kind, OrganKind::Gallbladder | OrganKind::Liver)
            || is_target(act.kind)
            || act.vessel.is_some();
        // One closing of the blades may cut a tube link by link.
        let is_wrong = !may_be_cut && self.is_new(AlarmKind::Cut, act);
        self.cuts_wrong += u32::from(is_wrong);
        is_wrong.then_some(AlarmKind::Cut)
    }

    fn tear(&mut self, act: &Act<'_>) -> Vec<AlarmKind> {
        let mut alarms = Vec::new();
        // One pull may tear an organ link by link.
        if self.is_new(AlarmKind::Torn, act) {
            self.tears += 1;
            alarms.push(AlarmKind::Torn);
        }
        // A torn attachment leaves the vessel closed: its division has an event of its own.
        if let Some(vessel) = self.vessel_of(act) {
            vessel.injured = true;
        }
        alarms
    }

    /// A leak may be reported before or after the cut that causes it.
    fn leak_after_division(&mut self, act: &Act<'_>) -> Option<AlarmKind> {
        let vessel: &Vessel = self.vessel_of(act)?;
        let leaks =
            vessel.divided.is_some() && !vessel.is_excused() && vessel.leaks(act.rules.done.leak);
        (leaks && self.is_unclamped(act)).then_some(AlarmKind::Unclamped)
    }

    /// Notes an injury that an event shows. The division of a tube has an event of its own. Returns
    /// true for heat at a place that is burnt too deep.
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
            // Also an attachment of the tube that tears, or a band that holds it.
            Ok(Event::Tear { .. }) => {
                let what = (InjuryKind::Torn, Cause::Torn);
                self.injuries.harm(at_s, what, organ, rule);
            }
            Ok(Event::Clip { .. }) => {
                let what = (InjuryKind::Clipped, Cause::Clipped);
                self.injuries.harm(at_s, what, organ, rule);
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
    fn is_new(&mut self, kind: AlarmKind, act: &Act<'_>) -> bool {
        let (organ, at_s) = (act.event.organ, act.at_s);
        let until_s = at_s + act.rules.quiet_s;
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

    /// The vessel of the event.
    fn vessel_of(&mut self, act: &Act<'_>) -> Option<&mut Vessel> {
        self.vessels.get_mut(act.vessel?)
    }

    /// Records an unclamped division. Returns true if it is new.
    fn is_unclamped(&mut self, act: &Act<'_>) -> bool {
        let known = act.vessel.and_then(|which| self.unclamped.get_mut(which));
        known.is_some_and(|known| !core::mem::replace(known, true))
    }

    /// True if an instructor opened this vessel.
    fn is_opened(&self, which: usize) -> bool {
        self.vessels.get(which).is_some_and(|it| it.opened)
    }
}
