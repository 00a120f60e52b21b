//! Statistics of hand movements: paths, movements, rest.
//!
//! # Noise and sampling rates
//!
//! Even a hand at rest moves in the samples, because a device's noise is some tenths of a
//! millimetre. A path that sums this noise grows by metres a minute. A count of movements by a
//! threshold of speed, as in ICSAD, depends on the tracker's noise and rate. So each track is
//! measured in four steps:
//!
//! 1. The mean over each interval of [`GRID_S`] is taken. The later steps then see one rate,
//!    however fast the samples come.
//! 2. Two low-pass stages of 10 Hz follow. A hand does nothing so fast on purpose. White noise with
//!    a standard deviation of σ in each sample at 100 Hz keeps 0.41 σ.
//! 3. A point follows the hand on a leash of [`LEASH_M`]. The point stands still until the hand has
//!    gone that far, so the noise that is left does not move it. The path is the point's path.
//! 4. The point's path in the last 0.1 s tells movement from rest. Each has a threshold of its own.
//!    Tremor turns back sixteen times a second, but it does not rest at the turns, so it is one
//!    movement.
//!
//! Noise of 0.3 mm keeps 0.12 mm after the second step. The leash is four times as long.

use crate::vector::{Vec3, distance};

/// Time between two points of a track, s. A session records the hands at this period.
const GRID_S: f64 = 0.01;
/// Part of its last value that a low-pass stage of 10 Hz still has after [`GRID_S`]: exp(−2π ·
/// 0.1).
const KEPT: f64 = 0.533_488_091_091_103_2;
/// Length of the leash, m.
const LEASH_M: f64 = 0.5e-3;
/// Number of points over which speed is measured: 0.1 s.
const WINDOW: usize = 10;
/// A movement begins when the path in the window is longer than this, m: 20 mm/s.
const MOVES_M: f64 = 2e-3;
/// A movement ends when the path in the window is shorter than this, m: 5 mm/s.
const RESTS_M: f64 = 0.5e-3;
/// Shortest rest that counts as idle, s.
const IDLE_S: f64 = 1.0;

/// The track of one hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    pub(crate) path_m: f64,
    pub(crate) movements: u32,
    /// The two low-pass stages; `None` after a gap.
    stages: Option<[Vec3; 2]>,
    /// The point on the leash.
    held: Vec3,
    /// The point's last steps: the place where each began, and its length, m.
    steps: [(Vec3, f64); WINDOW],
    oldest: usize,
    /// Place at which the present movement began, and [`Track::path_m`] at that time, m.
    moving_from: Option<(Vec3, f64)>,
    /// Sum of the straight distances of the finished movements, m.
    straight_m: f64,
    /// Sum of the path lengths of the finished movements, m.
    moved_m: f64,
}

impl Track {
    /// Takes the hand's mean position in the next [`GRID_S`]. Returns true if the hand rests.
    fn at(&mut self, place: Vec3) -> bool {
        let [first, second] = *self.stages.get_or_insert_with(|| {
            self.held = place;
            self.steps = [(place, 0.0); WINDOW];
            [place; 2]
        });
        let first = blend(place, first, KEPT);
        let second = blend(first, second, KEPT);
        self.stages = Some([first, second]);
        let before = self.held;
        let away_m = distance(before, second);
        let step_m = (away_m - LEASH_M).max(0.0);
        if step_m > 0.0 {
            self.held = blend(before, second, step_m / away_m);
            self.path_m += step_m;
        }
        if let Some(step) = self.steps.get_mut(self.oldest) {
            *step = (before, step_m);
        }
        self.oldest = (self.oldest + 1) % WINDOW;
        self.judge()
    }

    /// Begins or ends a movement if the path in the window passes a threshold. Returns true if the
    /// hand rests.
    fn judge(&mut self) -> bool {
        let gone_m: f64 = self.steps.iter().map(|(_, step_m)| step_m).sum();
        match self.moving_from {
            None if gone_m > MOVES_M => {
                let from = self.steps.get(self.oldest).map_or(self.held, |it| it.0);
                self.movements += 1;
                self.moving_from = Some((from, self.path_m - gone_m));
            }
            Some(_) if gone_m < RESTS_M => self.end_movement(),
            _ => {}
        }
        gone_m < RESTS_M
    }

    fn end_movement(&mut self) {
        if let Some((begin, path_m)) = self.moving_from.take() {
            let path_m = self.path_m - path_m;
            self.straight_m += distance(begin, self.held).min(path_m);
            self.moved_m += path_m;
        }
    }

    /// Ends the present movement. The track begins anew at the first position after the gap.
    fn gap(&mut self) {
        self.end_movement();
        self.stages = None;
    }

    /// Straight distance over path length, for all movements.
    pub(crate) fn economy(&self) -> f64 {
        let mut whole = self.clone();
        whole.end_movement();
        match whole.moved_m > 0.0 {
            true => whole.straight_m / whole.moved_m,
            false => f64::NAN,
        }
    }
}

/// Point between two: `share` of the way from the first to the second.
fn blend(from: Vec3, to: Vec3, share: f64) -> Vec3 {
    [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * share)
}

/// Both hands: instrument and endoscope.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hands {
    pub(crate) tracks: [Track; 2],
    /// Time integrals of the positions in the present interval of the grid, m·s.
    sums: [Vec3; 2],
    /// Length of the present interval so far, s.
    part_s: f64,
    rest_s: f64,
    idle_s: f64,
}

impl Hands {
    /// Takes a straight movement of both hands, which lasts `seconds`.
    pub(crate) fn step(&mut self, from: [Vec3; 2], to: [Vec3; 2], seconds: f64) {
        let numbers = || from.iter().chain(&to).flatten();
        if !numbers().all(|x| x.is_finite()) {
            self.gap();
            return;
        }
        let mut done_s = 0.0;
        while done_s < seconds {
            // The last part ends exactly at `seconds`. Because of rounding, the sum of the parts
            // could end just before `seconds`.
            let left_s = seconds - done_s;
            let part_s = (GRID_S - self.part_s).min(left_s);
            let middle = (done_s + 0.5 * part_s) / seconds;
            for ((sum, from), to) in self.sums.iter_mut().zip(from).zip(to) {
                let at = blend(from, to, middle);
                *sum = [0, 1, 2].map(|i| sum[i] + at[i] * part_s);
            }
            self.part_s += part_s;
            done_s = if part_s < left_s {
                done_s + part_s
            } else {
                seconds
            };
            if self.part_s >= GRID_S * (1.0 - 1e-6) {
                self.point();
            }
        }
    }

    /// Ends an interval of the grid, and gives the mean positions to the tracks.
    fn point(&mut self) {
        let part_s = core::mem::take(&mut self.part_s);
        let sums = core::mem::take(&mut self.sums);
        let [tip, lens] = &mut self.tracks;
        let [tip_at, lens_at] = sums.map(|sum| sum.map(|x| x / part_s));
        match [tip.at(tip_at), lens.at(lens_at)] {
            [true, true] => self.rest_s += part_s,
            _ => self.end_rest(),
        }
    }

    fn end_rest(&mut self) {
        let rest_s = core::mem::take(&mut self.rest_s);
        if rest_s >= IDLE_S {
            self.idle_s += rest_s;
        }
    }

    /// Marks a time without records.
    pub(crate) fn gap(&mut self) {
        self.end_rest();
        self.part_s = 0.0;
        self.sums = [[0.0; 3]; 2];
        for track in &mut self.tracks {
            track.gap();
        }
    }

    pub(crate) fn idle_s(&self) -> f64 {
        let mut whole = self.clone();
        whole.end_rest();
        whole.idle_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_pass_has_its_corner_at_ten_hertz() {
        let kept = (-std::f64::consts::TAU * 10.0 * GRID_S).exp();
        assert!((kept - KEPT).abs() < 1e-12, "{kept}");
    }
}
