//! Organ against organ, and an organ against itself: overlapping spheres that are not linked are
//! moved apart along the line of centres (the paper's projection).
//!
//! Inner spheres of one organ overlap at rest by construction. So within an organ only pairs
//! that were apart at rest are kept apart; spheres of two organs are not let nearer than they
//! were at rest. The paper does not say how it tells these cases.
//!
//! Near pairs are searched in a grid, a sixteenth of the spheres a tick: a list is complete after
//! [`CYCLE`] ticks and used for as many. Spheres that close more than [`MARGIN_M`] in that time
//! (0.1 m/s) are seen late by at most 32 ms. O(spheres in neighbouring cells / 16 + pairs) a tick.

use heapless::Vec;

use crate::capacity::MAX_SPHERE_PAIRS;
use crate::collision::grid::Grid;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::Scene;
use crate::soft_body::Bodies;

/// Ticks in which every sphere is searched once.
const CYCLE: u32 = 16;
/// Pairs nearer than this to touching are kept, m.
const MARGIN_M: f32 = 0.003;

/// Within an organ, only pairs nearer than this share of their squared distance at rest are
/// kept (5 % nearer than at rest): an organ at rest has none.
const HAS_CLOSED: f32 = 0.9;

/// Two spheres that may come to overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pair {
    a: u16,
    b: u16,
    /// Their centres are kept this far apart, m.
    apart_m: f32,
}

/// The pairs in use and those being collected.
#[derive(Debug)]
pub(crate) struct Pairs {
    grid: Grid,
    current: Vec<Pair, MAX_SPHERE_PAIRS>,
    next: Vec<Pair, MAX_SPHERE_PAIRS>,
    /// Position in the cycle.
    phase: u32,
    /// Radius of the scene's largest sphere, m.
    radius_max_m: f32,
}

impl Pairs {
    pub(crate) const fn new() -> Self {
        Self {
            grid: Grid::new(),
            current: Vec::new(),
            next: Vec::new(),
            phase: 0,
            radius_max_m: 0.0,
        }
    }

    /// Starts anew with `scene`, whose spheres `bodies` holds.
    pub(crate) fn load(&mut self, scene: &Scene<'_>) {
        self.radius_max_m = scene.spheres.iter().map(|s| s.radius_m).fold(0.0, f32::max);
        self.current.clear();
        self.next.clear();
        self.phase = 0;
    }

    /// Searches this tick's share of the spheres for near pairs.
    pub(crate) fn find(&mut self, scene: &Scene<'_>, bodies: &Bodies, faults: &mut FaultSet) {
        let count = scene.spheres.len() as u32;
        if self.phase == 0 {
            core::mem::swap(&mut self.current, &mut self.next);
            self.next.clear();
            self.grid
                .build(bodies, count, 2.0 * self.radius_max_m + MARGIN_M);
        }
        for a in (self.phase..count).step_by(CYCLE as usize) {
            for run in self.grid.near(&bodies.nodes.at(a).center_m()) {
                for &b in run.iter().filter(|&&b| u32::from(b) > a) {
                    if let Some(pair) = near_pair(bodies, a, u32::from(b)) {
                        faults.raise_if(self.next.push(pair).is_err(), Fault::PairOverflow);
                    }
                }
            }
        }
        self.phase = (self.phase + 1) % CYCLE;
    }

    /// Moves overlapping pairs apart, each sphere by its share of the inverse masses.
    pub(crate) fn project(&self, bodies: &mut Bodies) {
        for pair in &self.current {
            let (a, b) = (
                bodies.nodes.at(u32::from(pair.a)),
                bodies.nodes.at(u32::from(pair.b)),
            );
            let difference = (a.rest_m - b.rest_m) + (a.moved_m - b.moved_m);
            if difference.norm_squared() >= pair.apart_m * pair.apart_m {
                continue;
            }
            let (wa, wb) = (a.inverse_mass_per_kg, b.inverse_mass_per_kg);
            let (da, db) = push_apart(&difference, wa, wb, pair.apart_m);
            bodies.nodes.at_mut(u32::from(pair.a)).moved_m += da;
            bodies.nodes.at_mut(u32::from(pair.b)).moved_m += db;
        }
    }
}

/// Displacements that bring two spheres, the first at `difference` from the second, `apart_m`
/// from each other. Centres in one place part along x: any direction serves, always the same.
fn push_apart(difference: &Vec3, wa: f32, wb: f32, apart_m: f32) -> (Vec3, Vec3) {
    let sum = wa + wb;
    if sum <= 0.0 {
        return (Vec3::zeros(), Vec3::zeros());
    }
    let direction = math::unit(difference).unwrap_or_else(|| Vec3::new(1.0, 0.0, 0.0));
    let step = direction * ((apart_m - math::norm(difference)) / sum);
    (step * wa, step * -wb)
}

/// The pair, if it is near and must be kept apart.
fn near_pair(bodies: &Bodies, a: u32, b: u32) -> Option<Pair> {
    let (node_a, node_b) = (bodies.nodes.at(a), bodies.nodes.at(b));
    let reach = node_a.radius_m + node_b.radius_m;
    let squared = (node_a.center_m() - node_b.center_m()).norm_squared();
    if squared >= (reach + MARGIN_M) * (reach + MARGIN_M) {
        return None;
    }
    let at_rest_m = math::norm(&(node_a.rest_m - node_b.rest_m));
    let apart_m = reach.min(at_rest_m);
    let same_organ = bodies.organ.at(a) == bodies.organ.at(b);
    let linked = || bodies.adjacency.of(a).iter().any(|&n| u32::from(n) == b);
    let near = squared < (apart_m + MARGIN_M) * (apart_m + MARGIN_M);
    let has_closed = squared < HAS_CLOSED * at_rest_m * at_rest_m;
    let kept = near && (!same_organ || (has_closed && at_rest_m >= reach && !linked()));
    kept.then_some(Pair {
        a: a as u16,
        b: b as u16,
        apart_m,
    })
}
