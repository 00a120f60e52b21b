//! Where something can come out: both ends of a divided link, of a tube that is torn off what it was
//! grown to, and holes that are burnt.

use crate::capacity::MAX_ORGANS;
use crate::clip::Clips;
use crate::math::Vec3;
use crate::scene::{Anchor, Inside, Scene};
use crate::soft_body::Bodies;
use crate::vessel::Vessels;
use crate::vessel::flow::insides;

/// The inside of a bag narrows to a duct this wide, m: what a hole of it is compared with.
const NECK_RADIUS_M: f32 = 0.003;

/// Something that is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Opening {
    /// The end of a divided link at this sphere.
    Link { link: u32, sphere: u32 },
    /// Where this sphere was grown to another organ.
    Off { sphere: u32 },
    /// A hole in the wall at this sphere.
    Wall { sphere: u32, area_m2: f32 },
}

impl Opening {
    pub(super) const fn sphere(&self) -> u32 {
        match self {
            Self::Link { sphere, .. } | Self::Off { sphere } | Self::Wall { sphere, .. } => *sphere,
        }
    }

    /// Share of what reaches it that comes out.
    pub(super) fn share(&self, scene: &Scene<'_>, clips: &Clips) -> f32 {
        match self {
            Self::Link { link, .. } => clips.open(*link),
            Self::Off { .. } => 1.0,
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

/// An opening, and what was told of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hole {
    pub(super) opening: Opening,
    /// Its flow, as last told.
    pub(super) told: f32,
    /// Where it was first told of, m: whoever reads the events knows it again by that.
    pub(super) at_m: Option<Vec3>,
}

impl Hole {
    pub(super) const fn new(opening: Opening) -> Self {
        Self {
            opening,
            told: 0.0,
            at_m: None,
        }
    }
}

impl Vessels {
    /// Looks for what has been divided.
    pub(super) fn find_holes(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !matches!(it.inside, Inside::Blood | Inside::Bile) {
                continue;
            }
            for step in bodies.beads.steps_of(organ) {
                if bodies.parted.left_of_link(step.link) <= 0.0 {
                    let link = step.link;
                    for sphere in [u32::from(step.a), u32::from(step.b)] {
                        self.open_up(Opening::Link { link, sphere });
                    }
                    if let Some(divided) = self.divided.get_mut(usize::from(organ)) {
                        *divided = true;
                    }
                }
            }
        }
        self.find_torn_off(scene, bodies);
    }

    /// Tubes that no tie joins any more to an organ that they were grown to. Fat and other tissue around
    /// them hold no end of theirs.
    fn find_torn_off(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
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
                let is_whole = bodies.parted.left_of_tie(i) > 0.0;
                let Some(joined) = joined.get_mut(organs.0).and_then(|it| it.get_mut(organs.1))
                else {
                    continue;
                };
                if whole {
                    *joined |= is_whole;
                } else if !*joined {
                    // One of its ties stands for all.
                    *joined = true;
                    self.open_up(Opening::Off { sphere: tie.sphere });
                    if own == its {
                        self.open_up(Opening::Off { sphere: other });
                    }
                }
            }
        }
    }

    fn open_up(&mut self, opening: Opening) {
        if !self.holes.iter().any(|hole| hole.opening == opening) {
            let _ = self.holes.push(Hole::new(opening)); // what has no room leaks unseen
        }
    }
}
