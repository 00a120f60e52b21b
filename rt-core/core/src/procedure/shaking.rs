//! Organs that shake while a tool moves them.
//!
//! A moving hand moves organs, which is no fault. An organ shakes only if its motion reverses many
//! times a second, and if it is much faster than the tip was at any time in the last half second.
//! Tissue that is pulled, slips or swings either reverses less often, or is about as fast as the
//! tip.
//!
//! Nothing here feeds back into the simulation.

use crate::capacity::MAX_ORGANS;
use crate::math::{self, Vec3};

/// Length of an interval, ticks. Organs are judged at the end of each interval, by the largest
/// speed of the hand in this interval and the two before: at least the last 0.5 s.
const INTERVAL_TICKS: u16 = 250;
/// Number of consecutive intervals with shaking after which an organ is reported: 6 s, as for an
/// organ that no tool moves.
const INTERVALS: u8 = 24;
/// Least number of reversals of the watched sphere in an interval with shaking. An oscillation of 8
/// Hz makes four. A hand moves back and forth at most 5 times a second, hanging tissue once or
/// twice.
const REVERSALS: u8 = 3;
/// Multiple of the hand's speed up to which the hand explains the speed of an organ. The factor is
/// assumed: it allows for tissue that a tip drags or lets slip. No measurement of the speed of such
/// tissue is known to us.
const HAND_FACTOR: f32 = 3.0;

/// Motion of one organ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrganMotion {
    /// Sphere whose reversals are counted: the fastest at the end of the last interval. `None` if
    /// the organ was slow in that interval.
    sphere: Option<u32>,
    /// Last velocity of that sphere above the speed limit, m/s.
    last_velocity_m_s: Vec3,
    /// Reversals of that sphere in this interval.
    reversals: u8,
    /// Largest speed in this interval, m/s.
    peak_m_s: f32,
    /// Consecutive intervals with shaking.
    intervals: u8,
}

impl OrganMotion {
    const STILL: Self = Self {
        sphere: None,
        last_velocity_m_s: Vec3::new(0.0, 0.0, 0.0),
        reversals: 0,
        peak_m_s: 0.0,
        intervals: 0,
    };
}

/// Watches all organs.
#[derive(Debug, Clone)]
pub(crate) struct Shaking {
    organs: [OrganMotion; MAX_ORGANS],
    ticks: u16,
    /// Largest speed of the hand, at the tip, in this interval and in each of the two before, m/s.
    hand_m_s: [f32; 3],
}

impl Shaking {
    /// Nothing moves.
    pub(crate) const NONE: Self = Self {
        organs: [OrganMotion::STILL; MAX_ORGANS],
        ticks: 0,
        hand_m_s: [0.0; 3],
    };

    /// Records the speed of an organ's fastest sphere.
    pub(crate) fn record_speed(&mut self, organ: usize, speed_m_s: f32) {
        if let Some(organ) = self.organs.get_mut(organ) {
            organ.peak_m_s = organ.peak_m_s.max(speed_m_s);
        }
    }

    /// Sphere of the organ whose velocity [`Self::note_velocity`] needs; `None` if the organ was
    /// slow in the last interval.
    pub(crate) fn watched(&self, organ: usize) -> Option<u32> {
        self.organs.get(organ)?.sphere
    }

    /// Records the velocity of an organ's watched sphere, and counts a reversal. A velocity up to
    /// `speed_min_m_s` does not count.
    pub(crate) fn note_velocity(&mut self, organ: usize, velocity_m_s: &Vec3, speed_min_m_s: f32) {
        let Some(organ) = self.organs.get_mut(organ) else {
            return;
        };
        if math::norm(velocity_m_s) > speed_min_m_s {
            let is_reversal = velocity_m_s.dot(&organ.last_velocity_m_s) < 0.0;
            organ.reversals = organ.reversals.saturating_add(is_reversal.into());
            organ.last_velocity_m_s = *velocity_m_s;
        }
    }

    /// Ends a tick in which the hand had this speed. At the end of an interval, calls `report` with
    /// each organ that has shaken for [`INTERVALS`] intervals, and with its largest speed in the
    /// last of them. `fastest` gives the fastest sphere of an organ.
    pub(crate) fn end_tick(
        &mut self,
        hand_m_s: f32,
        speed_min_m_s: f32,
        fastest: impl Fn(usize) -> Option<u32>,
        mut report: impl FnMut(usize, f32),
    ) {
        let [this_m_s, last_m_s, before_m_s] = self.hand_m_s;
        self.hand_m_s = [this_m_s.max(hand_m_s), last_m_s, before_m_s];
        self.ticks = self.ticks.saturating_add(1);
        if self.ticks < INTERVAL_TICKS {
            return;
        }
        let hand_m_s = self.hand_m_s.into_iter().fold(0.0, f32::max);
        for (i, organ) in self.organs.iter_mut().enumerate() {
            let is_fast = organ.peak_m_s > speed_min_m_s.max(HAND_FACTOR * hand_m_s);
            organ.intervals = match is_fast && organ.reversals >= REVERSALS {
                true => organ.intervals.saturating_add(1),
                false => 0,
            };
            if organ.intervals >= INTERVALS {
                report(i, organ.peak_m_s);
            }
            *organ = OrganMotion {
                sphere: if is_fast { fastest(i) } else { None },
                intervals: organ.intervals,
                ..OrganMotion::STILL
            };
        }
        let [this_m_s, last_m_s, _] = self.hand_m_s;
        (self.ticks, self.hand_m_s) = (0, [0.0, this_m_s, last_m_s]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED_MIN_M_S: f32 = 0.03;

    /// First tick at which shaking is found. The organ swings `hz` times a second and reaches
    /// `speed_m_s`. `hand` gives the speed of the hand in each tick.
    fn found(ticks: u32, hz: f32, speed_m_s: f32, hand: impl Fn(u32) -> f32) -> Option<u32> {
        let mut shaking = Shaking::NONE;
        let mut first = None;
        for tick in 0..ticks {
            let phase = core::f32::consts::TAU * hz * tick as f32 * 0.001;
            let velocity_m_s = Vec3::new(speed_m_s * phase.sin(), 0.0, 0.0);
            shaking.record_speed(0, math::norm(&velocity_m_s));
            if shaking.watched(0).is_some() {
                shaking.note_velocity(0, &velocity_m_s, SPEED_MIN_M_S);
            }
            shaking.end_tick(
                hand(tick),
                SPEED_MIN_M_S,
                |_| Some(7),
                |organ, peak_m_s| {
                    assert!(organ == 0 && peak_m_s <= speed_m_s, "{organ} {peak_m_s}");
                    first = first.or(Some(tick));
                },
            );
        }
        first
    }

    #[test]
    fn organ_that_reverses_often_and_outruns_a_moving_hand_shakes() {
        for (hz, hand_m_s) in [(8.0, 0.02), (40.0, 0.02), (180.0, 0.08)] {
            let at = found(20_000, hz, 0.3, |_| hand_m_s);
            // No sphere is watched in the first interval, so 24 more intervals must pass.
            assert_eq!(at, Some(25 * 250 - 1), "{hz} Hz");
        }
    }

    #[test]
    fn swings_hand_motion_and_pauses_are_no_shaking() {
        assert_eq!(found(20_000, 2.0, 0.3, |_| 0.02), None, "a swinging organ");
        assert_eq!(
            found(20_000, 5.0, 0.3, |_| 0.02),
            None,
            "no faster back and forth than a hand"
        );
        assert_eq!(found(20_000, 40.0, 0.02, |_| 0.0), None, "a slow organ");
        assert_eq!(found(20_000, 40.0, 0.3, |_| 0.11), None, "the hand is fast");
        // A jerk of the hand every 6 s interrupts the sequence of intervals before it is 6 s long.
        let jerks = |tick: u32| if tick % 6000 == 3000 { 0.5 } else { 0.0 };
        assert_eq!(found(40_000, 40.0, 0.3, jerks), None);
    }

    #[test]
    fn a_jerk_of_the_hand_counts_for_half_a_second() {
        for at in 0..250 {
            let mut shaking = Shaking::NONE;
            for tick in 0..at + 500 {
                let hand_m_s = if tick == at { 0.5 } else { 0.0 };
                shaking.end_tick(hand_m_s, SPEED_MIN_M_S, |_| None, |_, _| {});
            }
            let hand_m_s = shaking.hand_m_s.into_iter().fold(0.0, f32::max);
            assert!(hand_m_s > 0.4, "after {at}");
        }
    }
}
