//! Passivity observer and controller at the handle (Hannaford and Ryu 2002, in the time domain).
//!
//! A contact may return to the hand at most the energy that the hand put in. The observer sums the
//! work that the hand does against the rendered force. For each period it uses the force that acted
//! then, which was sent `delay` earlier. The energy that the device's own damping absorbs is added.
//! If the sum is below zero, the loop has generated energy: it is too stiff for its delay, or
//! samples come late. The controller dissipates that energy by damping, at most as strong as the
//! device renders.
//!
//! Energy that tissue has dissipated must not hide energy that the loop generates. So the sum is
//! limited to the work that the present force would do on the way back to the place where contact
//! began. After `FREE_TICKS` without contact the sum is reset.

use crate::math::{self, Vec3};
use crate::port::DeviceCapabilities;
use crate::time::TICK_S;

/// Number of sent forces that are kept, one a tick. The longest delay that is taken into account is
/// one tick less, which is enough for a slow USB device.
const DELAY_MAX: usize = 16;
/// Ticks without force after which the energy is reset.
const FREE_TICKS: u32 = 100;
/// Speed below which nothing is damped, m/s: one encoder step of a Touch in 4 ms. With a larger
/// value, damping is less noisy and leaves more of the generated energy.
const STILL_M_S: f32 = 0.015;
/// Weight of a new velocity in the running mean, which smooths coarse encoder steps. With a larger
/// weight the mean follows faster and is noisier.
const SPEED_BLEND: f32 = 0.3;

/// State of the observer. Positions and forces are in the device's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Passivity {
    damping_n_s_m: f32,
    damping_max_n_s_m: f32,
    /// Forces sent, the newest last.
    sent_n: [Vec3; DELAY_MAX],
    delay_ticks: usize,
    /// Position of the handle at its last sample, m.
    handle_m: Option<Vec3>,
    /// Sum of the forces that acted in the ticks since the last sample, N.
    acting_sum_n: Vec3,
    /// Number of ticks since the last sample.
    ticks: f32,
    speed_m_s: Vec3,
    /// Position at which the present contact began, m.
    contact_start_m: Vec3,
    free_ticks: u32,
    /// Energy that the hand put in and did not get back, J.
    energy_j: f32,
}

impl Passivity {
    /// An observer without energy. Figures of the device that are negative, infinite or NaN count
    /// as zero. A delay above `DELAY_MAX - 1` ticks counts as `DELAY_MAX - 1` ticks.
    pub(crate) fn new(device: &DeviceCapabilities) -> Self {
        let non_negative = |x: f32| if x.is_finite() { x.max(0.0) } else { 0.0 };
        Self {
            damping_n_s_m: non_negative(device.damping_n_s_m),
            damping_max_n_s_m: non_negative(device.damping_max_n_s_m),
            sent_n: [Vec3::zeros(); DELAY_MAX],
            delay_ticks: (non_negative(device.delay_s) / TICK_S + 0.5) as usize,
            handle_m: None,
            acting_sum_n: Vec3::zeros(),
            ticks: 0.0,
            speed_m_s: Vec3::zeros(),
            contact_start_m: Vec3::zeros(),
            free_ticks: 0,
            energy_j: 0.0,
        }
    }

    /// Accounts for one period; `handle_m` is the handle's position if a sample of it came.
    pub(crate) fn observe(&mut self, handle_m: Option<Vec3>) {
        let delay = self.delay_ticks.min(DELAY_MAX - 1);
        let acting_n = self.sent_n.iter().nth_back(delay).copied();
        self.acting_sum_n += acting_n.unwrap_or_else(Vec3::zeros);
        self.ticks += 1.0;
        let Some(now_m) = handle_m else {
            return;
        };
        if let Some(before_m) = self.handle_m {
            let travel_m = now_m - before_m;
            let elapsed_s = self.ticks * TICK_S;
            let mean_n = self.acting_sum_n / self.ticks;
            self.energy_j -= mean_n.dot(&travel_m);
            self.energy_j += self.damping_n_s_m * travel_m.norm_squared() / elapsed_s;
            self.speed_m_s += (travel_m / elapsed_s - self.speed_m_s) * SPEED_BLEND;
        }
        self.handle_m = Some(now_m);
        self.acting_sum_n = Vec3::zeros();
        self.ticks = 0.0;
    }

    /// Returns `wanted_n` plus the damping force, and true if damping acted.
    pub(crate) fn damp(&mut self, wanted_n: &Vec3) -> (Vec3, bool) {
        let Some(handle_m) = self.handle_m else {
            return (*wanted_n, false);
        };
        let size_n = math::norm(wanted_n);
        if size_n <= 0.0 {
            self.free_ticks = self.free_ticks.saturating_add(1);
            self.contact_start_m = handle_m;
            if self.free_ticks > FREE_TICKS {
                self.energy_j = 0.0;
            }
            // Without contact there is no force, not even damping.
            return (*wanted_n, false);
        }
        self.free_ticks = 0;
        let returnable_j = size_n * math::norm(&(handle_m - self.contact_start_m));
        self.energy_j = self.energy_j.min(returnable_j);
        let speed = math::norm(&self.speed_m_s);
        let excess_m_s = speed - STILL_M_S;
        if self.energy_j >= 0.0 || excess_m_s <= 0.0 {
            return (*wanted_n, false);
        }
        // Damping that dissipates the deficit within a tick, at most what the device renders.
        let needed_n_s_m = -self.energy_j / (TICK_S * speed * speed);
        let damping = needed_n_s_m.min(self.damping_max_n_s_m);
        let damped_n = wanted_n - self.speed_m_s * (damping * excess_m_s / speed);
        (damped_n, true)
    }

    /// Records the force sent in this tick.
    pub(crate) fn record_sent(&mut self, force_n: &Vec3) {
        self.sent_n.rotate_left(1);
        if let Some(newest) = self.sent_n.last_mut() {
            *newest = *force_n;
        }
    }

    /// Resets the observer, after a time in which it was not called.
    pub(crate) fn reset(&mut self) {
        *self = Self {
            sent_n: [Vec3::zeros(); DELAY_MAX],
            handle_m: None,
            acting_sum_n: Vec3::zeros(),
            ticks: 0.0,
            speed_m_s: Vec3::zeros(),
            free_ticks: 0,
            energy_j: 0.0,
            ..*self
        };
    }

    /// Energy that the hand put in and did not get back, J.
    pub(crate) const fn energy_j(&self) -> f32 {
        self.energy_j
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    const DEVICE: DeviceCapabilities = DeviceCapabilities {
        damping_n_s_m: 0.0,
        delay_s: 0.0,
        workspace_radius_m: 0.1,
        ..DeviceCapabilities::TOUCH
    };

    /// Moves the handle along `positions_m`, a position a tick, against a wall of `stiffness` at 0.
    /// Returns the largest damping force and the energy at the end.
    fn drive(
        positions_m: impl Iterator<Item = f32>,
        stiffness: f32,
        device: &DeviceCapabilities,
    ) -> (f32, f32) {
        let mut passivity = Passivity::new(device);
        let mut damping_force_max_n = 0.0f32;
        for x_m in positions_m {
            passivity.observe(Some(Vec3::x() * x_m));
            let wanted_n = Vec3::x() * (-x_m * stiffness).max(0.0);
            let (out_n, acted) = passivity.damp(&wanted_n);
            damping_force_max_n = damping_force_max_n.max(math::norm(&(out_n - wanted_n)));
            assert!(acted || out_n == wanted_n);
            passivity.record_sent(&out_n);
        }
        (damping_force_max_n, passivity.energy_j())
    }

    fn stroke(depth_m: f32, ticks: usize) -> impl Iterator<Item = f32> {
        (0..=ticks).map(move |i| {
            let turn = core::f64::consts::TAU * i as f64 / ticks as f64;
            (-f64::from(depth_m) * 0.5 * (1.0 - turn.cos()) + 1.0e-4) as f32
        })
    }

    #[test]
    fn observer_counts_the_energy_that_a_held_force_generates() {
        // In and out in two steps of 10 mm at 100 N/m. The hand goes in against no force and comes
        // out with 1 N.
        let mut passivity = Passivity::new(&DEVICE);
        for (x, force, energy) in [(0.0, 0.0, 0.0), (-0.01, 1.0, 0.0), (0.0, 0.0, -0.01)] {
            passivity.observe(Some(Vec3::x() * x));
            assert!((passivity.energy_j() - energy).abs() < 1.0e-7);
            passivity.record_sent(&(Vec3::x() * force));
        }
        // The device's own damping of 0.05 N s/m takes 0.05 · (10 m/s)² · 1 ms = 5 mJ each way: the
        // sum is zero.
        let damped = DeviceCapabilities {
            damping_n_s_m: 0.05,
            ..DEVICE
        };
        let mut passivity = Passivity::new(&damped);
        for (x, force, energy) in [(0.0, 0.0, 0.0), (-0.01, 1.0, 0.005), (0.0, 0.0, 0.0)] {
            passivity.observe(Some(Vec3::x() * x));
            assert!((passivity.energy_j() - energy).abs() < 1.0e-7);
            passivity.record_sent(&(Vec3::x() * force));
        }
    }

    #[test]
    fn wall_is_damped_only_beyond_the_device_s_own_damping() {
        // K (T/2 + delay) = 400 · 2.5 ms = 1 N s/m.
        let device = |damping_n_s_m| DeviceCapabilities {
            delay_s: 0.002,
            damping_n_s_m,
            ..DEVICE
        };
        let strokes = || (0..20).flat_map(|_| stroke(0.003, 40));
        assert!(drive(strokes(), 400.0, &device(1.2)).0.to_bits() == 0);
        let (damping_force_max_n, _) = drive(strokes(), 400.0, &device(0.2));
        assert!(damping_force_max_n > 0.02, "{damping_force_max_n}");
    }

    #[test]
    fn late_sample_is_counted_with_the_mean_force_since_the_last_sample() {
        let mut passivity = Passivity::new(&DEVICE);
        passivity.observe(Some(Vec3::zeros()));
        for force in [1.0, 2.0, 3.0] {
            passivity.record_sent(&(Vec3::x() * force));
            passivity.observe(None);
        }
        passivity.record_sent(&(Vec3::x() * 4.0));
        passivity.observe(Some(Vec3::x() * -0.01)); // against 2.5 N on the mean
        assert!((passivity.energy_j() - 0.025).abs() < 1.0e-7);
    }

    proptest! {
        /// Without contact no force is added. An added force opposes the movement and stays within
        /// the device's damping.
        #[test]
        fn damping_force_opposes_the_motion_within_the_devices_damping(
            periods in prop::collection::vec((-0.002f32..0.002, -5.0f32..5.0, any::<bool>()), 1..200),
            damping in 0.0f32..3.0, delay in 0.0f32..0.05,
        ) {
            let device = DeviceCapabilities { damping_n_s_m: damping, delay_s: delay, ..DEVICE };
            let mut passivity = Passivity::new(&device);
            let mut at_m = Vec3::zeros();
            for (step_m, force, fresh) in periods {
                at_m.x += step_m;
                passivity.observe(fresh.then_some(at_m));
                let wanted_n = Vec3::x() * force.max(0.0);
                let (out_n, _) = passivity.damp(&wanted_n);
                let added = (out_n - wanted_n).x;
                prop_assert!(wanted_n.x > 0.0 || added.to_bits() == 0);
                prop_assert!(added * passivity.speed_m_s.x <= 0.0);
                prop_assert!(added.abs() <= 5.0 * passivity.speed_m_s.x.abs() + 1.0e-6);
                passivity.record_sent(&out_n);
            }
        }
    }
}
