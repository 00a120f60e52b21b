//! Smoothness of movements: the spectral arc length of their speed.
//!
//! The amplitude spectrum of the speed is divided by its value at 0 Hz. It is a curve from 0 Hz to
//! the last frequency with an amplitude of [`LEAST`] or more. A smooth movement has a short curve.
//! The smoothness is the negative length of the curve: −1.4 for one bell of speed, and less for
//! each hesitation. The measure (SPARC) depends neither on the movement's size nor on its duration,
//! and it differentiates nothing, so noise harms it less than measures of jerk: S. Balasubramanian,
//! A. Melendez-Calderon, A. Roby-Brami, E. Burdet, On the analysis of movement smoothness, J.
//! NeuroEng. Rehabil. 12:112, 2015. The limits here are those of this paper.
//!
//! Only the magnitude of the speed counts. So tremor along the way shows, and tremor across it
//! hardly does. The low-pass stages leave an eighth of a tremor of 8 Hz.

use std::f64::consts::TAU;

use super::GRID_S;

/// Highest frequency of the spectrum, Hz.
const HIGHEST_HZ: f64 = 10.0;
/// Least amplitude that counts, as a share of the amplitude at 0 Hz.
const LEAST: f64 = 0.05;
/// Number of frequencies in each interval of 1 / duration of a movement. Zero padding to 16 times
/// the length gives as many.
const FINENESS: f64 = 16.0;
/// A longer movement is cut after this number of points: 5 s. Chains of movements without a rest
/// would otherwise count as one movement that hesitates.
const LONGEST: usize = 500;

/// Mean smoothness of movements, weighted by their duration.
#[derive(Debug, Clone, Default)]
pub(super) struct Smoothness {
    /// Speeds of the present movement, m/s, one for each point of the grid.
    speeds: Vec<f64>,
    sum: f64,
    points: f64,
}

impl Smoothness {
    /// Takes the next speed of a movement, m/s.
    pub(super) fn take(&mut self, speed_m_s: f64) {
        self.speeds.push(speed_m_s);
        if self.speeds.len() >= LONGEST {
            self.end();
        }
    }

    /// Ends the movement.
    pub(super) fn end(&mut self) {
        let smoothness = -arc_length(&self.speeds);
        if smoothness.is_finite() {
            let points = self.speeds.len() as f64;
            self.sum += smoothness * points;
            self.points += points;
        }
        self.speeds.clear();
    }

    /// The mean of the ended movements; NaN without one.
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.points
    }
}

/// Length of the normalised amplitude spectrum; NaN if there is none.
fn arc_length(speeds: &[f64]) -> f64 {
    let step_hz = 1.0 / (FINENESS * GRID_S * speeds.len() as f64);
    let at_rest = amplitude(speeds, 0.0);
    let count = (HIGHEST_HZ / step_hz) as u32;
    let spectrum: Vec<f64> = (0..=count)
        .map(|index| amplitude(speeds, f64::from(index) * step_hz) / at_rest)
        .collect();
    let last = spectrum.iter().rposition(|share| *share >= LEAST);
    let counted = last.and_then(|last| spectrum.get(..=last));
    let counted = counted.unwrap_or_default();
    let along = 1.0 / (counted.len() as f64 - 1.0);
    let pairs = counted.iter().zip(counted.iter().skip(1));
    match counted.len() > 1 {
        true => pairs.map(|(from, to)| along.hypot(to - from)).sum(),
        false => f64::NAN,
    }
}

/// Amplitude of a frequency.
fn amplitude(speeds: &[f64], hz: f64) -> f64 {
    let (sin, cos) = (TAU * hz * GRID_S).sin_cos();
    let (mut turned, mut sum) = ([1.0, 0.0], [0.0; 2]);
    for speed in speeds {
        let [x, y] = turned;
        sum = [sum[0] + speed * x, sum[1] + speed * y];
        turned = [x * cos - y * sin, x * sin + y * cos];
    }
    sum[0].hypot(sum[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed of the smoothest movement from rest to rest (minimum jerk), at a share of its time.
    fn bell(at: f64) -> f64 {
        (30.0 * at * at * (1.0 - at) * (1.0 - at)).max(0.0)
    }

    fn smoothness(seconds: f64, speed: impl Fn(f64) -> f64) -> f64 {
        let points = (seconds / GRID_S) as u32;
        let share = |point: u32| f64::from(point) / f64::from(points);
        let speeds: Vec<f64> = (0..=points).map(|point| speed(share(point))).collect();
        -arc_length(&speeds)
    }

    #[test]
    fn one_bell_of_speed_is_the_smoothest_at_any_size_and_duration() {
        for seconds in [0.6, 1.0, 2.0, 4.0] {
            for size in [1.0, 50.0] {
                let one = smoothness(seconds, |at| size * bell(at));
                assert!((-1.5..-1.35).contains(&one), "{one} in {seconds} s");
            }
        }
    }

    #[test]
    fn each_hesitation_makes_a_movement_less_smooth() {
        let parts = |count: f64| smoothness(2.0, |at| bell((at * count) % 1.0));
        let less = [1.0, 2.0, 3.0, 4.0].map(parts);
        assert!(less.windows(2).all(|it| it[1] < it[0] - 0.3), "{less:?}");
    }

    #[test]
    fn a_long_movement_counts_in_parts_and_a_point_not_at_all() {
        let mut chain = Smoothness::default();
        assert!(chain.mean().is_nan());
        chain.take(1.0);
        chain.end();
        let one = chain.mean();
        for point in 0..2 * LONGEST {
            chain.take(bell((point as f64 / 100.0) % 1.0));
        }
        assert!(chain.speeds.is_empty() && chain.points >= 2.0 * LONGEST as f64);
        chain.end();
        assert!(chain.mean().is_finite(), "{one}");
    }
}
