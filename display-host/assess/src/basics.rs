//! The first steps: hold the camera, bring the tip into the middle of the picture, grasp, place a
//! clip, coagulate a strand. Each begins when the one before is done.

use session::Movement;
use session::identity::Seen;
use shared_mem::message::{Event, EventMsg, PoseMsg};
use shared_mem::scene::OrganKind;

use crate::anatomy::Anatomy;
use crate::hold::{Hold, Lack, Timer};
use crate::rules::ShowRule;
use crate::scope_drill::lack;
use crate::steady::Held;
use crate::step::Step;
use crate::tally::{VIEW_HALF_RAD, is_target};
use crate::vector::{Vec3, axis, distance, dot, off_sight, wide};

/// Organ that the camera shows and the grasper holds.
const HELD: OrganKind = OrganKind::Gallbladder;
/// Organs that may be clipped here.
const CLIPPED: [OrganKind; 2] = [OrganKind::CysticDuct, OrganKind::CysticArtery];
/// Distances between lens and tip, m, at which the tip counts as in front of the lens.
const TOGETHER_M: core::ops::RangeInclusive<f64> = 0.01..=0.12;
/// The tip is in the middle of the picture up to this angle from the line of sight, stated as a
/// share of the view's half angle.
const MIDDLE: f64 = 0.5;
/// Heat that coagulates a strand of 5 mm³, J: 0.1 J heats 1 mm³ to 63 °C.
const STRAND_J: f64 = 0.5;
/// Least displacement, m, and least turn, rad, of the camera. Either is enough to show that the
/// trainee led it. The organ is in view at the start, and the first step must not end without a
/// movement.
const LED: [f64; 2] = [0.01, 0.09];
/// Least displacement, m, that shows that the trainee led the tip: the camera of the first step may
/// have brought it into the middle already. A key held for a second led the tip by more at two
/// pictures a second, and the play of the paths, 0.8 mm, is less.
const TIP_LED_M: f64 = 0.005;
/// Number of steps.
const STEPS: usize = 5;

/// Progress of the first steps.
#[derive(Debug, Clone, Default)]
pub(crate) struct Basics {
    /// Number of steps that are done.
    done: usize,
    /// Pose of the camera at the start.
    began: Option<PoseMsg>,
    /// Place of the tip at which the second step began.
    tip_began: Option<Vec3>,
    /// True once the trainee has led the present step's thing far enough: first the camera, then
    /// the tip.
    is_led: bool,
    /// Time for which the camera has held the organ in view.
    timer: Timer,
    /// Time for which the tip has been in the middle of the picture, s.
    held_s: f64,
    /// Heat in fat and connective tissue since the fifth step began, J.
    heat_j: f64,
}

impl Basics {
    /// Takes a movement of the hands. `seconds` is the counted time since the last one.
    pub(crate) fn moved(&mut self, moved: &Movement, seconds: f64, look_s: f64) {
        let camera = &moved.world_from_camera;
        match self.done {
            0 => {
                let began = self.began.get_or_insert(*camera);
                self.is_led |= is_led(began, camera);
            }
            1 => {
                let tip = wide(moved.tip_m);
                let began = self.tip_began.get_or_insert(tip);
                self.is_led |= distance(*began, tip) >= TIP_LED_M;
                let (angle, distance_m) = off_sight(camera, tip);
                let is_held = angle <= MIDDLE * VIEW_HALF_RAD && TOGETHER_M.contains(&distance_m);
                self.held_s = if is_held { self.held_s + seconds } else { 0.0 };
                if self.held_s >= look_s && self.is_led {
                    self.next();
                }
            }
            _ => {}
        }
    }

    /// Takes an identity image, and the movement of the picture since the last identity image.
    pub(crate) fn look(
        &mut self,
        seen: &Seen,
        held: &Held,
        anatomy: &Anatomy,
        rule: &ShowRule,
        look_s: f64,
    ) {
        if self.done > 0 || !self.is_led {
            return;
        }
        let mut organs = anatomy.organs.iter();
        let index = organs.position(|it| it.kind == Some(HELD));
        let lack = match index.and_then(|index| seen.organs.get(index)) {
            Some(organ) => lack(organ, rule),
            None => Some(Lack::OutOfView),
        };
        let done = self.timer.look(lack, held, &rule.steadiness, look_s);
        if done.is_some() {
            self.next();
        }
    }

    /// The running hold of the first step.
    pub(crate) fn hold(&self, look_s: f64) -> Hold {
        let hold = self.timer.hold(look_s);
        Hold {
            lack: hold.lack.or((!self.is_led).then_some(Lack::Unled)),
            ..hold
        }
    }

    /// Takes an event.
    pub(crate) fn event(&mut self, event: &EventMsg, anatomy: &Anatomy) {
        let kind = anatomy.kind(event.organ);
        let clips = |kind| CLIPPED.iter().any(|it| Some(*it) == kind);
        match (self.done, event.decode()) {
            (2, Ok(Event::Grasp { .. })) if kind == Some(HELD) => self.next(),
            (3, Ok(Event::Clip { .. })) if clips(kind) => self.next(),
            (4, Ok(Event::Burn { energy_j })) if is_target(kind) => {
                self.heat_j += f64::from(energy_j).max(0.0);
                if self.heat_j >= STRAND_J {
                    self.next();
                }
            }
            _ => {}
        }
    }

    fn next(&mut self) {
        self.done += 1;
        (self.held_s, self.heat_j, self.is_led) = (0.0, 0.0, false);
    }

    /// Number of steps that are done.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// Share of the present step that is done.
    pub(crate) fn share(&self, look_s: f64) -> f64 {
        match self.done {
            0 => self.hold(look_s).share,
            1 if self.is_led => self.held_s / look_s,
            4 => self.heat_j / STRAND_J,
            _ => 0.0,
        }
    }

    /// The steps, of which the first `done` are done.
    pub(crate) fn steps(anatomy: &Anatomy, done: usize) -> Vec<(Step, bool)> {
        let name = |kind| organ(anatomy, kind).map_or_else(String::new, |it| it.name.clone());
        let steps: [Step; STEPS] = [
            Step::Show { organ: name(HELD) },
            Step::Meet,
            Step::Grasp { organ: name(HELD) },
            Step::Clip {
                organ: name(OrganKind::CysticDuct),
                count: 1,
            },
            Step::Coagulate,
        ];
        let steps = steps.into_iter().enumerate();
        steps.map(|(number, step)| (step, number < done)).collect()
    }
}

/// True if the camera moved or turned far enough from one pose to the other.
fn is_led(from: &PoseMsg, to: &PoseMsg) -> bool {
    let way_m = distance(wide(from.position_m), wide(to.position_m));
    let turn_rad = dot(axis(from, 2), axis(to, 2)).clamp(-1.0, 1.0).acos();
    way_m >= LED[0] || turn_rad >= LED[1]
}

fn organ(anatomy: &Anatomy, kind: OrganKind) -> Option<&crate::anatomy::Organ> {
    anatomy.organs.iter().find(|it| it.kind == Some(kind))
}
