//! Dissection with the hook: removes layered tissue cell by cell, the nearest reachable cell first.

use shared_mem::scene::CellRecord;

use crate::gentle::{CLOSER_M, ROOM_M, STUCK_S};
use crate::hold::{BEND_M, ELECTRODE_M, Hook, WORKS, electrode_room_m, free_side, turns};
use crate::nearing::Nearing;
use crate::plan::COAGULATE;
use crate::sight::{Bar, between, off_line};
use crate::vector::Vec3;
use crate::work::{BACK_M, Work};

/// Distance between the electrode and a structure that must not be burnt at which the current is
/// switched off, m.
const CLEAR_M: f64 = 0.001;
/// Distance to a delicate structure within which the hook moves slowly, and takes a cell from the
/// side that faces away from the structure, m.
const CLOSE_M: f64 = 0.003;
/// Longest movement in a quarter of a second within `CLOSE_M` of a delicate structure, m. It is
/// short because the current ends, and the picture changes, some time after the surgeon's decision.
const SLOW_M: f64 = 0.003;
/// If a cell is farther than this from the hook's working point, the hook withdraws and approaches
/// the cell from the port's side, m.
const NEAR_M: f64 = 0.010;
/// A cell within this distance of the path of the shaft obstructs the path, m.
const WAY_M: f64 = 0.0018;
/// Length of the path from a cell towards the port that is checked, m.
const LOOK_M: f64 = 0.04;
/// Delicate structures within this distance of the path from a cell towards the port are
/// considered, m.
const BESIDE_M: f64 = 0.012;
/// Cost of an obstructing cell outside the regions to remove, expressed as a detour, m.
const OTHER_M: f64 = 0.02;
/// Cost of a cell at which the hook has no room, expressed as a detour, m.
const CRAMPED_M: f64 = 0.1;
/// Distance from a duct or vessel that must stay whole within which a burning cell warms it, m.
/// The heat falls with the fourth power of the distance.
const WARMS_M: f64 = 0.008;
/// Temperatures of such a duct or vessel above the body's, K. Above the first, the cells near it
/// cost more, so that the surgeon works elsewhere while it cools. Above the second, the cost is the
/// whole [`WARM_M`]. At 13 K tissue dies within a quarter of an hour, at 18 K within half a minute.
const WARM_K: [f64; 2] = [8.0, 12.0];
/// Cost of a cell at a duct or vessel above the second of these temperatures, expressed as a
/// detour, m.
const WARM_M: f64 = 0.15;
/// Room for the hook at a cell above which no cost is added, m.
const ROOMY_M: f64 = 0.0015;
/// Cost of a cell at which the hook has less room than `ROOMY_M`, expressed as a detour, m.
const NARROW_M: f64 = 0.04;
/// Depth to which the electrode sinks into the tissue that it burns, m.
const SUNK_M: f64 = 0.0004;
/// Number of nearest candidates whose whole cost is computed. The whole cost of about as many
/// others, at equal steps in the list of candidates, is computed too.
const CLOSELY: usize = 16;
/// Number of directions of the bent end that are tried for each candidate.
const TURNS: u32 = 12;
/// Largest lead of the hand over a tip that tissue holds in the gallbladder's bed, m.
const LAG_M: f64 = 0.006;
/// Largest lead of the hand over a tip that fat holds, m. It is smaller, because ducts lie in the
/// fat and spring back when the fat gives way.
const PUSH_M: f64 = 0.005;
/// A cell that is displaced from rest by more than this counts as loose and is not removed, m.
const ADRIFT_M: f64 = 0.025;
/// The surgeon gives up a cell after this time, s.
const LONG_S: f64 = 4.0;
/// Cells within this distance of the target may lie in front of it, and are burnt with it, m.
const AROUND_M: f64 = 0.010;
/// Tissue within this distance of the electrode counts as touched, m.
const REACHED_M: f64 = 0.0002;
/// Largest number of tries of a cell.
const TRIES: u8 = 3;
/// All cells are tried again only if more than this share of the tissue was removed since the last
/// time.
const WORTH: f64 = 0.01;
/// If no cell is in reach, the surgeon withdraws, lets the tissue settle for this time, s, and
/// tries all cells again.
const REST_S: f64 = 1.5;
/// Largest number of such pauses in one dissection.
const RESTS: u32 = 3;

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
struct Choice {
    cost_m: f64,
    cell: usize,
    bend: Vec3,
}

/// Cost of warming a warm duct or vessel that must stay whole further, expressed as a detour, m.
fn warms_m(now: &Now, at: Vec3, radius_m: f64) -> f64 {
    let [from_k, to_k] = WARM_K;
    let costs_m = now.delicate.iter().filter(|bar| bar.is_touchy).map(|bar| {
        let room_m = between([at; 2], bar.ends).norm() - bar.radius_m - radius_m;
        let near = (1.0 - room_m / WARMS_M).clamp(0.0, 1.0);
        let warm = ((bar.rise_k - from_k) / (to_k - from_k)).clamp(0.0, 1.0);
        WARM_M * near * warm
    });
    costs_m.fold(0.0, f64::max)
}

impl Work<'_> {
    /// Removes cells of `regions` until this share of their tissue is removed, for at most
    /// `seconds`.
    pub(crate) fn dissect(
        &mut self,
        regions: &[u8],
        share: f64,
        seconds: f64,
    ) -> Result<(), String> {
        self.field.begin();
        let until_s = self.seen.at_s + seconds;
        let (mut before, mut rests) = (0.0, 0);
        let done = loop {
            let gone = self.field.gone(regions, &self.seen.state);
            if gone >= share {
                break Ok(());
            }
            if self.seen.at_s > until_s {
                break Err(format!(
                    "only {:.1} % is removed after {seconds:.0} s",
                    100.0 * gone
                ));
            }
            let Some(choice) = self.choose(regions) else {
                if gone > before + WORTH {
                    // Cells that were in the way may have been removed.
                    before = gone;
                    self.field.begin();
                    continue;
                }
                if rests < RESTS {
                    rests += 1;
                    self.withdraw(BACK_M)?;
                    self.wait(REST_S)?;
                    self.field.begin();
                    continue;
                }
                break Err(format!(
                    "only {:.1} % is removed, the rest is out of reach",
                    100.0 * gone
                ));
            };
            if !self.take_away(&choice)? {
                self.field.give_up(choice.cell);
                // Move the hook away from what stopped it, or from a tube that hangs on it.
                self.withdraw(0.01)?;
            }
            self.goes_on()?;
        };
        self.asked.switches = 0;
        done
    }

    /// Remaining cells and obstacles at this moment.
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

    /// Chooses the cell of least cost: a near one with little in front of it and much room around.
    fn choose(&self, regions: &[u8]) -> Option<Choice> {
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
        // The nearest candidates, and others at equal steps.
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
                    + warms_m(&now, at, cell.radius_m)
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
        let first = first.filter(|(_, (cell, _))| self.field.tries(*cell) < TRIES);
        (cost_m, first.map(|(_, first)| first))
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
            // A cell without room for the hook remains possible, because structures yield. It costs
            // so much that it comes last.
            let tight_m = |room_m: f64| 4.0 * (0.002 - room_m).clamp(0.0, 0.004);
            let is_cramped = room_m < ROOM_M || burns_m < CLEAR_M;
            let cost_m = 0.008 * angle.abs()
                + tight_m(room_m)
                + tight_m(burns_m)
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

    /// True if the electrode touches any of these cells.
    fn touches_any(&self, cells: &[usize], electrode: [Vec3; 2]) -> bool {
        let state = &self.seen.state;
        cells.iter().any(|&index| {
            let cell = self.field.cells.get(index);
            let cell = cell.filter(|_| self.field.is_left(index, state));
            cell.is_some_and(|cell| {
                let off_m = off_line(cell.at(&self.sight, state), electrode);
                off_m < cell.radius_m + ELECTRODE_M + REACHED_M
            })
        })
    }

    /// Moves to a cell and burns it. Returns true if the cell was removed.
    fn take_away(&mut self, choice: &Choice) -> Result<bool, String> {
        let &Choice {
            cell: index, bend, ..
        } = choice;
        let Some(cell) = self.field.cells.get(index) else {
            return Ok(false);
        };
        let is_bed = matches!(cell.region, CellRecord::LOWER_BED | CellRecord::UPPER_BED);
        let radius_m = cell.radius_m;
        let place = |work: &Self| {
            let cell = work.field.cells.get(index);
            cell.map_or_else(Vec3::zeros, |it| it.at(&work.sight, &work.seen.state))
        };
        self.keep_in_picture(&place)?;
        let is_far = (place(self) - self.works()).norm() > NEAR_M;
        if is_far {
            self.withdraw(0.012)?;
            let out = (self.sight.port() - place(self)).normalize();
            self.travel(&|work| place(work) + out * 0.006, bend, 2.0)?;
            if (place(self) - self.works()).norm() > NEAR_M {
                return Ok(false);
            }
        }
        // Time of the last picture, and of the last progress: the hook came nearer, or the cell
        // warmer.
        let (mut before_s, mut better_s) = (self.seen.at_s, self.seen.at_s);
        let around = self.field.around(index, AROUND_M);
        let began_s = self.seen.at_s;
        let (mut nearest_m, mut warmest) = (f64::MAX, 0);
        // Lead of the hand over the tip, and the tip's last position.
        let (mut pulled, mut tip) = (Vec3::zeros(), self.works());
        let mut gone = false;
        let (mut nearing, mut hanging) = (Nearing::default(), None);
        self.look_for(f64::MAX, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, 0.05);
            before_s = work.seen.at_s;
            let Some(electrode) = work.electrode() else {
                return true;
            };
            gone = !work.field.is_left(index, &work.seen.state);
            if gone {
                return true;
            }
            if work.comes_along(&mut hanging) {
                return true;
            }
            let at = place(work);
            let off_m = off_line(at, electrode);
            let warm = (work.seen.state.cells.get(index))
                .copied()
                .unwrap_or_default();
            if off_m < nearest_m - CLOSER_M || warm > warmest {
                (nearest_m, warmest) = (nearest_m.min(off_m), warmest.max(warm));
                better_s = work.seen.at_s;
            }
            let near = work.sight.delicate(work.works(), 0.012, &work.seen.state);
            let room_m = electrode_room_m(electrode, &near);
            let is_clear = nearing.soon(room_m, seconds) > CLEAR_M;
            let reach_m = radius_m + ELECTRODE_M;
            let touches = off_m < reach_m + REACHED_M;
            // Cells in front of the target are burnt as well. Otherwise the hook would push them
            // along.
            let burns = is_clear && (touches || work.touches_any(&around, electrode));
            work.asked.switches = if burns { COAGULATE } else { 0 };
            if burns && touches {
                better_s = work.seen.at_s;
            }
            let held = free_side(at, reach_m - SUNK_M, CLOSE_M, &near);
            let way = held - work.works();
            let mut way = if off_m < reach_m - 0.0002 {
                Vec3::zeros()
            } else if touches {
                way * 0.3
            } else {
                way * 3.0
            };
            if room_m < CLOSE_M {
                way = way.cap_magnitude(SLOW_M);
            }
            let is_held = work.seen.tools.contact_count > 0;
            // In fat, between duct and artery, the hand soon stops at a touch. In the bed the tip's
            // own movement is subtracted from the lead, so that the hand pushes on.
            pulled = match (is_held, is_bed) {
                (true, true) => pulled - (work.works() - tip),
                (true, false) => pulled,
                (false, _) => Vec3::zeros(),
            };
            tip = work.works();
            let most_m = if is_bed { LAG_M } else { PUSH_M };
            if pulled.norm() < most_m || pulled.dot(&way) < 0.0 {
                pulled += (way * 4.0).cap_magnitude(0.04) * seconds;
            } else {
                way = Vec3::zeros();
            }
            work.go_gently(way, bend, seconds);
            work.seen.at_s - better_s > STUCK_S || work.seen.at_s - began_s > LONG_S
        });
        if gone {
            self.burn_on()?;
        }
        self.asked.switches = 0;
        self.goes_on()?;
        Ok(gone)
    }
}
