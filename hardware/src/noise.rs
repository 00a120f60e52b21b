//! Measures how noisy the positions of a device are.
//!
//! Each position is compared with the straight line between the positions before and after it. The
//! distance of the position from that line is called the deviation. The smooth motion of a hand
//! deviates to one side for many samples in a row. A hand accelerates with up to 50 m/s², which
//! makes a deviation of 0.025 mm at 1 kHz. Noise deviates to one side, then to the other.
//!
//! If the noise is independent from sample to sample, the product of a deviation and the next one
//! is on average -1 times the mean square of the noise. The product of a deviation and the next but
//! one is 0.25 times that mean square. For smooth motion both products are nearly equal. So their
//! difference is 1.25 times the mean square of the noise, whatever the hand does.

use rt_core::math::Vec3;

/// Length of a window, µs.
const WINDOW_US: u32 = 1_000_000;
/// Fewest products from which the noise of a window is computed. With 90 products the mean is right
/// to about 10 %.
const PRODUCTS_MIN: u32 = 90;
/// Longest time between two samples that are compared, µs. The motion of a hand over three samples
/// at 100 Hz is still smooth.
const GAP_US: u32 = 12_000;
/// Rms length of the noise above which a window is noisy, m. At 1000 N/m, noise of this length
/// makes force steps of 0.14 N rms. An encoder with steps of 0.1 mm still passes: its steps make
/// noise of only 0.05 mm rms in space.
pub(crate) const NOISY_M: f32 = 1.0e-4;
/// Number of noisy windows in a row after which the device is noisy. A knock, or a jump of a few
/// samples, spoils one window, or two if it falls on their common end.
const WINDOWS: u32 = 3;

/// A position, and its time by the device's clock.
#[derive(Debug, Clone, Copy)]
struct Sample {
    us: u32,
    at_m: Vec3,
}

/// Measurement of the noise in one device's positions.
#[derive(Debug, Default)]
pub(crate) struct Noise {
    last: Option<Sample>,
    before: Option<Sample>,
    /// The last two deviations, the newest first.
    deviations_m: [Option<Vec3>; 2],
    /// Sum over the deviations of the window, m². Each term is the product of a deviation with the
    /// last but one, minus its product with the last.
    sum_m2: f32,
    /// Number of terms in that sum.
    count: u32,
    /// Length of the window so far, µs.
    window_us: u32,
    noisy_windows: u32,
    /// Rms length of the noise in the last whole window, m.
    rms_m: Option<f32>,
}

impl Noise {
    /// Takes a sample without a fault.
    pub(crate) fn take(&mut self, us: u32, at_m: &Vec3) {
        let now = Sample { us, at_m: *at_m };
        let Some(last) = self.last else {
            self.last = Some(now);
            return;
        };
        let passed_us = us.wrapping_sub(last.us);
        if passed_us == 0 || passed_us > GAP_US {
            self.interrupt();
            self.last = Some(now);
            return;
        }
        if let Some(before) = self.before {
            let [first_s, second_s] =
                [last.us.wrapping_sub(before.us), passed_us].map(|us| us as f32);
            let line_m = before.at_m + (now.at_m - before.at_m) * (first_s / (first_s + second_s));
            let deviation_m = last.at_m - line_m;
            if let [Some(next_m), Some(first_m)] = self.deviations_m {
                self.sum_m2 += deviation_m.dot(&first_m) - deviation_m.dot(&next_m);
                self.count += 1;
            }
            self.deviations_m = [Some(deviation_m), self.deviations_m[0]];
        }
        (self.before, self.last) = (Some(last), Some(now));
        self.window_us += passed_us;
        if self.window_us >= WINDOW_US {
            self.end_window();
        }
    }

    /// Forgets the last samples, because the next one does not continue their motion.
    pub(crate) const fn interrupt(&mut self) {
        (self.last, self.before, self.deviations_m) = (None, None, [None; 2]);
    }

    /// True if the last [`WINDOWS`] windows were noisy.
    pub(crate) const fn is_found(&self) -> bool {
        self.noisy_windows >= WINDOWS
    }

    /// Rms length of the noise in the last whole window, m. During the first window, the value
    /// covers the samples so far. `None` if there are too few samples.
    pub(crate) fn rms_m(&self) -> Option<f32> {
        self.rms_m.or_else(|| self.measured_m())
    }

    fn measured_m(&self) -> Option<f32> {
        let mean_m2 = self.sum_m2 / (1.25 * self.count as f32);
        (self.count >= PRODUCTS_MIN).then(|| mean_m2.max(0.0).sqrt())
    }

    fn end_window(&mut self) {
        if let Some(rms_m) = self.measured_m() {
            self.rms_m = Some(rms_m);
            self.noisy_windows = match rms_m > NOISY_M {
                true => self.noisy_windows.saturating_add(1),
                false => 0,
            };
        }
        (self.sum_m2, self.count, self.window_us) = (0.0, 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::Random;

    /// Measurement of a device's noise after 5 s. The device moves along `x_at_m`, sends `hz`
    /// samples a second, and has noise of this rms length.
    fn judged(hz: u32, noise_m: f32, mut x_at_m: impl FnMut(f32) -> f32) -> Noise {
        let (mut noise, mut random) = (Noise::default(), Random::new(3, 0));
        for n in 0..5 * hz {
            let us = n * (1_000_000 / hz);
            // A number spread evenly from -1 to 1 has the mean square 1/3, so three axes have 1.
            let mut part = || noise_m * (2.0 * random.unit() - 1.0);
            let off_m = Vec3::new(part(), part(), part());
            let x_m = x_at_m(us as f32 * 1.0e-6);
            noise.take(
                us.wrapping_add(u32::MAX - 1_000_000),
                &(off_m + Vec3::x() * x_m),
            );
        }
        noise
    }

    #[test]
    fn noise_is_measured_at_any_rate_and_during_any_movement_of_a_hand() {
        for hz in [100, 500, 1000, 4000] {
            for noise_m in [0.00015, 0.0005] {
                let swings = |s: f32| 0.05 * (s * 12.0).sin();
                for noise in [judged(hz, noise_m, |_| 0.0), judged(hz, noise_m, swings)] {
                    let rms_m = noise.rms_m().unwrap();
                    assert!(noise.is_found(), "{hz} Hz: {rms_m} of {noise_m}");
                    assert!((0.6..1.4).contains(&(rms_m / noise_m)), "{hz} Hz: {rms_m}");
                }
            }
        }
    }

    #[test]
    fn a_moving_hand_encoder_steps_and_a_knock_are_no_noise() {
        let still = [
            judged(1000, 0.0, |s| 0.05 * (s * 31.0).sin()),
            // A strong tremor: 2 mm at 12 Hz.
            judged(100, 0.0, |s| 0.002 * (s * 75.0).sin()),
            // A coarse encoder, with steps of 0.1 mm, under a slow hand.
            judged(1000, 0.0, |s| (s * 0.03 * 1.0e4).round() * 1.0e-4),
            judged(1000, 0.00005, |_| 0.0),
            // A leap of 3 mm, one sample long, every 2 s.
            judged(1000, 0.0, |s| if s % 2.0 < 0.001 { 0.003 } else { 0.0 }),
        ];
        for (number, noise) in still.iter().enumerate() {
            assert!(!noise.is_found(), "{number}: {:?}", noise.rms_m());
        }
    }
}
