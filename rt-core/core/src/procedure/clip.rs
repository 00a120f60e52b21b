//! Clips: a clip closes the tubes between the jaws of the closing applier, as far as the clip
//! reaches over the tubes.
//!
//! A clip stays on its link of the tube, moves with the link, and makes it stiff and thin. A tube
//! that is squeezed flat is half its circumference wide; the part of this width that the clip does
//! not reach stays open. Scissors do not cut a clip (`cut.rs`). A clip that closes on no tube is
//! lost.

use heapless::Vec;

use crate::capacity::{CLIPS, MAX_CLIPPED, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::procedure::grasp::Jaws;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::bar::Bar;
use crate::tissue::tubes::Step;

/// Length of a closed clip (medium-large, titanium), m. The clip lies at the ends of the jaws.
const LENGTH_M: f32 = 0.009;
/// Half of the length of tube that a clip occupies, m. Blades do not cut closer to the clip than
/// this.
const HALF_WIDTH_M: f32 = 0.001_2;
/// Compliance of a clipped link, relative to the link's own compliance.
const STIFF: f32 = 0.02;
/// Thickness of a tube that is fully closed, relative to the open tube.
const SQUEEZED: f32 = 0.5;

/// A clip on a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clip {
    /// Number of the clip, from 0. A clip that closes two tubes is listed on both.
    pub number: u32,
    /// Spheres of the tube between which the clip lies.
    pub spheres: [u32; 2],
    /// Position from the first sphere, 0, to the second, 1.
    pub share: f32,
    /// Share of the tube's lumen that the clip closes, 0 to 1.
    pub closed: f32,
    /// Direction of its legs, from the bend to the open ends: a unit vector across the tube, world
    /// frame.
    pub legs: Vec3,
    link: u32,
}

impl Clip {
    /// Position, world frame, m.
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
    /// Clips on tubes.
    pub(crate) fn on_tubes(&self) -> &[Clip] {
        &self.on
    }

    /// Number of clips left in the applier.
    pub(crate) const fn left(&self) -> u32 {
        CLIPS.saturating_sub(self.used)
    }

    /// Organs with a tube between closing jaws. The applier holds only these organs, and holds them
    /// before the jaws touch them: the ends of a clip close first, so tissue between its legs
    /// cannot slip out.
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

    /// Closes the next clip on every tube between `jaws`, if a clip is left. `closed` receives each
    /// organ with such a tube and the clip's number, or `None` and the number if there is no such
    /// tube. O(beads).
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

    /// Closes the next clip fully on this step of a tube, without an applier.
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

    /// Takes the newest clip off every tube that it closes. `slipped` receives each tube's organ,
    /// the clip's place, world frame, m, and its number. Nothing happens without a clip.
    pub(crate) fn slip(&mut self, bodies: &mut Bodies, mut slipped: impl FnMut(u8, Vec3, u32)) {
        let Some(number) = self.on.iter().map(|clip| clip.number).max() else {
            return;
        };
        for clip in self.on.iter().filter(|clip| clip.number == number) {
            widen(clip, bodies);
            let [sphere, _] = clip.spheres;
            slipped(*bodies.organ.at(sphere), clip.at_m(bodies), number);
        }
        self.on.retain(|clip| clip.number != number);
    }

    /// Share of a link's lumen that clips leave open.
    pub(crate) fn open(&self, link: u32) -> f32 {
        let own = self.on.iter().filter(|clip| clip.link == link);
        own.fold(1.0, |open, clip| open.min(1.0 - clip.closed))
    }

    /// Links with clips, and the clips' positions, world frame, m.
    pub(crate) fn places(&self, bodies: &Bodies) -> Vec<(u32, Vec3), MAX_CLIPPED> {
        let mut places = Vec::new();
        for clip in &self.on {
            let _ = places.push((clip.link, clip.at_m(bodies))); // has room for all
        }
        places
    }

    /// Holds clipped tubes together and turns each clip with its tube, after the constraints of a
    /// substep of `organ`. If `organ` is `None`: for the clips of all organs.
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
                let step_s = scene.step_s_of(own);
                let stiff = Bar {
                    rest_length_m: link.rest_length_m * bodies.parted.shrunk(own),
                    softness_per_kg: link.compliance_m_n * STIFF / (step_s * step_s),
                };
                stiff.project(&mut bodies.nodes, [link.a, link.b], 0.0, &mut 0.0);
            }
            let along = bodies.nodes.at(b).center_m() - bodies.nodes.at(a).center_m();
            let along = math::unit(&along).unwrap_or_else(Vec3::z);
            let across = clip.legs - along * along.dot(&clip.legs);
            clip.legs = math::unit(&across).unwrap_or_else(|| math::across(&along));
        }
    }
}

/// True if a clip at one of these places blocks blades that would cut here. `link` is the index of
/// the link to be cut, if it is one.
pub(crate) fn guards(places: &[(u32, Vec3)], link: Option<u32>, at_m: &Vec3) -> bool {
    let is_there =
        |place: &(u32, Vec3)| Some(place.0) == link || math::norm(&(place.1 - at_m)) < HALF_WIDTH_M;
    places.iter().any(is_there)
}

fn squeeze(clip: &Clip, bodies: &mut Bodies) {
    *squeezed(clip, bodies) *= thinned(clip);
}

/// Gives a tube the thickness back that this clip took.
fn widen(clip: &Clip, bodies: &mut Bodies) {
    *squeezed(clip, bodies) /= thinned(clip);
}

/// Radius of the sphere that a clip squeezes, m.
fn squeezed<'a>(clip: &Clip, bodies: &'a mut Bodies) -> &'a mut f32 {
    let [a, b] = clip.spheres;
    bodies.radius_m.at_mut(if clip.share > 0.5 { b } else { a })
}

/// Thickness of a tube under a clip, relative to the open tube.
fn thinned(clip: &Clip) -> f32 {
    1.0 - (1.0 - SQUEEZED) * clip.closed
}

/// Ends of a step (link) along a tube, world frame, m, and the radius of the tube there, m.
fn lies(step: &Step, bodies: &Bodies) -> ([Vec3; 2], f32) {
    let spheres = [u32::from(step.a), u32::from(step.b)];
    let [a, b] = spheres.map(|it| *bodies.radius_m.at(it));
    (spheres.map(|it| bodies.nodes.at(it).center_m()), a.min(b))
}

/// Position at which a link with these ends (world frame, m) crosses between the jaws, as a share
/// of the link, and the share of the lumen that a clip at the jaws' ends closes there.
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
