//! Flaws of clumsy hands: tremor, an endoscope that wanders off, rests in the middle of a movement.

use core::f64::consts::TAU;

use crate::plan::Surgeon;
use crate::work::Work;

/// Frequency of a tremor, Hz: physiological tremor has 8 to 12 Hz.
const TREMOR_HZ: f64 = 8.0;
/// Amplitude of the tremor, m. Metrics leave out movements within 1.6 mm, so a smaller one would
/// not show.
const TREMOR_M: f64 = 0.002;
/// Time in which the endoscope wanders off and comes back, s.
const WANDER_S: f64 = 12.0;
/// Angle by which the endoscope wanders off, rad. The picture ends 0.61 rad off its middle.
const WANDER_RAD: f64 = 0.9;
/// Time from one rest to the next, s.
const REST_EVERY_S: f64 = 8.0;
/// Length of a rest, s. Idle time counts from 1 s.
const REST_S: f64 = 3.0;

impl Work<'_> {
    /// True while a pausing hand rests.
    pub(crate) fn rests(&self) -> bool {
        self.surgeon == Surgeon::Pausing && self.seen.at_s % REST_EVERY_S > REST_EVERY_S - REST_S
    }

    /// Adds the present flaw of the hand to what is asked of it.
    pub(crate) fn stumble(&mut self) {
        match self.surgeon {
            Surgeon::Trembling => {
                let turns = TREMOR_HZ * self.seen.at_s;
                let off_m = [(turns * TAU).sin(), (turns * TAU).cos()].map(|it| TREMOR_M * it);
                for ((sum, off_m), last_m) in
                    self.asked.moved_m.iter_mut().zip(off_m).zip(&mut self.flaw)
                {
                    *sum += off_m - *last_m;
                    *last_m = off_m;
                }
            }
            Surgeon::Wandering => {
                let share = (self.seen.at_s / WANDER_S * TAU).sin();
                let off_rad = WANDER_RAD * share;
                let [last_rad, _] = &mut self.flaw;
                let [left, _] = &mut self.asked.scope_turned_rad;
                *left += off_rad - *last_rad;
                *last_rad = off_rad;
            }
            _ => {}
        }
    }
}
