//! The surgeons, and their plan for each task.

use assess::{DRILL_ORGANS, Task, ViewSide};
use clap::ValueEnum;
use shared_mem::scene::{CellRecord, OrganKind};
use shared_mem::words::{Instrument, Switches};

/// A scripted surgeon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Surgeon {
    /// Dissects, two clips on each vessel, and cuts between clips. Shows each organ of the drill
    Careful,
    /// As `Careful`, a little faster; burns on, loses a clip for each vessel, and shakes a shown
    /// picture
    Learner,
    /// As `Careful`, faster; two clips for each vessel close on nothing, and the endoscope wanders
    Novice,
    /// As `Careful`, at three times the speed, without lining up; burns on for longer
    Hurried,
    /// As `Careful`, with a hand that trembles
    Trembling,
    /// As `Careful`, with an endoscope that wanders off
    Wandering,
    /// As `Careful`, with rests in the middle of movements
    Pausing,
    /// Cuts where no clips are
    Unclamped,
    /// Coagulates the bile duct
    Burner,
    /// Closes clips on nothing
    Dropper,
    /// Takes the bile duct for the cystic duct and cuts it
    DuctCutter,
    /// Grasps the bile duct and tears it
    DuctTearer,
    /// Holds the cutting current on the bile duct until its wall is gone
    DuctScorcher,
    /// Holds the coagulating current on the bile duct until its wall is gone
    DuctCoagulator,
    /// Takes the hepatic artery for the cystic artery and cuts it
    ArteryCutter,
    /// Pulls hard at the cystic duct, until what holds it gives way
    DuctPuller,
    /// Pulls hard at the cystic artery, until what holds it gives way
    ArteryPuller,
    /// Holds the cutting current on the hepatic artery until its wall is gone
    ArteryScorcher,
    /// Burns through the gallbladder's wall
    BagBurner,
    /// Burns through the gallbladder's wall, and picks up a stone that spills
    StonePicker,
    /// Burns through the duodenum's wall
    BowelBurner,
    /// Holds the coagulating current deep in the liver
    LiverBurner,
}

/// One step of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Act {
    /// Place the remaining sutures.
    Hang,
    Take(Instrument),
    /// Move to this share of the way along a tube, or to the near side of another organ.
    Reach(OrganKind, f64),
    /// Close the jaws at this share of the way along an organ and withdraw. Repeat a few times,
    /// until a clip or a cut succeeds.
    Work(OrganKind, f64),
    /// Close and open the jaws.
    Close,
    /// Press the coagulation pedal at an organ until the organ has taken this heat, J.
    Scorch(OrganKind, f64),
    /// Press a pedal (a switch of `HandMsg`) for this time, s, and follow the organ as the tissue
    /// in front of it goes.
    BurnThrough(OrganKind, u32, f64),
    /// Close the jaws and draw what they hold back along the shaft by this distance, m.
    Pull(f64),
    /// Close the jaws, carry what they hold to this organ, and open them there.
    Carry(&'static str),
    /// Touch the organ of this name with the tip.
    Touch(&'static str),
    /// Wait for a stone to spill, and draw it out of the body with the grasper.
    PickStone,
    /// Withdraw along the shaft.
    Retreat,
    /// Turn the endoscope to an organ and hold it in the middle of the picture.
    Show(OrganKind),
    /// Show the critical view of safety from this side, and hold it.
    ShowView(ViewSide),
    /// Turn the endoscope back to where it began.
    LookBack,
    /// Dissect with the hook until this share of the regions' tissue is gone.
    Dissect(&'static [u8], f64),
}

impl Surgeon {
    /// The surgeon's steps for a task.
    pub(crate) fn plan(self, task: Task) -> Vec<Act> {
        let vessels = [OrganKind::CysticDuct, OrganKind::CysticArtery];
        let does = |own: Task| task == own || task == Task::Full;
        let mut plan = Vec::new();
        match self {
            Self::Careful
            | Self::Learner
            | Self::Novice
            | Self::Hurried
            | Self::Trembling
            | Self::Wandering
            | Self::Pausing => {
                if does(Task::Identify) {
                    plan.extend([
                        Act::Take(Instrument::Hook),
                        Act::Dissect(&[CellRecord::TRIANGLE], VIEW),
                        Act::Dissect(&[CellRecord::LOWER_BED], VIEW),
                        // The bed's tissue may have been in the way.
                        Act::Dissect(&[CellRecord::TRIANGLE], VIEW),
                        Act::Retreat,
                        Act::ShowView(ViewSide::Front),
                        Act::ShowView(ViewSide::Behind),
                        Act::LookBack,
                    ]);
                }
                if does(Task::Clamp) {
                    plan.push(Act::Take(Instrument::ClipApplier));
                    for kind in vessels {
                        plan.extend(std::iter::repeat_n(Act::Close, self.clips_dropped()));
                        plan.extend([0.45, 0.8].map(|share| Act::Work(kind, share)));
                    }
                }
                if does(Task::Cut) {
                    // Task `cut` begins with clips: two on the body's side of 0.65, one on the
                    // other side.
                    plan.push(Act::Take(Instrument::Scissors));
                    plan.extend(vessels.map(|kind| Act::Work(kind, CUT)));
                }
                if does(Task::Disconnect) {
                    plan.extend([
                        Act::Take(Instrument::Hook),
                        Act::Dissect(&[CellRecord::LOWER_BED, CellRecord::UPPER_BED], WHOLE),
                        Act::Retreat,
                    ]);
                }
                if task == Task::Scope {
                    plan.extend([DRILL_ORGANS; ROUNDS].concat().into_iter().map(Act::Show));
                }
                if task == Task::Basics {
                    plan.extend(basics());
                }
                if task == Task::Phantom {
                    plan.extend(drills());
                }
            }
            Self::Unclamped => {
                // The place is not between the clips with which task `cut` begins.
                let share = if task == Task::Cut { 0.92 } else { 0.65 };
                plan.push(Act::Take(Instrument::Scissors));
                plan.extend(vessels.map(|kind| Act::Work(kind, share)));
            }
            Self::Burner => plan.extend([
                Act::Take(Instrument::Hook),
                Act::Reach(OrganKind::BileDuct, 0.4),
                Act::Scorch(OrganKind::BileDuct, SCORCHED_J),
                Act::Retreat,
            ]),
            Self::Dropper => {
                plan.extend([Act::Take(Instrument::ClipApplier), Act::Retreat]);
                plan.extend([Act::Close; 3]);
            }
            Self::DuctCutter => plan.extend(cutting(OrganKind::BileDuct)),
            Self::ArteryCutter => plan.extend(cutting(OrganKind::Vessel)),
            Self::DuctTearer => plan.extend(grasping(OrganKind::BileDuct, 0.75, Act::Pull(TORN_M))),
            Self::DuctPuller => {
                plan.extend(grasping(OrganKind::CysticDuct, 0.5, Act::Pull(TORN_M)));
            }
            Self::ArteryPuller => {
                plan.extend(grasping(OrganKind::CysticArtery, 0.5, Act::Pull(TORN_M)));
            }
            Self::DuctScorcher => plan.extend(burning(OrganKind::BileDuct, CUTS)),
            Self::DuctCoagulator => plan.extend(burning(OrganKind::BileDuct, COAGULATE)),
            Self::ArteryScorcher => plan.extend(burning(OrganKind::Vessel, CUTS)),
            Self::BagBurner => plan.extend(burning(OrganKind::Gallbladder, CUTS)),
            Self::StonePicker => {
                plan.extend(burning(OrganKind::Gallbladder, CUTS));
                plan.push(Act::PickStone);
            }
            Self::BowelBurner => plan.extend(burning(OrganKind::Intestine, CUTS)),
            Self::LiverBurner => plan.extend(burning(OrganKind::Liver, COAGULATE)),
        }
        plan
    }

    /// True for a surgeon who looks before each step, whatever the hand does.
    pub(crate) fn is_careful(self) -> bool {
        matches!(
            self,
            Self::Careful
                | Self::Learner
                | Self::Novice
                | Self::Trembling
                | Self::Wandering
                | Self::Pausing
        )
    }

    pub(crate) fn speed_m_s(self) -> f64 {
        match self {
            Self::Hurried => 0.12,
            Self::Novice => 0.06,
            Self::Learner => 0.05,
            _ => 0.04,
        }
    }

    /// Clips that close on nothing before each vessel's clips.
    fn clips_dropped(self) -> usize {
        match self {
            Self::Novice => 2,
            Self::Learner => 1,
            _ => 0,
        }
    }
}

/// The scissors at this duct or vessel.
fn cutting(kind: OrganKind) -> [Act; 2] {
    [Act::Take(Instrument::Scissors), Act::Work(kind, 0.4)]
}

/// Takes the grasper to this share of the way along a duct or vessel, and does `act` there.
fn grasping(kind: OrganKind, share: f64, act: Act) -> [Act; 3] {
    [Act::Take(Instrument::Grasper), Act::Reach(kind, share), act]
}

/// The first steps: camera, tip, grasp, clip, current.
fn basics() -> [Act; 11] {
    [
        Act::Take(Instrument::Grasper),
        Act::Show(OrganKind::Stomach),
        Act::Show(OrganKind::Gallbladder),
        Act::Reach(OrganKind::Gallbladder, 0.5),
        Act::Close,
        Act::Retreat,
        Act::Take(Instrument::ClipApplier),
        Act::Work(OrganKind::CysticDuct, 0.45),
        Act::Take(Instrument::Hook),
        Act::Dissect(&[CellRecord::UPPER_BED], STRAND),
        Act::Retreat,
    ]
}

/// The drills on the phantom: touch, carry, clip, cut, take fat away.
fn drills() -> Vec<Act> {
    let mut plan = vec![Act::Take(Instrument::Grasper)];
    for ball in ["upper left ball", "lower left ball", "right ball"] {
        plan.extend([Act::Touch(ball), Act::Retreat]);
    }
    plan.extend([
        Act::Touch("rope"),
        Act::Carry("right ball"),
        Act::Retreat,
        Act::Take(Instrument::ClipApplier),
        Act::Work(OrganKind::CysticDuct, 0.45),
        Act::Work(OrganKind::CysticDuct, 0.8),
        Act::Take(Instrument::Scissors),
        Act::Work(OrganKind::CysticDuct, CUT),
        Act::Take(Instrument::Hook),
        Act::Dissect(&[CellRecord::NOWHERE], CLEARED),
        Act::Retreat,
    ]);
    plan
}

/// The hook at this organ, with this current until its wall is gone.
fn burning(kind: OrganKind, pedal: u32) -> [Act; 4] {
    [
        Act::Take(Instrument::Hook),
        Act::Reach(kind, 0.4),
        Act::BurnThrough(kind, pedal, THROUGH_S),
        Act::Retreat,
    ]
}

/// Time in which either current opens any wall that it is held on, s.
pub(crate) const THROUGH_S: f64 = 20.0;
/// Number of times that the organs of the endoscope drill are shown. A picture that sways, or few
/// identity images on a slow machine, may leave a hold uncounted. A trainee sees that in the ring.
const ROUNDS: usize = 4;
/// Switch of the coagulation pedal in `HandMsg::switches`.
pub(crate) const COAGULATE: u32 = Switches::COAGULATE.bits();
/// Switch of the cutting pedal.
const CUTS: u32 = Switches::CUT.bits();
/// Heat that burns the bile duct without a hole, J: more than the rules allow (0.5 J), less than
/// the 14 J of a hole.
const SCORCHED_J: f64 = 1.5;
/// Pull that tears a duct from its tissue, m.
const TORN_M: f64 = 0.12;
/// Place of the cut, as a share of a vessel's length; clips go on both sides.
pub(crate) const CUT: f64 = 0.65;
/// Share of the tissue of the triangle and of the lower bed that is removed, a little more than the
/// pass rules require (`rules.toml`).
const VIEW: f64 = 0.91;
/// Share of the tissue of the upper bed that the first strand is.
const STRAND: f64 = 0.02;
/// Share of the phantom's fat that is taken away, a little more than its drill asks for.
const CLEARED: f64 = 0.06;
/// Share of the tissue of the whole bed that is removed, a little more than the pass rules require.
const WHOLE: f64 = 0.985;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unclamped_takes_no_clip_and_the_careful_two_on_each() {
        let clips = |surgeon: Surgeon, task| {
            let plan = surgeon.plan(task);
            let applier = plan
                .iter()
                .position(|act| *act == Act::Take(Instrument::ClipApplier));
            let scissors = plan
                .iter()
                .position(|act| *act == Act::Take(Instrument::Scissors));
            let closes = plan.iter().enumerate().filter(|(number, act)| {
                let with_clips = applier.is_some_and(|it| it < *number)
                    && scissors.is_none_or(|it| it > *number);
                matches!(act, Act::Close | Act::Work(..)) && with_clips
            });
            closes.count()
        };
        assert_eq!(
            clips(Surgeon::Careful, Task::Cut),
            0,
            "the task begins with clips"
        );
        assert_eq!(clips(Surgeon::Careful, Task::Full), 4);
        assert_eq!(clips(Surgeon::Careful, Task::Clamp), 4);
        assert_eq!(clips(Surgeon::Careful, Task::Identify), 0);
        assert_eq!(clips(Surgeon::Unclamped, Task::Cut), 0);
        assert_eq!(clips(Surgeon::Dropper, Task::Clamp), 3);
        assert_eq!(clips(Surgeon::Learner, Task::Clamp), 6);
        assert_eq!(clips(Surgeon::Novice, Task::Clamp), 8);
    }
}
