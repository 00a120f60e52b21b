//! The steps of a task, whether they are done, and why the task has failed.

use super::{Procedure, VESSELS};
use crate::anatomy::{Anatomy, Region};
use crate::basics::Basics;
use crate::rules::Rules;
use crate::step::{Reason, Step};
use crate::tally::Tally;
use crate::task::Task;
use crate::vessel::Vessel;
use crate::view::ViewSide;

impl Procedure {
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
    pub(super) fn view(&self, anatomy: &Anatomy, rules: &Rules, tally: &Tally) -> bool {
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
}
