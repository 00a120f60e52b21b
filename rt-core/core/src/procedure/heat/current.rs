//! Heat of the current, by its path through the tissue.
//!
//! - Half of the power becomes heat within one tip radius of the tip's surface
//!   (`cautery::electrode`). One part of it boils tissue away; the rest warms the tissue that the
//!   tip touches.
//! - The other half becomes heat farther out. In solid tissue, the density of a current `I` from a
//!   tip of radius `a` at a surface falls with the square of the distance `r`, so its heat is
//!   `P a / 2π r⁴`. This heat warms the tissue that lies beside the tip.
//! - Where the tip touches a tube or a sheet, the current stays in it until it reaches a larger
//!   organ, or the body. Its potential is computed by sweeps of Jacobi's method, three in five
//!   ticks. Each link takes heat by its conductance and the square of its difference of potential.
//!
//! Current in a tube that hangs free, and heat farther than `REACH_M` from the tip, warm nothing:
//! their energy counts as spread.

use heapless::Vec;

use super::Heat;
use super::conduction::section_of_tie_m;
use super::tube_current::TubeCurrent;
use crate::capacity::MAX_ORGANS;
use crate::procedure::cautery::{Electrode, Shares, TouchedCell};
use crate::scene::{Cell, Organ, Scene};
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::{Bodies, Bounds};
use crate::words::SphereBits;

/// Distance from the tip beyond which its heat is left out, m. Less than a tenth of the power is
/// farther away.
const REACH_M: f32 = 0.012;
/// Most spheres that a tick warms beside the tip.
const NEAR_MAX: usize = 1024;
/// Length of a round, ticks. Each round computes the heat of tubes once.
const ROUND: u32 = 5;
/// Least sum over all paths with which current flows, m. The sum is section over length, weighted
/// by the squared difference of potential.
const PATH_SUM_MIN_M: f32 = 1.0e-12;

/// Current of a tick, and what it touches.
#[derive(Debug)]
pub(crate) struct Current<'a> {
    pub(crate) electrode: &'a Electrode,
    pub(crate) shares: &'a Shares,
    pub(crate) cells: &'a [TouchedCell],
}

impl Heat {
    /// Turns the current of a tick into heat.
    pub(crate) fn take(
        &mut self,
        current: &Current<'_>,
        scene: &Scene<'_>,
        bodies: &Bodies,
        bounds: &[Bounds; MAX_ORGANS],
    ) {
        let shares = current.shares;
        let given_j = 2.0 * shares.near_j();
        self.balance.given_j += f64::from(given_j);
        self.balance.boiled_j += f64::from(shares.dividing_j());
        let nearest = self.warm_near(current, scene, bodies, bounds);
        for (link, energy_j) in &shares.links {
            if let Some(link) = scene.links.get(*link as usize) {
                self.warm_or_spread(Some(link.a), 0.5 * energy_j);
                self.warm_or_spread(Some(link.b), 0.5 * energy_j);
            }
        }
        for touched in current.cells {
            let cell = scene.layers.cell(touched.cell).map(Cell::sphere);
            self.warm_or_spread(cell, shares.dose.drying_j_m2 * touched.area_m2);
        }
        for (area_m2, nearest) in shares.surfaces_m2.iter().zip(nearest) {
            self.warm_or_spread(nearest, shares.dose.drying_j_m2 * area_m2);
        }
        self.balance.spread_j += f64::from(shares.other_drying_j());
        self.warm_along_tubes(shares, scene, bodies);
    }

    fn warm_or_spread(&mut self, sphere: Option<u32>, energy_j: f32) {
        match sphere {
            Some(sphere) if *self.capacity_j_k.at(sphere) > 0.0 => self.warm(sphere, energy_j),
            _ => self.balance.spread_j += f64::from(energy_j.max(0.0)),
        }
    }

    /// Warms tissue beside the tip. Returns the sphere of each organ that is nearest to the tip.
    fn warm_near(
        &mut self,
        current: &Current<'_>,
        scene: &Scene<'_>,
        bodies: &Bodies,
        bounds: &[Bounds; MAX_ORGANS],
    ) -> [Option<u32>; MAX_ORGANS] {
        let (electrode, shares) = (current.electrode, current.shares);
        let joined = joined_organs(shares, current.cells, scene, bodies);
        let middle_m = electrode.middle_m();
        let mut around = Bounds::EMPTY;
        around.add(&middle_m, REACH_M);
        let budget_j = shares.near_j() * (1.0 - shares.tube_share());
        // Energy of the whole power in a tick, times the radius of the tip, over 2π.
        let tip_j_m = shares.near_j() * electrode.diameter_m() / core::f32::consts::TAU;
        let mut nearest = [None; MAX_ORGANS];
        let mut wanted: Vec<(u32, f32), NEAR_MAX> = Vec::new();
        for (((it, near), bounds), joined) in scene
            .organs
            .iter()
            .zip(&mut nearest)
            .zip(bounds)
            .zip(joined)
        {
            if !joined || !bounds.is_near(&around, 0.0) {
                continue;
            }
            let mut least_m2 = f32::MAX;
            for sphere in it.sphere_start..it.sphere_start.saturating_add(it.sphere_count) {
                let center_m = bodies.nodes.at(sphere).center_m();
                let distance_m2 = (center_m - middle_m).norm_squared();
                if distance_m2 < least_m2 {
                    (least_m2, *near) = (distance_m2, Some(sphere));
                }
                let is_removed = bodies.bits.at(sphere).contains(SphereBits::REMOVED);
                if distance_m2 < REACH_M * REACH_M && !is_removed {
                    let distance_m = electrode.distance_m(&center_m);
                    let rest = scene.spheres.get(sphere as usize);
                    let radius_m = rest.map_or(0.0, |it| it.radius_m);
                    let least_m = radius_m.max(electrode.diameter_m());
                    let off_m = distance_m.max(least_m);
                    let square_m2 = off_m * off_m;
                    let own_j = tip_j_m * self.volume_m3(sphere) / (square_m2 * square_m2);
                    let _ = wanted.push((sphere, own_j)); // without room: counts as spread
                }
            }
        }
        let sum_j: f32 = wanted.iter().map(|(_, own_j)| own_j).sum();
        let share = if sum_j > budget_j {
            budget_j / sum_j
        } else {
            1.0
        };
        for (sphere, own_j) in wanted {
            self.warm_or_spread(Some(sphere), own_j * share);
        }
        self.balance.spread_j += f64::from(budget_j - sum_j * share);
        nearest
    }

    /// Warms the tubes and sheets that the tip touches, along the path of the current. A round
    /// takes [`ROUND`] ticks: sweeps of the potential, then the sum of all heat, then the heat.
    fn warm_along_tubes(&mut self, shares: &Shares, scene: &Scene<'_>, bodies: &Bodies) {
        self.tube_current.due_j += shares.near_j() * shares.tube_share();
        if shares.links.is_empty() && self.tube_current.step == 0 {
            return;
        }
        let step = self.tube_current.step;
        self.tube_current.step = (step + 1) % ROUND;
        if step + 2 < ROUND {
            for (link, _) in &shares.links {
                if let Some(link) = scene.links.get(*link as usize) {
                    *self.potential.at_mut(link.a) = 1.0;
                    *self.potential.at_mut(link.b) = 1.0;
                }
            }
            self.sweep(scene, bodies);
        } else if step + 2 == ROUND {
            let mut sum_m = 0.0;
            self.for_paths(scene, bodies, |heat, [a, b], section_m| {
                let difference = *heat.potential.at(a) - *heat.potential.at(b);
                sum_m += section_m * difference * difference;
            });
            self.tube_current.sum_m = sum_m;
        } else {
            let sum_m = core::mem::take(&mut self.tube_current.sum_m);
            let due_j = core::mem::take(&mut self.tube_current.due_j);
            if !(sum_m.is_finite() && sum_m > PATH_SUM_MIN_M) {
                self.balance.spread_j += f64::from(due_j);
                return;
            }
            self.for_paths(scene, bodies, |heat, [a, b], section_m| {
                let difference = *heat.potential.at(a) - *heat.potential.at(b);
                let own_j = due_j * (section_m * difference * difference / sum_m);
                heat.warm_or_spread(Some(a), 0.5 * own_j);
                heat.warm_or_spread(Some(b), 0.5 * own_j);
            });
        }
    }

    /// Forgets the paths of the current, when it ends.
    pub(crate) fn end_current(&mut self) {
        if self.tube_current != TubeCurrent::NONE {
            self.balance.spread_j += f64::from(self.tube_current.due_j);
            self.tube_current = TubeCurrent::NONE;
            self.potential = PerSphere::new(0.0);
        }
    }

    /// One sweep of Jacobi's method over all tubes.
    fn sweep(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        self.for_paths(scene, bodies, |heat, [a, b], section_m| {
            for (to, from) in [(a, b), (b, a)] {
                let from = *heat.potential.at(from);
                let sums = heat.sums.at_mut(to);
                *sums = (sums.0 + section_m * from, sums.1 + section_m);
            }
        });
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !carries(organ, scene) {
                continue;
            }
            for sphere in it.sphere_start..it.sphere_start.saturating_add(it.sphere_count) {
                let (weighted, sum) = core::mem::take(self.sums.at_mut(sphere));
                let is_held = scene.spheres.get(sphere as usize).is_some_and(|it| it.held);
                let is_free = !is_held && sum > 0.0;
                *self.potential.at_mut(sphere) = if is_free { weighted / sum } else { 0.0 };
            }
        }
    }

    /// Calls `work` for every path of current: intact links of tubes and sheets, and their intact
    /// attachments. Gives both ends, and the section divided by the length, m.
    fn for_paths(
        &mut self,
        scene: &Scene<'_>,
        bodies: &Bodies,
        mut work: impl FnMut(&mut Self, [u32; 2], f32),
    ) {
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !carries(organ, scene) {
                continue;
            }
            for (i, link) in (it.link_start..).zip(scene.elastic_links_of(it)) {
                if bodies.damage.intact_of_link(i) > 0.0 {
                    let section_m = self.section_of_link_m(link, scene, bodies);
                    work(self, [link.a, link.b], section_m);
                }
            }
        }
        for (i, tie) in scene.attachments.iter().enumerate() {
            let Some(other) = tie.other_sphere() else {
                continue;
            };
            let carries = |sphere: u32| carries(*bodies.organ.at(sphere), scene);
            let is_path = carries(tie.sphere) || carries(other);
            if is_path && bodies.damage.intact_of_tie(i) > 0.0 {
                work(
                    self,
                    [tie.sphere, other],
                    section_of_tie_m(tie, other, scene),
                );
            }
        }
    }
}

/// True for a tube or sheet: current can flow only along it.
fn carries(organ: u8, scene: &Scene<'_>) -> bool {
    let it = scene.organs.get(usize::from(organ));
    it.is_some_and(Organ::is_tube)
}

/// Organs that the tip touches, and those that are attached to one of them.
fn joined_organs(
    shares: &Shares,
    cells: &[TouchedCell],
    scene: &Scene<'_>,
    bodies: &Bodies,
) -> [bool; MAX_ORGANS] {
    let mut touched = [false; MAX_ORGANS];
    let mut touch = |organ: u8| {
        if let Some(touched) = touched.get_mut(usize::from(organ)) {
            *touched = true;
        }
    };
    for (link, _) in &shares.links {
        if let Some(link) = scene.links.get(*link as usize) {
            touch(*bodies.organ.at(link.a));
        }
    }
    for cell in cells {
        touch(cell.organ);
    }
    for (organ, area_m2) in (0u8..).zip(shares.surfaces_m2) {
        if area_m2 > 0.0 {
            touch(organ);
        }
    }
    let mut joined = touched;
    for (i, tie) in scene.attachments.iter().enumerate() {
        if let (Some(other), true) = (tie.other_sphere(), bodies.damage.intact_of_tie(i) > 0.0) {
            let ends = [tie.sphere, other].map(|it| usize::from(*bodies.organ.at(it)));
            let is_touched = ends.iter().any(|it| touched.get(*it) == Some(&true));
            for end in ends {
                if let (Some(joined), true) = (joined.get_mut(end), is_touched) {
                    *joined = true;
                }
            }
        }
    }
    joined
}
