//! What spheres of organs do to each other that have come together: they press each other apart, and rub.
//!
//! The contact is a damped spring (XPBD, Macklin 2016) in each of the finer organ's substeps. So where a sphere is
//! squeezed between others, pushes come to a balance; were each to have its way in turn, none would ever rest.

use heapless::Vec;

use crate::capacity::MAX_CLOSE_PAIRS;
use crate::collision::pairs::Pair;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::Scene;
use crate::soft_body::Bodies;
use crate::soft_body::lanes::Lanes;
use crate::soft_body::pace::{Moment, Pace};
use crate::state::SphereBits;

/// Pairs nearer than this to touching at the beginning of a tick may touch within it, m: what comes together
/// faster than at half a metre a second does so a tick later.
const CLOSE_M: f32 = 0.000_5;
/// Stiffness of the contact of two spheres, N/m: a gallbladder that is pressed on the liver with 1 N lies a quarter of a
/// millimetre in it.
const STIFFNESS_N_M: f32 = 200.0;
/// How much the speed at which an overlap grows counts beside it, s: so much that nothing bounces.
const DAMPED_S: f32 = 0.001;
/// Share of an overlap that is taken back in a substep at most: light spheres are not shot out.
const SOFT: f32 = 0.4;
/// Organs that lie in each other part this fast at most, m/s: a duct that has slipped far into an organ comes
/// out of it, and is not shot out.
const PART_M_S: f32 = 0.5;
/// Friction of wet serous skins on each other (pleura on pleura; D'Angelo 2004, DOI 10.1016/j.resp.2004.05.006).
const FRICTION: f32 = 0.02;

/// Slots in which pairs are looked up.
const SLOTS: usize = 4 * MAX_CLOSE_PAIRS;
const NO_PAIR: [u16; 2] = [u16::MAX; 2];

/// A pair that may touch in this tick.
#[derive(Debug, Clone, Copy)]
struct Close {
    pair: Pair,
    /// In how many steps of a tick it is looked at.
    times: u32,
}

/// Those of a tick.
#[derive(Debug, Clone)]
pub(crate) struct Between {
    close: Vec<Close, MAX_CLOSE_PAIRS>,
    /// Where each of them is noted, so that none is in twice.
    slots: [[u16; 2]; SLOTS],
}

impl Between {
    pub(crate) const fn new() -> Self {
        Self {
            close: Vec::new(),
            slots: [NO_PAIR; SLOTS],
        }
    }

    /// None.
    pub(crate) fn clear(&mut self) {
        self.close.clear();
    }

    /// Chooses what may touch in this tick of pairs that are near.
    pub(crate) fn choose<'a>(
        &mut self,
        near: impl Iterator<Item = &'a Pair>,
        scene: &Scene<'_>,
        bodies: &Bodies,
        faults: &mut FaultSet,
    ) {
        self.close.clear();
        self.slots = [NO_PAIR; SLOTS];
        for pair in near {
            let [a, b] = [pair.a, pair.b].map(u32::from);
            let difference = bodies.nodes.at(a).from(bodies.nodes.at(b));
            let reach_m = pair.apart_m + CLOSE_M;
            if difference.norm_squared() >= reach_m * reach_m || self.is_noted(pair) {
                continue;
            }
            let substeps = |sphere| scene.substeps_of(*bodies.organ.at(sphere));
            let times = substeps(a).max(substeps(b));
            let close = Close { pair: *pair, times };
            faults.raise_if(self.close.push(close).is_err(), Fault::PairOverflow);
        }
    }

    /// Notes a pair; says whether it was already.
    fn is_noted(&mut self, pair: &Pair) -> bool {
        let key = [pair.a, pair.b];
        let hash = (u32::from(pair.a) << 16 | u32::from(pair.b)).wrapping_mul(0x9e37_79b1);
        let first = (hash >> 16) as usize;
        for i in 0..SLOTS {
            let Some(slot) = self.slots.get_mut((first + i) % SLOTS) else {
                return false;
            };
            if *slot == key {
                return true;
            }
            if *slot == NO_PAIR {
                *slot = key;
                return false;
            }
        }
        false
    }

    /// Presses apart, in the finest step `now` of the tick, what touches and whose turn it is.
    pub(crate) fn press_due(&self, now: u32, scene: &Scene<'_>, bodies: &mut Bodies) {
        for close in &self.close {
            if let Some(moment) = Moment::due(now, close.times, scene) {
                press(&close.pair, &moment, scene, bodies);
            }
        }
    }
}

fn press(pair: &Pair, at: &Moment, scene: &Scene<'_>, bodies: &mut Bodies) {
    let [a, b] = [pair.a, pair.b].map(u32::from);
    let (node_a, node_b) = (*bodies.nodes.at(a), *bodies.nodes.at(b));
    let [pace_a, pace_b] = [a, b].map(|sphere| Pace::of(sphere, at, scene, bodies));
    let start = node_a.away_at_start(&node_b);
    let now = (start + (pace_a.way(&node_a) - pace_b.way(&node_b))).vec3();
    let near_m = math::norm(&now);
    let weight_per_kg = pace_a.weight() + pace_b.weight();
    if near_m >= pair.apart_m || weight_per_kg <= 0.0 || is_gone(bodies, pair) {
        return;
    }
    let before = (start + (pace_a.way_before(&node_a) - pace_b.way_before(&node_b))).vec3();
    let direction = math::unit(&now).unwrap_or_else(Vec3::x);
    let came_m = math::norm(&before) - near_m;
    let step_s = at.step_s();
    let rate = DAMPED_S / step_s;
    // How far it goes apart for being so deep, were it as heavy as this.
    let softness = (STIFFNESS_N_M * step_s * step_s * weight_per_kg).recip();
    let answer = ((1.0 + rate) + softness).recip().min(SOFT);
    let wanted_m = answer * (pair.apart_m - near_m + rate * came_m);
    let push_m = wanted_m.min(came_m.max(0.0) + PART_M_S * step_s).max(0.0);
    // Along the surfaces they hold each other back by a share of that.
    let slid = now - before;
    let slid = slid - direction * direction.dot(&slid);
    let held = FRICTION * push_m
        / math::norm(&slid)
            .max(FRICTION * push_m)
            .max(f32::MIN_POSITIVE);
    let push = (direction * push_m - slid * held) / weight_per_kg;
    let push = Lanes::new(&push, 0.0);
    pace_a.push(bodies.nodes.at_mut(a), push);
    pace_b.push(bodies.nodes.at_mut(b), push.scaled(-1.0));
}

/// Whether one of the two is layered tissue of which nothing is left.
fn is_gone(bodies: &Bodies, pair: &Pair) -> bool {
    [pair.a, pair.b].iter().any(|&i| {
        let bits = bodies.bits.at(u32::from(i));
        bits.contains(SphereBits::GONE)
    })
}
