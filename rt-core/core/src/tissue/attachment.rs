//! Attachments between organs, and between an organ and the world.
//!
//! An attachment acts between the substeps of two organs (`multirate`): at least in each substep of
//! the coarser organ, at most in each of the finer one, and in between as often as its stiffness
//! needs. If a stiff attachment acted once a tick, an organ of 16 substeps would feel it in the
//! last one only: for a sixteenth of the time, at sixteen times the speed.

use heapless::Vec;

use crate::capacity::{MAX_ATTACHMENTS, MAX_ORGANS};
use crate::scene::{Anchor, Attachment, Scene, numbered};
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tissue::bar::Bar;
use crate::tissue::lanes::Lanes;
use crate::tissue::multirate::{Multirate, Pace, SubstepWindow};

/// Largest share of its stiffness that an attachment may lack. It is solved from zero impulses, in
/// one pass, so it lacks `k dt² w` with the stiffness `k`, the time between two solutions `dt` and
/// the sum of the ends' inverse masses `w`.
const SOFTER_MAX: f32 = 0.03;

/// An attachment in the order of solution.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Index in the scene.
    tie: u16,
    /// Number of the suture, if the attachment is one.
    suture: Option<u8>,
    /// Organs of its ends. An end in the world has the organ of the other end.
    organs: [u8; 2],
    /// Number of times that it acts in a tick.
    times: u32,
}

/// Attachments of a scene; those that act most often come first.
#[derive(Debug, Clone)]
pub(crate) struct Ties {
    turns: Vec<Turn, MAX_ATTACHMENTS>,
}

impl Ties {
    pub(crate) const NONE: Self = Self { turns: Vec::new() };

    /// Orders the attachments of `scene`. O(attachments · distinct rates).
    pub(crate) fn build(&mut self, scene: &Scene<'_>, organ_of: impl Fn(u32) -> u8) {
        self.turns.clear();
        let mut times = scene.finest();
        while times > 0 {
            for (i, (tie, suture)) in (0u16..).zip(numbered(scene.attachments.iter())) {
                let own = organ_of(tie.sphere);
                let other = match tie.to {
                    Anchor::World(_) => own,
                    Anchor::Sphere(sphere) => organ_of(sphere),
                };
                let organs = [own, other];
                if times_of(tie, organs.map(|organ| scene.substeps_of(organ)), scene) == times {
                    let _ = self.turns.push(Turn {
                        tie: i,
                        suture,
                        organs,
                        times,
                    }); // validation rejects a scene with more
                }
            }
            times /= 2;
        }
    }
}

/// Number of times that an attachment between organs of these `substeps` acts in a tick.
fn times_of(tie: &Attachment, substeps: [u32; 2], scene: &Scene<'_>) -> u32 {
    let weight_per_kg = |sphere: u32| {
        let rest = scene.spheres.get(sphere as usize);
        rest.map_or(0.0, super::inverse_mass_per_kg)
    };
    let other_per_kg = match tie.to {
        Anchor::World(_) => 0.0,
        Anchor::Sphere(sphere) => weight_per_kg(sphere),
    };
    let sum_per_kg = weight_per_kg(tie.sphere) + other_per_kg;
    let [own, other] = substeps;
    let (mut times, most) = (own.min(other), own.max(other));
    let lacks = |times: u32| {
        let step_s = TICK_S / times as f32;
        step_s * step_s * sum_per_kg / tie.compliance_m_n
    };
    while times < most && lacks(times) > SOFTER_MAX {
        times *= 2;
    }
    times
}

/// Projects every attachment that is due in the finest substep `now` as an elastic link. A suture
/// acts only while it is taut; a severed attachment never acts. An attachment of rest length zero
/// draws its ends together.
pub(crate) fn project_due(scene: &Scene<'_>, now: u32, bodies: &mut Bodies) {
    // Attachments that act equally often follow each other.
    let mut group = Group {
        times: 0,
        step_s: 0.0,
        paces: [Pace::SAME; MAX_ORGANS],
    };
    for i in 0..bodies.ties.turns.len() {
        let Some(turn) = bodies.ties.turns.get(i).copied() else {
            return;
        };
        if turn.times != group.times {
            let Some(window) = SubstepWindow::due(now, turn.times, scene) else {
                return; // later ones act less often, so none is due
            };
            group = Group {
                times: turn.times,
                step_s: window.step_s(),
                paces: Pace::of_all(scene, &window),
            };
        }
        if let Some(tie) = scene.attachments.get(usize::from(turn.tie))
            && let Some(tie) = bodies.sutures.now(tie, turn.suture)
        {
            let left = bodies.parted.left_of_tie(usize::from(turn.tie));
            project(&tie, left, group.step_s, group.paces_of(&turn), bodies);
        }
    }
}

/// Attachments that act equally often.
struct Group {
    /// In a tick.
    times: u32,
    /// Length of their step, s.
    step_s: f32,
    /// Of each organ.
    paces: [Pace; MAX_ORGANS],
}

impl Group {
    /// Paces of both ends.
    #[inline(always)]
    fn paces_of(&self, turn: &Turn) -> [Pace; 2] {
        let pace = |organ| self.paces.get(usize::from(organ)).copied();
        turn.organs.map(|organ| pace(organ).unwrap_or(Pace::SAME))
    }
}

#[inline(always)]
fn project(tie: &Attachment, left: f32, step_s: f32, paces: [Pace; 2], bodies: &mut Bodies) {
    if left <= 0.0 {
        return;
    }
    let [a_pace, b_pace] = paces;
    let a = *bodies.nodes.at(tie.sphere);
    let a_pace = Multirate::of(tie.sphere, a_pace, bodies);
    let (difference, other) = match tie.to {
        Anchor::World(at_m) => {
            let from = a.rest_m - Lanes::new(&at_m, 0.0);
            (from + (a.moved_m + a_pace.way(&a)), None)
        }
        Anchor::Sphere(sphere) => {
            let b = *bodies.nodes.at(sphere);
            let b_pace = Multirate::of(sphere, b_pace, bodies);
            let away = a.away_at_start(&b) + (a_pace.way(&a) - b_pace.way(&b));
            (away, Some((sphere, b_pace)))
        }
    };
    let slack = tie.rest_length_m * tie.rest_length_m;
    if tie.is_thread && difference.norm_squared() <= slack {
        return;
    }
    let bar = Bar {
        rest_length_m: tie.rest_length_m,
        compliance_m_n: tie.compliance_m_n / left,
        step_s,
    };
    let b_weight = other.map_or(0.0, |(_, pace)| pace.weight());
    let push = bar.push(difference, a_pace.weight() + b_weight);
    a_pace.push(bodies.nodes.at_mut(tie.sphere), push);
    if let Some((sphere, pace)) = other {
        pace.push(bodies.nodes.at_mut(sphere), push.scaled(-1.0));
    }
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

    /// A sphere of 0.03 g, of an organ with these substeps, hangs by a tie on a held sphere of an
    /// organ with those.
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
    fn a_tie_acts_as_often_as_its_stiffness_needs() {
        let (organs, spheres) = (organs(1, 16), spheres());
        let scene = Scene::new(&organs, &spheres, &[], room()).expect("sound");
        // `k dt² w`: 0.9 N/m at one solution a tick lacks 3 % of its stiffness.
        let expected = [
            (0.8, 1),
            (1.0, 2),
            (3.0, 2),
            (14.0, 4),
            (20.0, 8),
            (300.0, 16),
        ];
        for (stiffness_n_m, times) in expected {
            let found = times_of(&tie(stiffness_n_m), [1, 16], &scene);
            assert_eq!(found, times, "{stiffness_n_m} N/m");
        }
        assert_eq!(times_of(&tie(0.1), [4, 16], &scene), 4, "the coarser organ");
        assert_eq!(times_of(&tie(0.1), [16, 4], &scene), 4);
        assert_eq!(times_of(&tie(1.0e6), [4, 2], &scene), 4, "the finer organ");
    }

    /// The force is that of the tie's stiffness, whatever the substeps of the two organs.
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
                let off_m = (stretch_m - expected_m).abs();
                assert!(
                    off_m < 0.03 * expected_m + 0.000_003,
                    "{held} and {free} substeps, {stiffness_n_m} N/m: {stretch_m}, not {expected_m}"
                );
                assert!(math::norm(&tissue.velocity_m_s(1)) < 0.02);
            }
        }
    }
}
