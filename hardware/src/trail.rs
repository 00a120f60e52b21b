//! Newest positions of a handle, from which its velocity is computed. Times are those of the
//! device's own clock, if it has one.

use rt_core::math::Vec3;

/// Positions kept: 5 ms at up to 8 kHz.
const KEPT: usize = 48;
/// Shortest time over which a speed is measured, µs. A shorter time would turn sensor noise of half
/// a millimetre into a speed at which the safety chain cuts the force. With a longer time, a thrown
/// handle would be noticed later.
const BASE_US: u32 = 5_000;

/// The newest positions with their times.
#[derive(Debug)]
pub(crate) struct Trail {
    places: [(u32, Vec3); KEPT],
    next: usize,
    count: usize,
}

impl Default for Trail {
    fn default() -> Self {
        Self {
            places: [(0, Vec3::zeros()); KEPT],
            next: 0,
            count: 0,
        }
    }
}

impl Trail {
    /// Forgets all positions.
    pub(crate) const fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds a position. Returns the velocity since the newest position that is at least 5 ms old,
    /// m/s; zero before there is one.
    pub(crate) fn add(&mut self, us: u32, at_m: &Vec3) -> Vec3 {
        let newest_first = (1..=self.count).map(|back| (self.next + KEPT - back) % KEPT);
        let mut places = newest_first.filter_map(|at| self.places.get(at).copied());
        let passed_us = |then_us: u32| us.wrapping_sub(then_us);
        let base = places.find(|(then_us, _)| passed_us(*then_us) >= BASE_US);
        // A device above 9.6 kHz fills the trail before 5 ms are over.
        let oldest = (self.count == KEPT)
            .then(|| self.places.get(self.next).copied())
            .flatten();
        let velocity_m_s = base
            .or(oldest)
            .filter(|(then_us, _)| passed_us(*then_us) > 0)
            .map_or_else(Vec3::zeros, |(then_us, then_m)| {
                (at_m - then_m) / (passed_us(then_us) as f32 * 1.0e-6)
            });
        if let Some(place) = self.places.get_mut(self.next) {
            *place = (us, *at_m);
        }
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
        velocity_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fastest(period_us: u32, at_m: impl Fn(u32) -> f32) -> f32 {
        let mut trail = Trail::default();
        let speeds = (0..2000).map(|i| {
            let at_m = Vec3::new(at_m(i), 0.0, 0.0);
            trail
                .add((u32::MAX - 500_000).wrapping_add(i * period_us), &at_m)
                .norm()
        });
        speeds.fold(0.0, f32::max)
    }

    #[test]
    fn a_steady_speed_is_measured_at_any_rate_across_a_wrap_of_the_clock() {
        for period_us in [125, 1000, 4000, 50_000] {
            let speed_m_s = fastest(period_us, |i| i as f32 * period_us as f32 * 1.0e-7);
            assert!(
                (speed_m_s - 0.1).abs() < 0.01,
                "{period_us} µs: {speed_m_s} m/s"
            );
        }
    }

    #[test]
    fn noise_of_half_a_millimetre_counts_as_a_low_speed() {
        let speed_m_s = fastest(1000, |i| if i % 2 == 0 { 0.0005 } else { -0.0005 });
        assert!(speed_m_s < 0.5, "{speed_m_s} m/s");
    }
}
