//! Judges the motion that a vendor's library or service reports: leaps, and a velocity that
//! contradicts the positions.

use rt_core::fault::Fault;
use rt_core::math::Vec3;
use rt_core::port::Findings;
use rt_core::time::TimeNs;

use crate::gate::Gate;
use crate::trail::Trail;

/// Fastest plausible movement of a handle, m/s. Thrown handles reach 3 m/s.
const SPEED_LIMIT_M_S: f32 = 5.0;
/// Noise of a position, m, allowed on top of that movement.
const NOISE_M: f32 = 0.002;

/// Judgement of one device's motion.
#[derive(Debug)]
pub(crate) struct Motion {
    gate: Gate<3>,
    trail: Trail,
    admitted_ns: TimeNs,
    leaps: u64,
    findings: Findings,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            gate: Gate::new(SPEED_LIMIT_M_S, NOISE_M),
            trail: Trail::default(),
            admitted_ns: 0,
            leaps: 0,
            findings: Findings::default(),
        }
    }
}

impl Motion {
    /// Begins a poll.
    pub(crate) fn begin(&mut self) {
        self.findings = Findings::default();
    }

    /// Judges a sample. Returns its velocity, m/s, if the sample is plausible: the larger of the
    /// velocity that the device reports and the velocity of its positions.
    pub(crate) fn take(&mut self, at_m: Vec3, reported_m_s: Vec3, at_ns: TimeNs) -> Option<Vec3> {
        let before = self.gate.last();
        let is_gap = self.gate.is_gap(at_ns);
        if !self.gate.admit(at_m.into(), at_ns) {
            // After a gap the handle may be anywhere, so the next sample decides.
            if !is_gap {
                self.leaps += 1;
                self.findings.faults.raise(Fault::DeviceLeap);
            }
            return None;
        }
        let passed_s = at_ns.saturating_sub(self.admitted_ns) as f32 * 1e-9;
        let reach_m = NOISE_M + SPEED_LIMIT_M_S * passed_s;
        if before.is_some_and(|before| (at_m - Vec3::from(before)).amax() > reach_m) {
            self.findings.leapt = true;
            self.trail.clear();
        }
        self.admitted_ns = at_ns;
        let derived_m_s = self.trail.add((at_ns / 1000) as u32, &at_m);
        Some(faster(reported_m_s, derived_m_s))
    }

    /// Findings of this poll.
    pub(crate) const fn findings(&self) -> Findings {
        self.findings
    }

    /// Number of samples that were dropped for a leap.
    pub(crate) const fn leaps(&self) -> u64 {
        self.leaps
    }
}

/// The larger of a reported velocity and the velocity of the positions: the report may be zero, or
/// use another unit.
pub(crate) fn faster(reported_m_s: Vec3, derived_m_s: Vec3) -> Vec3 {
    if derived_m_s.norm() <= reported_m_s.norm() {
        reported_m_s
    } else {
        derived_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Number of samples admitted, fastest velocity and number of leaps of a handle at 1 kHz; true
    /// if a leap was admitted in the end.
    fn judged(reported_m_s: f32, x_m: impl Fn(u64) -> f32) -> (u32, f32, u64, bool) {
        let mut motion = Motion::default();
        let (mut admitted, mut fastest_m_s, mut leapt) = (0, 0.0f32, false);
        for ms in 1..=1000u64 {
            motion.begin();
            let at_m = Vec3::x() * x_m(ms);
            if let Some(velocity) = motion.take(at_m, Vec3::x() * reported_m_s, ms * MS) {
                admitted += 1;
                fastest_m_s = fastest_m_s.max(velocity.norm());
            }
            leapt |= motion.findings().leapt;
        }
        (admitted, fastest_m_s, motion.leaps(), leapt)
    }

    #[test]
    fn a_velocity_that_is_always_zero_is_replaced_by_that_of_the_positions() {
        let (admitted, fastest_m_s, leaps, _) = judged(0.0, |ms| ms as f32 * 2.0e-3);
        assert!((fastest_m_s - 2.0).abs() < 0.01, "{fastest_m_s}");
        assert_eq!((admitted, leaps), (999, 0));
        let (_, fastest_m_s, ..) = judged(3.0, |ms| ms as f32 * 2.0e-3);
        assert!((fastest_m_s - 3.0).abs() < 0.01, "{fastest_m_s}");
    }

    #[test]
    fn a_leap_of_three_samples_is_dropped_and_makes_no_speed() {
        let (admitted, fastest_m_s, leaps, leapt) =
            judged(0.0, |ms| if (500..503).contains(&ms) { 0.05 } else { 0.0 });
        assert_eq!((admitted, leaps, leapt), (996, 3, false));
        assert!(fastest_m_s < 0.01, "{fastest_m_s}");
    }

    #[test]
    fn a_lasting_leap_is_accepted_and_reported() {
        let (admitted, fastest_m_s, leaps, leapt) =
            judged(0.0, |ms| if ms >= 500 { 0.05 } else { 0.0 });
        assert_eq!((admitted, leaps, leapt), (992, 7, true));
        assert!(fastest_m_s < 0.01, "{fastest_m_s}");
    }
}
