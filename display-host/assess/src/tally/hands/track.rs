//! The track of one hand. The parent module explains the steps: low-pass stages, a point on a
//! leash, and a threshold for movements.

use super::GRID_S;
use super::smooth::Smoothness;
use crate::vector::{Vec3, blend, distance};

/// Share of its last value that a low-pass stage of 6 Hz keeps over [`GRID_S`]: exp(−2π · 6 Hz ·
/// 0.01 s).
const KEPT: f64 = 0.685_922_165_934_166_2;
/// Length of the leash, m. The point on the leash moves only while the hand is farther away.
const LEASH_M: f64 = 0.8e-3;
/// Number of points over which speed is measured: 0.2 s.
const WINDOW: usize = 20;
/// A movement begins when the path in the window is longer than this, m. The mean speed is then
/// 20 mm/s.
const MOVES_M: f64 = 4e-3;
/// A movement ends when the path in the window is shorter than this, m. The mean speed is then
/// 5 mm/s.
const RESTS_M: f64 = 1e-3;

/// Movement of the point on the leash during [`GRID_S`].
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// Place at which it began.
    from: Vec3,
    /// Its length, m.
    length_m: f64,
    /// Speed of the hand after all low-pass stages, m/s.
    speed_m_s: f64,
}

/// The track of one hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    path_m: f64,
    movements: u32,
    /// The four low-pass stages; `None` after a gap. The path comes from the second stage and the
    /// speed of a movement from the last, because noise disturbs a speed more than a path.
    stages: Option<[Vec3; 4]>,
    /// Place of the point on the leash.
    held: Vec3,
    /// The last steps, in a ring.
    steps: [Step; WINDOW],
    /// Index of the oldest step. The next step replaces it.
    oldest: usize,
    /// Place at which the present movement began, and [`Track::path_m`] at that time, m.
    moving_from: Option<(Vec3, f64)>,
    /// Sum of the straight distances of the finished movements, m.
    straight_m: f64,
    /// Sum of the path lengths of the finished movements, m.
    moved_m: f64,
    smoothness: Smoothness,
}

impl Track {
    /// Takes the hand's mean position in the next [`GRID_S`]. Returns true if the hand rests.
    pub(super) fn at(&mut self, place: Vec3) -> bool {
        let stages = self.stages.get_or_insert_with(|| {
            self.held = place;
            let from = place;
            self.steps = [Step {
                from,
                ..Step::default()
            }; WINDOW];
            [place; 4]
        });
        let [.., last] = *stages;
        let mut next = place;
        for stage in stages.iter_mut() {
            next = blend(next, *stage, KEPT);
            *stage = next;
        }
        let [_, second, _, fourth] = *stages;
        let from = self.held;
        let away_m = distance(from, second);
        let length_m = (away_m - LEASH_M).max(0.0);
        if length_m > 0.0 {
            self.held = blend(from, second, length_m / away_m);
            self.path_m += length_m;
        }
        let speed_m_s = distance(last, fourth) / GRID_S;
        if let Some(step) = self.steps.get_mut(self.oldest) {
            *step = Step {
                from,
                length_m,
                speed_m_s,
            };
        }
        self.oldest = (self.oldest + 1) % WINDOW;
        if self.moves() {
            self.smoothness.take(speed_m_s);
        }
        self.judge()
    }

    /// Begins or ends a movement if the path in the window passes a threshold. Returns true if the
    /// hand rests.
    fn judge(&mut self) -> bool {
        let gone_m: f64 = self.steps.iter().map(|step| step.length_m).sum();
        match self.moving_from {
            None if gone_m > MOVES_M => {
                let from = self
                    .steps
                    .get(self.oldest)
                    .map_or(self.held, |step| step.from);
                self.movements += 1;
                self.moving_from = Some((from, self.path_m - gone_m));
                let (newer, older) = self.steps.split_at(self.oldest);
                for step in older.iter().chain(newer) {
                    self.smoothness.take(step.speed_m_s);
                }
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
            self.smoothness.end();
        }
    }

    /// Ends the present movement. The track begins anew at the first position after the gap.
    pub(super) fn gap(&mut self) {
        self.end_movement();
        self.stages = None;
    }

    /// True during a movement.
    pub(super) fn moves(&self) -> bool {
        self.moving_from.is_some()
    }

    /// Path length, m.
    pub(crate) fn path_m(&self) -> f64 {
        self.path_m
    }

    /// Number of movements.
    pub(crate) fn movements(&self) -> u32 {
        self.movements
    }

    /// Sum of the straight distances over the sum of the path lengths. All movements count, and the
    /// present one counts up to now. NaN without a movement.
    pub(crate) fn economy(&self) -> f64 {
        let mut whole = self.clone();
        whole.end_movement();
        match whole.moved_m > 0.0 {
            true => whole.straight_m / whole.moved_m,
            false => f64::NAN,
        }
    }

    /// Smoothness of the finished movements; NaN if there are none.
    pub(crate) fn smoothness(&self) -> f64 {
        self.smoothness.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_pass_has_its_corner_at_six_hertz() {
        let kept = (-std::f64::consts::TAU * 6.0 * GRID_S).exp();
        assert!((kept - KEPT).abs() < 1e-12, "{kept}");
    }

    #[test]
    fn the_low_pass_keeps_the_share_of_noise_from_which_the_leash_follows() {
        for (samples_hz, share) in [(100.0, 0.31), (30.0, 0.52)] {
            let kept = kept_of_white_noise(samples_hz);
            assert!((kept - share).abs() < 0.01, "{kept} at {samples_hz} Hz");
            assert!(LEASH_M > 5.0 * kept * 0.3e-3, "{kept}");
        }
    }

    /// Standard deviation after two low-pass stages of white noise with standard deviation 1.
    /// Straight lines join the samples of the noise.
    fn kept_of_white_noise(samples_hz: f64) -> f64 {
        let mut seed = 5;
        let mut uniform = || {
            seed = u64::wrapping_mul(seed, 6_364_136_223_846_793_005).wrapping_add(1);
            ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12f64.sqrt()
        };
        let (mut from, mut to, mut at) = (uniform(), uniform(), 0.0);
        let (mut stages, mut squares) = ([0.0; 2], 0.0);
        for _ in 0..200_000 {
            let value = from + (to - from) * at;
            stages[0] = value + (stages[0] - value) * KEPT;
            stages[1] = stages[0] + (stages[1] - stages[0]) * KEPT;
            squares += stages[1] * stages[1];
            at += samples_hz * GRID_S;
            while at >= 1.0 {
                (from, to, at) = (to, uniform(), at - 1.0);
            }
        }
        (squares / 200_000.0).sqrt()
    }
}
