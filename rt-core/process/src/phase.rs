//! Lets the ticks follow the arrivals of the haptic device's samples.
//!
//! A device that sends at the tick's rate has an unknown phase against the ticks, so the median
//! wait of its samples for the tick is half a period. A slow loop moves the ticks to just after the
//! arrivals. It takes each wait as a unit vector on the circle of the period and averages the
//! vectors. The spread of the waits is their mean distance from this average, on the circle. Unlike
//! a mean of squares, it hardly changes with the few samples in a hundred that a busy machine reads
//! too late. The ticks aim at a wait of five spreads (four standard deviations, if the jitter is
//! normal), so that nearly no other sample comes just too late. The loop rests while the spread is
//! so large that little could be gained.
//!
//! The mean lags behind a drift of the device's clock, and until the loop has learnt the drift, the
//! lag counts as spread. So the loop also rests beside a clock that is off by about 195 in a
//! million or more: 256 waits × 195 ns are a twentieth of the period. If the line jitters more, the
//! loop rests at less drift, down to about 100 in a million.
//!
//! A step of the ticks changes all later waits by the length of the step. So the loop turns the
//! mean with each step and need not wait for later arrivals. It moves with the largest step until
//! it has arrived, which takes half a second at most.

use core::f64::consts::TAU;

/// Largest step of a tick's start, ns. It changes a period of 1 ms by 0.1 %. The clock of any
/// device drifts by more in ten seconds.
const STEP_MAX_NS: f64 = 1_000.0;
/// Number of waits in the mean and in the spread.
const MEAN_OF: u32 = 256;
/// Time constant with which the loop removes an error, ticks, if it needs no step beyond the
/// largest.
const LOOP_TICKS: f64 = 64.0;
/// Time constant with which the loop learns how much faster or slower the device's clock is, ticks:
/// slow against the mean, so that both together stay damped. Without this learning, a clock that is
/// off by 50 in a million would leave an error of 50 ns × (`MEAN_OF` + `LOOP_TICKS`) = 16 µs.
const DRIFT_TICKS: f64 = 2048.0;
/// Number of waits before the loop begins.
const SETTLED: u32 = 2 * MEAN_OF;
/// Wait that the ticks aim at, in spreads of the jitter.
const SPREADS: f64 = 5.0;
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
    /// Mean distance of the waits from their mean, as a share of the period.
    spread: f64,
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
            spread: 0.0,
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
        self.note((scheduled_ns as i64 - arrived_ns as i64) as f64 / self.period_ns);
        if self.rests() {
            return 0;
        }
        let aim = self.aim().max(AIM[0]);
        let pull_ns = -circle(self.phase() - aim) * self.period_ns / LOOP_TICKS;
        let wanted_ns = pull_ns + self.drift_ns;
        let step_ns = wanted_ns.clamp(-STEP_MAX_NS, STEP_MAX_NS).round();
        // The drift of the device's clock cancels its own part of the step; the rest moves all
        // waits.
        self.turn((step_ns - self.drift_ns) / self.period_ns);
        // On the way to its aim the loop learns nothing about the device's clock.
        if wanted_ns.abs() < STEP_MAX_NS {
            let most = STEP_MAX_NS / 2.0;
            self.drift_ns = (self.drift_ns + pull_ns / DRIFT_TICKS).clamp(-most, most);
        }
        step_ns as i64
    }

    /// True while the loop moves no tick: it has seen too few arrivals, or they jitter too much.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.waits < SETTLED || self.aim() > AIM[1]
    }

    /// Wait that the jitter asks for, as a share of the period.
    fn aim(&self) -> f64 {
        SPREADS * self.spread
    }

    /// Takes a wait, as a share of the period.
    fn note(&mut self, wait: f64) {
        self.waits = self.waits.saturating_add(1);
        let share = 1.0 / f64::from(self.waits.min(MEAN_OF));
        let distance = circle(wait - self.phase()).abs();
        // The first wait has no mean to be distant from.
        if self.waits > 1 {
            self.spread += share * (distance - self.spread);
        }
        let (sin, cos) = (TAU * wait).sin_cos();
        let [x, y] = self.mean;
        self.mean = [x + share * (cos - x), y + share * (sin - y)];
    }

    /// Mean wait, as a share of the period.
    fn phase(&self) -> f64 {
        let [x, y] = self.mean;
        y.atan2(x) / TAU
    }

    /// Turns the mean by a share of the period.
    fn turn(&mut self, by: f64) {
        let (sin, cos) = (TAU * by).sin_cos();
        let [x, y] = self.mean;
        self.mean = [x * cos - y * sin, x * sin + y * cos];
    }
}

/// The shorter way round the circle of the period, from −½ to ½.
fn circle(share: f64) -> f64 {
    (share + 0.5).rem_euclid(1.0) - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u64 = 1_000_000;

    /// Uniform random numbers from 0 to 1, from a fixed seed.
    struct Uniform(u64);

    impl Uniform {
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

    /// Runs ten seconds of ticks beside a device. Its samples are sent every `device_ns`,
    /// `first_ns` after the first tick, and jitter by `jitter_ns`. `late` of them are late by up to
    /// a period. Returns the waits of the last seven seconds and the steps of all ticks.
    fn ten_seconds(
        device_ns: f64,
        first_ns: f64,
        jitter_ns: f64,
        late: f64,
    ) -> (Vec<u64>, Vec<i64>) {
        let mut phase = Phase::new(PERIOD_NS);
        let mut chance = Uniform(7);
        let mut arrival = |n: f64| {
            let is_late = chance.next() < late;
            let late_ns = if is_late {
                device_ns * chance.next()
            } else {
                0.0
            };
            1e9 + first_ns + n * device_ns + jitter_ns * chance.normal() + late_ns
        };
        let (mut start_ns, mut sent) = (1_000_000_000u64, 0.0);
        let mut next = arrival(sent);
        let (mut waits, mut steps) = (Vec::new(), Vec::new());
        for tick in 0..10_000 {
            let mut newest = None;
            while next <= start_ns as f64 {
                newest = Some(next as u64);
                sent += 1.0;
                next = arrival(sent);
            }
            if tick >= 3_000 {
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
            let (waits, steps) = ten_seconds(1_000_050.0, f64::from(first_us) * 1e3, 10_000.0, 0.0);
            let (p50, p99) = (quantile(&waits, 0.5), quantile(&waits, 0.99));
            assert!(p50.abs_diff(42_000) < 15_000, "{first_us}: {p50}");
            assert!(p99 < 90_000, "{first_us}: {p99}");
            // Nearly every tick has a sample.
            assert!(waits.len() > 6_990, "{first_us}: {}", waits.len());
            assert!(steps.iter().all(|step| step.abs() <= 1_000));
        }
    }

    #[test]
    fn loop_rests_while_the_line_jitters_or_has_another_rate() {
        let resting = |(_, steps): (Vec<u64>, Vec<i64>)| {
            let moved: i64 = steps.iter().map(|step| step.abs()).sum();
            moved < 200_000
        };
        assert!(
            resting(ten_seconds(1_000_000.0, 3e5, 150_000.0, 0.0)),
            "it jitters"
        );
        assert!(
            resting(ten_seconds(900_000.0, 3e5, 1_000.0, 0.0)),
            "it is faster"
        );
        let mut silent = Phase::new(PERIOD_NS);
        assert!((0..5000).all(|i| silent.step_ns(i * PERIOD_NS, None) == 0));
    }

    #[test]
    fn loop_reports_when_it_rests() {
        let mut phase = Phase::new(PERIOD_NS);
        let mut chance = Uniform(7);
        let mut ticks = |phase: &mut Phase, jitter_ns: f64| {
            for tick in 1..1000 {
                let at_ns = tick * PERIOD_NS;
                phase.step_ns(
                    at_ns,
                    Some(at_ns - (3e5 + jitter_ns * chance.next()) as u64),
                );
            }
        };
        assert!(phase.rests(), "it has seen no arrival");
        ticks(&mut phase, 1e3);
        assert!(!phase.rests());
        ticks(&mut phase, 6e5);
        assert!(phase.rests(), "arrivals jitter");
    }

    #[test]
    fn more_jitter_gives_a_longer_wait() {
        let (quiet, _) = ten_seconds(1_000_000.0, 6e5, 5_000.0, 0.0);
        let (noisy, _) = ten_seconds(1_000_000.0, 6e5, 40_000.0, 0.0);
        let (quiet, noisy) = (quantile(&quiet, 0.5), quantile(&noisy, 0.5));
        assert!(
            quiet < 60_000 && noisy > 120_000 && noisy < 220_000,
            "{quiet} {noisy}"
        );
    }

    #[test]
    fn a_device_of_half_the_rate_is_followed_too() {
        let (waits, _) = ten_seconds(2_000_000.0, 7e5, 5_000.0, 0.0);
        assert!(
            quantile(&waits, 0.99) < 80_000,
            "{}",
            quantile(&waits, 0.99)
        );
        assert!(waits.len() > 3_490, "{}", waits.len());
    }

    #[test]
    fn a_few_samples_that_come_late_do_not_hold_up_the_others() {
        let (waits, _) = ten_seconds(1_000_000.0, 6e5, 5_000.0, 0.02);
        let p50 = quantile(&waits, 0.5);
        assert!(p50 < 80_000, "{p50}");
    }

    #[test]
    fn the_ticks_arrive_within_half_a_second_after_the_first_half() {
        for first_us in [0, 250, 499, 501, 750] {
            let (_, steps) = ten_seconds(1_000_000.0, f64::from(first_us) * 1e3, 5_000.0, 0.0);
            let moved = |steps: &[i64]| steps.iter().map(|step| step.abs()).sum::<i64>();
            let (before, after) = steps.split_at(1_200);
            assert!(before.iter().take(500).all(|step| *step == 0));
            assert!(moved(before) < 600_000, "{first_us}: {}", moved(before));
            // Then only the jitter of the mean moves them.
            assert!(moved(after) < 400_000, "{first_us}: {}", moved(after));
            let sum: i64 = after.iter().sum();
            assert!(sum.abs() < 30_000, "{first_us}: {sum}");
        }
    }
}
