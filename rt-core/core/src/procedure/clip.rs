//! Clips: what tubes the applier's jaws truly have between them is closed as far as the clip reaches.
//!
//! A clip stays on its link of the tube and goes with it; the link is stiff and thin there. A tube that
//! is squeezed flat is half its girth wide: what of that lies beyond the clip stays open. Steel is not
//! cut (`cut.rs`), and what is not on a tube is lost.

use heapless::Vec;

use crate::capacity::{CLIPS, MAX_CLIPPED, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::procedure::grasp::Jaws;
use crate::scene::{Link, Scene};
use crate::tissue::tubes::Step;
use crate::tissue::{Bodies, bar};

/// Length of a closed clip (medium-large, titanium), m: it lies at the jaws' ends.
const LENGTH_M: f32 = 0.009;
/// Half the way along a tube that a clip takes, and blades that meet it, m.
const HALF_WIDTH_M: f32 = 0.001_2;
/// Compliance of a clipped link beside that of the tube.
const STIFF: f32 = 0.02;
/// How thick a tube is where it is closed altogether, beside what it was.
const SQUEEZED: f32 = 0.5;

/// A clip on a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clip {
    /// The clip's number, from 0. One that has two tubes between its legs is on both.
    pub number: u32,
    /// The spheres between which it lies.
    pub spheres: [u32; 2],
    /// How far from the first of them to the second, 0 to 1.
    pub share: f32,
    /// Share of the tube's inside that it closes.
    pub closed: f32,
    /// Along its legs, from the bend to the open ends: a unit vector across the tube, world frame.
    pub legs: Vec3,
    link: u32,
}

impl Clip {
    /// Where it is, world frame, m.
    fn at_m(&self, bodies: &Bodies) -> Vec3 {
        let [a, b] = self.spheres.map(|it| bodies.nodes.at(it).center_m());
        a + (b - a) * self.share
    }
}

/// All clips of a session.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clips {
    on: Vec<Clip, MAX_CLIPPED>,
    used: u32,
}

impl Clips {
    /// Those on tubes.
    pub(crate) fn on_tubes(&self) -> &[Clip] {
        &self.on
    }

    /// How many are left in the applier.
    pub(crate) const fn left(&self) -> u32 {
        CLIPS.saturating_sub(self.used)
    }

    /// Which organs have a tube between closing jaws. The applier holds these and nothing beside them, and
    /// does so before they touch, for the ends of a clip close first: what is within its legs cannot slip out.
    pub(crate) fn between(
        jaws: &Jaws<'_>,
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) -> [bool; MAX_ORGANS] {
        let mut between = [false; MAX_ORGANS];
        for ((organ, _), between) in (0u8..).zip(scene.organs).zip(&mut between) {
            *between = bodies.beads.steps_of(organ).any(|step| {
                let (ends_m, radius_m) = lies(&step, bodies);
                jaws.crossing(&ends_m, radius_m).is_some()
            });
        }
        between
    }

    /// Closes the next clip on every tube between `jaws`, if there is one left. `closed` hears of each
    /// organ with such a tube, or of none, and of the clip's number. O(beads).
    pub(crate) fn close(
        &mut self,
        jaws: &Jaws<'_>,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        mut closed: impl FnMut(Option<u8>, u32),
    ) {
        if self.left() == 0 {
            return;
        }
        let (number, before) = (self.used, self.on.len());
        self.used += 1;
        let legs = jaws.world_from_instrument.rotation * -Vec3::z();
        for (organ, _) in (0u8..).zip(scene.organs) {
            let mut has = false;
            for step in bodies.beads.steps_of(organ) {
                let (ends_m, radius_m) = lies(&step, bodies);
                let is_whole = bodies.parted.left_of_link(step.link) > 0.0;
                let held = reach(jaws, &ends_m, radius_m).filter(|_| is_whole);
                let Some((share, closed)) = held else {
                    continue;
                };
                let clip = Clip {
                    number,
                    spheres: [u32::from(step.a), u32::from(step.b)],
                    share,
                    closed,
                    legs,
                    link: step.link,
                };
                has |= self.on.push(clip).is_ok();
            }
            if has {
                closed(Some(organ), number);
            }
        }
        for clip in self.on.iter().skip(before) {
            squeeze(clip, bodies);
        }
        if self.on.len() == before {
            closed(None, number);
        }
    }

    /// Closes the next clip on this step of a tube altogether, whatever the applier does.
    pub(crate) fn put_on(&mut self, step: &Step, bodies: &mut Bodies) {
        let (ends_m, _) = lies(step, bodies);
        let clip = Clip {
            number: self.used,
            spheres: [u32::from(step.a), u32::from(step.b)],
            share: 0.5,
            closed: 1.0,
            legs: math::across(&(ends_m[1] - ends_m[0])),
            link: step.link,
        };
        if self.left() > 0 && self.on.push(clip).is_ok() {
            self.used += 1;
            squeeze(&clip, bodies);
        }
    }

    /// Share of a link's inside that clips leave open.
    pub(crate) fn open(&self, link: u32) -> f32 {
        let own = self.on.iter().filter(|clip| clip.link == link);
        own.fold(1.0, |open, clip| open.min(1.0 - clip.closed))
    }

    /// Where they are, world frame, m, and the links that they are on.
    pub(crate) fn places(&self, bodies: &Bodies) -> Vec<(u32, Vec3), MAX_CLIPPED> {
        let mut places = Vec::new();
        for clip in &self.on {
            let _ = places.push((clip.link, clip.at_m(bodies))); // has room for all
        }
        places
    }

    /// Holds what they are on together, after the constraints of organ `organ` in a substep, and turns with it;
    /// that of every organ if none is given.
    pub(crate) fn carry(&mut self, organ: Option<u8>, scene: &Scene<'_>, bodies: &mut Bodies) {
        for clip in &mut self.on {
            let [a, b] = clip.spheres;
            let own = *bodies.organ.at(a);
            let Some(link) = scene.links.get(clip.link as usize) else {
                continue;
            };
            if organ.is_some_and(|organ| organ != own) {
                continue;
            }
            if bodies.parted.left_of_link(clip.link) > 0.0 {
                let stiff = Link {
                    rest_length_m: link.rest_length_m * bodies.parted.shrunk(own),
                    compliance_m_n: link.compliance_m_n * STIFF,
                    ..*link
                };
                let step_s = scene.step_s_of(own);
                bar::project(&mut bodies.nodes, &stiff, 1.0, 0.0, step_s);
            }
            let along = bodies.nodes.at(b).center_m() - bodies.nodes.at(a).center_m();
            let along = math::unit(&along).unwrap_or_else(Vec3::z);
            let across = clip.legs - along * along.dot(&clip.legs);
            clip.legs = math::unit(&across).unwrap_or_else(|| math::across(&along));
        }
    }
}

/// Whether a clip at one of these places is in the way of blades that would cut a bar (the link with
/// this index, if it is one) here.
pub(crate) fn guards(places: &[(u32, Vec3)], link: Option<u32>, at_m: &Vec3) -> bool {
    let is_there =
        |place: &(u32, Vec3)| Some(place.0) == link || math::norm(&(place.1 - at_m)) < HALF_WIDTH_M;
    places.iter().any(is_there)
}

fn squeeze(clip: &Clip, bodies: &mut Bodies) {
    let [a, b] = clip.spheres;
    let radius_m = bodies.radius_m.at_mut(if clip.share > 0.5 { b } else { a });
    *radius_m *= 1.0 - (1.0 - SQUEEZED) * clip.closed;
}

/// Where a step along a tube lies, world frame, m, and how thick it is.
fn lies(step: &Step, bodies: &Bodies) -> ([Vec3; 2], f32) {
    let spheres = [u32::from(step.a), u32::from(step.b)];
    let [a, b] = spheres.map(|it| *bodies.radius_m.at(it));
    (spheres.map(|it| bodies.nodes.at(it).center_m()), a.min(b))
}

/// Where a link with these ends (world frame, m) crosses between the jaws, as a share of it, and which
/// share of its tube's inside a clip at their ends closes there.
fn reach(jaws: &Jaws<'_>, ends_m: &[Vec3; 2], radius_m: f32) -> Option<(f32, f32)> {
    let crossing = jaws.crossing(ends_m, radius_m)?;
    let (tip_m, half_m) = (
        jaws.instrument.jaw_length_m(),
        core::f32::consts::FRAC_PI_2 * radius_m,
    );
    let at_m = crossing.along * tip_m;
    let from_m = (at_m - half_m).max(tip_m - LENGTH_M);
    let to_m = (at_m + half_m).min(tip_m);
    let closed = (to_m - from_m) / (2.0 * half_m);
    (closed > 0.0).then(|| (crossing.share, closed.min(1.0)))
}
