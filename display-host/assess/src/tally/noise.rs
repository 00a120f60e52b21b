//! Noise of the handle at rest.

use crate::vector::Vec3;

/// Duration of a part, s. In each part the handle's path is compared with a straight line. A
/// working hand does not follow a straight line for longer. Noise and tremor deviate from it within
/// a shorter time.
const PART_S: f64 = 0.25;
/// Fewest samples of a part.
const SAMPLES_MIN: f64 = 10.0;
/// Width of a bin of deviation, mm.
const BIN_MM: f64 = 0.01;
/// Number of bins. The last one takes all greater deviations.
const BINS: usize = 1000;
/// Fewest parts that yield a figure.
const PARTS_MIN: u32 = 8;
/// Least von Neumann ratio, mean squared step / (2 variance), that counts as noise. White noise has
/// 1, or 0.5 if each sample comes twice. An 8 Hz tremor has 0.12 at 100 samples/s and exceeds 0.3
/// below 63 samples/s (`1 - cos(2π · 8 Hz / rate)`).
const RATIO_MIN: f64 = 0.3;
/// Share of the parts that counts as rest: the calmest tenth. Their largest deviation is reported.
const CALM: f64 = 0.1;

/// Sums for the line through the present part, and a histogram of past parts' deviations.
#[derive(Debug, Clone, Default)]
pub(crate) struct Noise {
    origin: Option<Vec3>,
    count: f64,
    at_s: f64,
    sum_t: f64,
    sum_tt: f64,
    sum_p: Vec3,
    sum_tp: Vec3,
    sum_pp: Vec3,
    last: Option<Vec3>,
    /// Sum of squared steps, mm².
    steps: f64,
    bins: Vec<u32>,
}

impl Noise {
    /// Takes the handle's position, `seconds` after the last one.
    pub(crate) fn step(&mut self, place: Vec3, seconds: f64) {
        if !place.iter().all(|x| x.is_finite()) {
            self.gap();
            return;
        }
        if self.origin.is_some() {
            self.at_s += seconds;
        }
        if self.at_s >= PART_S {
            self.end_part();
            self.gap();
        }
        let origin = *self.origin.get_or_insert(place);
        let (t, mm) = (self.at_s, [0, 1, 2].map(|i| (place[i] - origin[i]) * 1e3));
        if let Some(last) = self.last.replace(mm) {
            self.steps += [0, 1, 2]
                .map(|i| (mm[i] - last[i]).powi(2))
                .iter()
                .sum::<f64>();
        }
        self.count += 1.0;
        self.sum_t += t;
        self.sum_tt += t * t;
        for ((x, sum_p), (sum_tp, sum_pp)) in
            (mm.into_iter().zip(&mut self.sum_p)).zip(self.sum_tp.iter_mut().zip(&mut self.sum_pp))
        {
            *sum_p += x;
            *sum_tp += t * x;
            *sum_pp += x * x;
        }
    }

    fn end_part(&mut self) {
        let n = self.count;
        if n < SAMPLES_MIN {
            return;
        }
        let tt = self.sum_tt - self.sum_t * self.sum_t / n;
        let off = |i: usize| {
            let tp = self.sum_tp[i] - self.sum_t * self.sum_p[i] / n;
            self.sum_pp[i] - self.sum_p[i] * self.sum_p[i] / n - tp * tp / tt
        };
        let squares: f64 = [0, 1, 2].map(off).iter().sum();
        // A line takes two parameters an axis. Rounding may make the sum negative.
        let mm = (squares.max(0.0) / (3.0 * (n - 2.0))).sqrt();
        // A smooth deviation is a moving hand, not noise. A deviation smaller than a bin is rest.
        if mm >= BIN_MM && self.steps < RATIO_MIN * 2.0 * squares {
            return;
        }
        self.bins.resize(BINS, 0);
        if let Some(bin) = self.bins.get_mut(((mm / BIN_MM) as usize).min(BINS - 1)) {
            *bin += 1;
        }
    }

    /// Discards the current part. The next position begins a new one.
    pub(crate) fn gap(&mut self) {
        let bins = core::mem::take(&mut self.bins);
        *self = Self {
            bins,
            ..Self::default()
        };
    }

    /// Tenth percentile of the parts' standard deviations per axis, mm: the lower edge of its bin.
    /// NaN if there are fewer than `PARTS_MIN` parts.
    pub(crate) fn mm(&self) -> f64 {
        let parts: u32 = self.bins.iter().sum();
        if parts < PARTS_MIN {
            return f64::NAN;
        }
        let wanted = (f64::from(parts) * CALM).ceil();
        let mut sum = 0.0;
        let bin = self.bins.iter().position(|count| {
            sum += f64::from(*count);
            sum >= wanted
        });
        bin.map_or(f64::NAN, |bin| bin as f64 * BIN_MM)
    }
}
