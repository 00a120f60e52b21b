//! Beads along tubes: the balls with which tools collide on organs without a contact skin.

use heapless::Vec;

use crate::capacity::{MAX_BEADS, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::scene::{Link, Organ, Scene};
use crate::tissue::{Adjacency, Bodies};

/// Largest distance between two beads, in radii. Beads this close make a nearly smooth tube; a
/// smaller distance costs more beads.
const SPACING_RADII: f32 = 0.75;
/// Largest number of beads between two spheres.
const BEADS_PER_SEGMENT_MAX: u16 = 4;

/// A place on a tube's centre line, between two spheres. A sphere that belongs to no tube is a bead
/// by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bead {
    pub(crate) a: u16,
    pub(crate) b: u16,
    /// Position from `a`, 0, to `b`, 1.
    pub(crate) share: f32,
    /// Share of a sphere's contact stiffness.
    pub(crate) stiffness_share: f32,
    /// The link on which the bead lies, if any.
    pub(crate) link: Option<u32>,
}

impl Bead {
    /// True if `next` follows this bead along the same tube.
    pub(crate) fn is_followed_by(&self, next: &Self) -> bool {
        self.link.is_some() && next.link.is_some() && (self.link == next.link || self.b == next.a)
    }

    /// The ball of this bead in the present state.
    pub(crate) fn present_ball(&self, bodies: &Bodies) -> Ball {
        let (a, b) = (u32::from(self.a), u32::from(self.b));
        let from_m = bodies.nodes.at(a).center_m();
        let to_m = bodies.nodes.at(b).center_m();
        let (a_radius_m, b_radius_m) = (*bodies.radius_m.at(a), *bodies.radius_m.at(b));
        Ball {
            center_m: from_m + (to_m - from_m) * self.share,
            radius_m: a_radius_m + (b_radius_m - a_radius_m) * self.share,
            along: math::unit(&(to_m - from_m)).unwrap_or_else(Vec3::zeros),
        }
    }
}

/// A link between successive spheres of a tube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TubeSegment {
    pub(crate) a: u16,
    pub(crate) b: u16,
    /// Index in the scene.
    pub(crate) link: u32,
}

/// A bead in the present state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    /// Centre, world frame, m.
    pub(crate) center_m: Vec3,
    pub(crate) radius_m: f32,
    /// Unit vector along the tube; zero for a single sphere.
    pub(crate) along: Vec3,
}

/// The beads of all organs.
#[derive(Debug, Clone)]
pub(crate) struct Beads {
    all: Vec<Bead, MAX_BEADS>,
    /// First bead of each organ, and one past the last.
    ranges: [(u16, u16); MAX_ORGANS],
}

impl Beads {
    pub(crate) const fn new() -> Self {
        Self {
            all: Vec::new(),
            ranges: [(0, 0); MAX_ORGANS],
        }
    }

    /// Finds the tubes of `scene`, once when it is loaded. O(spheres · links · links of a sphere)
    /// of organs without a skin.
    pub(crate) fn build(&mut self, scene: &Scene<'_>, adjacency: &Adjacency) {
        self.all.clear();
        self.ranges = [(0, 0); MAX_ORGANS];
        for (i, organ) in scene.organs.iter().enumerate() {
            let start = self.all.len() as u16;
            if scene.skin.near_sphere(organ.sphere_start).is_none() {
                self.add_beads(scene, organ, adjacency);
            }
            if let Some(ranges) = self.ranges.get_mut(i) {
                *ranges = (start, self.all.len() as u16);
            }
        }
    }

    fn add_beads(&mut self, scene: &Scene<'_>, organ: &Organ, adjacency: &Adjacency) {
        let segments = || {
            let links = (organ.link_start..).zip(scene.links_of(organ));
            links.filter(|(_, link)| is_segment(link, scene, adjacency))
        };
        // A line of spheres, even one that forks and closes, has about as many segments as spheres.
        // An organ with more segments is not a tube.
        let segments_max = organ.sphere_count + organ.sphere_count / 8 + 1;
        let count = segments().count();
        // Spheres always find room as single beads, even if the beads between them do not.
        let spheres_to_come =
            scene.spheres.len() - (organ.sphere_start as usize).min(scene.spheres.len());
        let beads = self.all.len() + spheres_to_come + count * usize::from(BEADS_PER_SEGMENT_MAX);
        let is_tube = organ.batch_count == 0 && count as u32 <= segments_max && beads <= MAX_BEADS;
        let end = organ.sphere_start.saturating_add(organ.sphere_count);
        for sphere in organ.sphere_start..end {
            let mut segments = segments();
            if !(is_tube && segments.any(|(_, segment)| segment.a == sphere || segment.b == sphere))
            {
                self.add([sphere; 2], 0.0, 1.0, None);
            }
        }
        for (link, segment) in segments().filter(|_| is_tube) {
            let count = beads_on(segment, scene);
            for i in 0..count {
                let share_per_bead = f32::from(count).recip();
                let share = (f32::from(i) + 0.5) * share_per_bead;
                self.add([segment.a, segment.b], share, share_per_bead, Some(link));
            }
        }
    }

    fn add(&mut self, [a, b]: [u32; 2], share: f32, stiffness_share: f32, link: Option<u32>) {
        let _ = self.all.push(Bead {
            a: a as u16,
            b: b as u16,
            share,
            stiffness_share,
            link,
        }); // `add_beads` sees to it that there is room
    }

    /// Beads of the organ with this index, numbered.
    pub(crate) fn of(&self, organ: u8) -> impl Iterator<Item = (u16, &Bead)> {
        let (start, end) = self
            .ranges
            .get(usize::from(organ))
            .copied()
            .unwrap_or((0, 0));
        let own = self.all.get(usize::from(start)..usize::from(end));
        (start..end).zip(own.unwrap_or(&[]))
    }

    /// Segments of the tubes of the organ with this index.
    pub(crate) fn segments_of(&self, organ: u8) -> impl Iterator<Item = TubeSegment> {
        self.of(organ).filter_map(|(_, bead)| {
            // The first bead on each link.
            let link = bead.link.filter(|_| bead.share < bead.stiffness_share)?;
            Some(TubeSegment {
                a: bead.a,
                b: bead.b,
                link,
            })
        })
    }

    /// The bead with this number.
    pub(crate) fn get(&self, number: u16) -> Option<&Bead> {
        self.all.get(usize::from(number))
    }
}

/// True if a link joins successive spheres of a tube: no third sphere is linked to both and nearer
/// to each of them than they are to each other.
fn is_segment(link: &Link, scene: &Scene<'_>, adjacency: &Adjacency) -> bool {
    let length_m = |a: u32, b: u32| rest_length_m(a, b, scene);
    let link_m = length_m(link.a, link.b);
    !adjacency.of(link.a).iter().any(|&c| {
        let c = u32::from(c);
        c != link.b
            && adjacency.of(link.b).iter().any(|&d| u32::from(d) == c)
            && length_m(link.a, c).max(length_m(c, link.b)) < link_m
    })
}

fn beads_on(segment: &Link, scene: &Scene<'_>) -> u16 {
    let radius_m = |i: u32| scene.spheres.get(i as usize).map_or(0.0, |s| s.radius_m);
    let thin_m = radius_m(segment.a).min(radius_m(segment.b)).max(1.0e-6);
    let gaps = rest_length_m(segment.a, segment.b, scene) / (SPACING_RADII * thin_m);
    // `as` saturates and truncates.
    (gaps as u16).saturating_add(1).min(BEADS_PER_SEGMENT_MAX)
}

fn rest_length_m(a: u32, b: u32, scene: &Scene<'_>) -> f32 {
    let at = |i: u32| scene.spheres.get(i as usize).map(|s| s.center_m);
    match (at(a), at(b)) {
        (Some(a), Some(b)) => math::norm(&(a - b)),
        _ => 0.0,
    }
}
