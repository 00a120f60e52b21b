//! Clips: a clip closes the tubes between the jaws of the closing applier, as far as the clip
//! covers them.
//!
//! A clip stays on its link of the tube, moves with the link, and makes it stiff and thin. A
//! flattened tube is half its circumference wide; the part of this width that the clip does not
//! cover stays open. Scissors do not cut a clip (`cut.rs`). A clip that closes on no tube is lost.

use heapless::Vec;

use crate::capacity::{CLIPS, MAX_CLIPPED, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::procedure::grasp::Jaws;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::bar::Bar;
use crate::tissue::tubes::TubeSegment;

/// Length of a closed clip (medium-large, titanium), m. The clip lies at the ends of the jaws.
const CLIP_LENGTH_M: f32 = 0.009;
/// Half of the length of tube that a clip occupies, m. Blades do not cut closer to the clip than
/// this.
const HALF_WIDTH_M: f32 = 0.001_2;
/// Compliance of a clipped link, as a share of the link's own compliance.
const CLIPPED_COMPLIANCE_SHARE: f32 = 0.02;
/// Thickness of a fully closed tube, as a share of the thickness of the open tube.
const CLOSED_THICKNESS_SHARE: f32 = 0.5;

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

/// A clip that closes on a tube of an organ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Closed {
    pub(crate) organ: u8,
    /// Share of the tube's lumen that it closes, 0 to 1.
    pub(crate) share: f32,
    /// Place along the tube at rest, from its end with the lowest sphere, m.
    pub(crate) along_m: f32,
}

/// All clips of a session.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clips {
    clips: Vec<Clip, MAX_CLIPPED>,
    /// Number of clips that closed so far, and number of the next one.
    used: u32,
    /// Number of clips that slipped off. The applier has them again.
    returned: u32,
}

impl Clips {
    /// Clips on tubes.
    pub(crate) fn on_tubes(&self) -> &[Clip] {
        &self.clips
    }

    /// Number of clips left in the applier.
    pub(crate) const fn remaining(&self) -> u32 {
        CLIPS
            .saturating_add(self.returned)
            .saturating_sub(self.used)
    }

    /// Organs with a tube between closing jaws. The applier grasps only these organs. It grasps
    /// them before the jaws touch them, because the ends of a clip close first, so that tissue
    /// between its legs cannot slip out.
    pub(crate) fn between(
        jaws: &Jaws<'_>,
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) -> [bool; MAX_ORGANS] {
        let mut between = [false; MAX_ORGANS];
        for ((organ, _), between) in (0u8..).zip(scene.organs).zip(&mut between) {
            *between = bodies.beads.segments_of(organ).any(|segment| {
                let (ends_m, radius_m) = segment_ends(&segment, bodies);
                jaws.crossing(&ends_m, radius_m).is_some()
            });
        }
        between
    }

    /// Closes the next clip on every tube between `jaws`, if a clip is left. `closed` receives the
    /// clip's number and each organ with such a tube, or no organ if there is no such tube.
    /// O(beads).
    pub(crate) fn close(
        &mut self,
        jaws: &Jaws<'_>,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        mut closed: impl FnMut(u32, Option<Closed>),
    ) {
        if self.remaining() == 0 {
            return;
        }
        let (number, before) = (self.used, self.clips.len());
        self.used += 1;
        let legs = jaws.world_from_instrument.rotation * -Vec3::z();
        for (organ, _) in (0u8..).zip(scene.organs) {
            let mut clipped: Option<Closed> = None;
            for segment in bodies.beads.segments_of(organ) {
                let (ends_m, radius_m) = segment_ends(&segment, bodies);
                let is_whole = bodies.damage.intact_of_link(segment.link) > 0.0;
                let covered = covered_share(jaws, &ends_m, radius_m).filter(|_| is_whole);
                let Some((share, closed)) = covered else {
                    continue;
                };
                let clip = Clip {
                    number,
                    spheres: [u32::from(segment.a), u32::from(segment.b)],
                    share,
                    closed,
                    legs,
                    link: segment.link,
                };
                let is_kept = self.clips.push(clip).is_ok();
                if is_kept && clipped.is_none_or(|it| it.share < clip.closed) {
                    clipped = Some(Closed {
                        organ,
                        share: clip.closed,
                        along_m: along_m(&segment, share, organ, (scene, bodies)),
                    });
                }
            }
            if clipped.is_some() {
                closed(number, clipped);
            }
        }
        for clip in self.clips.iter().skip(before) {
            squeeze(clip, bodies);
        }
        if self.clips.len() == before {
            closed(number, None);
        }
    }

    /// Closes the next clip fully on this segment of a tube, without an applier.
    pub(crate) fn close_on(&mut self, segment: &TubeSegment, bodies: &mut Bodies) {
        let (ends_m, _) = segment_ends(segment, bodies);
        let clip = Clip {
            number: self.used,
            spheres: [u32::from(segment.a), u32::from(segment.b)],
            share: 0.5,
            closed: 1.0,
            legs: math::perpendicular(&(ends_m[1] - ends_m[0])),
            link: segment.link,
        };
        if self.remaining() > 0 && self.clips.push(clip).is_ok() {
            self.used += 1;
            squeeze(&clip, bodies);
        }
    }

    /// Takes the newest clip off every tube that it closes, and gives the applier one back.
    /// `slipped` receives each tube's organ, the clip's place, world frame, m, and its number.
    /// Nothing happens without a clip.
    pub(crate) fn slip(&mut self, bodies: &mut Bodies, mut slipped: impl FnMut(u8, Vec3, u32)) {
        let Some(number) = self.clips.iter().map(|clip| clip.number).max() else {
            return;
        };
        for clip in self.clips.iter().filter(|clip| clip.number == number) {
            widen(clip, bodies);
            let [sphere, _] = clip.spheres;
            slipped(*bodies.organ.at(sphere), clip.at_m(bodies), number);
        }
        self.clips.retain(|clip| clip.number != number);
        self.returned = self.returned.saturating_add(1);
    }

    /// Share of a link's lumen that clips leave open.
    pub(crate) fn open_share(&self, link: u32) -> f32 {
        let on_link = self.clips.iter().filter(|clip| clip.link == link);
        on_link.fold(1.0, |open_share, clip| open_share.min(1.0 - clip.closed))
    }

    /// Links with clips, and the clips' positions, world frame, m.
    pub(crate) fn places(&self, bodies: &Bodies) -> Vec<(u32, Vec3), MAX_CLIPPED> {
        let mut places = Vec::new();
        for clip in &self.clips {
            let _ = places.push((clip.link, clip.at_m(bodies))); // has room for all
        }
        places
    }

    /// Holds clipped tubes together and turns each clip with its tube, after the constraints of a
    /// substep of `organ`. If `organ` is `None`, does so for the clips of all organs.
    pub(crate) fn carry(&mut self, organ: Option<u8>, scene: &Scene<'_>, bodies: &mut Bodies) {
        for clip in &mut self.clips {
            let [a, b] = clip.spheres;
            let own_organ = *bodies.organ.at(a);
            let Some(link) = scene.links.get(clip.link as usize) else {
                continue;
            };
            if organ.is_some_and(|organ| organ != own_organ) {
                continue;
            }
            if bodies.damage.intact_of_link(clip.link) > 0.0 {
                let step_s = scene.step_s_of(own_organ);
                let bar = Bar {
                    rest_length_m: link.rest_length_m * bodies.damage.rest_length_share(own_organ),
                    scaled_compliance_per_kg: link.compliance_m_n * CLIPPED_COMPLIANCE_SHARE
                        / (step_s * step_s),
                };
                bar.project(&mut bodies.nodes, [link.a, link.b], 0.0, &mut 0.0);
            }
            let along = bodies.nodes.at(b).center_m() - bodies.nodes.at(a).center_m();
            let along = math::unit(&along).unwrap_or_else(Vec3::z);
            let across = clip.legs - along * along.dot(&clip.legs);
            clip.legs = math::unit(&across).unwrap_or_else(|| math::perpendicular(&along));
        }
    }
}

/// True if a clip at one of these places keeps blades from cutting at `at_m`. `link` is the index
/// of the link to be cut, if a link is to be cut.
pub(crate) fn clip_blocks(places: &[(u32, Vec3)], link: Option<u32>, at_m: &Vec3) -> bool {
    let blocks =
        |place: &(u32, Vec3)| Some(place.0) == link || math::norm(&(place.1 - at_m)) < HALF_WIDTH_M;
    places.iter().any(blocks)
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
    1.0 - (1.0 - CLOSED_THICKNESS_SHARE) * clip.closed
}

/// Place along a tube at rest, m, from its end with the lowest sphere: spheres are numbered along a
/// tube. `share` is the place along the segment, from its sphere `a`, 0, to `b`, 1. O(beads).
fn along_m(
    segment: &TubeSegment,
    share: f32,
    organ: u8,
    (scene, bodies): (&Scene<'_>, &Bodies),
) -> f32 {
    let length_m = |it: &TubeSegment| {
        let link = scene.links.get(it.link as usize);
        link.map_or(0.0, |link| link.rest_length_m)
    };
    let first = segment.a.min(segment.b);
    let before = |it: &TubeSegment| it.a.max(it.b) <= first;
    let before_m: f32 = (bodies.beads.segments_of(organ))
        .filter(before)
        .map(|it| length_m(&it))
        .sum();
    let share = if segment.a == first {
        share
    } else {
        1.0 - share
    };
    before_m + share * length_m(segment)
}

/// Ends of a segment of a tube, world frame, m, and the radius of the tube there, m.
fn segment_ends(segment: &TubeSegment, bodies: &Bodies) -> ([Vec3; 2], f32) {
    let spheres = [u32::from(segment.a), u32::from(segment.b)];
    let [a, b] = spheres.map(|it| *bodies.radius_m.at(it));
    (spheres.map(|it| bodies.nodes.at(it).center_m()), a.min(b))
}

/// Two shares for a link with these ends (world frame, m): the position along the link at which it
/// crosses between the jaws, and the part of its lumen that a clip at the jaws' ends closes there.
fn covered_share(jaws: &Jaws<'_>, ends_m: &[Vec3; 2], radius_m: f32) -> Option<(f32, f32)> {
    let crossing = jaws.crossing(ends_m, radius_m)?;
    let (tip_m, half_m) = (
        jaws.instrument.jaw_length_m(),
        core::f32::consts::FRAC_PI_2 * radius_m,
    );
    let at_m = crossing.along * tip_m;
    let from_m = (at_m - half_m).max(tip_m - CLIP_LENGTH_M);
    let to_m = (at_m + half_m).min(tip_m);
    let closed = (to_m - from_m) / (2.0 * half_m);
    (closed > 0.0).then(|| (crossing.share, closed.min(1.0)))
}
