//! Attachments between organs, and between an organ and the world.
//!
//! An attachment acts in the substeps of the finer of its two organs. A sphere of the coarser organ
//! is then in the middle of a longer substep. The attachment uses the position that this sphere has
//! reached by then, and its impulse acts over the whole of the longer substep. If attachments were
//! solved once a tick, an organ of 16 substeps would feel them in the last one only: for a
//! sixteenth of the time, at sixteen times the speed.

use heapless::Vec;

use crate::capacity::MAX_ATTACHMENTS;
use crate::scene::{Anchor, Attachment, Scene, numbered};
use crate::tissue::Bodies;
use crate::tissue::bar::Bar;
use crate::tissue::lanes::Lanes;
use crate::tissue::multirate::{Multirate, SubstepWindow};

/// An attachment in the order of solution.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Index in the scene.
    tie: u16,
    /// Number of the suture, if the attachment is one.
    suture: Option<u8>,
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
        let substeps = |sphere: u32| {
            let organ = scene.organs.get(usize::from(organ_of(sphere)));
            organ.map_or(1, |organ| organ.substeps)
        };
        let mut times = scene.finest();
        while times > 0 {
            for (i, (tie, suture)) in (0u16..).zip(numbered(scene.attachments.iter())) {
                let other = match tie.to {
                    Anchor::World(_) => 1,
                    Anchor::Sphere(sphere) => substeps(sphere),
                };
                if substeps(tie.sphere).max(other) == times {
                    let _ = self.turns.push(Turn {
                        tie: i,
                        suture,
                        times,
                    }); // validation rejects a scene with more
                }
            }
            times /= 2;
        }
    }
}

/// Projects every attachment that is due in the finest substep `now` as an elastic link. A suture
/// acts only while it is taut; a severed attachment never acts. An attachment of rest length zero
/// draws its ends together.
pub(crate) fn project_due(scene: &Scene<'_>, now: u32, bodies: &mut Bodies) {
    for i in 0..bodies.ties.turns.len() {
        let Some(turn) = bodies.ties.turns.get(i).copied() else {
            return;
        };
        let Some(moment) = SubstepWindow::due(now, turn.times, scene) else {
            return; // later ones act less often, so none is due
        };
        if let Some(tie) = scene.attachments.get(usize::from(turn.tie))
            && let Some(tie) = bodies.sutures.now(tie, turn.suture)
        {
            let left = bodies.parted.left_of_tie(usize::from(turn.tie));
            project(&tie, left, &moment, scene, bodies);
        }
    }
}

fn project(
    tie: &Attachment,
    left: f32,
    at: &SubstepWindow,
    scene: &Scene<'_>,
    bodies: &mut Bodies,
) {
    if left <= 0.0 {
        return;
    }
    let a = *bodies.nodes.at(tie.sphere);
    let a_pace = Multirate::of(tie.sphere, at, scene, bodies);
    let (difference, other) = match tie.to {
        Anchor::World(at_m) => {
            let from = a.rest_m - Lanes::new(&at_m, 0.0);
            (from + (a.moved_m + a_pace.way(&a)), None)
        }
        Anchor::Sphere(sphere) => {
            let b = *bodies.nodes.at(sphere);
            let b_pace = Multirate::of(sphere, at, scene, bodies);
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
        step_s: at.step_s(),
    };
    let b_weight = other.map_or(0.0, |(_, pace)| pace.weight());
    let push = bar.push(difference, a_pace.weight() + b_weight);
    a_pace.push(bodies.nodes.at_mut(tie.sphere), push);
    if let Some((sphere, pace)) = other {
        pace.push(bodies.nodes.at_mut(sphere), push.scaled(-1.0));
    }
}
