//! Leaks: both ends of a divided link, the end of a tube that is torn off an organ, tubes that are
//! torn, cut or burnt half through, and burnt holes.

use crate::capacity::MAX_ORGANS;
use crate::math::Vec3;
use crate::procedure::clip::Clips;
use crate::procedure::vessel::Vessels;
use crate::procedure::vessel::flow::insides;
use crate::scene::{Anchor, Inside, Scene};
use crate::tissue::Bodies;
use crate::tissue::tubes::TubeSegment;

/// Radius of a bag's neck, m. The flow from a hole in a bag is the hole's area over the area of the
/// neck.
const NECK_RADIUS_M: f32 = 0.003;

/// Share of the arriving flow that leaves a half-parted tube.
const HALF_OPEN: f32 = 0.5;

/// An opening to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Opening {
    /// End of a divided link at this sphere.
    Link { link: u32, sphere: u32 },
    /// Former attachment of this sphere to another organ.
    Off { sphere: u32 },
    /// Hole in the wall at this sphere.
    Wall { sphere: u32, area_m2: f32 },
    /// Link at this sphere that is half parted.
    Slit { link: u32, sphere: u32 },
}

impl Opening {
    pub(super) const fn sphere(&self) -> u32 {
        match self {
            Self::Link { sphere, .. }
            | Self::Off { sphere }
            | Self::Wall { sphere, .. }
            | Self::Slit { sphere, .. } => *sphere,
        }
    }

    /// Share of the arriving flow that comes out.
    pub(super) fn share(&self, scene: &Scene<'_>, clips: &Clips, bodies: &Bodies) -> f32 {
        match self {
            Self::Link { link, .. } => clips.open(*link),
            Self::Off { .. } => 1.0,
            // A link that has parted since leaks at its two ends.
            Self::Slit { link, .. } if bodies.damage.intact_of_link(*link) <= 0.0 => 0.0,
            Self::Slit { link, .. } => HALF_OPEN.min(clips.open(*link)),
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
    pub(super) waits: u32,
    /// Place of the first event of this leak, m. Readers of the events identify a leak by this
    /// place.
    pub(super) at_m: Option<Vec3>,
}

impl Hole {
    pub(super) const fn new(opening: Opening) -> Self {
        Self {
            opening,
            reported: 0.0,
            waits: 0,
            at_m: None,
        }
    }
}

impl Vessels {
    /// Finds new divisions, and calls `divided` with each. A division for which `divided` returns
    /// false is left for a later call. Returns true if none was left.
    pub(super) fn find_holes(
        &mut self,
        scene: &Scene<'_>,
        bodies: &Bodies,
        mut divided: impl FnMut(Opening) -> bool,
    ) -> bool {
        let mut is_all = true;
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !matches!(it.inside, Inside::Blood | Inside::Bile) {
                continue;
            }
            for step in bodies.beads.segments_of(organ) {
                if bodies.damage.intact_of_link(step.link) <= 0.0 {
                    let link = step.link;
                    let [a, b] = [u32::from(step.a), u32::from(step.b)]
                        .map(|sphere| Opening::Link { link, sphere });
                    if !self.is_open(a) && !self.holes.is_full() && !divided(a) {
                        is_all = false;
                        continue;
                    }
                    self.open_up(a);
                    self.open_up(b);
                    if let Some(divided) = self.divided.get_mut(usize::from(organ)) {
                        *divided = true;
                    }
                }
            }
        }
        self.find_torn_off(scene, bodies, divided) && is_all
    }

    /// Finds tubes that have lost all their attachments to an organ. Attachments to fat and other
    /// solid tissue do not count, because they hold no end of a tube.
    fn find_torn_off(
        &mut self,
        scene: &Scene<'_>,
        bodies: &Bodies,
        mut divided: impl FnMut(Opening) -> bool,
    ) -> bool {
        let mut is_all = true;
        let mut joined = [[false; MAX_ORGANS]; MAX_ORGANS];
        let pair = |own: u32, other: u32| {
            let organ = |sphere| usize::from(*bodies.organ.at(sphere));
            (organ(own), organ(other))
        };
        for whole in [true, false] {
            for (i, tie) in scene.attachments.iter().enumerate() {
                let Anchor::Sphere(other) = tie.to else {
                    continue;
                };
                let (own, its) = insides(tie, scene);
                let organs = pair(tie.sphere, other);
                let is_tube = scene.organs.get(organs.0).is_some_and(|it| it.is_tube());
                let leads = matches!(own, Inside::Blood | Inside::Bile);
                if !is_tube || !leads || its == Inside::Solid {
                    continue;
                }
                let is_whole = bodies.damage.intact_of_tie(i) > 0.0;
                let Some(joined) = joined.get_mut(organs.0).and_then(|it| it.get_mut(organs.1))
                else {
                    continue;
                };
                if whole {
                    *joined |= is_whole;
                } else if !*joined {
                    // One attachment stands for all.
                    *joined = true;
                    let off = Opening::Off { sphere: tie.sphere };
                    if !self.is_open(off) && !self.holes.is_full() && !divided(off) {
                        is_all = false;
                        continue;
                    }
                    self.open_up(off);
                    if own == its {
                        self.open_up(Opening::Off { sphere: other });
                    }
                }
            }
        }
        is_all
    }

    pub(super) fn is_open(&self, opening: Opening) -> bool {
        self.holes.iter().any(|hole| hole.opening == opening)
    }

    /// Adds an opening. If there is no room, no event reports the leak, and `Vessels::is_overrun`
    /// reports the lack of room.
    pub(super) fn open_up(&mut self, opening: Opening) {
        if !self.is_open(opening) {
            self.is_overrun |= self.holes.push(Hole::new(opening)).is_err();
        }
    }
}

/// Share of a tube's lumen that clips leave open, on the side of the division where more is open.
pub(super) fn unclosed(opening: Opening, scene: &Scene<'_>, clips: &Clips, bodies: &Bodies) -> f32 {
    let Opening::Link { link, .. } = opening else {
        // A tube torn off an organ leaves no stump there that a clip could close.
        return 1.0;
    };
    let Some(ends) = scene.links.get(link as usize) else {
        return 1.0;
    };
    let side = |sphere| unclosed_from(sphere, link, clips, bodies);
    side(ends.a).max(side(ends.b))
}

/// Share of a tube's lumen that clips leave open between this sphere of the divided link `from` and
/// the tube's end; 0 if another division lies in between. O(beads of the organ, squared).
fn unclosed_from(mut sphere: u32, from: u32, clips: &Clips, bodies: &Bodies) -> f32 {
    let organ = *bodies.organ.at(sphere);
    let (mut open, mut last) = (clips.open(from), from);
    for _ in bodies.beads.of(organ) {
        let leads_on = |step: &TubeSegment| {
            let is_at = u32::from(step.a) == sphere || u32::from(step.b) == sphere;
            is_at && step.link != last
        };
        let Some(step) = bodies.beads.segments_of(organ).find(leads_on) else {
            break;
        };
        if bodies.damage.intact_of_link(step.link) <= 0.0 {
            return 0.0;
        }
        open = open.min(clips.open(step.link));
        last = step.link;
        let (a, b) = (u32::from(step.a), u32::from(step.b));
        sphere = if a == sphere { b } else { a };
    }
    open
}
