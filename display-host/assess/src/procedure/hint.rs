//! The next instruction for a beginner, with the share of the step that is done.

use session::Movement;

use super::{Procedure, VESSELS};
use crate::anatomy::{Anatomy, Region};
use crate::rules::Rules;
use crate::step::{Advice, Hint, Step};
use crate::tally::Tally;
use crate::task::Task;

impl Procedure {
    /// Next instruction for a beginner.
    pub(crate) fn hint(
        &self,
        steps: &[(Step, bool)],
        moved: Option<&Movement>,
        (anatomy, rules, tally): (&Anatomy, &Rules, &Tally),
    ) -> Option<Hint> {
        let (step, _) = steps.iter().find(|(_, done)| !done)?;
        let held = moved.and_then(Movement::instrument);
        let advice = match step.instrument() {
            Some(it) if held == Some(it) => Advice::Use(it),
            Some(it) => Advice::Take(it),
            None => Advice::Hold,
        };
        let share = self.share(step, anatomy, rules, tally);
        // A step that is not done never shows 100 %.
        let percent = share.map(|it| (100.0 * it).clamp(0.0, 99.0) as u8);
        let step = step.clone();
        Some(Hint {
            step,
            advice,
            percent,
        })
    }

    /// Share of a step that is done, 0 to 1. `None` if the step has no measurable part.
    fn share(&self, step: &Step, anatomy: &Anatomy, rules: &Rules, tally: &Tally) -> Option<f64> {
        let removed = |regions: &[Region], least: f64| {
            let share = tally.removed(anatomy, regions) / least;
            share.is_finite().then_some(share)
        };
        let done = &rules.done;
        match step {
            Step::Hang { count } => {
                Some(f64::from(self.hung.count_ones()) / (*count).max(1) as f64)
            }
            Step::Triangle => removed(&[Region::Triangle], done.triangle),
            Step::LowerBed => removed(&[Region::LowerBed], done.lower_bed),
            Step::Free => removed(&[Region::LowerBed, Region::UpperBed], done.bed),
            _ if self.task == Task::Phantom => self.phantom.share(),
            Step::Clip { organ, count } => {
                let which = VESSELS.iter().position(|(_, name)| name == organ)?;
                let clips = self.vessels.get(which)?.clips();
                Some(clips as f64 / (*count).max(1) as f64)
            }
            Step::Show { .. } if self.task == Task::Scope => Some(self.drill.share(done.look_s)),
            Step::Show { .. } | Step::Meet | Step::Coagulate => {
                Some(self.basics.share(done.look_s))
            }
            Step::ShowView { .. } => Some(self.views.hold(rules.view.as_ref()?)?.share),
            Step::LeaveWhole
            | Step::Divide { .. }
            | Step::Grasp { .. }
            | Step::Touch { .. }
            | Step::Carry { .. }
            | Step::Clear { .. }
            | Step::Collect { .. } => None,
        }
    }
}
