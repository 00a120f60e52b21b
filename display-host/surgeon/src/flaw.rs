//! Flaws of clumsy hands: tremor, an endoscope that wanders off, rests in the middle of a movement,
//! current that stays on where the tissue has gone.

use core::f64::consts::TAU;

use crate::plan::Surgeon;
use crate::work::Work;

/// Frequency of a tremor, Hz: physiological tremor has 8 to 12 Hz.
const TREMOR_HZ: f64 = 8.0;
/// Amplitude of the tremor, m. Metrics leave out movements within 1.6 mm, so a smaller one would
/// not show.
const TREMOR_M: f64 = 0.002;
/// Sway of a wandering endoscope in an operation: largest angle, rad, and period, s. The picture
/// ends 0.61 rad off its middle.
const WANDER: [f64; 2] = [0.9, 12.0];
/// Sway of the endoscope while it shows an organ: largest angle, rad, and period, s. The endoscope
/// turns about its port, 25 cm from the place in the picture. A hand that trembles moves that place
/// by 17 mm/s on the mean, one that wanders by 40. The drill allows 30.
const TREMBLE_SHOWING: [f64; 2] = [0.012, 0.7];
const WANDER_SHOWING: [f64; 2] = [0.12, 3.0];
/// Sway of a learner's and of a novice's endoscope: 12 mm/s and 23 mm/s on the mean. The novice's
/// reaches 37 mm/s for 0.3 s at a time, which pauses a hold and does not end it.
const LEARNER_SHOWING: [f64; 2] = [0.012, 1.0];
const NOVICE_SHOWING: [f64; 2] = [0.035, 1.5];
/// Time for which a learner and a hurried surgeon hold the current where the tissue has gone, s.
/// `hands_that_burn_on_heat_organs_instead_of_tissue` compares the heat that goes astray.
const LEARNER_BURNS_ON_S: f64 = 0.2;
const HURRIED_BURNS_ON_S: f64 = 0.4;
/// Period of the rests, s.
const REST_EVERY_S: f64 = 8.0;
/// Length of a rest, s. Idle time counts from 1 s.
const REST_S: f64 = 3.0;

impl Work<'_> {
    /// True while a pausing hand rests.
    pub(crate) fn rests(&self) -> bool {
        self.surgeon == Surgeon::Pausing && self.seen.at_s % REST_EVERY_S > REST_EVERY_S - REST_S
    }

    /// Burns on at a place where the tissue has gone, as a hand does that does not watch what the
    /// current does.
    pub(crate) fn burn_on(&mut self) -> Result<(), String> {
        let seconds = match self.surgeon {
            Surgeon::Learner => LEARNER_BURNS_ON_S,
            Surgeon::Hurried => HURRIED_BURNS_ON_S,
            _ => return Ok(()),
        };
        if self.asked.switches != 0 {
            self.wait(seconds)?;
        }
        Ok(())
    }

    /// Adds the present flaw of the hand to its next movement.
    pub(crate) fn stumble(&mut self) {
        match self.surgeon {
            Surgeon::Trembling if self.shows => self.sway(TREMBLE_SHOWING),
            Surgeon::Learner if self.shows => self.sway(LEARNER_SHOWING),
            Surgeon::Novice if self.shows => self.sway(NOVICE_SHOWING),
            Surgeon::Novice => self.sway(WANDER),
            Surgeon::Trembling => self.tremble(),
            Surgeon::Wandering if self.shows => self.sway(WANDER_SHOWING),
            Surgeon::Wandering => self.sway(WANDER),
            _ => {}
        }
    }

    fn tremble(&mut self) {
        let turns = TREMOR_HZ * self.seen.at_s;
        let off_m = [(turns * TAU).sin(), (turns * TAU).cos()].map(|it| TREMOR_M * it);
        let sums = self.asked.moved_m.iter_mut();
        for ((sum, off_m), last_m) in sums.zip(off_m).zip(&mut self.flaw) {
            *sum += off_m - *last_m;
            *last_m = off_m;
        }
    }

    /// Turns the endoscope to and fro.
    fn sway(&mut self, [most_rad, period_s]: [f64; 2]) {
        let off_rad = most_rad * (self.seen.at_s / period_s * TAU).sin();
        let [last_rad, _] = &mut self.flaw;
        let [left, _] = &mut self.asked.scope_turned_rad;
        *left += off_rad - *last_rad;
        *last_rad = off_rad;
    }
}
