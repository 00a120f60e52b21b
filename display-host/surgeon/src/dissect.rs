//! Dissection with the hook: removes layered tissue cell by cell, the nearest reachable cell first.

use shared_mem::scene::CellRecord;

use crate::choose::{CLEAR_M, CLOSE_M, Choice, SUNK_M};
use crate::gentle::{CLOSER_M, STUCK_S};
use crate::hold::{ELECTRODE_M, electrode_room_m, free_side};
use crate::nearing::Nearing;
use crate::plan::COAGULATE;
use crate::sight::off_line;
use crate::vector::Vec3;
use crate::work::{BACK_M, Work};

/// Longest movement within `CLOSE_M` in a quarter of a second, m. It is short because pedal and
/// picture lag.
const SLOW_M: f64 = 0.003;
/// If a cell is farther than this from the hook's working point, the hook withdraws and approaches
/// the cell from the port's side, m.
const NEAR_M: f64 = 0.010;
/// Distance before a cell from which the hook comes in, m, and the longest time to get there, s.
const OUTSIDE_M: f64 = 0.02;
const OUTSIDE_S: f64 = 3.0;
/// Largest lead of the hand over a tip that tissue holds in the gallbladder's bed, m.
const LAG_M: f64 = 0.006;
/// Largest lead of the hand over a tip that fat holds, m. It is smaller, because ducts lie in the
/// fat and spring back when the fat gives way.
const PUSH_M: f64 = 0.005;
/// A cell is given up after this time, s.
const LONG_S: f64 = 4.0;
/// The hook lets go of a cell that it has moved by this distance without burning it, m: tissue that
/// is pulled farther tears, or brings duct and artery along.
const PULLED_M: f64 = 0.004;
/// The hook lets go of tissue that it holds where it must not burn after this time, s.
const BLOCKED_S: f64 = 0.25;
/// A cell within this distance of the target may lie in front of the target, m.
const AROUND_M: f64 = 0.010;
/// The electrode touches tissue within this distance, m.
const REACHED_M: f64 = 0.0002;
/// Share of the tissue that must be removed in the meantime before all cells are tried again.
const WORTH: f64 = 0.01;
/// If no cell is in reach, the surgeon withdraws, lets the tissue settle for this time, s, and
/// tries all cells again.
const REST_S: f64 = 1.5;
/// Largest number of such pauses in one dissection.
const RESTS: u32 = 3;

impl Work<'_> {
    /// Removes cells of these regions until this share of them is gone, for at most this time, s.
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
                    "{:.1} % is gone after {seconds:.0} s",
                    100.0 * gone
                ));
            }
            let Some(choice) = self.choose(regions) else {
                if gone > before + WORTH {
                    // Cells that were in the way may be gone now.
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
                    "{:.1} % is gone, the rest is out of reach",
                    100.0 * gone
                ));
            };
            if !self.take_away(&choice)? {
                self.field.give_up(choice.cell);
                // The hook leaves whatever held it up or came along.
                self.withdraw(0.01)?;
            }
            self.goes_on()?;
        };
        self.asked.switches = 0;
        done
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

    /// Moves to a cell and burns it. Returns true once it is gone.
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
        let is_far = (place(self) - self.works()).norm() > NEAR_M;
        if is_far {
            self.withdraw(0.012)?;
            let out = (self.sight.port() - place(self)).normalize();
            // From the port's side the hook comes in along its shaft, and sweeps nothing aside.
            self.travel(&|work| place(work) + out * OUTSIDE_M, bend, OUTSIDE_S)?;
            self.travel(&|work| place(work) + out * 0.006, bend, 2.0)?;
            self.trail.clear();
            if (place(self) - self.works()).norm() > NEAR_M {
                return Ok(false);
            }
        }
        let (mut before_s, mut better_s) = (self.seen.at_s, self.seen.at_s);
        let around = self.field.around(index, AROUND_M);
        let began_s = self.seen.at_s;
        let (mut nearest_m, mut warmest) = (f64::MAX, 0);
        // Lead of the hand over the tip, and the tip's last position.
        let (mut pulled, mut tip) = (Vec3::zeros(), self.works());
        let mut gone = false;
        let (mut nearing, mut hanging) = (Nearing::default(), None);
        let (from, mut blocked_s) = (place(self), 0.0);
        self.look_for(f64::MAX, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, 0.05);
            before_s = work.seen.at_s;
            let Some(electrode) = work.electrode() else {
                return true;
            };
            work.note_way();
            gone = !work.field.is_left(index, &work.seen.state);
            if gone {
                return true;
            }
            if work.tube_along(&mut hanging).is_some() {
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
            let is_held = work.seen.tools.contact_count > 0;
            blocked_s = match is_held && !is_clear {
                true => blocked_s + seconds,
                false => 0.0,
            };
            let is_pulled = !burns && is_held && (at - from).norm() > PULLED_M;
            if is_pulled || blocked_s > BLOCKED_S {
                return true;
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
        if !gone {
            self.asked.switches = 0;
        }
        self.goes_on()?;
        Ok(gone)
    }
}
