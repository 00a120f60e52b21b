//! With the hook: cell after cell of layered tissue is taken away, the nearest that can be reached first.

use shared_mem::message::StateFrame;
use shared_mem::scene::{CellRecord, NO_CELL, SceneFile};

use crate::sight::{Bar, Place, off_line, wide};
use crate::work::{COAGULATE, Vec3, Work};

/// The electrode's radius, m (`rt_core::tool`).
const ELECTRODE_M: f64 = 0.0008;
/// Current that comes this near to what must not be burnt is cut off, m.
const CLEAR_M: f64 = 0.0005;
/// A cell farther from the tip than this is come to from in front, m.
const NEAR_M: f64 = 0.008;
/// What lies so near to the way of shaft and hook is in the way, m.
const WAY_M: f64 = 0.0018;
/// The way that is looked along from a cell to the port, m.
const LOOK_M: f64 = 0.04;
/// Candidates that are looked at closely.
const CLOSELY: usize = 24;
/// The hand does not pull farther ahead of a tip that is held, m.
const LAG_M: f64 = 0.006;
/// A cell that does not get nearer or warmer for so long is left, s.
const STUCK_S: f64 = 0.7;
/// A cell is tried so often.
const TRIES: u8 = 3;
/// What lies so near to one that was given up counts as tried, too, m.
const BESIDE_M: f64 = 0.002;

/// Layered tissue at rest.
#[derive(Debug)]
pub(crate) struct Field {
    cells: Vec<Cell>,
    /// How often each was given up.
    tries: Vec<u8>,
}

#[derive(Debug)]
struct Cell {
    center: Vec3,
    spheres: Vec<(usize, f64)>,
    neighbours: [u16; 6],
    /// Outwards, of unit length.
    outwards: Vec3,
    /// As a ball, m.
    radius_m: f64,
    volume_m3: f64,
    region: u8,
}

impl Field {
    pub(crate) fn new(scene: &SceneFile) -> Self {
        let records = scene.cells();
        let center = |index: u16| records.get(usize::from(index)).map(|it| wide(it.center_m));
        let cells = records.iter().map(|record| {
            let own = wide(record.center_m);
            let [.., inner, outer] = record.neighbours;
            let outwards = center(outer).unwrap_or(own) - center(inner).unwrap_or(own);
            let weights = record.spheres.iter().zip(record.weights);
            let weights = weights.filter(|(_, weight)| *weight != 0.0);
            Cell {
                center: own,
                spheres: weights
                    .map(|(sphere, weight)| (usize::from(*sphere), f64::from(weight)))
                    .collect(),
                neighbours: record.neighbours,
                outwards: outwards.try_normalize(1e-9).unwrap_or_else(Vec3::y),
                radius_m: 0.5
                    * record
                        .extent_m
                        .iter()
                        .fold(0.0, |a, b| f64::max(a, (*b).into())),
                volume_m3: record.volume_m3.into(),
                region: record.region,
            }
        });
        let cells: Vec<Cell> = cells.collect();
        Self {
            tries: vec![0; cells.len()],
            cells,
        }
    }

    /// What held this one up holds those beside it up.
    fn give_up(&mut self, index: usize) {
        let Some(at) = self.cells.get(index).map(|cell| cell.center) else {
            return;
        };
        for (cell, tries) in self.cells.iter().zip(&mut self.tries) {
            if (cell.center - at).norm() < BESIDE_M {
                *tries = tries.saturating_add(1);
            }
        }
    }

    /// Share of a region that is gone, by volume.
    fn gone(&self, region: u8, state: &StateFrame) -> f64 {
        let (mut gone, mut all) = (0.0, 0.0);
        for (cell, shown) in self.cells.iter().zip(&state.cells) {
            if cell.region == region {
                all += cell.volume_m3;
                gone += if *shown == StateFrame::GONE {
                    cell.volume_m3
                } else {
                    0.0
                };
            }
        }
        gone / all
    }
}

/// Where the cells that are left are now.
struct Now {
    /// Their numbers and places.
    left: Vec<(usize, Vec3)>,
    /// What else stands in the way of a shaft.
    solid: Vec<Bar>,
}

impl Work<'_> {
    /// Takes cells of a region away until this share of it is gone.
    pub(crate) fn dissect(&mut self, region: u8, share: f64) -> Result<(), String> {
        self.field.tries.fill(0);
        let done = loop {
            let gone = self.field.gone(region, &self.seen.state);
            if gone >= share {
                break Ok(());
            }
            let Some(cell) = self.choose(region) else {
                break Err(format!(
                    "{:.1} % is gone, the rest is out of reach",
                    100.0 * gone
                ));
            };
            if !self.take_away(cell)? {
                self.field.give_up(cell);
                // Out of what held it up.
                let _ = self.retreat(0.01);
            }
            self.goes_on()?;
        };
        self.asked.switches = 0;
        done
    }

    fn is_left(&self, cell: u16) -> bool {
        let shown = self.seen.state.cells.get(usize::from(cell));
        cell != NO_CELL && shown.is_some_and(|shown| *shown != StateFrame::GONE)
    }

    fn at(&self, cell: &Cell) -> Vec3 {
        let state = &self.seen.state;
        let moved = cell.spheres.iter();
        let moved = moved.map(|(sphere, weight)| self.sight.moved(*sphere, state) * *weight);
        cell.center + moved.sum::<Vec3>()
    }

    fn now(&self) -> Now {
        let cells = self.field.cells.iter().enumerate();
        let left = cells.filter(|(index, _)| self.is_left(*index as u16));
        Now {
            left: left.map(|(index, cell)| (index, self.at(cell))).collect(),
            solid: self.sight.solid(&self.seen.state),
        }
    }

    /// The cell to be taken away next: near, and little before it.
    fn choose(&self, region: u8) -> Option<usize> {
        let now = self.now();
        let (tip, port) = (self.tip(), self.sight.port());
        let mut candidates: Vec<(f64, usize, Vec3)> = Vec::new();
        for &(index, at) in &now.left {
            let cell = self.field.cells.get(index)?;
            let tries = *self.field.tries.get(index)?;
            let is_exposed = cell.neighbours.iter().any(|beside| !self.is_left(*beside));
            if cell.region == region && tries < TRIES && is_exposed {
                let far_m = (at - tip).norm() + 0.5 * (at - port).norm();
                candidates.push((far_m + 0.02 * f64::from(tries), index, at));
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Near ones, and some of all.
        let step = (candidates.len() / CLOSELY).max(1);
        let near = candidates.iter().take(CLOSELY);
        let chosen = near
            .chain(candidates.iter().step_by(step))
            .map(|&(cost, index, at)| {
                let (in_way, first) = self.in_way(&now, index, at);
                (cost + in_way, first.unwrap_or(index))
            });
        let best = chosen.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, index)| index)
    }

    /// How much stands between a cell and the port, as m of a detour, and the cell that comes first.
    fn in_way(&self, now: &Now, index: usize, at: Vec3) -> (f64, Option<usize>) {
        let out = (self.sight.port() - at).normalize();
        let line = [at, at + out * LOOK_M];
        let mut cost_m = 0.0;
        let mut first: Option<(f64, usize)> = None;
        for &(other, there) in &now.left {
            let ahead = (there - at).dot(&out);
            if other != index && ahead > 0.001 && off_line(there, line) < WAY_M {
                cost_m += 0.002;
                if first.is_none_or(|(farthest, _)| ahead > farthest) {
                    first = Some((ahead, other));
                }
            }
        }
        for bar in &now.solid {
            let deep_m = bar.radius_m + 0.001 - off_line(bar.ends[0], line);
            cost_m += if deep_m > 0.0 { 4.0 * deep_m } else { 0.0 };
        }
        for bar in self.sight.delicate(at, 0.01, &self.seen.state) {
            let gap_m = off_line(at, bar.ends) - bar.radius_m;
            cost_m += 0.01 * (1.0 - gap_m / 0.002).max(0.0);
        }
        let first =
            first.filter(|(_, cell)| self.field.tries.get(*cell).is_some_and(|it| *it < TRIES));
        (cost_m, first.map(|(_, cell)| cell))
    }

    /// Goes to a cell and burns until it is gone; whether it is.
    fn take_away(&mut self, index: usize) -> Result<bool, String> {
        let Some(cell) = self.field.cells.get(index) else {
            return Ok(false);
        };
        let at = self.at(cell);
        let is_bed = matches!(cell.region, CellRecord::LOWER_BED | CellRecord::UPPER_BED);
        if (at - self.tip()).norm() > NEAR_M {
            self.asked.switches = 0;
            // Out, and from in front.
            let _ = self.retreat(0.015);
            let out = (self.sight.port() - at).normalize();
            let before = Place {
                at: at + out * 0.01,
                along: None,
            };
            let _ = self.reach(&|_| Some(before), 0.0, false);
            self.goes_on()?;
        }
        let (mut before_s, mut better_s) = (self.seen.at_s, self.seen.at_s);
        let (mut nearest_m, mut warmest) = (f64::MAX, 0);
        // How far the hand has gone ahead.
        let (mut pulled, mut tip) = (Vec3::zeros(), self.tip());
        let mut gone = false;
        self.look_for(f64::MAX, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, 0.05);
            before_s = work.seen.at_s;
            let (Some(cell), Some(electrode)) = (work.field.cells.get(index), work.electrode())
            else {
                return true;
            };
            gone = !work.is_left(index as u16);
            if gone {
                return true;
            }
            let (at, radius_m, outwards) = (work.at(cell), cell.radius_m, cell.outwards);
            let off_m = off_line(at, electrode);
            let warm = work
                .seen
                .state
                .cells
                .get(index)
                .copied()
                .unwrap_or_default();
            if off_m < nearest_m - 0.0002 || warm > warmest {
                (nearest_m, warmest) = (nearest_m.min(off_m), warmest.max(warm));
                better_s = work.seen.at_s;
            }
            let near = work.sight.delicate(at, 0.012, &work.seen.state);
            let is_clear = near.iter().all(|bar| clearance_m(bar, electrode) > CLEAR_M);
            let touches = off_m < radius_m + ELECTRODE_M + 0.0002;
            work.asked.switches = if is_clear && (touches || off_m < 0.003) {
                COAGULATE
            } else {
                0
            };
            // The part near the hook's end is to lie on it, flat.
            let [heel, end] = electrode;
            let way = at - end.lerp(&heel, 0.3);
            let way = if touches { way * 0.3 } else { way };
            let is_held = work.seen.tools.contact_count > 0;
            // In fat, between duct and artery, it goes no farther than that at a touch; in the bed it pushes.
            pulled = match (is_held, is_bed) {
                (true, true) => pulled - (work.tip() - tip),
                (true, false) => pulled,
                (false, _) => Vec3::zeros(),
            };
            tip = work.tip();
            if pulled.norm() < LAG_M || pulled.dot(&way) < 0.0 {
                work.go(way, seconds);
                pulled += (way * 4.0).cap_magnitude(0.04) * seconds;
            }
            let off = work.off(outwards);
            work.turn(off, seconds);
            work.seen.at_s - better_s > STUCK_S
        });
        if !gone {
            self.asked.switches = 0;
        }
        self.goes_on()?;
        Ok(gone)
    }
}

/// Between an electrode's side and a bar's, m.
fn clearance_m(bar: &Bar, [a, b]: [Vec3; 2]) -> f64 {
    let places = (0..=4).map(|step| a.lerp(&b, f64::from(step) / 4.0));
    let off_m = places.map(|at| off_line(at, bar.ends));
    off_m.fold(f64::MAX, f64::min) - bar.radius_m - ELECTRODE_M
}
