//! Choice of the next cell to remove, and of the direction of the hook's bent end for it.

use crate::gentle::ROOM_M;
use crate::hold::{BEND_M, ELECTRODE_M, Hook, WORKS, electrode_room_m, free_side, turns};
use crate::sight::{Bar, between, off_line};
use crate::vector::Vec3;
use crate::work::Work;

/// Distance between the electrode and a structure that must not be burnt at which the current is
/// switched off, m.
pub(crate) const CLEAR_M: f64 = 0.001;
/// Distance to a delicate structure within which the hook moves slowly, and takes a cell from the
/// side that faces away from the structure, m.
pub(crate) const CLOSE_M: f64 = 0.003;
/// Depth to which the electrode sinks into the tissue that it burns, m.
pub(crate) const SUNK_M: f64 = 0.0004;
/// Largest number of tries of a cell.
const TRIES: u8 = 3;
/// A cell within this distance of the path of the shaft obstructs the path, m.
const WAY_M: f64 = 0.0018;
/// Length of the path from a cell towards the port that is checked, m.
const LOOK_M: f64 = 0.04;
/// Delicate structures within this distance of that path are considered, m.
const BESIDE_M: f64 = 0.012;
/// Cost of first removing an obstructing cell outside the regions to remove, expressed as a detour,
/// m.
const OTHER_M: f64 = 0.02;
/// Cost of a cell behind one that was given up, expressed as a detour, m: the hook would push into the
/// tissue there.
const BEHIND_M: f64 = 0.06;
/// Cost of a cell at which the hook has no room, expressed as a detour, m.
const CRAMPED_M: f64 = 0.1;
/// A cell where the hook has this much room costs nothing more, m.
const ROOMY_M: f64 = 0.0015;
/// Cost of a cell with less room than `ROOMY_M`, expressed as a detour, m.
const NARROW_M: f64 = 0.04;
/// Number of nearest candidates that are examined closely. About as many are sampled from all
/// candidates.
const CLOSELY: usize = 16;
/// Number of directions of the bent end that are tried for each candidate.
const TURNS: u32 = 12;
/// Places of the bent end on its way out that are checked, as distances from the cell, m. A tube that
/// it meets there would be hooked.
const OUT_M: [f64; 6] = [0.002, 0.004, 0.007, 0.010, 0.014, 0.018];
/// Cost of a direction in which the bent end meets a tube on its way, expressed as a detour, m.
const HOOKED_M: f64 = 0.03;
/// A cell that is displaced from rest by more than this counts as loose and is left out, m.
const ADRIFT_M: f64 = 0.025;

/// The scene as seen before a cell is chosen.
struct Now {
    /// Indices and positions of the remaining cells, m.
    left: Vec<(usize, Vec3)>,
    /// Solid organs that can obstruct the shaft.
    solid: Vec<Bar>,
    /// Structures that must not be burnt or touched.
    delicate: Vec<Bar>,
}

/// A cell, and the direction in which to turn the hook's bent end for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choice {
    cost_m: f64,
    pub(crate) cell: usize,
    pub(crate) bend: Vec3,
}

impl Work<'_> {
    fn now(&self) -> Now {
        let state = &self.seen.state;
        let cells = self.field.cells.iter().enumerate();
        let left = cells.filter(|(index, _)| self.field.is_left(*index, state));
        Now {
            left: left
                .map(|(index, cell)| (index, cell.at(&self.sight, state), cell.center))
                .filter(|(_, at, rest)| (at - rest).norm() < ADRIFT_M)
                .map(|(index, at, _)| (index, at))
                .collect(),
            solid: self.sight.solid(state),
            delicate: self.sight.delicate(self.works(), 0.08, state),
        }
    }

    /// Chooses the next cell: a near one with little in front of it.
    pub(crate) fn choose(&self, regions: &[u8]) -> Option<Choice> {
        let now = self.now();
        let (tip, port) = (self.works(), self.sight.port());
        let mut candidates: Vec<(f64, usize, Vec3)> = Vec::new();
        for &(index, at) in &now.left {
            let cell = self.field.cells.get(index)?;
            let tries = self.field.tries(index);
            if self.field.is_in(index, regions)
                && tries < TRIES
                && self.field.is_exposed(cell, &self.seen.state)
            {
                let travel_m = (at - tip).norm() + 0.5 * (at - port).norm();
                candidates.push((travel_m + 0.02 * f64::from(tries), index, at));
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The nearest candidates, and a sample of all.
        let step = (candidates.len() / CLOSELY).max(1);
        let near = candidates.iter().take(CLOSELY);
        let chosen = near.chain(candidates.iter().step_by(step));
        let chosen = chosen.filter_map(|&(_, index, at)| {
            let (in_way_m, first) = self.in_way(&now, index, at);
            let (index, at) = first.unwrap_or((index, at));
            let cell = self.field.cells.get(index)?;
            let other_m = if self.field.is_in(index, regions) {
                0.0
            } else {
                OTHER_M
            };
            let (held_m, bend) = self.hold(&now, at, cell.radius_m)?;
            let travel_m = (at - tip).norm() + 0.5 * (at - port).norm();
            Some(Choice {
                cost_m: travel_m
                    + other_m
                    + 0.02 * f64::from(self.field.tries(index))
                    + in_way_m
                    + held_m,
                cell: index,
                bend,
            })
        });
        chosen.min_by(|a, b| a.cost_m.total_cmp(&b.cost_m))
    }

    /// Obstruction between a cell and the port, expressed as a detour, m, and the obstructing cell
    /// to remove first: the one nearest to the port.
    fn in_way(&self, now: &Now, index: usize, at: Vec3) -> (f64, Option<(usize, Vec3)>) {
        let out = (self.sight.port() - at).normalize();
        let line = [at, at + out * LOOK_M];
        let mut cost_m = 0.0;
        let mut first: Option<(f64, (usize, Vec3))> = None;
        for &(other, there) in &now.left {
            let ahead = (there - at).dot(&out);
            if other != index && ahead > 0.001 && off_line(there, line) < WAY_M {
                cost_m += 0.004;
                if first.is_none_or(|(farthest, _)| ahead > farthest) {
                    first = Some((ahead, (other, there)));
                }
            }
        }
        for bar in &now.solid {
            let deep_m = bar.radius_m + 0.001 - off_line(bar.ends[0], line);
            cost_m += if deep_m > 0.0 { 4.0 * deep_m } else { 0.0 };
        }
        match first {
            Some((_, (cell, _))) if self.field.tries(cell) >= TRIES => (cost_m + BEHIND_M, None),
            first => (cost_m, first.map(|(_, first)| first)),
        }
    }

    /// Best direction of the bent end for a cell, and the direction's cost, expressed as a detour,
    /// m.
    fn hold(&self, now: &Now, at: Vec3, radius_m: f64) -> Option<(f64, Vec3)> {
        let [heel, end] = self.electrode()?;
        let port = self.sight.port();
        let out = (port - at).normalize();
        let line = [at, at + out * LOOK_M];
        let near = now.delicate.iter();
        let near = near.filter(|bar| between(line, bar.ends).norm() - bar.radius_m < BESIDE_M);
        let near: Vec<&Bar> = near.collect();
        let touchy: Vec<&Bar> = near.iter().copied().filter(|bar| bar.is_touchy).collect();
        let off_m = radius_m + ELECTRODE_M - SUNK_M;
        let held = free_side(at, off_m, CLOSE_M, near.iter().copied());
        let mut best: Option<(f64, Vec3)> = None;
        for (bend, angle) in turns((end - heel).normalize(), -out, TURNS) {
            let hook = Hook::held(held, bend, port);
            let (room_m, _) = hook.room(touchy.iter().copied());
            let from = held - bend * (WORKS * BEND_M);
            let burns_m = electrode_room_m([from, from + bend * BEND_M], near.iter().copied());
            let hooks = OUT_M.iter().any(|by_m| {
                let ends = [from, from + bend * BEND_M].map(|end| end + out * *by_m);
                electrode_room_m(ends, near.iter().copied()) < ROOM_M
            });
            // Without any room the hook pushes aside what it can: such cells come last.
            let tight_m = |room_m: f64| 4.0 * (0.002 - room_m).clamp(0.0, 0.004);
            let is_cramped = room_m < ROOM_M || burns_m < CLEAR_M;
            let cost_m = 0.008 * angle.abs()
                + tight_m(room_m)
                + tight_m(burns_m)
                + if hooks { HOOKED_M } else { 0.0 }
                + match (is_cramped, room_m < ROOMY_M) {
                    (true, _) => CRAMPED_M,
                    (false, true) => NARROW_M,
                    (false, false) => 0.0,
                };
            if best.is_none_or(|(least, _)| cost_m < least) {
                best = Some((cost_m, bend));
            }
        }
        best
    }
}
