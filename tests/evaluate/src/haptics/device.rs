//! A haptic device and the hand on it, along one axis. Their mechanics are stepped at 20 kHz in
//! `f64`.

use std::collections::VecDeque;

/// Steps of the mechanics in a tick.
const SUBSTEPS: u32 = 20;
/// Length of a step, s.
const STEP_S: f64 = 1e-3 / SUBSTEPS as f64;

/// A device. Its axis points away from the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Device {
    /// Apparent mass at the tip, kg.
    pub(super) mass_kg: f64,
    /// Viscous damping, N s/m.
    pub(super) damping_n_s_m: f64,
    /// Dry friction, N.
    pub(super) friction_n: f64,
    /// Encoder step, m.
    pub(super) encoder_m: f64,
    /// Peak force of the motors, N.
    pub(super) peak_n: f64,
    /// Time from a command to its force, s.
    pub(super) delay_s: f64,
    /// Ticks from one sample to the next.
    pub(super) every: u32,
    /// Share of samples that are lost.
    pub(super) lost: f64,
    /// Largest delay of a sample, ticks.
    pub(super) late: u32,
    /// Time from a sample to the tick that takes it, s; a tick at most.
    pub(super) wait_s: f64,
}

impl Device {
    /// The emulated Touch without its damping and friction.
    pub(super) const BARE: Self = Self {
        mass_kg: 0.045,
        damping_n_s_m: 0.0,
        friction_n: 0.0,
        encoder_m: 0.055e-3,
        peak_n: 3.3,
        delay_s: 0.0,
        every: 1,
        lost: 0.0,
        late: 0,
        wait_s: 0.0,
    };
    /// The emulated Touch.
    pub(super) const TOUCH: Self = Self {
        damping_n_s_m: 0.2,
        friction_n: 0.26,
        ..Self::BARE
    };
}

/// A hand: a spring and a damper that pull the handle to the hand's target position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hand {
    pub(super) name: &'static str,
    pub(super) stiffness_n_m: f64,
    pub(super) damping_n_s_m: f64,
    /// Mass that moves with the handle, kg.
    pub(super) mass_kg: f64,
}

impl Hand {
    /// No hand: a weight lies on the handle.
    pub(super) const NONE: Self = Self {
        name: "none",
        stiffness_n_m: 0.0,
        damping_n_s_m: 0.0,
        mass_kg: 0.0,
    };
    /// Two fingers that hardly hold the handle.
    pub(super) const RELAXED: Self = Self {
        name: "relaxed",
        stiffness_n_m: 30.0,
        damping_n_s_m: 0.2,
        mass_kg: 0.0,
    };
    /// The emulator's precision grip.
    pub(super) const FIRM: Self = Self {
        name: "firm",
        stiffness_n_m: 400.0,
        damping_n_s_m: 4.0,
        mass_kg: 0.02,
    };
    pub(super) const ALL: [Self; 3] = [Self::NONE, Self::RELAXED, Self::FIRM];
}

/// Simulation of device and hand, from one tick to the next.
pub(super) struct Loop {
    device: Device,
    hand: Hand,
    pub(super) x_m: f64,
    pub(super) v_m_s: f64,
    /// Commands on their way: steps until they act, and their force.
    coming: VecDeque<(u32, f64)>,
    /// Force of the motors at present, N.
    pub(super) acting_n: f64,
    tick: u32,
    /// Samples on their way: tick of arrival, and position.
    samples: Vec<(u32, f64)>,
    /// Positions at the steps of the last tick, the newest last.
    past_m: VecDeque<f64>,
    random: u64,
    /// Work of the motors on the handle, J.
    pub(super) motor_j: f64,
}

impl Loop {
    pub(super) fn new(device: Device, hand: Hand, x_m: f64) -> Self {
        Self {
            device,
            hand,
            x_m,
            v_m_s: 0.0,
            coming: VecDeque::new(),
            acting_n: 0.0,
            tick: 0,
            samples: Vec::new(),
            past_m: VecDeque::from(vec![x_m; SUBSTEPS as usize]),
            random: 0x9e37_79b9_7f4a_7c15,
            motor_j: 0.0,
        }
    }

    /// The sample that this tick brings, if any.
    pub(super) fn sample(&mut self) -> Option<f64> {
        if self.tick.is_multiple_of(self.device.every) && self.draw() >= self.device.lost {
            let late = (self.draw() * f64::from(self.device.late + 1)) as u32;
            let step = self.device.encoder_m;
            let waited = ((self.device.wait_s / STEP_S).round() as usize).min(SUBSTEPS as usize);
            let before = self.past_m.iter().rev().nth(waited.wrapping_sub(1));
            let x_m = (before.unwrap_or(&self.x_m) / step).round() * step;
            self.samples.push((self.tick + late, x_m));
        }
        // Take the newest sample that has arrived. Older samples are dropped, also if they arrive
        // later.
        let newest = self.samples.iter().rposition(|s| s.0 <= self.tick)?;
        let x_m = self.samples[newest].1;
        self.samples.drain(..=newest);
        Some(x_m)
    }

    /// Advances the mechanics by one tick, with this force commanded at its start. The hand pulls
    /// the handle towards `target_m`, and in addition with the force `pull_n`.
    pub(super) fn tick(&mut self, force_n: f64, target_m: f64, pull_n: f64) {
        let delay = (self.device.delay_s / STEP_S).round() as u32;
        let peak = self.device.peak_n;
        self.coming.push_back((delay, force_n.clamp(-peak, peak)));
        let mass_kg = self.device.mass_kg + self.hand.mass_kg;
        for _ in 0..SUBSTEPS {
            self.past_m.pop_front();
            self.past_m.push_back(self.x_m);
            while let Some(&(0, force_n)) = self.coming.front() {
                self.acting_n = force_n;
                self.coming.pop_front();
            }
            for command in &mut self.coming {
                command.0 = command.0.saturating_sub(1);
            }
            let held_n = self.hand.stiffness_n_m * (target_m - self.x_m) + pull_n;
            let damping = self.device.damping_n_s_m + self.hand.damping_n_s_m;
            let free_n = self.acting_n + held_n - damping * self.v_m_s;
            let v = self.v_m_s + free_n * STEP_S / mass_kg;
            // Dry friction slows the handle but never reverses its motion.
            let brake = self.device.friction_n * STEP_S / mass_kg;
            self.v_m_s = v.signum() * (v.abs() - brake).max(0.0);
            self.x_m += self.v_m_s * STEP_S;
            self.motor_j += self.acting_n * self.v_m_s * STEP_S;
        }
        self.tick += 1;
    }

    /// A pseudo-random number from 0 to 1, the same in every run (SplitMix64).
    fn draw(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.random;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mass_on_a_spring_swings_at_its_frequency() {
        let hand = Hand {
            stiffness_n_m: 45.0,
            ..Hand::NONE
        };
        let mut handle = Loop::new(Device::BARE, hand, 0.01);
        // √(45 / 0.045) = 31.6 rad/s, so a whole swing takes 198.7 ms.
        let mut furthest = (0, 0.0);
        for tick in 100..250 {
            if tick == 100 {
                (0..100).for_each(|_| handle.tick(0.0, 0.0, 0.0));
            }
            handle.tick(0.0, 0.0, 0.0);
            if handle.x_m > furthest.1 {
                furthest = (tick + 1, handle.x_m);
            }
        }
        assert!((197..=200).contains(&furthest.0), "{furthest:?}");
        assert!((furthest.1 - 0.01).abs() < 2e-4, "{furthest:?}");
    }

    #[test]
    fn commands_act_late_and_samples_come_late_in_order() {
        let device = Device {
            delay_s: 0.002,
            late: 3,
            lost: 0.3,
            ..Device::BARE
        };
        let mut handle = Loop::new(device, Hand::NONE, 0.0);
        for tick in 0..3 {
            handle.tick(1.0, 0.0, 0.0);
            assert_eq!(handle.v_m_s > 0.0, tick == 2);
        }
        let mut last = f64::MIN;
        let mut fresh = 0;
        for _ in 0..1000 {
            if let Some(x_m) = handle.sample() {
                assert!(x_m >= last);
                last = x_m;
                fresh += 1;
            }
            handle.tick(1.0, 0.0, 0.0);
        }
        assert!((350..700).contains(&fresh), "{fresh}");
    }

    #[test]
    fn a_sample_that_waited_shows_where_the_handle_was() {
        let at = |wait_s: f64| {
            let device = Device {
                wait_s,
                encoder_m: 1e-9,
                ..Device::BARE
            };
            let mut handle = Loop::new(device, Hand::NONE, 0.0);
            (0..10).for_each(|_| handle.tick(1.0, 0.0, 0.0));
            let sample = handle.sample().unwrap();
            // At 1 N on 45 g the handle is at a t² / 2.
            let expected = 0.5 / 0.045 * (0.01 - wait_s) * (0.01 - wait_s);
            assert!(
                (sample / expected - 1.0).abs() < 0.02,
                "{wait_s} {sample} {expected}"
            );
            sample
        };
        let places = [0.0, 0.25e-3, 0.5e-3, 1e-3].map(at);
        assert!(places.iter().rev().is_sorted(), "{places:?}");
    }
}
