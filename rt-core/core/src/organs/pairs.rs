//! Near pairs of spheres, of two organs or of one, that are not linked. [`crate::organs::between`]
//! presses them apart.
//!
//! Spheres lie under the skin. So the reach of an outer sphere is about its distance at rest from
//! the skin over it, if this is more than its radius.
//!
//! Neighbouring spheres of one organ overlap at rest by construction. So within an organ, only
//! pairs that were apart at rest are kept apart. Spheres of two organs that overlapped at rest come
//! no nearer than they were at rest. The inner-sphere paper does not say how it distinguishes these
//! cases.
//!
//! Near pairs are searched in a grid, a sixteenth of the spheres a tick. A list of pairs is
//! complete after [`CYCLE_TICKS`] ticks, and is used for the next `CYCLE_TICKS` ticks. A pair of
//! two organs is also used from the tick in which it is found. Spheres that approach by more than
//! [`MARGIN_M`] in 16 ticks (0.2 m/s) are found late, by at most 16 ms. Spheres that have hardly
//! moved since their last search are not searched again; a pair of two such spheres is kept.
//! O(spheres that move · spheres in cells within reach / 16 + pairs) a tick.
//!
//! A pair that begins to push late, from an overlap, adds energy. So pairs of one organ are listed
//! as far ahead as their speed demands. Otherwise ducts and fat that were pushed into each other
//! shake for ever, and change direction with the list.

use heapless::Vec;

use crate::capacity::{MAX_SPHERE_PAIRS, MAX_SPHERES};
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::organs::grid::Grid;
use crate::scene::Scene;
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;

/// Number of ticks within which every sphere is searched once. With a larger number, a tick costs
/// less, but fast spheres are found later.
const CYCLE_TICKS: u32 = 16;
/// Largest gap of a listed pair, m. A larger value finds faster spheres in time, but lists more
/// pairs.
const MARGIN_M: f32 = 0.003;

/// Travel of a sphere since the grid was built that a search allows for, m. Faster spheres (0.2
/// m/s) are found in the next grid.
const TRAVEL_MAX_M: f32 = 0.003;

/// Travel since its last search below which a sphere counts as still, m. Two still spheres can have
/// approached each other by three times this value since the later of their two searches.
const STILL_TRAVEL_M: f32 = 0.000_15;

/// Upper bound of the distance to which a pair within one organ is pressed apart, as a share of the
/// pair's distance at rest. It is below 1, so no pair of an organ at rest pushes.
const APART_SHARE_OF_REST: f32 = 0.95;
/// Squared distance below which a pair within one organ is listed, as a share of the squared
/// distance at rest. A pair that is farther apart is listed if its speed can close the gap before
/// its next search ends.
const LISTED_SHARE_OF_REST: f32 = 0.96;

/// Largest reach of a sphere, in its radii. It keeps the ball of a sphere near a thin rim from
/// extending as far as the rim.
const REACH_MAX: f32 = 1.5;

/// Position of a sphere that was never searched.
const NEVER: Vec3 = Vec3::new(f32::MAX, f32::MAX, f32::MAX);

/// Two spheres that may come to overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) a: u16,
    pub(crate) b: u16,
    /// Distance between the centres at and beyond which the spheres do not push each other, m.
    pub(crate) apart_m: f32,
}

/// Distances of a sphere from the skin vertices to which it is the nearest.
#[derive(Debug, Clone, Copy)]
struct SkinDistance {
    vertices: f32,
    sum_m: f32,
    nearest_m: f32,
}

impl SkinDistance {
    const NONE: Self = Self {
        vertices: 0.0,
        sum_m: 0.0,
        nearest_m: f32::MAX,
    };

    fn add(&mut self, distance_m: f32) {
        self.vertices += 1.0;
        self.sum_m += distance_m;
        self.nearest_m = self.nearest_m.min(distance_m);
    }

    /// Reach of the sphere, m: midway between the least and the mean distance. When balls of this
    /// reach touch, the skin between them overlaps in some places and is apart in others, by equal
    /// amounts.
    fn reach_m(&self) -> Option<f32> {
        (self.vertices > 0.0).then(|| 0.5 * (self.nearest_m + self.sum_m / self.vertices))
    }
}

/// The list of pairs in use, and the list that is being collected.
#[derive(Debug, Clone)]
pub(crate) struct Pairs {
    grid: Grid,
    /// Spheres that can touch other spheres. In an organ with a skin, these are the spheres that
    /// are nearest to some skin vertex; the other spheres lie behind them.
    outer: Vec<u16, MAX_SPHERES>,
    /// Reach of each sphere from its centre, m.
    reach_m: PerSphere<f32>,
    current: Vec<Pair, MAX_SPHERE_PAIRS>,
    next: Vec<Pair, MAX_SPHERE_PAIRS>,
    /// Position of each sphere at its last search, m.
    last_search_m: PerSphere<Vec3>,
    /// Spheres that count as still in this cycle.
    is_still: PerSphere<bool>,
    /// Position in the cycle.
    phase: u32,
}

impl Pairs {
    pub(crate) const fn new() -> Self {
        Self {
            grid: Grid::new(),
            outer: Vec::new(),
            reach_m: PerSphere::new(0.0),
            current: Vec::new(),
            next: Vec::new(),
            last_search_m: PerSphere::new(NEVER),
            is_still: PerSphere::new(false),
            phase: 0,
        }
    }

    /// Loads `scene`, and drops all pairs.
    pub(crate) fn load(&mut self, scene: &Scene<'_>) {
        self.outer.clear();
        let mut skin_distances = PerSphere::new(SkinDistance::NONE);
        for vertex in scene.skin.vertices {
            let number = u32::from(vertex.spheres[0]);
            if let Some(sphere) = scene.spheres.get(number as usize) {
                let distance_m = math::norm(&(scene.skin_at_rest_m(vertex) - sphere.center_m));
                skin_distances.at_mut(number).add(distance_m);
            }
        }
        for (number, sphere) in (0..).zip(scene.spheres) {
            let skin_m = skin_distances.at(number).reach_m();
            let reach_m = skin_m.unwrap_or(0.0).max(sphere.radius_m);
            *self.reach_m.at_mut(number) = reach_m.min(REACH_MAX * sphere.radius_m);
            // Spheres of organs without a skin, and spheres nearest to some skin vertex.
            if scene.skin.near_sphere(number).is_none() || skin_m.is_some() {
                let _ = self.outer.push(number as u16); // has room for every sphere
            }
        }
        self.current.clear();
        self.next.clear();
        self.last_search_m = PerSphere::new(NEVER);
        self.phase = 0;
    }

    /// Searches this tick's share of the spheres for near pairs.
    pub(crate) fn find(&mut self, bodies: &Bodies, faults: &mut FaultSet) {
        if self.phase == 0 {
            core::mem::swap(&mut self.current, &mut self.next);
            self.next.clear();
            for a in self.outer.iter().map(|&a| u32::from(a)) {
                let moved_m = bodies.nodes.at(a).center_m() - self.last_search_m.at(a);
                *self.is_still.at_mut(a) = moved_m.norm_squared() < STILL_TRAVEL_M * STILL_TRAVEL_M;
            }
            for pair in &self.current {
                let [a, b] = [pair.a, pair.b].map(|i| *self.is_still.at(u32::from(i)));
                if a && b {
                    faults.raise_if(self.next.push(*pair).is_err(), Fault::PairOverflow);
                }
            }
            let reach_m = &self.reach_m;
            self.grid
                .build(bodies, &self.outer, |sphere| *reach_m.at(sphere));
        }
        let share = self.outer.iter().skip(self.phase as usize);
        for a in share.step_by(CYCLE_TICKS as usize).map(|&a| u32::from(a)) {
            if *self.is_still.at(a) {
                continue;
            }
            let center_m = bodies.nodes.at(a).center_m();
            *self.last_search_m.at_mut(a) = center_m;
            let (at, reach_m) = (
                center_m.into(),
                self.reach_m.at(a) + MARGIN_M + TRAVEL_MAX_M,
            );
            for run in self.grid.near(&center_m, reach_m) {
                for found in run {
                    if !found.is_near(&at, reach_m) {
                        continue;
                    }
                    let b = u32::from(found.sphere);
                    // Each of two moving spheres finds the other, so one of the two finds is
                    // skipped.
                    if b <= a && (b == a || !*self.is_still.at(b)) {
                        continue;
                    }
                    if let Some(pair) = near_pair(bodies, &self.reach_m, a.min(b), a.max(b)) {
                        faults.raise_if(self.next.push(pair).is_err(), Fault::PairOverflow);
                        if bodies.organ.at(a) != bodies.organ.at(b) {
                            // The pair is also used at once. A pair that is listed twice is solved
                            // once.
                            let _ = self.current.push(pair);
                        }
                    }
                }
            }
        }
        self.phase = (self.phase + 1) % CYCLE_TICKS;
    }

    /// The near pairs in use; a pair may be listed twice.
    pub(crate) fn near(&self) -> impl Iterator<Item = &Pair> {
        self.current.iter()
    }
}

/// The pair, if it is near and must be kept apart.
fn near_pair(bodies: &Bodies, reach_m: &PerSphere<f32>, a: u32, b: u32) -> Option<Pair> {
    let (node_a, node_b) = (bodies.nodes.at(a), bodies.nodes.at(b));
    let reach = reach_m.at(a) + reach_m.at(b);
    let squared = node_a.from(node_b).norm_squared();
    if squared >= (reach + MARGIN_M) * (reach + MARGIN_M) {
        return None;
    }
    let at_rest_squared = (node_a.rest_m() - node_b.rest_m()).norm_squared();
    let mut apart_m = reach.min(math::sqrt(at_rest_squared));
    if bodies.organ.at(a) == bodies.organ.at(b) {
        let was_apart = at_rest_squared >= reach * reach;
        apart_m = apart_m.min(APART_SHARE_OF_REST * math::sqrt(at_rest_squared));
        // A pair that is found now is in use until the end of the next cycle.
        let speed_m_s = math::norm(&(node_a.velocity_m_s() - node_b.velocity_m_s()));
        let reached_m = apart_m + speed_m_s * (2 * CYCLE_TICKS) as f32 * TICK_S;
        let may_come = squared < reached_m * reached_m;
        let is_pressed = squared < LISTED_SHARE_OF_REST * at_rest_squared;
        let linked = || bodies.adjacency.of(a).iter().any(|&n| u32::from(n) == b);
        if !was_apart || !(is_pressed || may_come) || linked() {
            return None;
        }
    }
    let near = squared < (apart_m + MARGIN_M) * (apart_m + MARGIN_M);
    near.then_some(Pair {
        a: a as u16,
        b: b as u16,
        apart_m,
    })
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use crate::scene::{Link, Organ, RestSphere};
    use std::boxed::Box;
    use std::vec::Vec as List;

    /// `Pairs` and `Bodies` of these organs after `moved`, when every pair has been found.
    fn found(
        organs: &[Organ],
        spheres: &[RestSphere],
        links: &[Link],
        moved: &[(u32, Vec3)],
    ) -> (Box<Pairs>, Box<Bodies>) {
        let scene = Scene::new(organs, spheres, links, room()).unwrap();
        let (mut pairs, mut bodies) = (Box::new(Pairs::new()), Box::new(Bodies::new()));
        bodies.load(&scene);
        bodies.begin(&scene, true);
        pairs.load(&scene);
        for (i, u) in moved {
            bodies.nodes.at_mut(*i).move_by(u);
        }
        let mut faults = FaultSet::NONE;
        for _ in 0..=CYCLE_TICKS {
            pairs.find(&bodies, &mut faults);
        }
        (pairs, bodies)
    }

    fn listed(pairs: &Pairs) -> List<(u16, u16)> {
        let mut list: List<_> = pairs.current.iter().map(|pair| (pair.a, pair.b)).collect();
        list.sort_unstable();
        list.dedup();
        list
    }

    #[test]
    fn still_spheres_keep_their_pairs_and_a_moving_sphere_finds_new_pairs() {
        let at = |x: f32| sphere(Vec3::new(x, 0.0, 0.0), 0.01);
        let spheres = [at(0.0), at(0.05), at(0.1)];
        let organs = [organ(0, 3, 0, 0)];
        let near = [(1, Vec3::new(-0.032, 0.0, 0.0))];
        let (mut pairs, mut bodies) = found(&organs, &spheres, &[], &near);
        assert_eq!(listed(&pairs), [(0, 1)]);
        let mut after = |sphere: u32, travel_m: f32| {
            bodies.nodes.at_mut(sphere).move_by(&(Vec3::x() * travel_m));
            for _ in 0..3 * CYCLE_TICKS {
                let mut faults = FaultSet::NONE;
                pairs.find(&bodies, &mut faults);
            }
            listed(&pairs)
        };
        assert_eq!(after(1, 0.0), [(0, 1)], "kept");
        assert_eq!(after(1, 0.0001), [(0, 1)], "hardly moved");
        // Motion to either side, of the sphere with the higher number and of the sphere with the
        // lower number.
        assert_eq!(after(1, 0.06), [(1, 2)]);
        assert_eq!(after(1, -0.06), [(0, 1)]);
        assert_eq!(after(0, -0.05), []);
        assert_eq!(after(0, 0.05), [(0, 1)]);
    }

    #[test]
    fn only_pairs_apart_at_rest_are_kept_apart() {
        // Organ 0: spheres 0, 1 overlap at rest; 2 is 3 cm off, 3 linked to 2; organ 1: sphere 4.
        let at = |x: f32| sphere(Vec3::new(x, 0.0, 0.0), 0.01);
        let spheres = [at(0.0), at(0.015), at(0.045), at(0.075), at(0.1)];
        let links = [Link {
            a: 2,
            b: 3,
            rest_length_m: 0.03,
            compliance_m_n: 0.0,
        }];
        let organs = [organ(0, 4, 0, 1), organ(4, 1, 1, 0)];
        // At rest nothing is near enough.
        assert!(listed(&found(&organs, &spheres, &links, &[]).0).is_empty());
        // 2 and 3 come together (linked: not kept), and 1 and 2 (kept), and 3 and 4 (kept).
        let moved = [
            (1, Vec3::new(0.012, 0.0, 0.0)),
            (0, Vec3::new(0.012, 0.0, 0.0)),
            (3, Vec3::new(-0.011, 0.0, 0.0)),
            (4, Vec3::new(-0.018, 0.0, 0.0)),
        ];
        let (pairs, _) = found(&organs, &spheres, &links, &moved);
        assert_eq!(listed(&pairs), [(1, 2), (3, 4)]);
    }

    #[test]
    fn grid_finds_the_pairs_of_a_brute_force_search() {
        let mut seed = 7_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        let spheres: List<_> = (0..400)
            .map(|i| {
                let center = Vec3::new(random(), random(), random()) * 0.2;
                let radius = 0.004 + 0.006 * random();
                (i, sphere(center, radius))
            })
            .collect();
        let spheres: List<_> = spheres.into_iter().map(|(_, s)| s).collect();
        let organs: List<_> = (0..16).map(|i| organ(i * 25, 25, 0, 0)).collect();
        let moved: List<_> = (0..400)
            .map(|i| (i, Vec3::new(random(), random(), random()) * 0.05))
            .collect();
        let (pairs, bodies) = found(&organs, &spheres, &[], &moved);
        let mut expected = List::new();
        for a in 0..400 {
            for b in a + 1..400 {
                if near_pair(&bodies, &pairs.reach_m, a, b).is_some() {
                    expected.push((a as u16, b as u16));
                }
            }
        }
        assert!(expected.len() > 100, "{}", expected.len());
        assert_eq!(listed(&pairs), expected);
    }
}
