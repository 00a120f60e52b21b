//! Judges the samples of a rig by the rig's own clock: speed, leaps, a clock that does not run, a
//! place that does not change while it is said to move. The host's clock would blame the device for
//! what the host was late for.

use rt_core::math::Vec3;

use crate::gate::Gate;

/// Fastest plausible movement of a handle, m/s: a hand that jerks reaches 3 to 4.
const SPEED_MAX_M_S: f32 = 5.0;
/// Noise of a position on top of it, m.
const NOISE_M: f32 = 0.002;
/// Time over which a speed is taken, µs. White noise of 0.5 mm then adds 0.14 m/s, a tenth of the
/// speed at which the force trips; over a millisecond it would add 0.7 m/s.
const SPAN_US: u64 = 5_000;
/// Samples that are kept: a rig of up to 8 kHz sends 40 in that time.
const KEPT: usize = 48;
/// A place that stays exactly the same for this time, µs, while the rig says that it moves, is no
/// measurement.
const FROZEN_US: u64 = 100_000;
/// Speed, m/s, above which a rig says that it moves.
const MOVES_M_S: f32 = 0.005;
/// Samples in a row whose clock does not advance, after which the clock is not believed. A rig that
/// starts anew sets its clock back once.
const CLOCK_STANDS: u32 = 3;

/// A sample as the rig sent it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Said {
    /// The rig's clock, µs; wraps.
    pub(super) device_time_us: u32,
    pub(super) position_m: Vec3,
    /// Velocity, m/s, if the rig measures it.
    pub(super) velocity_m_s: Option<Vec3>,
}

/// Recent samples of one rig.
#[derive(Debug)]
pub(super) struct Pace {
    gate: Gate<3>,
    /// The rig's clock without wrapping, µs.
    now_us: u64,
    last_us: Option<u32>,
    standing: u32,
    /// Good places with their times, a ring.
    kept: [(u64, Vec3); KEPT],
    count: usize,
    /// Since when the place is exactly the same, µs.
    same_since_us: u64,
    /// True if the last sample was taken for a leap.
    is_held_back: bool,
}

impl Pace {
    pub(super) fn new() -> Self {
        Self {
            gate: Gate::new(SPEED_MAX_M_S, NOISE_M),
            now_us: 0,
            last_us: None,
            standing: 0,
            kept: [(0, Vec3::zeros()); KEPT],
            count: 0,
            same_since_us: 0,
            is_held_back: false,
        }
    }

    /// Velocity of the handle, m/s, by the rig's own clock: what the rig says or what its places
    /// say, whichever is faster. `None`: the sample is not to be believed.
    pub(super) fn take(&mut self, said: &Said) -> Option<Vec3> {
        if !self.advance(said.device_time_us) {
            return None;
        }
        let place = <[f32; 3]>::from(said.position_m);
        if self.gate.last().is_none() {
            self.gate.begin(place, self.now_us * 1000);
        }
        let is_true = self.gate.admit(place, self.now_us * 1000);
        if !is_true {
            self.is_held_back = true;
            return None;
        }
        if std::mem::take(&mut self.is_held_back) {
            // A leap that is believed at last is no speed.
            self.count = 0;
        }
        let before = self.at(1);
        if before.is_none_or(|(_, place)| place != said.position_m) {
            self.same_since_us = self.now_us;
        }
        let moved = self.speed(said.position_m);
        self.keep(said.position_m);
        let Some(told) = said.velocity_m_s else {
            return Some(moved);
        };
        let is_frozen = self.now_us - self.same_since_us > FROZEN_US && told.norm() > MOVES_M_S;
        if is_frozen {
            return None;
        }
        Some(if moved.norm() > told.norm() {
            moved
        } else {
            told
        })
    }

    /// Takes the rig's clock. False while it does not advance.
    fn advance(&mut self, device_time_us: u32) -> bool {
        let step = self
            .last_us
            .map_or(1, |last| device_time_us.wrapping_sub(last).cast_signed());
        self.last_us = Some(device_time_us);
        if step <= 0 {
            // Its former samples say nothing of the speed now.
            self.count = 0;
            self.standing = self.standing.saturating_add(1);
            return self.standing < CLOCK_STANDS;
        }
        self.standing = 0;
        self.now_us += u64::from(step.cast_unsigned());
        true
    }

    /// Velocity since the newest kept sample that is old enough, m/s.
    fn speed(&self, position_m: Vec3) -> Vec3 {
        let mut ages = (1..=self.count.min(KEPT)).filter_map(|back| self.at(back));
        let old = ages.find(|(at_us, _)| self.now_us - at_us >= SPAN_US);
        let oldest = || self.at(self.count.min(KEPT));
        match old.or_else(oldest) {
            Some((at_us, place)) if self.now_us > at_us => {
                let passed_us = (self.now_us - at_us).max(SPAN_US);
                (position_m - place) / (passed_us as f32 * 1e-6)
            }
            _ => Vec3::zeros(),
        }
    }

    fn keep(&mut self, position_m: Vec3) {
        let place = self.count % KEPT;
        if let Some(kept) = self.kept.get_mut(place) {
            *kept = (self.now_us, position_m);
        }
        self.count += 1;
    }

    /// The sample that was kept `back` samples ago; 1 is the newest.
    fn at(&self, back: usize) -> Option<(u64, Vec3)> {
        let index = self.count.checked_sub(back)?;
        (1..=KEPT)
            .contains(&back)
            .then(|| self.kept.get(index % KEPT).copied())
            .flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(ms: u32, x_mm: f32, told_m_s: Option<f32>) -> Said {
        Said {
            device_time_us: (u32::MAX - 20_000).wrapping_add(ms * 1000),
            position_m: Vec3::new(x_mm * 1e-3, 0.0, 0.0),
            velocity_m_s: told_m_s.map(|x| Vec3::new(x, 0.0, 0.0)),
        }
    }

    #[test]
    fn the_speed_is_that_of_the_places_by_the_rigs_clock_also_when_it_wraps() {
        let mut pace = Pace::new();
        let speeds = (0..100).map(|ms| pace.take(&said(ms, 0.1 * ms as f32, None)).unwrap());
        let last = speeds.last().unwrap();
        assert!((last.x - 0.1).abs() < 1e-3, "{last}");
    }

    #[test]
    fn a_wrong_velocity_does_not_hide_a_fast_handle() {
        let mut pace = Pace::new();
        let told = |ms: u32| pace.take(&said(ms, 2.0 * ms as f32, Some(0.0))).unwrap();
        let last = (0..50).map(told).last().unwrap();
        assert!((last.x - 2.0).abs() < 0.02, "{last}");
    }

    #[test]
    fn a_leap_is_dropped_and_the_sample_after_it_is_slow() {
        let mut pace = Pace::new();
        for ms in 0..20 {
            pace.take(&said(ms, 0.0, None)).unwrap();
        }
        assert_eq!(pace.take(&said(20, 50.0, None)), None);
        let after = pace.take(&said(21, 0.1, None)).unwrap();
        assert!(after.norm() < 0.05, "{after}");
    }

    #[test]
    fn a_leap_that_lasts_is_believed_and_is_no_speed() {
        let mut pace = Pace::new();
        for ms in 0..20 {
            pace.take(&said(ms, 0.0, None)).unwrap();
        }
        let after: Vec<_> = (20..60)
            .filter_map(|ms| pace.take(&said(ms, 50.0, None)))
            .collect();
        assert!(after.len() > 30, "{} of 40", after.len());
        assert!(after.iter().all(|it| it.norm() < 0.01), "{after:?}");
    }

    #[test]
    fn a_place_that_stays_while_it_is_said_to_move_is_not_believed() {
        let mut pace = Pace::new();
        let ends = |told: f32| {
            let mut pace = Pace::new();
            (0..300)
                .map(|ms| pace.take(&said(ms, 3.0, Some(told))))
                .last()
        };
        assert_eq!(ends(0.0126), Some(None));
        assert!(ends(0.0).flatten().is_some(), "a handle that rests");
        assert!(pace.take(&said(0, 3.0, Some(0.0126))).is_some());
    }

    #[test]
    fn a_clock_that_stands_or_runs_back_is_not_believed_and_one_restart_is() {
        let mut pace = Pace::new();
        for ms in 100..120 {
            pace.take(&said(ms, 0.0, None)).unwrap();
        }
        assert!(pace.take(&said(1, 0.0, None)).is_some(), "it started anew");
        assert!(pace.take(&said(2, 0.0, None)).is_some());
        let back = (0..10).map(|_| pace.take(&said(2, 0.0, None))).last();
        assert_eq!(back, Some(None), "it stands");
        let back = (0..10)
            .map(|ms| pace.take(&said(100 - ms, 0.0, None)))
            .last();
        assert_eq!(back, Some(None), "it runs back");
    }

    #[test]
    fn noise_of_a_resting_hand_is_far_from_a_trip() {
        let mut pace = Pace::new();
        let mut random = 1u32;
        let mut noise = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((random >> 16) as f32 / 65_536.0 - 0.5) * 1.7 // σ = 0.5 mm
        };
        let fastest = (0..5000)
            .filter_map(|ms| pace.take(&said(ms, noise(), None)))
            .map(|it| it.norm())
            .fold(0.0, f32::max);
        assert!(fastest < 0.4, "{fastest} m/s");
    }
}
