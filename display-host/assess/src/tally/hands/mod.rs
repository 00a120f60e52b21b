//! Statistics of hand movements: paths, movements, smoothness, rest.
//!
//! # Noise and sampling rates
//!
//! Even a hand at rest moves in the samples, because a device's noise is some tenths of a
//! millimetre. A path that sums this noise grows by metres a minute. A count of movements by a
//! threshold of speed, as in ICSAD, depends on the tracker's noise and rate. So each track is
//! measured in five steps:
//!
//! 1. The mean over each interval of [`GRID_S`] is taken. The later steps then see one rate,
//!    however fast the samples come.
//! 2. Two low-pass stages of 6 Hz follow. This is the usual limit for the course of a hand (Winter,
//!    Biomechanics and Motor Control of Human Movement). White noise with a standard deviation of
//!    σ in each sample keeps 0.31 σ at 100 Hz, 0.52 σ at 30 Hz.
//! 3. A point follows the hand on a leash. The point stands still until the hand is farther away
//!    than the leash is long, so the noise that is left does not move it. The path of the hand is
//!    the point's path.
//! 4. A movement begins and ends when the point's path in the last 0.2 s passes a threshold, one
//!    for the beginning and a lower one for the end.
//! 5. Two more stages of 6 Hz smooth the position. The smoothness of a movement comes from the
//!    spectrum of the speed of that position ([`smooth`]).
//!
//! Noise of 0.3 mm at 30 Hz keeps 0.16 mm an axis after the second step. The leash of 0.8 mm is
//! five times as long. The window of 0.2 s holds two samples of a device with 10 Hz. In a shorter
//! window, a movement would end between two samples, while such a device's position stands still.
//!
//! The tests `tests::hand` compare movements sampled at 10 Hz to 1 kHz, with and without noise.
//! `evaluate hands` does so with the hands of surgeons and novices.

mod smooth;
mod track;

use self::track::Track;
use crate::vector::{Vec3, blend};

/// Time between two points of a track, s. A session records the hands at this period.
const GRID_S: f64 = 0.01;
/// Shortest rest that counts as idle, s.
const IDLE_S: f64 = 1.0;

/// Mean positions of `N` points over each [`GRID_S`], from samples at any rate.
#[derive(Debug, Clone)]
pub(crate) struct Grid<const N: usize> {
    /// Time integrals of the positions in the present interval, m·s.
    sums: [Vec3; N],
    /// Length of the present interval so far, s.
    part_s: f64,
}

impl<const N: usize> Default for Grid<N> {
    fn default() -> Self {
        Self {
            sums: [[0.0; 3]; N],
            part_s: 0.0,
        }
    }
}

impl<const N: usize> Grid<N> {
    /// Takes a straight movement of all points, which lasts `seconds`. Calls `each` with the mean
    /// positions of every interval that ends in it, and the interval's length, s.
    pub(crate) fn step(
        &mut self,
        [from, to]: [[Vec3; N]; 2],
        seconds: f64,
        mut each: impl FnMut([Vec3; N], f64),
    ) {
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
                let Self { sums, part_s } = core::mem::take(self);
                each(sums.map(|sum| sum.map(|x| x / part_s)), part_s);
            }
        }
    }
}

/// Both hands: instrument and endoscope.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hands {
    grid: Grid<2>,
    totals: Totals,
}

/// The two tracks, and times of rest and movement of both.
#[derive(Debug, Clone, Default)]
struct Totals {
    tracks: [Track; 2],
    rest_s: f64,
    idle_s: f64,
    /// Time in which one hand or both moved, s.
    moving_s: f64,
    /// Time in which both hands moved, s.
    both_s: f64,
}

impl Totals {
    /// Takes the mean positions in an interval of the grid.
    fn point(&mut self, places: [Vec3; 2], part_s: f64) {
        let [tip, lens] = &mut self.tracks;
        let [tip_at, lens_at] = places;
        match [tip.at(tip_at), lens.at(lens_at)] {
            [true, true] => self.rest_s += part_s,
            _ => self.end_rest(),
        }
        match self.tracks.each_ref().map(Track::moves) {
            [false, false] => {}
            [both, also] => {
                self.moving_s += part_s;
                self.both_s += if both && also { part_s } else { 0.0 };
            }
        }
    }

    fn end_rest(&mut self) {
        let rest_s = core::mem::take(&mut self.rest_s);
        if rest_s >= IDLE_S {
            self.idle_s += rest_s;
        }
    }
}

impl Hands {
    /// Takes a straight movement of both hands, which lasts `seconds`.
    pub(crate) fn step(&mut self, from: [Vec3; 2], to: [Vec3; 2], seconds: f64) {
        let numbers = || from.iter().chain(&to).flatten();
        if !numbers().all(|x| x.is_finite()) {
            self.gap();
            return;
        }
        let Self { grid, totals } = self;
        grid.step([from, to], seconds, |places, part_s| {
            totals.point(places, part_s);
        });
    }

    /// Ends rest and movements before a time that does not count.
    pub(crate) fn gap(&mut self) {
        self.grid = Grid::default();
        self.totals.end_rest();
        self.totals.tracks.iter_mut().for_each(Track::gap);
    }

    /// The tracks of instrument and endoscope.
    pub(crate) fn tracks(&self) -> &[Track; 2] {
        &self.totals.tracks
    }

    pub(crate) fn idle_s(&self) -> f64 {
        let rest_s = Some(self.totals.rest_s).filter(|rest_s| *rest_s >= IDLE_S);
        self.totals.idle_s + rest_s.unwrap_or(0.0)
    }

    /// Share of the time with a movement in which both hands moved; NaN without a movement.
    pub(crate) fn both_moving(&self) -> f64 {
        self.totals.both_s / self.totals.moving_s
    }
}

/// Path of the point in the middle of the picture at a working distance before the lens. If the
/// picture shakes or drifts, the path is long.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sight {
    grid: Grid<1>,
    track: Track,
    last: Option<Vec3>,
}

impl Sight {
    /// Takes the picture's middle, `seconds` after the last one; 0 s after a gap.
    pub(crate) fn step(&mut self, middle: Vec3, seconds: f64) {
        let last = self.last.replace(middle);
        let is_number = middle.iter().all(|x| x.is_finite());
        match last.filter(|_| seconds > 0.0 && is_number) {
            Some(from) => {
                let Self { grid, track, .. } = self;
                grid.step([[from], [middle]], seconds, |[place], _| {
                    track.at(place);
                });
            }
            None => {
                self.grid = Grid::default();
                self.track.gap();
            }
        }
    }

    /// Path so far, m.
    pub(crate) fn path_m(&self) -> f64 {
        self.track.path_m()
    }
}
