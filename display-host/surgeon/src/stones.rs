//! Picking up a stone that spilled.

use shared_mem::message::StoneMsg;
use shared_mem::words::{Buttons, Instrument};

use crate::sight::Place;
use crate::vector::wide;
use crate::work::{BACK_M, Work};

/// Longest wait for a stone to spill, s.
const SPILLS_S: f64 = 60.0;
/// Time in which a spilled stone comes to rest, s.
const RESTS_S: f64 = 3.0;
/// Distance of the tip beyond a stone that lies between the jaws, m.
const PAST_M: f64 = 0.003;
/// Time in which the jaws close, s.
const CLOSES_S: f64 = 0.9;
/// Number of attempts at a stone.
const ATTEMPTS: u32 = 4;

impl Work<'_> {
    /// Waits for a stone, takes it between the jaws of the grasper, and draws it out of the body.
    pub(crate) fn pick_stone(&mut self) -> Result<(), String> {
        let lies = |work: &mut Self| work.seen.state.stones().is_some_and(|it| !it.is_empty());
        let spilled = self.look_for(SPILLS_S, lies);
        self.goes_on()?;
        if !spilled {
            return Err(format!("no stone spilled in {SPILLS_S} s"));
        }
        self.take(Instrument::Grasper)?;
        self.wait(RESTS_S)?;
        for _ in 0..ATTEMPTS {
            let Some(number) = self.nearest_stone().map(|it| it.number) else {
                return Err("no stone lies on tissue any more".to_owned());
            };
            let place = |work: &Self| {
                let at = wide(work.stone(number)?.at_m);
                Some(Place { at, along: None })
            };
            self.reach(&place, BACK_M, false)?;
            let missed = self.reach(&place, -PAST_M, false);
            self.asked.buttons = Buttons::GRASP.bits();
            self.wait(CLOSES_S)?;
            if self.stone(number).is_some_and(|it| it.is_held != 0) {
                // It leaves the body with the grasper.
                let drawn = self.take(Instrument::Hook);
                self.asked.buttons = Buttons::NONE.bits();
                return drawn;
            }
            self.asked.buttons = Buttons::NONE.bits();
            self.wait(CLOSES_S)?;
            self.theatre
                .tell(&format!("stone {number} slipped: {missed:?}"));
            self.retreat(BACK_M)?;
        }
        Err(format!("{ATTEMPTS} attempts failed"))
    }

    fn stone(&self, number: u32) -> Option<&StoneMsg> {
        let stones = self.seen.state.stones()?;
        stones.iter().find(|it| it.number == number)
    }

    /// The stone nearest to the port.
    fn nearest_stone(&self) -> Option<&StoneMsg> {
        let port = self.sight.port();
        let far_m = |it: &StoneMsg| (wide(it.at_m) - port).norm();
        let stones = self.seen.state.stones()?.iter();
        stones.min_by(|a, b| far_m(a).total_cmp(&far_m(b)))
    }
}
