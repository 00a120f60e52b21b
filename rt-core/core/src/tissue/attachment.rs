//! Attachments between organs, and between an organ and the world.
//!
//! An attachment is solved as often as its stiffness needs (`multirate`): at least in each substep
//! of the coarser organ, at most in each substep of the finer organ. Between two solutions, its
//! force on the finer organ is constant.

use heapless::Vec;

use crate::capacity::{MAX_ATTACHMENTS, MAX_ORGANS};
use crate::scene::{Anchor, Attachment, Scene, numbered};
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tissue::bar::{self, Bar};
use crate::tissue::lanes::Lanes;
use crate::tissue::multirate::{Multirate, Pace, SubstepWindow};

/// Largest permitted loss of an attachment's stiffness, as a share. An attachment is solved in one
/// pass and without warm start, so it loses the share `k dt² w`: k is its stiffness, dt the time
/// between two solutions, w the sum of the inverse masses of its ends.
const STIFFNESS_LOSS_MAX: f32 = 0.03;

/// An attachment, in the order of solution.
#[derive(Debug, Clone, Copy)]
struct ScheduledTie {
    /// Index in the scene.
    tie: u16,
    /// Number of the suture, if the attachment is a suture.
    suture: Option<u8>,
    /// Organs of its ends. An end in the world has the organ of the other end.
    organs: [u8; 2],
    /// Sphere of the end in the finer organ.
    finer_sphere: u32,
}

/// Moments of a tick at which an attachment is solved and acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Schedule {
    /// Number of times that it is solved in a tick.
    solutions: u32,
    /// Number of times that its force acts on the finer organ in a tick: once in each substep of
    /// that organ.
    applications: u32,
    /// Index of the end in the finer organ.
    finer: u8,
}

/// Attachments with the same schedule.
#[derive(Debug, Clone, Copy)]
struct Group {
    schedule: Schedule,
    /// Range of indices in `TieSchedule::ties`: the first, and one past the last.
    ties: [u16; 2],
}

/// Number of possible schedules: 1, 2, 4, 8 or 16 solutions; 1, 2, 4, 8 or 16 substeps of the finer
/// organ; either end in the finer organ.
const MAX_GROUPS: usize = 5 * 5 * 2;

/// Attachments of a scene; those that are solved most often come first.
#[derive(Debug, Clone)]
pub(crate) struct TieSchedule {
    groups: Vec<Group, MAX_GROUPS>,
    ties: Vec<ScheduledTie, MAX_ATTACHMENTS>,
    /// Positional impulse of each attachment on its finer end in a substep of the finer organ, m
    /// kg. Every tick computes it anew.
    repeated: [Lanes; MAX_ATTACHMENTS],
}

impl TieSchedule {
    pub(crate) const NONE: Self = Self {
        groups: Vec::new(),
        ties: Vec::new(),
        repeated: [Lanes::ZERO; MAX_ATTACHMENTS],
    };

    /// Orders the attachments of `scene`. O(attachments · possible schedules).
    pub(crate) fn build(&mut self, scene: &Scene<'_>, organ_of: impl Fn(u32) -> u8) {
        self.groups.clear();
        self.ties.clear();
        let finest = scene.finest();
        for solutions in halvings_from(finest) {
            for applications in halvings_from(finest) {
                for finer in [0, 1] {
                    let first = self.ties.len() as u16;
                    let schedule = Schedule {
                        solutions,
                        applications,
                        finer,
                    };
                    self.add(schedule, scene, &organ_of);
                    let ties = [first, self.ties.len() as u16];
                    if ties[0] < ties[1] {
                        let _ = self.groups.push(Group { schedule, ties }); // there is room for all
                    }
                }
            }
        }
    }

    /// Adds the attachments with this schedule.
    fn add(&mut self, schedule: Schedule, scene: &Scene<'_>, organ_of: impl Fn(u32) -> u8) {
        for (i, (tie, suture)) in (0u16..).zip(numbered(scene.attachments.iter())) {
            let spheres = [tie.sphere, tie.other_sphere().unwrap_or(tie.sphere)];
            let organs = spheres.map(&organ_of);
            if Schedule::of(tie, organs.map(|organ| scene.substeps_of(organ)), scene) == schedule {
                let _ = self.ties.push(ScheduledTie {
                    tie: i,
                    suture,
                    organs,
                    finer_sphere: spheres[usize::from(schedule.finer & 1)],
                }); // validation rejects a scene with more
            }
        }
    }
}

/// A power of two, and each smaller one.
fn halvings_from(solutions_max: u32) -> impl Iterator<Item = u32> {
    core::iter::successors(Some(solutions_max), |it| Some(it / 2)).take_while(|it| *it > 0)
}

impl Schedule {
    /// Schedule of an attachment between organs of these `substeps`.
    fn of(tie: &Attachment, substeps: [u32; 2], scene: &Scene<'_>) -> Self {
        let weight_per_kg = |sphere: u32| {
            let rest = scene.spheres.get(sphere as usize);
            rest.map_or(0.0, super::inverse_mass_per_kg)
        };
        let other_per_kg = tie.other_sphere().map_or(0.0, weight_per_kg);
        let sum_per_kg = weight_per_kg(tie.sphere) + other_per_kg;
        let [own, other] = substeps;
        Self {
            solutions: solutions_per_tick(tie.compliance_m_n, sum_per_kg, substeps),
            applications: own.max(other),
            finer: u8::from(other > own),
        }
    }
}

/// Number of times that an attachment of this compliance is solved in a tick. The inverse masses of
/// its ends sum to `weight_sum_per_kg`, and their organs have these `substeps`.
#[must_use]
pub fn solutions_per_tick(
    compliance_m_n: f32,
    weight_sum_per_kg: f32,
    [own, other]: [u32; 2],
) -> u32 {
    let (mut solutions, solutions_max) = (own.min(other).max(1), own.max(other));
    let stiffness_loss = |solutions: u32| {
        let step_s = TICK_S / solutions as f32;
        step_s * step_s * weight_sum_per_kg / compliance_m_n
    };
    while solutions < solutions_max && stiffness_loss(solutions) > STIFFNESS_LOSS_MAX {
        solutions *= 2;
    }
    solutions
}

/// Projects, as elastic links, the attachments whose window begins with the finest substep `now`.
/// Repeats the forces of the other attachments in the substeps of their finer organs. A suture acts
/// only while it is taut; a severed attachment never acts. An attachment of rest length zero draws
/// its ends together.
pub(crate) fn project_due(scene: &Scene<'_>, now: u32, bodies: &mut Bodies) {
    for group in 0..bodies.ties.groups.len() {
        let Some(Group { schedule, ties }) = bodies.ties.groups.get(group).copied() else {
            return;
        };
        if let Some(window) = SubstepWindow::due(now, schedule.solutions, scene) {
            let per_step_s2 = (window.step_s() * window.step_s()).recip();
            let paces = Pace::of_all(scene, &window);
            for index in ties[0]..ties[1] {
                solve(index, schedule, per_step_s2, &paces, scene, bodies);
            }
        } else if SubstepWindow::due(now, schedule.applications, scene).is_some() {
            for index in ties[0]..ties[1] {
                repeat(index, bodies);
            }
        }
    }
}

/// Solves an attachment for a window of length dt, and applies its impulses. `per_step_s2` is
/// 1/dt².
#[inline(always)]
fn solve(
    index: u16,
    schedule: Schedule,
    per_step_s2: f32,
    paces: &[Pace; MAX_ORGANS],
    scene: &Scene<'_>,
    bodies: &mut Bodies,
) {
    let number = usize::from(index);
    let Some(scheduled) = bodies.ties.ties.get(number).copied() else {
        return;
    };
    let pace = |organ: u8| paces.get(usize::from(organ)).copied();
    let paces = scheduled
        .organs
        .map(|organ| pace(organ).unwrap_or(Pace::SAME));
    let mut pushes = [Lanes::ZERO; 2];
    if let Some(tie) = scene.attachments.get(usize::from(scheduled.tie))
        && let Some(tie) = bodies.sutures.current(tie, scheduled.suture)
    {
        let intact = bodies.damage.intact_of_tie(usize::from(scheduled.tie));
        let push = projection(&tie, intact, per_step_s2, paces, bodies);
        let [own, other] = paces;
        pushes = [push.scaled(own.spread()), push.scaled(-other.spread())];
        push_sphere(tie.sphere, pushes[0], bodies);
        if let Some(sphere) = tie.other_sphere() {
            push_sphere(sphere, pushes[1], bodies);
        }
    }
    if schedule.solutions < schedule.applications
        && let Some(repeated) = bodies.ties.repeated.get_mut(number)
    {
        *repeated = pushes[usize::from(schedule.finer & 1)];
    }
}

/// Applies the impulse of the last solution to the finer end of an attachment.
#[inline(always)]
fn repeat(index: u16, bodies: &mut Bodies) {
    let number = usize::from(index);
    let (Some(scheduled), Some(repeated)) = (
        bodies.ties.ties.get(number),
        bodies.ties.repeated.get(number),
    ) else {
        return;
    };
    push_sphere(scheduled.finer_sphere, *repeated, bodies);
}

/// Applies a positional impulse, m kg.
#[inline(always)]
fn push_sphere(sphere: u32, impulse_m_kg: Lanes, bodies: &mut Bodies) {
    let weight_per_kg = bodies.weight_per_kg(sphere);
    let node = bodies.nodes.at_mut(sphere);
    node.step_m = node.step_m + impulse_m_kg.scaled(weight_per_kg);
}

/// Positional impulse on the first end of an attachment, m kg. `intact` is the intact share of its
/// stiffness; `per_step_s2` is 1/dt², with dt the length of the window.
#[inline(always)]
fn projection(
    tie: &Attachment,
    intact: f32,
    per_step_s2: f32,
    paces: [Pace; 2],
    bodies: &Bodies,
) -> Lanes {
    if intact <= 0.0 {
        return Lanes::ZERO;
    }
    let [a_pace, b_pace] = paces;
    let a = bodies.nodes.at(tie.sphere);
    let a_pace = Multirate::of(tie.sphere, a_pace, bodies);
    let (difference, b_weight) = match tie.to {
        Anchor::World(at_m) => {
            let from = a.rest_m - Lanes::new(&at_m, 0.0);
            (from + (a.moved_m + a_pace.way(a)), 0.0)
        }
        Anchor::Sphere(sphere) => {
            let b = bodies.nodes.at(sphere);
            let b_pace = Multirate::of(sphere, b_pace, bodies);
            let away = a.away_at_start(b) + (a_pace.way(a) - b_pace.way(b));
            (away, b_pace.weight())
        }
    };
    let slack = tie.rest_length_m * tie.rest_length_m;
    if tie.is_thread && difference.norm_squared() <= slack {
        return Lanes::ZERO;
    }
    let bar = Bar {
        rest_length_m: tie.rest_length_m,
        scaled_compliance_per_kg: bar::scaled_compliance_per_kg(
            tie.compliance_m_n,
            intact,
            per_step_s2,
        ),
    };
    bar.push(difference, a_pace.weight() + b_weight)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::{self, Vec3};
    use crate::scene::tests::{organ, room, sphere};
    use crate::scene::{Organ, RestSphere};
    use crate::study::Tissue;
    use crate::tissue::Method;
    use std::boxed::Box;

    const MASS_KG: f32 = 0.000_03;

    /// An organ of `held` substeps with a held sphere, and an organ of `free` substeps with a
    /// sphere that hangs on it by a tie.
    fn organs(held: u32, free: u32) -> [Organ; 2] {
        let mut organs = [organ(0, 1, 0, 0), organ(1, 1, 0, 0)];
        organs[0].substeps = held;
        organs[1].substeps = free;
        organs[1].material.damping_per_s = 200.0;
        organs
    }

    fn spheres() -> [RestSphere; 2] {
        let above = RestSphere {
            held: true,
            ..sphere(Vec3::z() * 0.005, 0.001)
        };
        let below = RestSphere {
            mass_kg: MASS_KG,
            ..sphere(Vec3::zeros(), 0.001)
        };
        [above, below]
    }

    fn tie(stiffness_n_m: f32) -> Attachment {
        Attachment {
            sphere: 1,
            to: Anchor::Sphere(0),
            rest_length_m: 0.005,
            compliance_m_n: stiffness_n_m.recip(),
            is_thread: false,
            tear_j: 0.0,
        }
    }

    #[test]
    fn tie_is_solved_as_often_as_its_stiffness_needs() {
        let (organs, spheres) = (organs(1, 16), spheres());
        let scene = Scene::new(&organs, &spheres, &[], room()).expect("sound");
        // `k dt² w`: at one solution a tick, a stiffness of 0.9 N/m loses 3 %.
        let expected = [
            (0.8, 1),
            (1.0, 2),
            (3.0, 2),
            (14.0, 4),
            (20.0, 8),
            (300.0, 16),
        ];
        for (stiffness_n_m, solutions) in expected {
            let found = Schedule::of(&tie(stiffness_n_m), [1, 16], &scene);
            assert_eq!(
                (found.solutions, found.applications),
                (solutions, 16),
                "{stiffness_n_m} N/m"
            );
        }
        let solutions =
            |stiffness_n_m, substeps| Schedule::of(&tie(stiffness_n_m), substeps, &scene).solutions;
        assert_eq!(solutions(0.1, [4, 16]), 4, "the coarser organ");
        assert_eq!(solutions(0.1, [16, 4]), 4);
        assert_eq!(solutions(1.0e6, [4, 2]), 4, "the finer organ");
    }

    /// The stretch follows from the tie's stiffness, with any substeps of the two organs.
    #[test]
    fn a_hanging_sphere_stretches_a_tie_by_its_weight() {
        for (held, free) in [(1, 1), (1, 4), (1, 16), (4, 16), (16, 4), (16, 1)] {
            for stiffness_n_m in [0.5, 2.0, 8.0] {
                let (organs, spheres) = (organs(held, free), spheres());
                let ties = [tie(stiffness_n_m)];
                let scene = Scene::new(&organs, &spheres, &[], room())
                    .and_then(|scene| scene.with_attachments(&ties))
                    .expect("sound");
                let mut bodies = Box::new(Bodies::new());
                let mut tissue = Tissue::new(scene, &mut bodies, Method::NeoHookean);
                let ticks = 4000;
                let mut stretch_m = 0.0;
                for tick in 0..ticks {
                    assert_eq!(tissue.step(), 0);
                    if tick >= ticks / 2 {
                        stretch_m -= tissue.displacement_m(1).z / (ticks / 2) as f32;
                    }
                }
                let expected_m = MASS_KG * 9.81 / stiffness_n_m;
                // Within a tick, the sphere falls a quarter of `g dt²` below the place where the
                // tick ends.
                let error_m = (stretch_m - expected_m).abs();
                assert!(
                    error_m < 0.03 * expected_m + 0.000_003,
                    "{held} and {free} substeps, {stiffness_n_m} N/m: {stretch_m}, not {expected_m}"
                );
                assert!(math::norm(&tissue.velocity_m_s(1)) < 1.0e-4, "at rest");
            }
        }
    }
}
