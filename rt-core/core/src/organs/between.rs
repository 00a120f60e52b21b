//! Contact of organs: spheres that overlap press each other apart, with friction.
//!
//! The contact is a damped spring (XPBD, Macklin 2016) in each of the finer organ's substeps. So
//! the pushes on a sphere that is squeezed between others come to a balance. Exact distance
//! constraints, solved one after another, would never let such a sphere rest.
//!
//! A pair keeps its impulse. A substep begins with the last impulses of all pairs. Each pair also
//! sees the last impulses of the tools, which act later in the substep. A pair then takes its own
//! impulse out, solves for the whole impulse anew, and applies the difference, as tetrahedra do
//! (`tissue::warm_start`). A fold that jaws pull, and ducts that were pushed into fat, need this:
//! without the impulses of jaws and neighbours their spheres spring back, and press each other for
//! ever.

use heapless::Vec;

use crate::capacity::MAX_CLOSE_PAIRS;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::organs::pairs::Pair;
use crate::scene::Scene;
use crate::tissue::lanes::Lanes;
use crate::tissue::multirate::{Multirate, Pace, SubstepWindow};
use crate::tissue::{Bodies, Node};
use crate::words::SphereBits;

/// Largest gap of a pair at the beginning of a tick, m, with which the pair may touch in that tick.
/// Spheres that approach faster than 0.5 m/s push each other a tick late.
const CLOSE_M: f32 = 0.000_5;
/// Stiffness of the contact of two spheres, N/m: a gallbladder that is pressed on the liver with 1
/// N sinks a quarter of a millimetre into it.
const STIFFNESS_N_M: f32 = 200.0;
/// Damping of the contact divided by its stiffness, s: enough that nothing bounces. A larger value
/// slows the approach to balance.
const DAMPING_TIME_S: f32 = 0.001;
/// Largest share of an overlap that a substep corrects. With 0.4, a rod that a tool folds shakes at
/// 0.6 m/s (`bodies_of_common_tissue_rest`). With 0.3 it rests, and 0.25 leaves a margin.
const CORRECTION_SHARE_MAX: f32 = 0.25;
/// Largest speed at which overlapping organs part, m/s. A duct that has slipped far into an organ
/// comes out slowly.
const PARTING_SPEED_MAX_M_S: f32 = 0.1;
/// Friction of wet serous skins on each other (pleura on pleura; D'Angelo 2004, DOI
/// 10.1016/j.resp.2004.05.006).
const FRICTION: f32 = 0.02;

/// Slots of the hash table of pairs.
const SLOTS: usize = 4 * MAX_CLOSE_PAIRS;
/// An empty slot.
const EMPTY: u16 = u16::MAX;

/// A pair that may touch in this tick.
#[derive(Debug, Clone, Copy)]
struct Close {
    pair: Pair,
    /// Number of substeps of a tick in which the pair is solved.
    substeps: u16,
    /// Positional impulse on the first sphere in the last substep, m kg.
    push_m_kg: Lanes,
}

/// Pairs without repetition, and a hash table that finds them.
#[derive(Debug, Clone)]
struct Listed {
    close: Vec<Close, MAX_CLOSE_PAIRS>,
    /// Indices into `close`.
    slots: [u16; SLOTS],
}

impl Listed {
    const NONE: Self = Self {
        close: Vec::new(),
        slots: [EMPTY; SLOTS],
    };

    fn clear(&mut self) {
        self.close.clear();
        self.slots = [EMPTY; SLOTS];
    }

    /// The pair if it is listed, or else the slot for its index.
    fn find(&self, pair: &Pair) -> Result<&Close, usize> {
        let hash = (u32::from(pair.a) << 16 | u32::from(pair.b)).wrapping_mul(0x9e37_79b1);
        let first = (hash >> 16) as usize;
        for i in 0..SLOTS {
            let slot = (first + i) % SLOTS;
            let index = self.slots.get(slot).copied().unwrap_or(EMPTY);
            match self.close.get(usize::from(index)) {
                Some(close) if (close.pair.a, close.pair.b) == (pair.a, pair.b) => {
                    return Ok(close);
                }
                Some(_) => {}
                None => return Err(slot),
            }
        }
        Err(SLOTS) // never: there are more slots than pairs
    }

    /// Appends a pair whose slot is known. Returns false if there is no room.
    fn push(&mut self, close: Close, slot: usize) -> bool {
        let index = self.close.len() as u16;
        let is_pushed = self.close.push(close).is_ok();
        if let (true, Some(slot)) = (is_pushed, self.slots.get_mut(slot)) {
            *slot = index;
        }
        is_pushed
    }
}

/// Pairs that may touch in a tick.
#[derive(Debug, Clone)]
pub(crate) struct Between {
    now: Listed,
    /// Pairs of the tick before.
    before: Listed,
    /// True if no pair acts in this tick.
    is_idle: bool,
}

impl Between {
    pub(crate) const fn new() -> Self {
        Self {
            now: Listed::NONE,
            before: Listed::NONE,
            is_idle: true,
        }
    }

    /// Removes all pairs and their impulses, after the tissue was loaded or reset.
    pub(crate) fn forget(&mut self) {
        self.now.clear();
        self.before.clear();
        self.is_idle = true;
    }

    /// Lets no pair act in this tick. The pairs keep their impulses.
    pub(crate) fn skip(&mut self) {
        self.is_idle = true;
    }

    /// Chooses the near pairs that may touch in this tick.
    pub(crate) fn choose<'a>(
        &mut self,
        near: impl Iterator<Item = &'a Pair>,
        scene: &Scene<'_>,
        bodies: &Bodies,
        faults: &mut FaultSet,
    ) {
        self.is_idle = false;
        core::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        for pair in near {
            let [a, b] = [pair.a, pair.b].map(u32::from);
            let difference = bodies.nodes.at(a).from(bodies.nodes.at(b));
            let reach_m = pair.apart_m + CLOSE_M;
            if difference.norm_squared() >= reach_m * reach_m {
                continue;
            }
            let Err(slot) = self.now.find(pair) else {
                continue; // listed already
            };
            let [substeps_a, substeps_b] =
                [a, b].map(|sphere| scene.substeps_of(*bodies.organ.at(sphere)));
            let before = self.before.find(pair);
            let close = Close {
                pair: *pair,
                substeps: substeps_a.max(substeps_b) as u16,
                push_m_kg: before.map_or(Lanes::ZERO, |before| before.push_m_kg),
            };
            faults.raise_if(!self.now.push(close, slot), Fault::PairOverflow);
        }
    }

    /// Presses apart the touching pairs that are due in the finest substep `now` of the tick.
    pub(crate) fn press_due(&mut self, now: u32, scene: &Scene<'_>, bodies: &mut Bodies) {
        if self.is_idle {
            return;
        }
        // Most pairs are near and do not touch: they have no impulse.
        let pressed = self.now.close.iter();
        for close in pressed.filter(|it| it.push_m_kg != Lanes::ZERO) {
            if let Some(window) = SubstepWindow::due(now, close.substeps.into(), scene) {
                let paces = close.paces(&window, scene, bodies);
                close.move_by(close.push_m_kg, paces, bodies);
            }
        }
        for close in &mut self.now.close {
            if let Some(window) = SubstepWindow::due(now, close.substeps.into(), scene) {
                close.press(&window, scene, bodies);
            }
        }
    }
}

impl Close {
    fn spheres(&self) -> [u32; 2] {
        [self.pair.a, self.pair.b].map(u32::from)
    }

    /// Paces of the organs of the two spheres.
    fn paces(&self, at: &SubstepWindow, scene: &Scene<'_>, bodies: &Bodies) -> [Pace; 2] {
        self.spheres()
            .map(|sphere| Pace::of(scene.substeps_of(*bodies.organ.at(sphere)), at))
    }

    /// Applies a positional impulse over the window's length, m kg, to the first sphere, and the
    /// opposite impulse to the second.
    fn move_by(&self, push_m_kg: Lanes, paces: [Pace; 2], bodies: &mut Bodies) {
        let pushes = [push_m_kg, push_m_kg.scaled(-1.0)];
        for ((sphere, pace), push_m_kg) in self.spheres().into_iter().zip(paces).zip(pushes) {
            Multirate::of(sphere, pace, bodies).push(bodies.nodes.at_mut(sphere), push_m_kg);
        }
    }

    /// Solves for the impulse of the pair, and applies its difference from the one before.
    fn press(&mut self, at: &SubstepWindow, scene: &Scene<'_>, bodies: &mut Bodies) {
        let paces = self.paces(at, scene, bodies);
        let push_m_kg = match is_removed(bodies, &self.pair) {
            true => Lanes::ZERO,
            false => self.solve(paces, at.step_s(), bodies),
        };
        if push_m_kg != self.push_m_kg {
            self.move_by(push_m_kg - self.push_m_kg, paces, bodies);
            self.push_m_kg = push_m_kg;
        }
    }

    /// Sphere without the pair's own impulse, with the last impulses of the tools.
    fn seen(sphere: u32, pace: Multirate, own_m_kg: Lanes, bodies: &Bodies) -> Node {
        let mut node = *bodies.nodes.at(sphere);
        let tools_m_kg = bodies.warm_start.tools(sphere);
        node.push(tools_m_kg, bodies.weight_per_kg(sphere));
        pace.push(&mut node, own_m_kg.scaled(-1.0));
        node
    }

    /// Positional impulse that presses the first sphere away from the second, m kg.
    fn solve(&self, paces: [Pace; 2], step_s: f32, bodies: &Bodies) -> Lanes {
        let [a, b] = self.spheres();
        let [pace_a, pace_b] = paces;
        let pace_a = Multirate::of(a, pace_a, bodies);
        let pace_b = Multirate::of(b, pace_b, bodies);
        let node_a = Self::seen(a, pace_a, self.push_m_kg, bodies);
        let node_b = Self::seen(b, pace_b, self.push_m_kg.scaled(-1.0), bodies);
        let start = node_a.away_at_start(&node_b);
        let now = (start + (pace_a.way(&node_a) - pace_b.way(&node_b))).vec3();
        let near_m = math::norm(&now);
        let weight_per_kg = pace_a.weight() + pace_b.weight();
        if near_m >= self.pair.apart_m || weight_per_kg <= 0.0 {
            return Lanes::ZERO;
        }
        let before = (start + (pace_a.way_before(&node_a) - pace_b.way_before(&node_b))).vec3();
        let direction = math::unit(&now).unwrap_or_else(Vec3::x);
        let approached_m = math::norm(&before) - near_m;
        let rate = DAMPING_TIME_S / step_s;
        // Compliance of the spring, relative to the pair's inverse mass.
        let softness = (STIFFNESS_N_M * step_s * step_s * weight_per_kg).recip();
        let correction_share = ((1.0 + rate) + softness).recip().min(CORRECTION_SHARE_MAX);
        let wanted_m = correction_share * (self.pair.apart_m - near_m + rate * approached_m);
        let push_m = wanted_m
            .min(approached_m + PARTING_SPEED_MAX_M_S * step_s)
            .max(0.0);
        // Friction reduces the slide along the surfaces, by at most `FRICTION` times the push.
        let slid = now - before;
        let slid = slid - direction * direction.dot(&slid);
        let friction_share = FRICTION * push_m
            / math::norm(&slid)
                .max(FRICTION * push_m)
                .max(f32::MIN_POSITIVE);
        let push = (direction * push_m - slid * friction_share) / weight_per_kg;
        Lanes::new(&push, 0.0)
    }
}

/// True if one of the two spheres is layered tissue that has been removed.
fn is_removed(bodies: &Bodies, pair: &Pair) -> bool {
    [pair.a, pair.b].iter().any(|&i| {
        let bits = bodies.bits.at(u32::from(i));
        bits.contains(SphereBits::REMOVED)
    })
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::capacity::MAX_ORGANS;
    use crate::organs::pairs::Pairs;
    use crate::scene::tests::{organ, room, sphere};
    use crate::scene::{Organ, RestSphere};
    use crate::time::TICK_S;
    use crate::tissue::neo_hookean::NeoHookean;
    use crate::tissue::substeps::{self, Coupling};
    use std::boxed::Box;

    const RADIUS_M: f32 = 0.01;

    /// Two spheres of 0.2 g, their centres 5 cm apart at rest, in one organ or in two; no other
    /// force acts.
    struct Two {
        organs: std::vec::Vec<Organ>,
        spheres: std::vec::Vec<RestSphere>,
        pairs: Box<Pairs>,
        between: Box<Between>,
        bodies: Box<Bodies>,
    }

    struct PairsOnly<'a>(&'a mut Between, &'a Scene<'a>);

    impl Coupling for PairsOnly<'_> {
        fn pre_solve(&mut self, _: u8, _: f32, _: &mut Bodies) {}
        fn couple(&mut self, now: u32, bodies: &mut Bodies) {
            self.0.press_due(now, self.1, bodies);
        }
        fn post_solve(&mut self, _: u8, _: f32, _: f32, _: &mut Bodies) {}
    }

    fn free(first: u32, spheres: u32, substeps: u32) -> Organ {
        let mut free = organ(first, spheres, 0, 0);
        free.substeps = substeps;
        free.gravity_share = 0.0;
        free.material.damping_per_s = 0.0;
        free
    }

    fn at(x: f32) -> RestSphere {
        RestSphere {
            mass_kg: 0.000_2,
            ..sphere(Vec3::x() * x, RADIUS_M)
        }
    }

    impl Two {
        fn new(organs: &[Organ], apart_m: f32, speed_m_s: [f32; 2]) -> Self {
            let mut two = Self {
                organs: organs.to_vec(),
                spheres: std::vec![at(0.0), at(0.05)],
                pairs: Box::new(Pairs::new()),
                between: Box::new(Between::new()),
                bodies: Box::new(Bodies::new()),
            };
            let scene = Scene::new(&two.organs, &two.spheres, &[], room()).unwrap();
            two.bodies.load(&scene);
            two.pairs.load(&scene);
            let moved = [Vec3::zeros(), Vec3::x() * (apart_m - 0.05)];
            for ((i, moved), v) in (0..).zip(&moved).zip(speed_m_s) {
                two.bodies.nodes.at_mut(i).put(moved, &(Vec3::x() * v));
            }
            two
        }

        fn tick(&mut self) {
            self.advance(|_| {});
        }

        /// A tick in which `tool` acts last.
        fn advance(&mut self, tool: impl FnOnce(&mut Bodies)) {
            let scene = Scene::new(&self.organs, &self.spheres, &[], room()).unwrap();
            let mut faults = FaultSet::NONE;
            self.bodies.begin(&scene, true);
            self.pairs.find(&self.bodies, &mut faults);
            self.between
                .choose(self.pairs.near(), &scene, &self.bodies, &mut faults);
            let mut pairs_only = PairsOnly(&mut self.between, &scene);
            let moves = [true; MAX_ORGANS];
            let bodies = &mut self.bodies;
            let _ = substeps::run(&scene, &mut NeoHookean, &moves, &mut pairs_only, bodies);
            tool(bodies);
            for (organ, number) in self.organs.iter().zip(0..) {
                let _ = bodies.advance(&scene, organ, scene.step_s_of(number));
            }
            assert!(faults.is_empty());
        }

        fn apart_m(&self) -> f32 {
            math::norm(&self.bodies.nodes.at(0).from(self.bodies.nodes.at(1)).vec3())
        }

        fn speeds_m_s(&self) -> [f32; 2] {
            [0, 1].map(|i| self.bodies.nodes.at(i).velocity_m_s().x)
        }
    }

    /// Equal and unequal substeps, and folds of one organ.
    fn kinds() -> [std::vec::Vec<Organ>; 4] {
        [
            std::vec![free(0, 1, 1), free(1, 1, 1)],
            std::vec![free(0, 1, 1), free(1, 1, 16)],
            std::vec![free(0, 1, 4), free(1, 1, 2)],
            std::vec![free(0, 2, 4)],
        ]
    }

    #[test]
    fn colliding_organ_is_stopped_by_equal_momenta_without_bounce() {
        for organs in kinds() {
            let mut two = Two::new(&organs, 0.0225, [0.1, 0.0]);
            let mut nearest_m = f32::MAX;
            for _ in 0..200 {
                two.tick();
                nearest_m = nearest_m.min(two.apart_m());
                let [a, b] = two.speeds_m_s();
                assert!((a + b - 0.1).abs() < 1.0e-4, "{a} {b} m/s");
                let energy = a * a + b * b;
                assert!(energy < 0.01 + 1.0e-5, "{energy}");
            }
            // Without damping, 0.1 m/s with a reduced mass of 0.1 g would go 0.07 mm deep against
            // 200 N/m.
            assert!(nearest_m > 2.0 * RADIUS_M - 0.000_08, "{nearest_m}");
            let [a, b] = two.speeds_m_s();
            assert!(b - a < 0.02 && b >= a, "{a} {b} m/s");
        }
    }

    #[test]
    fn deeply_overlapping_organs_part_slowly() {
        for organs in kinds() {
            let mut two = Two::new(&organs, 0.015, [0.0, 0.0]);
            for tick in 0..400 {
                let before_m = two.apart_m();
                two.tick();
                let parted_m = two.apart_m() - before_m;
                let most_m = 1.01 * PARTING_SPEED_MAX_M_S * TICK_S;
                assert!(parted_m < most_m, "tick {tick}: {parted_m} m");
            }
            assert!(two.apart_m() > 2.0 * RADIUS_M - 1.0e-5);
        }
    }

    #[test]
    fn tissue_that_a_tool_holds_presses_nothing_beyond_its_reach() {
        let mut two = Two::new(&[free(0, 2, 1)], 0.05, [0.0, 0.0]);
        let below = |z| RestSphere {
            mass_kg: 0.000_2,
            ..sphere(Vec3::z() * z, RADIUS_M)
        };
        two.spheres = std::vec![below(0.0), below(-5.0 * RADIUS_M)];
        let scene = Scene::new(&two.organs, &two.spheres, &[], room()).unwrap();
        two.bodies.load(&scene);
        two.pairs.load(&scene);
        // Each tick the first sphere sets off by 9.8 µm, and the tool brings it back.
        let down = Vec3::z() * -0.009_8;
        for tick in 0..48 {
            two.bodies.nodes.at_mut(0).put(&Vec3::zeros(), &down);
            two.advance(|bodies| {
                let back_m = -bodies.nodes.at(0).moved_m();
                bodies.nodes.at_mut(0).move_by(&back_m);
            });
            if tick == 2 {
                // The gap of 4 µm is less than those 9.8 µm.
                let up = Vec3::z() * (3.0 * RADIUS_M - 0.000_004);
                two.bodies.nodes.at_mut(1).put(&up, &Vec3::zeros());
            }
            let speed_m_s = two.bodies.nodes.at(1).velocity_m_s();
            assert_eq!(speed_m_s, Vec3::zeros(), "tick {tick}");
        }
        assert_eq!(two.between.now.close.len(), 1);
    }

    #[test]
    fn coincident_spheres_part() {
        let mut two = Two::new(&kinds()[0], 0.0, [0.0, 0.0]);
        for _ in 0..10 {
            two.tick();
        }
        assert!(two.apart_m() > 1.0e-4, "{}", two.apart_m());
    }

    #[test]
    fn squeezed_sphere_comes_to_rest_as_between_springs() {
        // A free sphere between two held ones, which are 0.3 mm too near each other for it.
        let mut two = Two::new(&kinds()[0], 0.05, [0.0, 0.0]);
        two.spheres = std::vec![at(0.0), at(0.05), at(0.1)];
        two.spheres[0].held = true;
        two.spheres[2].held = true;
        two.organs = std::vec![free(0, 1, 1), free(1, 1, 8), free(2, 1, 2)];
        let scene = Scene::new(&two.organs, &two.spheres, &[], room()).unwrap();
        two.bodies.load(&scene);
        two.pairs.load(&scene);
        let put = [0.0, 0.0199 - 0.05, 0.0397 - 0.1];
        for (i, x) in (0..).zip(put) {
            let node = two.bodies.nodes.at_mut(i);
            node.put(&(Vec3::x() * x), &Vec3::zeros());
        }
        let mut last_m = 0.0;
        for tick in 0..300 {
            two.tick();
            let now_m = two.bodies.nodes.at(1).center_m().x;
            assert!(tick < 250 || (now_m - last_m).abs() < 1.0e-8, "{now_m}");
            last_m = now_m;
        }
        // The neighbours push one after the other, so the first overlap is a little deeper.
        assert!((last_m - 0.019_85).abs() < 1.5e-5, "{last_m}");
    }

    #[test]
    fn organs_that_overlap_at_rest_do_not_move() {
        let organs = [free(0, 1, 1), free(1, 1, 1)];
        let mut two = Two::new(&organs, 0.05, [0.0, 0.0]);
        two.spheres = std::vec![at(0.0), at(0.012)];
        let scene = Scene::new(&two.organs, &two.spheres, &[], room()).unwrap();
        two.bodies.load(&scene);
        two.pairs.load(&scene);
        for _ in 0..50 {
            two.tick();
        }
        assert!((two.apart_m() - 0.012).abs() < 1.0e-7);
        // Spheres that come nearer return to their distance at rest.
        let nearer = Vec3::x() * -0.002;
        two.bodies.nodes.at_mut(1).put(&nearer, &Vec3::zeros());
        for _ in 0..400 {
            two.tick();
        }
        assert!(two.apart_m() > 0.0119, "{}", two.apart_m());
    }

    #[test]
    fn friction_slows_sliding_and_never_reverses_it() {
        let mut two = Two::new(&kinds()[1], 0.0201, [0.05, 0.0]);
        let at = two.bodies.nodes.at(0).moved_m();
        let along = Vec3::new(0.05, 0.01, 0.0);
        two.bodies.nodes.at_mut(0).put(&at, &along);
        for _ in 0..100 {
            two.tick();
        }
        let y = |i: u32, two: &Two| two.bodies.nodes.at(i).velocity_m_s().y;
        let (a, b) = (y(0, &two), y(1, &two));
        assert!((a + b - 0.01).abs() < 1.0e-5, "{a} {b}");
        assert!(b > 0.000_1 && a > b, "{a} {b}");
    }
}
