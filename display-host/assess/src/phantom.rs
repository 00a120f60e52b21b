//! The drills on the phantom: touch the balls, carry the rope's end to a ball, clip the tube twice,
//! cut it between the clips, take fat away with the hook. Each begins when the one before is done.

use session::Movement;
use shared_mem::message::{Event, EventMsg};

use crate::anatomy::phantom::{BALLS, FAT, ROPE, TUBE};
use crate::anatomy::{Anatomy, Region};
use crate::step::Step;
use crate::tally::Tally;
use crate::vector::{distance, wide};

/// Ball to which the rope's end is carried.
const GOAL: &str = "right ball";
/// Number of clips on the tube.
const CLIPS: usize = 2;
/// Largest distance of the jaws from the middle of the ball at which the rope's end counts as
/// carried, m: twice the ball's radius.
const CARRIED_M: f64 = 0.014;
/// Share of the fat that the trainee must remove in the last drill.
const CLEARED: f64 = 0.05;

/// Progress of the drills.
#[derive(Debug, Clone, Default)]
pub(crate) struct Phantom {
    /// Number of steps that are done.
    done: usize,
    /// True while the jaws hold the rope.
    holds: bool,
    /// Clips on the tube.
    clips: usize,
    /// Removed share of the fat when the present step began.
    began: f64,
    /// Removed share of the fat.
    removed: f64,
}

fn plan() -> Vec<Step> {
    let name = |it: &str| it.to_owned();
    let touch = |it: &str| Step::Touch { organ: name(it) };
    let mut steps: Vec<Step> = BALLS.map(touch).into();
    steps.extend([
        Step::Carry {
            organ: name(ROPE),
            to: name(GOAL),
        },
        Step::Clip {
            organ: name(TUBE),
            count: CLIPS,
        },
        Step::Divide { organ: name(TUBE) },
        Step::Clear { organ: name(FAT) },
    ]);
    steps
}

impl Phantom {
    fn present(&self) -> Option<Step> {
        plan().into_iter().nth(self.done)
    }

    fn next(&mut self, tally: &Tally, anatomy: &Anatomy) {
        self.done += 1;
        self.began = tally.removed(anatomy, &[Region::Elsewhere]);
        self.removed = self.began;
    }

    /// Takes a movement of the hands.
    pub(crate) fn moved(&mut self, moved: &Movement, tally: &Tally, anatomy: &Anatomy) {
        match self.present() {
            Some(Step::Carry { to, .. }) if self.holds => {
                let goal = anatomy.named(&to).and_then(|it| anatomy.organ(it));
                let off_m = goal.map(|it| distance(it.middle, wide(moved.tip_m)));
                if off_m.is_some_and(|it| it <= CARRIED_M) {
                    self.next(tally, anatomy);
                }
            }
            Some(Step::Clear { .. }) => {
                self.removed = tally.removed(anatomy, &[Region::Elsewhere]);
                if self.removed - self.began >= CLEARED {
                    self.next(tally, anatomy);
                }
            }
            _ => {}
        }
    }

    /// Takes an event.
    pub(crate) fn event(&mut self, event: &EventMsg, tally: &Tally, anatomy: &Anatomy) {
        let name = anatomy.organ(event.organ).map(|it| it.name.as_str());
        let is = |organ: &str| name == Some(organ);
        let decoded = event.decode();
        match decoded {
            Ok(Event::Grasp { .. }) => self.holds = is(ROPE),
            Ok(Event::LetGo { .. }) => self.holds = false,
            // A clip that is placed too early is on the tube all the same.
            Ok(Event::Clip { .. }) if is(TUBE) => self.clips += 1,
            _ => {}
        }
        let is_done = match (self.present(), decoded) {
            (Some(Step::Touch { organ }), Ok(Event::Contact { .. } | Event::Press { .. })) => {
                is(&organ)
            }
            (Some(Step::Clip { count, .. }), Ok(_)) => self.clips >= count,
            (Some(Step::Divide { organ }), Ok(Event::Divided { .. })) => is(&organ),
            _ => false,
        };
        if is_done {
            self.next(tally, anatomy);
        }
    }

    /// Share of the present step that is done. `None`: it cannot be measured.
    pub(crate) fn share(&self) -> Option<f64> {
        match self.present()? {
            Step::Clip { count, .. } => Some(self.clips as f64 / count as f64),
            Step::Clear { .. } => Some((self.removed - self.began) / CLEARED),
            _ => None,
        }
    }

    /// The steps, each with true if it is done.
    pub(crate) fn steps(&self) -> Vec<(Step, bool)> {
        let steps = plan().into_iter().enumerate();
        steps
            .map(|(number, step)| (step, number < self.done))
            .collect()
    }
}
