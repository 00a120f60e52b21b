//! Lets the ticks follow the arrivals of the haptic device's samples.
//!
//! A device that sends at the tick's rate has a phase of its own, so the median wait of its samples
//! for the tick is half a period. A slow loop moves the ticks to just after the arrivals. It takes
//! each wait as a unit vector on the circle of the period and averages the vectors. Their mean has
//! the length `r`. Normal jitter of σ gives `r = exp(−(2πσ/T)²/2)`, from which σ follows. The ticks
//! aim at a wait of 4σ, so that nearly no sample comes just too late, and the loop rests while the
//! jitter is so large that little could be gained.

use core::f64::consts::TAU;

/// Largest step of a tick's start, ns. It changes a period of 1 ms by 0.1 %. The clock of any
/// device drifts by more in ten seconds.
const STEP_MAX_NS: f64 = 1_000.0;
/// Share of a new wait in the mean, which so has a time constant of 256 ticks.
const NEW_SHARE: f64 = 1.0 / 256.0;
/// Time constant with which the loop removes an error, ticks, if it needs no step beyond the
/// largest. Four times the mean's time constant make the loop of second order critically damped.
const LOOP_TICKS: f64 = 1024.0;
/// Time constant with which the loop learns how much faster or slower the device's clock is, ticks:
/// four times `LOOP_TICKS`, so that both together stay damped. Without this learning, a clock that
/// is off by 50 in a million would leave an error of 50 ns × `LOOP_TICKS` = 51 µs.
const DRIFT_TICKS: f64 = 4.0 * LOOP_TICKS;
/// Number of waits before the loop begins. After four time constants, the mean's initial value
/// still has a share of 2 % in it.
const SETTLED: u32 = 1024;
/// Wait that the ticks aim at, in standard deviations of the jitter. With normal jitter, one sample
/// in 30 000 arrives too late.
const DEVIATIONS: f64 = 4.0;
/// Bounds of the wait that the ticks aim at, as shares of the period. Below the first a late
/// wake-up of the line's thread would lose samples. Above the second, the gain against the mean
/// wait of half a period is less than half: the loop rests.
const AIM: [f64; 2] = [0.04, 0.25];

/// The loop.
#[derive(Debug, Clone, Copy)]
pub struct Phase {
    period_ns: f64,
    /// Mean of the unit vectors of the waits.
    mean: [f64; 2],
    waits: u32,
    /// Step that the device's clock needs at each tick, ns.
    drift_ns: f64,
}

impl Phase {
    /// A loop for ticks of this period that has seen no arrival.
    #[must_use]
    pub fn new(period_ns: u64) -> Self {
        Self {
            period_ns: period_ns.max(1) as f64,
            mean: [0.0; 2],
            waits: 0,
            drift_ns: 0.0,
        }
    }

    /// Takes the arrival of the sample that a tick used, if a new one came, and the tick's
    /// scheduled start. Returns the step of the next tick's start, ns: negative is earlier.
    pub fn step_ns(&mut self, scheduled_ns: u64, arrived_ns: Option<u64>) -> i64 {
        let Some(arrived_ns) = arrived_ns else {
            return 0;
        };
        let wait_ns = scheduled_ns as i64 - arrived_ns as i64;
        let (sin, cos) = (TAU * wait_ns as f64 / self.period_ns).sin_cos();
        let [x, y] = self.mean;
        self.mean = [x + NEW_SHARE * (cos - x), y + NEW_SHARE * (sin - y)];
        self.waits = self.waits.saturating_add(1);
        let Some(aim) = self.aim().filter(|_| self.waits >= SETTLED) else {
            return 0;
        };
        let [x, y] = self.mean;
        // The shorter way round the circle.
        let error = (y.atan2(x) / TAU - aim + 0.5).rem_euclid(1.0) - 0.5;
        let pull_ns = -error * self.period_ns / LOOP_TICKS;
        let step_ns = pull_ns + self.drift_ns;
        let most = STEP_MAX_NS / 2.0;
        self.drift_ns = (self.drift_ns + pull_ns / DRIFT_TICKS).clamp(-most, most);
        step_ns.clamp(-STEP_MAX_NS, STEP_MAX_NS).round() as i64
    }

    /// Wait that the ticks aim at, as a share of the period. `None` while the line jitters too
    /// much.
    fn aim(&self) -> Option<f64> {
        let [x, y] = self.mean;
        let length = x.hypot(y).clamp(1e-9, 1.0);
        let deviation = (-2.0 * length.ln()).sqrt() / TAU;
        let aim = (DEVIATIONS * deviation).max(AIM[0]);
        (aim <= AIM[1]).then_some(aim)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u64 = 1_000_000;

    /// Uniform random numbers from 0 to 1, from a fixed seed.
    struct Even(u64);

    impl Even {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        /// An approximately normal random number of standard deviation 1.
        fn normal(&mut self) -> f64 {
            (0..12).map(|_| self.next()).sum::<f64>() - 6.0
        }
    }

    /// Runs a minute of ticks beside a device. Its samples are sent every `device_ns`, `first_ns`
    /// after the first tick, and jitter by `jitter_ns`. Returns the waits of the last ten seconds
    /// and the steps of all ticks.
    fn minute(device_ns: f64, first_ns: f64, jitter_ns: f64) -> (Vec<u64>, Vec<i64>) {
        let mut phase = Phase::new(PERIOD_NS);
        let mut chance = Even(7);
        let mut arrival = |n: f64| 1e9 + first_ns + n * device_ns + jitter_ns * chance.normal();
        let (mut start_ns, mut sent) = (1_000_000_000u64, 0.0);
        let mut next = arrival(sent);
        let (mut waits, mut steps) = (Vec::new(), Vec::new());
        for tick in 0..60_000 {
            let mut newest = None;
            while next <= start_ns as f64 {
                newest = Some(next as u64);
                sent += 1.0;
                next = arrival(sent);
            }
            if tick >= 50_000 {
                waits.extend(newest.map(|at_ns| start_ns - at_ns));
            }
            let step_ns = phase.step_ns(start_ns, newest);
            steps.push(step_ns);
            start_ns = (start_ns + PERIOD_NS).saturating_add_signed(step_ns);
        }
        waits.sort_unstable();
        (waits, steps)
    }

    fn quantile(waits: &[u64], share: f64) -> u64 {
        waits[((waits.len() - 1) as f64 * share) as usize]
    }

    #[test]
    fn samples_wait_a_twentieth_of_a_period_instead_of_half() {
        for first_us in [10, 250, 490, 510, 750, 990] {
            // The device's clock is off by 50 in a million, and the line jitters by 10 µs.
            let (waits, steps) = minute(1_000_050.0, f64::from(first_us) * 1e3, 10_000.0);
            let (p50, p99) = (quantile(&waits, 0.5), quantile(&waits, 0.99));
            assert!(p50.abs_diff(45_000) < 25_000, "{first_us}: {p50}");
            assert!(p99 < 100_000, "{first_us}: {p99}");
            // Nearly every tick has a sample.
            assert!(waits.len() > 9_990, "{first_us}: {}", waits.len());
            assert!(steps.iter().all(|step| step.abs() <= 1_000));
        }
    }

    #[test]
    fn it_rests_while_the_line_jitters_or_has_another_rate() {
        let resting = |(_, steps): (Vec<u64>, Vec<i64>)| {
            let moved: i64 = steps.iter().map(|step| step.abs()).sum();
            moved < 1_000_000
        };
        assert!(resting(minute(1_000_000.0, 3e5, 150_000.0)), "it jitters");
        assert!(resting(minute(900_000.0, 3e5, 1_000.0)), "it is faster");
        let mut silent = Phase::new(PERIOD_NS);
        assert!((0..5000).all(|i| silent.step_ns(i * PERIOD_NS, None) == 0));
    }

    #[test]
    fn more_jitter_leaves_more_room() {
        let (quiet, _) = minute(1_000_000.0, 6e5, 5_000.0);
        let (noisy, _) = minute(1_000_000.0, 6e5, 40_000.0);
        let (quiet, noisy) = (quantile(&quiet, 0.5), quantile(&noisy, 0.5));
        assert!(
            quiet < 60_000 && noisy > 120_000 && noisy < 220_000,
            "{quiet} {noisy}"
        );
    }

    #[test]
    fn a_device_of_half_the_rate_is_followed_too() {
        let (waits, _) = minute(2_000_000.0, 7e5, 5_000.0);
        assert!(
            quantile(&waits, 0.99) < 80_000,
            "{}",
            quantile(&waits, 0.99)
        );
        assert!(waits.len() > 4_990, "{}", waits.len());
    }
}
