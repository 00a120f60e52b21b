//! Leaks: both ends of a divided link, the end of a tube that is torn off an organ, slits (tubes
//! that are torn, cut or burnt half through), and burnt holes.

use crate::capacity::MAX_ORGANS;
use crate::math::Vec3;
use crate::procedure::clip::Clips;
use crate::procedure::vessel::Vessels;
use crate::procedure::vessel::flow::insides;
use crate::scene::{Anchor, Inside, Scene};
use crate::tissue::Bodies;
use crate::tissue::tubes::TubeSegment;

/// Radius of a bag's neck, m. The flow from a hole in a bag is the area of the hole divided by the
/// area of the neck.
const NECK_RADIUS_M: f32 = 0.003;

/// Share of the arriving flow that leaves a slit.
const SLIT_SHARE: f32 = 0.5;

/// An opening to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Opening {
    /// End of a divided link at this sphere.
    Link { link: u32, sphere: u32 },
    /// Former attachment of this sphere to another organ.
    TornOff { sphere: u32 },
    /// Hole in the wall at this sphere.
    Wall { sphere: u32, area_m2: f32 },
    /// Half-severed link at this sphere.
    Slit { link: u32, sphere: u32 },
}

impl Opening {
    pub(super) const fn sphere(&self) -> u32 {
        match self {
            Self::Link { sphere, .. }
            | Self::TornOff { sphere }
            | Self::Wall { sphere, .. }
            | Self::Slit { sphere, .. } => *sphere,
        }
    }

    /// Area of the opening if it is one of a bag, m². A torn-off neck is as wide as a neck.
    pub(super) const fn bag_area_m2(&self) -> f32 {
        match self {
            Self::Wall { area_m2, .. } => *area_m2,
            _ => core::f32::consts::PI * NECK_RADIUS_M * NECK_RADIUS_M,
        }
    }

    /// Share of the arriving flow that leaves through the opening.
    pub(super) fn share(&self, scene: &Scene<'_>, clips: &Clips, bodies: &Bodies) -> f32 {
        match self {
            Self::Link { link, .. } => clips.open_share(*link),
            Self::TornOff { .. } => 1.0,
            // A link that was severed after it became a slit leaks at its two ends.
            Self::Slit { link, .. } if bodies.damage.intact_of_link(*link) <= 0.0 => 0.0,
            Self::Slit { link, .. } => SLIT_SHARE.min(clips.open_share(*link)),
            Self::Wall { sphere, area_m2 } => {
                let holds = |it: &&crate::scene::Organ| {
                    sphere.wrapping_sub(it.sphere_start) < it.sphere_count
                };
                let is_tube = scene
                    .organs
                    .iter()
                    .find(holds)
                    .is_some_and(|it| it.is_tube());
                let own_m = scene
                    .spheres
                    .get(*sphere as usize)
                    .map_or(0.0, |it| it.radius_m);
                let radius_m = if is_tube { own_m } else { NECK_RADIUS_M };
                let inside_m2 = core::f32::consts::PI * radius_m * radius_m;
                (area_m2 / inside_m2.max(f32::MIN_POSITIVE)).min(1.0)
            }
        }
    }
}

/// An opening, and the state of its events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hole {
    pub(super) opening: Opening,
    /// Flow in the last event of this leak.
    pub(super) reported: f32,
    /// Ticks until the opening leaks.
    pub(super) delay_ticks: u32,
    /// Place of the first event of this leak, m. Readers of the events identify a leak by this
    /// place.
    pub(super) at_m: Option<Vec3>,
}

impl Hole {
    pub(super) const fn new(opening: Opening) -> Self {
        Self {
            opening,
            reported: 0.0,
            delay_ticks: 0,
            at_m: None,
        }
    }
}

impl Vessels {
    /// Finds new divisions, and calls `divided` with each. A division for which `divided` returns
    /// false is deferred to a later call. Returns true if none was deferred.
    pub(super) fn find_holes(
        &mut self,
        scene: &Scene<'_>,
        bodies: &Bodies,
        mut divided: impl FnMut(Opening) -> bool,
    ) -> bool {
        let mut all_accepted = true;
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !matches!(it.inside, Inside::Blood | Inside::Bile) {
                continue;
            }
            for segment in bodies.beads.segments_of(organ) {
                if bodies.damage.intact_of_link(segment.link) <= 0.0 {
                    let link = segment.link;
                    let [a, b] = [u32::from(segment.a), u32::from(segment.b)]
                        .map(|sphere| Opening::Link { link, sphere });
                    if !self.is_open(a) && !self.holes.is_full() && !divided(a) {
                        all_accepted = false;
                        continue;
                    }
                    self.add_opening(a);
                    self.add_opening(b);
                    if let Some(divided) = self.divided.get_mut(usize::from(organ)) {
                        *divided = true;
                    }
                }
            }
        }
        self.find_torn_off(scene, bodies, divided) && all_accepted
    }

    /// Finds tubes that have lost all their attachments to an organ. Attachments to fat and other
    /// solid tissue do not count, because they hold no end of a tube.
    fn find_torn_off(
        &mut self,
        scene: &Scene<'_>,
        bodies: &Bodies,
        mut divided: impl FnMut(Opening) -> bool,
    ) -> bool {
        let mut all_accepted = true;
        let mut joined = [[false; MAX_ORGANS]; MAX_ORGANS];
        let pair = |own: u32, other: u32| {
            let organ = |sphere| usize::from(*bodies.organ.at(sphere));
            (organ(own), organ(other))
        };
        for is_first_pass in [true, false] {
            for (i, tie) in scene.attachments.iter().enumerate() {
                let Anchor::Sphere(other) = tie.to else {
                    continue;
                };
                let (own, other_inside) = insides(tie, scene);
                let organs = pair(tie.sphere, other);
                let is_tube = scene.organs.get(organs.0).is_some_and(|it| it.is_tube());
                let carries_flow = matches!(own, Inside::Blood | Inside::Bile);
                if !is_tube || !carries_flow || other_inside == Inside::Solid {
                    continue;
                }
                let is_intact = bodies.damage.intact_of_tie(i) > 0.0;
                let Some(joined) = joined.get_mut(organs.0).and_then(|it| it.get_mut(organs.1))
                else {
                    continue;
                };
                if is_first_pass {
                    *joined |= is_intact;
                } else if !*joined {
                    // One event reports the loss of all attachments between two organs.
                    *joined = true;
                    let torn_off = Opening::TornOff { sphere: tie.sphere };
                    if !self.is_open(torn_off) && !self.holes.is_full() && !divided(torn_off) {
                        all_accepted = false;
                        continue;
                    }
                    self.add_opening(torn_off);
                    if own == other_inside {
                        self.add_opening(Opening::TornOff { sphere: other });
                    }
                }
            }
        }
        all_accepted
    }

    pub(super) fn is_open(&self, opening: Opening) -> bool {
        self.holes.iter().any(|hole| hole.opening == opening)
    }

    /// Adds an opening. If there is no room, the leak is lost, and `Vessels::take_lost_leak`
    /// returns true.
    pub(super) fn add_opening(&mut self, opening: Opening) {
        if !self.is_open(opening) {
            self.has_lost_leak |= self.holes.push(Hole::new(opening)).is_err();
        }
    }
}

/// Share of a tube's lumen that clips leave open beside a division; of the two sides, the larger
/// share.
pub(super) fn open_lumen(
    opening: Opening,
    scene: &Scene<'_>,
    clips: &Clips,
    bodies: &Bodies,
) -> f32 {
    let Opening::Link { link, .. } = opening else {
        // A tube torn off an organ leaves no stump there that a clip could close.
        return 1.0;
    };
    let Some(ends) = scene.links.get(link as usize) else {
        return 1.0;
    };
    let side = |sphere| open_lumen_from(sphere, link, clips, bodies);
    side(ends.a).max(side(ends.b))
}

/// Share of a tube's lumen that clips leave open between this sphere of the divided link `from` and
/// the tube's end; 0 if another division lies in between. O(beads of the organ, squared).
fn open_lumen_from(mut sphere: u32, from: u32, clips: &Clips, bodies: &Bodies) -> f32 {
    let organ = *bodies.organ.at(sphere);
    let (mut open, mut last) = (clips.open_share(from), from);
    for _ in bodies.beads.of(organ) {
        let is_next = |segment: &TubeSegment| {
            let is_at = u32::from(segment.a) == sphere || u32::from(segment.b) == sphere;
            is_at && segment.link != last
        };
        let Some(segment) = bodies.beads.segments_of(organ).find(is_next) else {
            break;
        };
        if bodies.damage.intact_of_link(segment.link) <= 0.0 {
            return 0.0;
        }
        open = open.min(clips.open_share(segment.link));
        last = segment.link;
        let (a, b) = (u32::from(segment.a), u32::from(segment.b));
        sphere = if a == sphere { b } else { a };
    }
    open
}
